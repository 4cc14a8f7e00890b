//! Bézier patches and closed (periodic) surfaces from a net alone.

use glam::DVec3;

use super::knot_vector::KnotVector;
use super::surface::NurbsSurface;
use crate::error::{Error, Result};

impl NurbsSurface {
    /// Builds the Bézier patch of a net, of degree `rows - 1` × `cols - 1`.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface};
    /// let net = vec![DVec3::ZERO, DVec3::Y, DVec3::X, DVec3::ONE];
    /// let patch = NurbsSurface::bezier(net, None, (2, 2))?;
    /// assert_eq!(patch.point(0.5, 0.5), DVec3::new(0.5, 0.5, 0.25));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a side does not have 2 to 10 control points; [`Error::Net`] as
    /// [`NurbsSurface::new`].
    pub fn bezier(
        net: Vec<DVec3>,
        weights: Option<Vec<f64>>,
        (rows, cols): (usize, usize),
    ) -> Result<Self> {
        let knots = |count: usize| KnotVector::clamped_uniform(count.saturating_sub(1), count);
        Self::new(net, weights, knots(rows)?, knots(cols)?)
    }

    /// Builds a surface that is smoothly closed in the given directions, with evenly spaced knots
    /// on `[0, 1]²`.
    ///
    /// `net` contains each row and column once; the first ones are repeated here.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface};
    /// let ring = |i: i32, z: i32| DVec3::new(f64::from(i).cos(), f64::from(i).sin(), f64::from(z));
    /// let net: Vec<_> = (0..6).flat_map(|i| (0..3).map(move |z| ring(i, z))).collect();
    /// let tube = NurbsSurface::periodic(&net, None, (6, 3), (3, 2), (true, false))?;
    /// assert_eq!((tube.shape(), tube.closed()), ((9, 3), (true, false)));
    /// assert!(tube.point(0.0, 0.4).distance(tube.point(1.0, 0.4)) < 1e-15);
    /// assert!(tube.normal(0.0, 0.4).distance(tube.normal(1.0, 0.4)) < 1e-14);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a side has at most `degree` control points; [`Error::Net`] as
    /// [`NurbsSurface::new`].
    pub fn periodic(
        net: &[DVec3],
        weights: Option<&[f64]>,
        (rows, cols): (usize, usize),
        degrees: (usize, usize),
        closed: (bool, bool),
    ) -> Result<Self> {
        let knots = |degree, count, closed| {
            if closed {
                KnotVector::periodic_uniform(degree, count)
            } else {
                KnotVector::clamped_uniform(degree, count)
            }
        };
        let (u, v) = (knots(degrees.0, rows, closed.0)?, knots(degrees.1, cols, closed.1)?);
        if net.len() != rows * cols {
            let got = format!("{} were given for a shape of {rows} × {cols}", net.len());
            return Err(Error::Net {
                must: "have as many control points as its shape requires",
                got,
            });
        }
        let place = |k: usize| {
            let (i, j) = (k / v.control_points(), k % v.control_points());
            (i % rows) * cols + j % cols
        };
        let count = u.control_points() * v.control_points();
        if let Some(weights) = weights.filter(|weights| weights.len() != net.len()) {
            let got = format!("{} weights were given for {} points", weights.len(), net.len());
            return Err(Error::Net { must: "have one weight for each control point", got });
        }
        let weights = weights.map(|weights| (0..count).map(|k| weights[place(k)]).collect());
        Self::new((0..count).map(|k| net[place(k)]).collect(), weights, u, v)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_directions_are_smooth_at_the_seam() {
        let net: Vec<DVec3> = (0..35)
            .map(|i| DVec3::new(f64::from(i).sin(), f64::from(i * i % 7), f64::from(i % 5)))
            .collect();
        let weights: Vec<f64> = (0..35).map(|i| 1.0 + f64::from(i % 3)).collect();
        for degree in 2..=4 {
            let both = (true, true);
            let shape = (degree, degree);
            let closed = NurbsSurface::periodic(&net, Some(&weights), (7, 5), shape, both);
            let closed = closed.unwrap();
            assert_eq!(closed.closed(), both);
            for t in [0.0, 0.21, 0.7] {
                for ((a, b), (c, d)) in [((0.0, t), (1.0, t)), ((t, 0.0), (t, 1.0))] {
                    assert!(closed.point(a, b).distance(closed.point(c, d)) < 1e-13);
                    let (start, end) = (closed.partials(a, b), closed.partials(c, d));
                    assert!(start.u.distance(end.u) < 1e-11 && start.v.distance(end.v) < 1e-11);
                    assert!(closed.normal(a, b).distance(closed.normal(c, d)) < 1e-12);
                }
            }
        }
    }
}
