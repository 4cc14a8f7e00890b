//! Checks of the loops of a face: closed, inside the rectangle, simple, disjoint, well nested.
//!
//! That loops do not cross is proved by convex hulls: pieces are halved until a line separates
//! each pair, or until the pair is too small to differ from a touch.

use glam::{DVec2, DVec3};

use super::loops::Loop;
use super::plane_curves::{PlanePiece, signed_area, winding_number};
use super::settings::BrepSettings;
use crate::error::{Error, Result};
use crate::nurbs::{NurbsCurve, NurbsSurface};
use crate::progress::Silent;

/// Checks loops of a surface and orients them: the first, which must contain the others,
/// counter-clockwise, the others clockwise.
pub(super) fn check_loops(
    surface: &NurbsSurface,
    loops: Vec<Vec<NurbsCurve>>,
) -> Result<Vec<Loop>> {
    let rectangle = Rectangle::of(surface);
    let mut checked = vec![];
    for (index, curves) in loops.into_iter().enumerate() {
        checked.push(rectangle.check_chain(index, curves)?);
    }
    let scaled = |curves: &Vec<NurbsCurve>| {
        let curves: Result<Vec<NurbsCurve>> = curves.iter().map(|c| rectangle.scaled(c)).collect();
        Ok(simple_pieces(PlanePiece::of(&curves?)?))
    };
    let pieces: Vec<Vec<PlanePiece>> = checked.iter().map(scaled).collect::<Result<_>>()?;
    rectangle.check_inside(&pieces)?;
    rectangle.check_crossings(&pieces)?;
    check_nesting(&pieces)?;
    let oriented = checked.into_iter().zip(&pieces).enumerate().map(|(index, (curves, pieces))| {
        let counter_clockwise = signed_area(pieces) > 0.0;
        let right = counter_clockwise == (index == 0);
        Ok(Loop::new(if right { curves } else { reversed(&curves)? }))
    });
    oriented.collect()
}

/// The curves of a loop in the opposite direction.
pub(super) fn reversed(curves: &[NurbsCurve]) -> Result<Vec<NurbsCurve>> {
    curves.iter().rev().map(|curve| curve.reversed(&mut Silent)).collect()
}

/// The rectangle of a surface, for coordinates relative to it.
struct Rectangle {
    low: DVec2,
    size: DVec2,
}

impl Rectangle {
    fn of(surface: &NurbsSurface) -> Self {
        let ((u0, u1), (v0, v1)) = (surface.knots_u().domain(), surface.knots_v().domain());
        Self { low: DVec2::new(u0, v0), size: DVec2::new(u1 - u0, v1 - v0) }
    }

    /// The point in (u, v) of a point in the unit square.
    fn place(&self, point: DVec2) -> String {
        let at = self.low + point * self.size;
        format!("(u, v) = ({:.4}, {:.4})", at.x, at.y)
    }

    /// A curve in the coordinates of the unit square.
    fn scaled(&self, curve: &NurbsCurve) -> Result<NurbsCurve> {
        let scale = |p: &DVec3| ((p.truncate() - self.low) / self.size).extend(0.0);
        let points = curve.control_points().iter().map(scale).collect();
        NurbsCurve::new(points, curve.weights().map(<[f64]>::to_vec), curve.knots().clone())
    }

    /// Checks that curves form a closed chain; returns them with clamped knots.
    fn check_chain(&self, index: usize, curves: Vec<NurbsCurve>) -> Result<Vec<NurbsCurve>> {
        if curves.is_empty() {
            return Err(loop_error(index, "have at least one curve", "it has none".into()));
        }
        if let Some(point) =
            curves.iter().flat_map(NurbsCurve::control_points).find(|point| point.z != 0.0)
        {
            let got = format!("a control point has z = {}", point.z);
            return Err(loop_error(index, "consist of curves in (u, v), with z = 0", got));
        }
        let clamp = |curve: NurbsCurve| {
            if curve.knots().is_clamped() { Ok(curve) } else { curve.clamp(&mut Silent) }
        };
        let curves: Vec<NurbsCurve> = curves.into_iter().map(clamp).collect::<Result<_>>()?;
        for (k, curve) in curves.iter().enumerate() {
            let next = &curves[(k + 1) % curves.len()];
            let points = curve.control_points();
            let (end, start) = (points[points.len() - 1], next.control_points()[0]);
            let gap = ((end - start).truncate() / self.size).abs().max_element();
            if gap > BrepSettings::STANDARD.loop_gap {
                let (end, start) = (end.truncate(), start.truncate());
                let got = format!(
                    "curve {k} ends at ({}, {}) and the next one begins at ({}, {})",
                    end.x, end.y, start.x, start.y
                );
                return Err(loop_error(index, "be closed", got));
            }
        }
        Ok(curves)
    }

    /// Checks that all pieces, in the coordinates of the unit square, lie in it.
    fn check_inside(&self, loops: &[Vec<PlanePiece>]) -> Result<()> {
        for (index, pieces) in loops.iter().enumerate() {
            if let Some(outside) = pieces.iter().find_map(outlying_point) {
                let (low, high) = (self.low, self.low + self.size);
                let got = format!(
                    "it passes {}, outside [{}, {}] × [{}, {}]",
                    self.place(outside),
                    low.x,
                    high.x,
                    low.y,
                    high.y
                );
                return Err(loop_error(index, "stay inside the surface's rectangle", got));
            }
        }
        Ok(())
    }

    /// Checks that no two pieces cross or touch, except where one follows the other.
    fn check_crossings(&self, loops: &[Vec<PlanePiece>]) -> Result<()> {
        let mut all: Vec<(usize, usize, &PlanePiece)> = loops
            .iter()
            .enumerate()
            .flat_map(|(l, pieces)| pieces.iter().enumerate().map(move |(k, piece)| (l, k, piece)))
            .collect();
        all.sort_by(|a, b| a.2.low.x.total_cmp(&b.2.low.x));
        for (i, &(l, k, a)) in all.iter().enumerate() {
            for &(m, n, b) in all[i + 1..].iter().take_while(|(_, _, b)| b.low.x <= a.high.x) {
                let count = loops[l].len();
                let joints = Joints {
                    after: l == m && (k + 1) % count == n,
                    before: l == m && (n + 1) % count == k,
                };
                if let Some(at) = crossing(a, b, joints) {
                    let must = "neither cross nor touch itself or another loop";
                    let other = if l == m { "itself".into() } else { format!("loop {}", l.min(m)) };
                    let got = format!("it meets {other} near {}", self.place(at));
                    return Err(loop_error(l.max(m), must, got));
                }
            }
        }
        Ok(())
    }
}

/// The error of a loop: `loop {index} of a face must {must}, but {got}`.
fn loop_error(index: usize, must: &'static str, got: String) -> Error {
    Error::Loop { index, must, got }
}

/// Checks that all loops but the first lie inside the first and outside each other.
fn check_nesting(loops: &[Vec<PlanePiece>]) -> Result<()> {
    for (index, pieces) in loops.iter().enumerate().skip(1) {
        let point = pieces[0].start();
        for (other, around) in loops.iter().enumerate() {
            if other == index {
                continue;
            }
            let inside = winding_number(around, point).is_some_and(|turns| turns != 0);
            if inside != (other == 0) {
                let got = if inside {
                    format!("it lies inside loop {other}")
                } else {
                    "it lies outside loop 0".to_string()
                };
                let must = "lie inside loop 0 and outside the other loops";
                return Err(loop_error(index, must, got));
            }
        }
    }
    Ok(())
}

/// Pieces that cannot cross themselves: their control polygons turn by less than half a turn.
fn simple_pieces(pieces: Vec<PlanePiece>) -> Vec<PlanePiece> {
    let mut simple = vec![];
    let mut left: Vec<(PlanePiece, u32)> = pieces.into_iter().rev().map(|p| (p, 0)).collect();
    while let Some((piece, depth)) = left.pop() {
        if turns_little(&piece) || depth == MAX_HALVINGS {
            simple.push(piece);
        } else {
            let [first, second] = piece.halves();
            left.extend([(second, depth + 1), (first, depth + 1)]);
        }
    }
    simple
}

/// Halvings of a piece at most, until it turns little. At a cusp it never does.
const MAX_HALVINGS: u32 = 30;

/// Whether the legs of the control polygon all point into the half-plane of the chord.
fn turns_little(piece: &PlanePiece) -> bool {
    let chord = piece.end() - piece.start();
    let points: Vec<DVec2> = piece.control_points().collect();
    chord != DVec2::ZERO && points.windows(2).all(|leg| (leg[1] - leg[0]).dot(chord) >= 0.0)
}

/// A point of a piece outside the unit square.
fn outlying_point(piece: &PlanePiece) -> Option<DVec2> {
    let gap = BrepSettings::STANDARD.loop_gap;
    let outside = |point: DVec2| (-point).max(point - 1.0).max_element() > gap;
    if !outside(piece.low) && !outside(piece.high) {
        return None;
    }
    if let Some(point) = [piece.start(), piece.end()].into_iter().find(|point| outside(*point)) {
        return Some(point);
    }
    if piece.size() <= gap {
        return None;
    }
    piece.halves().iter().find_map(outlying_point)
}

/// Where a piece follows another: after its end, before its start.
#[derive(Clone, Copy)]
struct Joints {
    after: bool,
    before: bool,
}

/// A point where two pieces, in the coordinates of the unit square, meet beside their joints.
fn crossing(a: &PlanePiece, b: &PlanePiece, joints: Joints) -> Option<DVec2> {
    let gap = BrepSettings::STANDARD.loop_gap;
    if a.low.cmpgt(b.high).any() || b.low.cmpgt(a.high).any() {
        return None;
    }
    let separated = match (joints.after, joints.before) {
        (false, false) => apart(a, b),
        (true, false) => apart_at_joint(a, b, a.end().midpoint(b.start())),
        (false, true) => apart_at_joint(a, b, b.end().midpoint(a.start())),
        (true, true) => false,
    };
    if separated {
        return None;
    }
    if a.size().max(b.size()) <= gap {
        // Both are parts of the gap at a joint, or a place where loops meet.
        let at_joint = joints.after || joints.before;
        return (!at_joint).then(|| a.start().midpoint(b.start()));
    }
    if a.size() >= b.size() {
        let [first, second] = a.halves();
        let after = crossing(&first, b, Joints { after: false, ..joints });
        after.or_else(|| crossing(&second, b, Joints { before: false, ..joints }))
    } else {
        let [first, second] = b.halves();
        let before = crossing(a, &first, Joints { before: false, ..joints });
        before.or_else(|| crossing(a, &second, Joints { after: false, ..joints }))
    }
}

/// Whether a line along or across a chord separates the control points of two pieces.
fn apart(a: &PlanePiece, b: &PlanePiece) -> bool {
    let chords = [a.end() - a.start(), b.end() - b.start()];
    chords.iter().flat_map(|chord| [*chord, chord.perp()]).any(|axis| {
        let range = |piece: &PlanePiece| {
            let heights = piece.control_points().map(|point| point.dot(axis));
            heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)))
        };
        let (a, b) = (range(a), range(b));
        a.1 < b.0 || b.1 < a.0
    })
}

/// Whether a line through the joint of two pieces has their control points on different sides.
fn apart_at_joint(a: &PlanePiece, b: &PlanePiece, joint: DVec2) -> bool {
    let gap = BrepSettings::STANDARD.loop_gap;
    let away = |piece: &PlanePiece| -> Vec<DVec2> {
        let rays = piece.control_points().map(|point| point - joint);
        rays.filter(|ray| ray.length() > gap).map(DVec2::normalize).collect()
    };
    let (a, b) = (away(a), away(b));
    let mean = |rays: &[DVec2]| rays.iter().sum::<DVec2>().normalize_or_zero();
    let axis = mean(&b) - mean(&a);
    a.iter().all(|ray| ray.dot(axis) < 0.0) && b.iter().all(|ray| ray.dot(axis) > 0.0)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::super::face::Face;
    use super::*;

    fn plane() -> NurbsSurface {
        NurbsSurface::plane(DVec3::ZERO, DVec3::X, DVec3::Y).unwrap()
    }

    fn polygon(points: &[(f64, f64)]) -> Vec<NurbsCurve> {
        let point = |k: usize| {
            let (u, v) = points[k % points.len()];
            DVec3::new(u, v, 0.0)
        };
        (0..points.len()).map(|k| NurbsCurve::line(point(k), point(k + 1)).unwrap()).collect()
    }

    fn circle(u: f64, v: f64, radius: f64) -> Vec<NurbsCurve> {
        let center = DVec3::new(u, v, 0.0);
        vec![NurbsCurve::arc(center, radius * DVec3::X, radius * DVec3::Y, TAU).unwrap()]
    }

    fn square() -> Vec<NurbsCurve> {
        polygon(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    }

    fn message(loops: Vec<Vec<NurbsCurve>>) -> String {
        Face::trimmed(plane(), loops).unwrap_err().to_string()
    }

    #[test]
    fn right_loops_pass_and_are_oriented() {
        let l = [(0.1, 0.1), (0.1, 0.9), (0.5, 0.9), (0.5, 0.5), (0.9, 0.5), (0.9, 0.1)];
        let clockwise = Face::trimmed(plane(), vec![polygon(&l)]).unwrap();
        assert_eq!(clockwise.outer().curves()[0].point(0.0), DVec3::new(0.1, 0.1, 0.0));
        assert_eq!(clockwise.outer().curves()[0].point(1.0), DVec3::new(0.9, 0.1, 0.0));
        let holes = vec![square(), circle(0.3, 0.3, 0.1), circle(0.7, 0.3, 0.29999)];
        let face = Face::trimmed(plane(), holes).unwrap();
        assert_eq!(face.inner().len(), 2);
        for hole in face.inner() {
            assert!(signed_area(&PlanePiece::of(hole.curves()).unwrap()) < 0.0);
        }
        // Two arcs that meet in two cusps, and a needle.
        let lens = |bulge: f64| {
            let points = [(0.2, 0.5), (0.5, 0.5 + bulge), (0.8, 0.5)];
            let points = points.map(|(u, v)| DVec3::new(u, v, 0.0)).to_vec();
            NurbsCurve::clamped(points, 2).unwrap()
        };
        for bulge in [0.3, 1e-3] {
            let back = lens(-bulge).reversed(&mut Silent).unwrap();
            Face::trimmed(plane(), vec![vec![lens(bulge), back]]).unwrap();
        }
    }

    #[test]
    fn wrong_loops_are_refused_with_the_place() {
        let bow = polygon(&[(0.1, 0.1), (0.9, 0.9), (0.9, 0.1), (0.1, 0.9)]);
        assert!(message(vec![bow]).contains("it meets itself near (u, v) = (0.5"));
        let crossed = vec![square(), circle(0.3, 0.5, 0.2), circle(0.6, 0.5, 0.2)];
        let crossed = message(crossed);
        assert!(crossed.contains("loop 2 of a face must neither cross"), "{crossed}");
        assert!(crossed.contains("it meets loop 1 near"), "{crossed}");
        let touching = vec![square(), circle(0.5, 0.3, 0.3)];
        assert!(message(touching).contains("near (u, v) = (0.5"));
        let outlying = message(vec![circle(0.5, 0.5, 0.6)]);
        assert!(outlying.contains("stay inside the surface's rectangle"), "{outlying}");
        let outside = vec![circle(0.3, 0.3, 0.2), circle(0.8, 0.8, 0.1)];
        assert!(message(outside).contains("it lies outside loop 0"));
        let nested = vec![square(), circle(0.5, 0.5, 0.3), circle(0.5, 0.5, 0.1)];
        assert!(message(nested).contains("loop 2 of a face must lie inside loop 0"));
        let open = polygon(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)])[..2].to_vec();
        assert!(message(vec![open]).contains("curve 1 ends at (1, 1)"));
        assert!(message(vec![vec![]]).contains("it has none"));
        assert!(message(vec![]).contains("at least one"));
        let lifted = vec![NurbsCurve::line(DVec3::ZERO, DVec3::Z).unwrap()];
        assert!(message(vec![lifted]).contains("z = 1"));
        // A curve that goes back on itself.
        let flat = polygon(&[(0.1, 0.1), (0.9, 0.1), (0.5, 0.1)]);
        assert!(message(vec![flat]).contains("it meets itself"));
    }
}
