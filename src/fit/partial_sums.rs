//! Sums over the points of a fit, mergeable over parts of a cloud.

use glam::{DVec2, DVec3};

use super::fairness_energy::{Energy, LengthSums, ORDER};
use super::least_squares::{Equations, PointSums, THIN_PLATE, check};
use super::normal_equations::NormalEquations;
use super::options::FitOptions;
use super::spline_space::SplineSpace;
use crate::bytes::{Reader, Writer, read_saved};
use crate::error::{Error, Result};
use crate::nurbs::{KnotVector, NurbsSurface};
use crate::worker_pool::install;

/// Sums over points at known parameters, from which [`fit`](super::fit()) solves for the surface.
///
/// Sums of chunks merge: points in several files, threads or machines give the same surface as
/// together, up to rounding. Chunks of fixed sizes that are merged in a fixed order give the same
/// bits. The sums take about `8 (2 degree² + 2 degree + 1)` bytes for each control point.
///
/// ```
/// use neurbs::{DVec2, DVec3, fit::{FitOptions, PartialSums}};
/// let uv: Vec<DVec2> = (0..400)
///     .map(|i| DVec2::new(f64::from(i * 7 % 400) / 399.0, f64::from(i) / 399.0))
///     .collect();
/// let points: Vec<DVec3> = uv.iter().map(|at| DVec3::new(at.x, at.y, at.x * at.y)).collect();
/// let options = FitOptions::new((5, 6), (3, 3), (false, false))?;
/// let mut sums = PartialSums::of(&points[..150], &uv[..150], None, DVec3::ZERO, &options)?;
/// sums.merge(&PartialSums::of(&points[150..], &uv[150..], None, DVec3::ZERO, &options)?)?;
/// let surface = sums.solve(1e-9)?;
/// assert!(surface.point(0.3, 0.4).distance(DVec3::new(0.3, 0.4, 0.12)) < 1e-6);
/// # Ok::<(), neurbs::Error>(())
/// ```
#[derive(Clone)]
pub struct PartialSums {
    space: SplineSpace,
    origin: DVec3,
    extent: f64,
    count: u64,
    /// Sum of the weighted squared distances from the origin.
    squares: f64,
    lengths: LengthSums,
    /// The matrix of the normal equations, in the order of [`SplineSpace::each_pair`].
    matrix: Vec<f64>,
    right: Vec<[f64; 3]>,
}

/// The first bytes of saved sums: the kind of data and the version of the layout.
const MAGIC: &[u8; 17] = b"neurbs-fit-sums-1";

impl PartialSums {
    /// The sums over points at parameters, each with its weight, 1 without weights. Coordinates
    /// keep most digits relative to an `origin` near the points. Sums that are merged need the same
    /// origin. The fairness of the options is not used.
    ///
    /// # Errors
    ///
    /// Those of [`fit`](super::fit()), except that any number of points is allowed.
    pub fn of(
        points: &[DVec3],
        uv: &[DVec2],
        weights: Option<&[f64]>,
        origin: DVec3,
        options: &FitOptions,
    ) -> Result<Self> {
        check(points, uv, weights, options)?;
        let sums = install(|| PointSums::of(points, uv, weights, origin, options, &mut || Ok(())))?;
        let weight = |i: usize| weights.map_or(1.0, |weights| weights[i]);
        let distances = points.iter().map(|point| point.distance_squared(origin));
        let squares = distances.enumerate().map(|(i, square)| weight(i) * square).sum();
        let PointSums { space, origin, extent, count, equations, lengths } = sums;
        let mut matrix = Vec::new();
        space.each_pair(|[a, b]| matrix.push(equations.matrix.entry(a, b)));
        Ok(Self { space, origin, extent, count, squares, lengths, matrix, right: equations.right })
    }

    /// Adds the sums over other points.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if their knots or origins differ.
    pub fn merge(&mut self, other: &Self) -> Result<()> {
        if self.space != other.space || self.origin != other.origin {
            return Err(Error::parameter("sums", "over the same knots and origin", other.origin));
        }
        self.extent = self.extent.max(other.extent);
        self.count += other.count;
        self.squares += other.squares;
        self.lengths.merge(&other.lengths);
        self.matrix.iter_mut().zip(&other.matrix).for_each(|(sum, value)| *sum += value);
        let right = self.right.as_flattened_mut().iter_mut().zip(other.right.as_flattened());
        right.for_each(|(sum, value)| *sum += value);
        Ok(())
    }

    /// Number of points.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The surface with the least squared distances, with this weight of the thin-plate energy.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if the points do not determine the net, or the fairness is out of
    /// range; [`Error::Memory`] if there is too little memory.
    pub fn solve(&self, fairness: f64) -> Result<NurbsSurface> {
        let energy = Energy::new(self.lengths.lengths(), THIN_PLATE);
        self.solve_with(energy, fairness)
    }

    /// The surface with the least squared distances, with this weight of the energy of third
    /// derivatives over a domain of these lengths in space. It does not depend on the parts, up to
    /// rounding: [`Self::solve`] estimates the lengths from neighbors in each part.
    ///
    /// # Errors
    ///
    /// As [`Self::solve`].
    pub fn solve_over(&self, fairness: f64, lengths: (f64, f64)) -> Result<NurbsSurface> {
        if !(lengths.0 > 0.0 && lengths.1 > 0.0 && (lengths.0 + lengths.1).is_finite()) {
            let got = format!("{} and {}", lengths.0, lengths.1);
            return Err(Error::parameter("lengths", "two positive numbers", got));
        }
        self.solve_with(Energy::new(lengths, ORDER), fairness)
    }

    fn solve_with(&self, energy: Energy, fairness: f64) -> Result<NurbsSurface> {
        super::options::check_fairness(fairness)?;
        self.space.check_memory(1, 3)?;
        install(|| {
            let equations = Equations::with_energy(self.point_sums(), energy);
            equations.solve(fairness, &mut || Ok(()))
        })
    }

    /// The sums as band matrices.
    fn point_sums(&self) -> PointSums {
        let Self { space, origin, extent, count, lengths, .. } = self.clone();
        let (mut matrix, mut values) = (space.matrix(1), self.matrix.iter());
        space.each_pair(|[a, b]| matrix.add(a, b, values.next().copied().unwrap_or(0.0)));
        let equations = NormalEquations { matrix, right: self.right.clone() };
        PointSums { space, origin, extent, count, equations, lengths }
    }

    /// The sum of the weighted squared distances from the points to a surface with the same knots,
    /// at the points' parameters. Rounding adds some 1e-16 of the squared distances from the
    /// origin.
    ///
    /// ```
    /// use neurbs::{DVec2, DVec3, fit::{FitOptions, PartialSums}};
    /// let at = |i| DVec2::new(f64::from(i % 9) / 8.0, f64::from(i / 9) / 9.0);
    /// let uv: Vec<DVec2> = (0..90).map(at).collect();
    /// let points: Vec<DVec3> = uv.iter().map(|at| DVec3::new(at.x, at.y, 0.1)).collect();
    /// let options = FitOptions::new((4, 4), (3, 3), (false, false))?;
    /// let flat: Vec<DVec3> = points.iter().map(|point| point.with_z(0.0)).collect();
    /// let surface = PartialSums::of(&flat, &uv, None, DVec3::ZERO, &options)?.solve(1e-9)?;
    /// let sums = PartialSums::of(&points, &uv, None, DVec3::ZERO, &options)?;
    /// assert!((sums.squared_distance(&surface)? - 90.0 * 0.1 * 0.1).abs() < 1e-9);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if the knots differ, or the surface is rational.
    pub fn squared_distance(&self, surface: &NurbsSurface) -> Result<f64> {
        let [u, v] = &self.space.knots;
        if surface.weights().is_some() || surface.knots_u() != u || surface.knots_v() != v {
            let must = "polynomial, with the knots of the sums";
            let (rows, cols) = surface.shape();
            return Err(Error::parameter("surface", must, format!("a net {rows} × {cols}")));
        }
        let mut net = self.space.unknown_points(surface);
        for point in &mut net {
            *point -= self.origin;
        }
        let (mut sum, mut values) = (self.squares, self.matrix.iter());
        self.space.each_pair(|[a, b]| {
            let times = if a == b { 1.0 } else { 2.0 };
            sum += times * values.next().copied().unwrap_or(0.0) * net[a].dot(net[b]);
        });
        for (point, right) in net.iter().zip(&self.right) {
            sum -= 2.0 * point.dot(DVec3::from_array(*right));
        }
        Ok(sum.max(0.0))
    }
}

impl PartialSums {
    /// The sums as bytes for [`Self::from_bytes`], to save or send them.
    ///
    /// ```
    /// use neurbs::{DVec2, DVec3, fit::{FitOptions, PartialSums}};
    /// let (points, uv) = ([DVec3::X], [DVec2::new(0.3, 0.4)]);
    /// let options = FitOptions::new((5, 6), (3, 2), (false, true))?;
    /// let sums = PartialSums::of(&points, &uv, None, DVec3::ZERO, &options)?;
    /// let bytes = sums.to_bytes();
    /// assert_eq!(PartialSums::from_bytes(&bytes)?.to_bytes(), bytes);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = Writer(MAGIC.to_vec());
        for (knots, closed) in self.space.knots.iter().zip(self.space.closed) {
            out.count(knots.degree() as u64);
            out.reals(knots.as_slice());
            out.count(u64::from(closed));
        }
        out.points(&[self.origin]);
        out.count(self.count);
        out.reals(&[self.extent, self.squares]);
        out.reals(&self.lengths.to_array());
        out.reals(&self.matrix);
        out.reals(self.right.as_flattened());
        out.0
    }

    /// Reads sums that [`Self::to_bytes`] wrote.
    ///
    /// ```
    /// use neurbs::fit::PartialSums;
    /// assert!(PartialSums::from_bytes(b"others").is_err());
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if the bytes are not complete sums.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        read_saved(bytes, MAGIC, "sums", "saved sums", Self::read)
    }

    fn read(from: &mut Reader<'_>) -> Option<Self> {
        let mut side = || {
            let (degree, knots) = (from.size()?, from.reals()?);
            Some((KnotVector::new(degree, knots).ok()?, from.count()? == 1))
        };
        let ((u, closed_u), (v, closed_v)) = (side()?, side()?);
        let space = SplineSpace::new([u, v], [closed_u, closed_v]).ok()?;
        let [origin] = from.points()?[..] else { return None };
        let count = from.count()?;
        let [extent, squares] = from.reals()?[..] else { return None };
        let lengths = LengthSums::from_array(from.reals()?.try_into().ok()?);
        let (matrix, right) = (from.reals()?, from.reals()?);
        let mut pairs = 0;
        space.each_pair(|_| pairs += 1);
        let (triples, rest) = right.as_chunks::<3>();
        let complete =
            matrix.len() == pairs && triples.len() == space.unknowns() && rest.is_empty();
        let right = triples.to_vec();
        complete.then_some(Self { space, origin, extent, count, squares, lengths, matrix, right })
    }
}

#[cfg(test)]
mod tests {
    use super::super::least_squares::fit;
    use super::*;
    use crate::progress::Silent;

    fn tube() -> (Vec<DVec3>, Vec<DVec2>) {
        let uv: Vec<DVec2> = (0..900_u32)
            .map(|i| DVec2::new(f64::from(i * 7 % 900) / 900.0, f64::from(i) / 899.0))
            .collect();
        let place = |at: &DVec2| {
            let (sin, cos) = (std::f64::consts::TAU * at.x).sin_cos();
            DVec3::new(100.0 + cos, sin, 2.0 * at.y + 0.1 * cos * at.y)
        };
        (uv.iter().map(place).collect(), uv)
    }

    #[test]
    fn parts_give_the_surface_of_all_points_in_closed_directions_too() {
        let (points, uv) = tube();
        // With few distinct columns, functions overlap themselves around the tube.
        for columns in [4, 5, 7, 9] {
            let options = FitOptions::new((columns, 5), (3, 3), (true, false)).unwrap();
            let whole = fit(&points, &uv, None, &options, &mut Silent).unwrap();
            let sums = |from: usize, to: usize| {
                let origin = DVec3::new(100.0, 0.0, 1.0);
                PartialSums::of(&points[from..to], &uv[from..to], None, origin, &options).unwrap()
            };
            let mut parts = sums(0, 100);
            parts.merge(&sums(100, 101)).unwrap();
            parts.merge(&sums(101, 900)).unwrap();
            assert_eq!(parts.count(), 900);
            let surface = parts.solve(1e-9).unwrap();
            let distances = uv.iter().zip(&points).map(|(at, point)| {
                assert!(surface.point(at.x, at.y).distance(whole.point(at.x, at.y)) < 1e-3);
                surface.point(at.x, at.y).distance_squared(*point)
            });
            let expected: f64 = distances.sum();
            let got = parts.squared_distance(&surface).unwrap();
            assert!((got - expected).abs() < 1e-10 * (1.0 + expected), "{got} {expected}");
            assert!(parts.squared_distance(&whole).unwrap() >= got - 1e-10);
        }
    }

    #[test]
    fn given_lengths_make_the_surface_independent_of_the_parts() {
        let (points, uv) = tube();
        let options = FitOptions::new((9, 8), (3, 3), (true, false)).unwrap();
        let solved = |size: usize| {
            let mut parts = points.chunks(size).zip(uv.chunks(size)).map(|(points, uv)| {
                PartialSums::of(points, uv, None, DVec3::X * 100.0, &options).unwrap()
            });
            let mut sums = parts.next().unwrap();
            parts.for_each(|part| sums.merge(&part).unwrap());
            sums.solve_over(1e-6, (6.0, 2.0)).unwrap()
        };
        let whole = solved(900);
        for size in [7, 130] {
            for (got, wanted) in solved(size).control_points().iter().zip(whole.control_points()) {
                assert!(got.distance(*wanted) < 1e-9);
            }
        }
    }
}
