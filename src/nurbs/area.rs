//! The area of a surface.

use pulp::Arch;
use rayon::prelude::*;

use super::basis::Row;
use super::bezier_patch::{Patch, bernstein};
use super::gauss;
use super::gauss::check_accuracy;
use super::surface::NurbsSurface;
use super::work_blocks::{in_rows, listening};
use crate::error::Result;
use crate::progress::Observer;

/// Points along each side of a piece: of the quadrature, and of the coarser ones whose differences
/// from it say how far it can be wrong. Where the surface is singular one of them may agree by
/// chance, two hardly ever do.
const NODES: [usize; 3] = [12, 9, 8];

/// Times at most that the doubtful pieces are quartered: where the surface is singular, they are
/// negligible by then.
const MOST_ROUNDS: usize = 24;

/// Points whose evaluation costs as much as a piece; what reports count with.
const POINTS_PER_PIECE: usize = 1 << 9;

/// Two estimates of an area agree when they differ by this share of what it could be at most, the
/// tangents' lengths times the patch's extent: the rest is rounding.
const ROUNDING: f64 = 1e-15;

impl NurbsSurface {
    /// The area, in the square of the points' unit, to a share of `accuracy` (for instance 1e-9).
    ///
    /// Gauss-Legendre quadrature on each Bézier patch with 12 × 12 points, and the larger of its
    /// differences from those with 9 × 9 and 8 × 8 as the doubt about it. While all doubts together
    /// pass the accuracy, the most doubtful pieces are quartered: a few where the surface folds over
    /// cost no more than they must.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface, progress::Silent};
    /// let area = NurbsSurface::sphere(DVec3::ZERO, 1.0)?.area(1e-12, &mut Silent)?;
    /// assert!((area / (4.0 * std::f64::consts::PI) - 1.0).abs() < 1e-12);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`](crate::Error::Parameter) if the accuracy is not between 1e-14 and 1,
    /// [`Error::Interrupted`](crate::Error::Interrupted) if the observer stops it.
    pub fn area(&self, accuracy: f64, observer: &mut dyn Observer) -> Result<f64> {
        check_accuracy(accuracy)?;
        let (patches, _) = Patch::of(self, &mut listening(observer))?;
        let degrees = (self.knots_u().degree(), self.knots_v().degree());
        let rules = NODES.map(|count| Rule::new(count, degrees));
        let mut pieces = measured(&patches, Patch::centred, &rules, observer)?;
        for _ in 0..MOST_ROUNDS {
            let enough = accuracy * pieces.iter().map(|piece| piece.area).sum::<f64>();
            if pieces.iter().map(|piece| piece.doubt).sum::<f64>() <= enough {
                break;
            }
            pieces.sort_by(|a, b| a.doubt.total_cmp(&b.doubt));
            let mut doubt = 0.0;
            let stays = |piece: &&Piece| {
                doubt += piece.doubt;
                doubt <= enough / 2.0
            };
            let doubtful = pieces.split_off(pieces.iter().take_while(stays).count());
            let quarters: Vec<(Patch, f64)> = doubtful.iter().flat_map(Piece::quarters).collect();
            pieces.extend(measured(&quarters, Clone::clone, &rules, observer)?);
        }
        Ok(pieces.iter().map(|piece| piece.area).sum())
    }
}

/// A part of the surface whose area is known.
struct Piece {
    patch: Patch,
    /// The diagonal of the box of the patch that it is part of.
    extent: f64,
    area: f64,
    /// How far the area can be wrong.
    doubt: f64,
}

impl Piece {
    fn new((patch, extent): (Patch, f64), rules: &[Rule; 3], arch: Arch) -> Self {
        let integrate = |rule: &Rule| {
            arch.dispatch(
                #[inline(always)]
                || rule.integrate(&patch),
            )
        };
        let [(area, lengths), rough @ ..] = rules.each_ref().map(integrate);
        let difference = rough.iter().map(|(rough, _)| (area - rough).abs()).fold(0.0, f64::max);
        let doubt = if difference <= ROUNDING * extent * lengths { 0.0 } else { difference };
        Self { patch, extent, area, doubt }
    }

    fn quarters(&self) -> [(Patch, f64); 4] {
        let (first, second) = self.patch.halves_u();
        let ((a, b), (c, d)) = (first.halves_v(), second.halves_v());
        [a, b, c, d].map(|quarter| (quarter, self.extent))
    }
}

/// What `part` makes of patches, as pieces.
fn measured<T: Sync>(
    patches: &[T],
    part: impl Fn(&T) -> (Patch, f64) + Sync,
    rules: &[Rule; 3],
    observer: &mut dyn Observer,
) -> Result<Vec<Piece>> {
    let (mut pieces, arch) = (Vec::with_capacity(patches.len()), Arch::new());
    in_rows(patches.len(), POINTS_PER_PIECE, observer, |from, to| {
        let tasks = patches[from..to].par_iter();
        pieces.par_extend(tasks.map(|patch| Piece::new(part(patch), rules, arch)));
    })?;
    Ok(pieces)
}

/// A quadrature over patches of the same degrees.
struct Rule {
    u: Vec<Node>,
    v: Vec<Node>,
}

/// One of its parameters, with the Bernstein polynomials there.
struct Node {
    weight: f64,
    values: Row,
    slopes: Row,
}

impl Rule {
    fn new(count: usize, degrees: (usize, usize)) -> Self {
        let nodes = |degree| {
            let node = |(place, weight): (f64, f64)| {
                let [values, slopes, _] = bernstein(degree, place);
                Node { weight, values, slopes }
            };
            gauss::rule(count).into_iter().map(node).collect()
        };
        Self { u: nodes(degrees.0), v: nodes(degrees.1) }
    }

    /// The area, and the lengths of both tangents, integrated likewise.
    #[expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]
    #[inline(always)]
    fn integrate(&self, patch: &Patch) -> (f64, f64) {
        let (mut area, mut lengths) = (0.0, 0.0);
        for u in &self.u {
            let (along, along_slopes) = (patch.row(&u.values), patch.row(&u.slopes));
            for v in &self.v {
                let value = along.sum(&v.values);
                let (by_u, by_v) = (along_slopes.sum(&v.values), along.sum(&v.slopes));
                let point = value.truncate() / value.w;
                let tangent = |d: glam::DVec4| (d.truncate() - d.w * point) / value.w;
                let (by_u, by_v) = (tangent(by_u), tangent(by_v));
                let weight = u.weight * v.weight;
                area += weight * by_u.cross(by_v).length();
                lengths += weight * (by_u.length() + by_v.length());
            }
        }
        (area, lengths)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::error::Error;
    use crate::progress::{Progress, Silent};

    #[test]
    fn areas_are_those_of_closed_forms() {
        use std::f64::consts::PI;
        let area =
            |surface: Result<NurbsSurface>| surface.unwrap().area(1e-12, &mut Silent).unwrap();
        let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-11, "{a} {b}");
        close(area(NurbsSurface::torus(DVec3::ONE, 3.0, 1.0)), 12.0 * PI * PI);
        close(area(NurbsSurface::cone(DVec3::ONE, DVec3::X * 4.0, 3.0, 0.0)), 15.0 * PI);
        close(
            area(NurbsSurface::plane(DVec3::ONE, DVec3::X * 2.0, DVec3::new(5.0, 3.0, 0.0))),
            6.0,
        );
    }

    #[test]
    fn areas_of_what_has_none_and_of_what_is_far_away_are_found_at_once() {
        let line = |i: i32| DVec3::new(0.3, 0.7, -0.1) * f64::from(i * i % 11);
        let line = NurbsSurface::clamped((0..64).map(line).collect(), (8, 8), 3).unwrap();
        assert!(line.area(1e-12, &mut Silent).unwrap() < 1e-13);
        let far = NurbsSurface::sphere(DVec3::new(5e6, 7.5e6, 300.0), 2.0).unwrap();
        let area = far.area(1e-14, &mut Silent).unwrap();
        // The centre's coordinates have a rounding of 1e-9.
        assert!((area / (16.0 * std::f64::consts::PI) - 1.0).abs() < 1e-9, "{area}");
        let mut stop = |_: &Progress| std::ops::ControlFlow::Break(());
        assert!(matches!(far.area(1e-9, &mut stop), Err(Error::Interrupted)));
    }

    #[test]
    fn accuracies_are_held_where_the_surface_is_singular() {
        // Random nets have points without a normal in a good part of their patches.
        let random = |k: u32| f64::from(k.wrapping_mul(2_654_435_761) >> 8) / f64::from(1 << 24);
        let net = (0..225).map(|k| DVec3::new(random(3 * k), random(3 * k + 1), random(3 * k + 2)));
        let noise = NurbsSurface::clamped(net.collect(), (15, 15), 3).unwrap();
        let area = |accuracy| noise.area(accuracy, &mut Silent).unwrap();
        let exact = area(1e-11);
        for accuracy in [1e-3, 1e-6, 1e-9] {
            assert!((area(accuracy) / exact - 1.0).abs() <= accuracy, "{accuracy}");
        }
    }

    #[test]
    fn estimates_that_agree_by_chance_are_no_area() {
        // With 12 x 12 points and with 8 x 8 this folded patch has the same area to 1e-5, and
        // neither is right to 2e-4.
        let patch = [
            [0.814, 0.0, -0.624, 4.084],
            [0.831, 0.0, 0.982, 5.208],
            [0.629, 0.335, 0.102, 5.755],
            [-0.905, 0.54, -0.703, 9.455],
            [0.484, -0.541, -0.847, 4.211],
            [0.754, -0.392, 0.231, 9.903],
            [0.656, -0.516, -0.875, 2.012],
            [-0.382, 0.409, -0.674, 3.825],
            [-0.358, 0.24, 0.506, 5.187],
            [0.519, 0.242, 0.167, 1.325],
            [0.184, 0.371, 0.543, 8.397],
            [0.296, -0.07, -0.119, 7.737],
        ];
        let net = patch.iter().map(|p| DVec3::new(p[0], p[1], p[2])).collect();
        let weights = patch.iter().map(|p| p[3]).collect();
        let knots = |degree| crate::nurbs::KnotVector::clamped_uniform(degree, degree + 1).unwrap();
        let patch = NurbsSurface::new(net, Some(weights), knots(2), knots(3)).unwrap();
        let area = |accuracy| patch.area(accuracy, &mut Silent).unwrap();
        assert!((area(1e-5) / area(1e-9) - 1.0).abs() <= 1e-5);
    }
}
