//! The curve in (u, v) of an edge's use, with the parameter of the edge's curve in space.
//!
//! CAD files (STEP: pcurve) require that both curves have the same parameter.

use glam::DVec3;

use super::affine::{AffineMap, rounding};
use super::edge::EdgeUse;
use super::edge_curve::edge_curve;
use super::piecewise_cubic::{INSET, Node, Traced, piecewise_cubic};
use super::settings::BrepSettings;
use super::shell::Shell;
use crate::error::Result;
use crate::nurbs::{CurveSearch, NurbsCurve, NurbsSurface};
use crate::progress::Silent;

/// Places of an edge where the parameters of two curves are compared.
const SAMPLES: u32 = 32;

/// Steps of Gauss and Newton from the nearest point on a curve within the tolerance of the surface
/// to the nearest point on the surface's own curve.
const STEPS: u32 = 3;

impl Shell {
    /// The curve in (u, v) of a use of an edge, with the direction and the parameter of
    /// [`Edge::curve`](super::Edge::curve), within the shell's tolerance.
    ///
    /// It is the coedge's curve if that has the parameter already, reversed if it runs against the
    /// edge. Else it is a piecewise cubic, or exact on a parallelogram.
    ///
    /// ```
    /// use neurbs::{DVec3, Face, NurbsSurface, Shell};
    /// let tube = Face::whole(NurbsSurface::cylinder(DVec3::ZERO, DVec3::Z, 1.0)?)?;
    /// let shell = Shell::new(vec![tube], None)?;
    /// let seam = shell.edges().iter().find(|edge| !edge.is_border()).unwrap();
    /// let [first, second] = [0, 1].map(|k| shell.pcurve(seam.uses[k]));
    /// assert_eq!(first?.point(0.25), DVec3::new(1.0, 0.25, 0.0));
    /// assert_eq!(second?.point(0.25), DVec3::new(0.0, 0.25, 0.0));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Panics
    ///
    /// If the place is not in the shell or is a pole.
    ///
    /// # Errors
    ///
    /// [`Error::Net`](crate::Error::Net) if weights differ so much that a piece of the curve has no
    /// finite control points.
    pub fn pcurve(&self, at: EdgeUse) -> Result<NurbsCurve> {
        let surface = self.faces()[at.face].surface();
        let coedge = &self.coedges(at.face)[at.in_loop][at.place];
        let edge = &self.edges()[coedge.edge.expect("the place is not a pole")];
        let curve = if coedge.forward {
            coedge.curve.clone()
        } else {
            coedge.curve.reversed(&mut Silent)?
        };
        if edge.uses[0] == at {
            return Ok(curve);
        }
        let accuracy = BrepSettings::STANDARD.edge_curve * self.tolerance();
        let accuracy = accuracy.max(rounding(surface));
        let domain = edge.curve.knots().domain();
        let curve = if curve.knots().domain() == domain {
            curve
        } else {
            curve.with_domain(domain.0, domain.1)?
        };
        let search = CurveSearch::new(&edge_curve(surface, &curve, accuracy)?)?;
        let along = AlongEdge { surface, curve: &curve, edge: &edge.curve, search };
        let same = (1..SAMPLES).all(|k| {
            let share = f64::from(k) / f64::from(SAMPLES);
            let at = domain.0 + share * (domain.1 - domain.0);
            along.distance(at, curve.point(at)) <= accuracy
        });
        if same {
            return Ok(curve);
        }
        match AffineMap::of(surface) {
            Some(map) => map.in_parameters(&edge.curve),
            None => along.cubic(accuracy),
        }
    }
}

/// A curve in (u, v) with the parameter of a curve in space that runs along it.
struct AlongEdge<'a> {
    surface: &'a NurbsSurface,
    curve: &'a NurbsCurve,
    edge: &'a NurbsCurve,
    /// Finds parameters of `curve` by points in space.
    search: CurveSearch,
}

impl AlongEdge<'_> {
    fn cubic(&self, accuracy: f64) -> Result<NurbsCurve> {
        let mut breaks = self.edge.knots().breaks();
        let (start, end) = self.edge.knots().domain();
        let onto_edge = CurveSearch::new(self.edge)?;
        for at in self.curve.knots().inner() {
            breaks.push(onto_edge.closest_point(self.on_surface(*at)[0]).u);
        }
        breaks.sort_by(f64::total_cmp);
        let apart = INSET.sqrt() * (end - start);
        breaks.dedup_by(|b, a| *b - *a <= apart);
        // The last one may have been dropped for one just before it.
        if let Some(last) = breaks.last_mut() {
            *last = end;
        }
        let cubic = piecewise_cubic(self, &breaks, accuracy)?;
        let ((u0, u1), (v0, v1)) =
            (self.surface.knots_u().domain(), self.surface.knots_v().domain());
        let (low, high) = (DVec3::new(u0, v0, 0.0), DVec3::new(u1, v1, 0.0));
        let points = cubic.control_points().iter().map(|point| point.clamp(low, high)).collect();
        NurbsCurve::new(points, None, cubic.knots().clone())
    }

    /// The point in space at a parameter of the curve, and its derivative.
    fn on_surface(&self, s: f64) -> [DVec3; 2] {
        let (uv, along) = (self.curve.point(s), self.curve.velocity(s));
        let [point, by_u, by_v] = self.surface.tangents(uv.x, uv.y);
        [point, along.x * by_u + along.y * by_v]
    }

    /// The parameter of the curve at a parameter of the edge.
    fn parameter(&self, at: f64) -> f64 {
        let (start, end) = self.edge.knots().domain();
        // Ends of closed edges have the same point.
        if at <= start || at >= end {
            return at;
        }
        let target = self.edge.point(at);
        let mut s = self.search.closest_point(target).u;
        for _ in 0..STEPS {
            let [point, velocity] = self.on_surface(s);
            let step = (target - point).dot(velocity) / velocity.length_squared();
            if !step.is_finite() {
                break;
            }
            s = (s + step).clamp(start, end);
        }
        s
    }
}

impl Traced for AlongEdge<'_> {
    fn node(&self, at: f64, toward: f64) -> Node {
        let s = self.parameter(at);
        let inside = if toward == at { s } else { s + INSET * (self.parameter(toward) - s) };
        let along = self.edge.velocity(at + INSET * (toward - at));
        let velocity = self.on_surface(inside)[1];
        // The speed with which `inside` follows the edge; 1 at a singular place.
        let speed = along.dot(velocity) / velocity.length_squared();
        let speed = if speed.is_finite() { speed } else { 1.0 };
        Node { at, point: self.curve.point(s), velocity: speed * self.curve.velocity(inside) }
    }

    fn distance(&self, at: f64, point: DVec3) -> f64 {
        let uv = self.curve.point(self.parameter(at));
        let exact = self.surface.point(uv.x, uv.y);
        exact.distance(self.surface.point(point.x, point.y))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::super::face::Face;
    use super::*;
    use crate::nurbs::KnotVector;

    /// The largest distance, over all uses of edges, between the edge's curve and the surface over
    /// the use's curve, as a fraction of the shell's tolerance.
    fn gap(shell: &Shell) -> f64 {
        let mut gap = 0.0_f64;
        for edge in shell.edges() {
            for &at in &edge.uses {
                let (curve, surface) =
                    (shell.pcurve(at).unwrap(), shell.faces()[at.face].surface());
                let (start, end) = edge.curve.knots().domain();
                assert_eq!(curve.knots().domain(), (start, end));
                for k in 0..=500 {
                    let at = start + (end - start) * f64::from(k) / 500.0;
                    let uv = curve.point(at);
                    gap = gap.max(surface.point(uv.x, uv.y).distance(edge.curve.point(at)));
                }
            }
        }
        gap / shell.tolerance()
    }

    fn line(from: (f64, f64), to: (f64, f64)) -> NurbsCurve {
        let point = |(u, v)| DVec3::new(u, v, 0.0);
        NurbsCurve::line(point(from), point(to)).unwrap()
    }

    #[test]
    fn both_uses_have_the_parameter_of_the_edge() {
        let torus = NurbsSurface::torus(1e3 * DVec3::ONE, 3.0, 1.0).unwrap();
        // Coordinates near 1000 are rounded to 1e-8 of the tolerance.
        assert!(gap(&Shell::whole(torus).unwrap()) < 1e-6);
        // The second loop follows a wave with another parameter, by weights 1, 2, 4, 8.
        let net = [(0.0, 0.5), (0.3, 0.6), (0.7, 0.4), (1.0, 0.5)];
        let net = net.map(|(u, v)| DVec3::new(u, v, 0.0)).to_vec();
        let knots = KnotVector::clamped(3, (0.0, 1.0), vec![]).unwrap();
        let weights = Some(vec![1.0, 2.0, 4.0, 8.0]);
        let other = NurbsCurve::new(net.clone(), weights, knots).unwrap();
        let back = NurbsCurve::clamped(net, 3).unwrap().reversed(&mut Silent).unwrap();
        let side = |from, to| line(from, to);
        let low = vec![
            side((0.0, 0.0), (1.0, 0.0)),
            side((1.0, 0.0), (1.0, 0.5)),
            back,
            side((0.0, 0.5), (0.0, 0.0)),
        ];
        let high = vec![
            other,
            side((1.0, 0.5), (1.0, 1.0)),
            side((1.0, 1.0), (0.0, 1.0)),
            side((0.0, 1.0), (0.0, 0.5)),
        ];
        let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0).unwrap();
        let faces = [low, high].map(|l| Face::trimmed(sphere.clone(), vec![l]).unwrap());
        for faces in [faces.to_vec(), faces.iter().rev().cloned().collect()] {
            let shell = Shell::new(faces, None).unwrap();
            assert!(shell.is_closed());
            let gap = gap(&shell);
            assert!(gap < 0.6, "{gap}");
        }
    }

    #[test]
    fn a_cap_follows_the_rim_of_a_tube_exactly() {
        let tube = NurbsSurface::cylinder(DVec3::ZERO, 2.0 * DVec3::Z, 1.0).unwrap();
        let origin = DVec3::new(-2.0, -2.0, 2.0);
        let plane = NurbsSurface::plane(origin, 4.0 * DVec3::X, 4.0 * DVec3::Y).unwrap();
        let turned = |angle: f64| 0.25 * DVec3::new(angle.cos(), angle.sin(), 0.0);
        let center = DVec3::new(0.5, 0.5, 0.0);
        let circle = NurbsCurve::arc(center, turned(1.0), turned(1.0 + PI / 2.0), TAU).unwrap();
        let cap = Face::trimmed(plane, vec![vec![circle]]).unwrap();
        let faces = [Face::whole(tube).unwrap(), cap];
        assert!(gap(&Shell::new(faces.to_vec(), None).unwrap()) < 1e-8);
        // Now the rim of the tube follows the circle.
        let turned = faces.into_iter().rev().collect();
        assert!(gap(&Shell::new(turned, None).unwrap()) < 0.6);
    }
}
