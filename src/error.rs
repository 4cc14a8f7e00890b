//! The one error type of the crate.

use glam::DVec3;

use crate::numeric::Short;

/// All errors of the crate. Each message gives the rule, the value that breaks it, and a remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A coordinate is NaN or infinite.
    ///
    /// ```
    /// use neurbs::{DVec3, Error, cloud};
    /// let points = [DVec3::ZERO, DVec3::new(0.0, f64::NAN, 1.0)];
    /// let error = cloud::check(&points).unwrap_err();
    /// assert!(matches!(error, Error::NotFinite { index: 1, .. }));
    /// ```
    #[error(
        "points must be finite, but point {index} is ({}, {}, {}): remove or repair it",
        point.x, point.y, point.z
    )]
    NotFinite {
        /// Index in the input, from 0.
        index: usize,
        /// The point.
        point: DVec3,
    },

    /// There are too few distinct points for a surface.
    ///
    /// ```
    /// use neurbs::{DVec3, Error, cloud};
    /// let error = cloud::check(&[DVec3::X, DVec3::Y, DVec3::X]).unwrap_err();
    /// assert!(matches!(error, Error::TooFewPoints { distinct: 2, given: 3, .. }));
    /// ```
    #[error(
        "a surface needs at least {needed} distinct points, got {distinct} (of {given} given): \
         add points"
    )]
    TooFewPoints {
        /// Number of distinct points that are needed.
        needed: usize,
        /// Number of distinct points.
        distinct: usize,
        /// Number of given points.
        given: usize,
    },

    /// All points coincide.
    ///
    /// ```
    /// use neurbs::{DVec3, Error, cloud};
    /// let error = cloud::check(&[DVec3::ONE; 5]).unwrap_err();
    /// assert!(matches!(error, Error::AllEqual { given: 5, .. }));
    /// ```
    #[error(
        "points must differ, but all {given} are ({}, {}, {}): check which columns were read",
        Short(point.x), Short(point.y), Short(point.z)
    )]
    AllEqual {
        /// Number of given points.
        given: usize,
        /// The place of all points.
        point: DVec3,
    },

    /// All points lie on one straight line.
    ///
    /// ```
    /// use neurbs::{DVec3, Error, cloud};
    /// let points: Vec<DVec3> = (0..9).map(|i| DVec3::splat(f64::from(i))).collect();
    /// let error = cloud::check(&points).unwrap_err();
    /// assert!(matches!(error, Error::Collinear { given: 9, .. }));
    /// ```
    #[error(
        "points must span a surface, but all {given} lie on one line \
         (length {length:.3e}, width {width:.1e}): add points beside it, or subtract an offset from \
         large coordinates, whose small digits may be lost"
    )]
    Collinear {
        /// Number of given points.
        given: usize,
        /// Extent along the line, in the points' unit.
        length: f64,
        /// Largest distance from the line, in the points' unit.
        width: f64,
    },

    /// The extent of the cloud is so large or small that squared areas overflow or vanish.
    ///
    /// ```
    /// use neurbs::{DVec3, Error, cloud};
    /// let points = [DVec3::ZERO, DVec3::X * 1e200, DVec3::Y * 1e200, DVec3::ONE];
    /// assert!(matches!(cloud::check(&points), Err(Error::Extent { .. })));
    /// ```
    #[error(
        "points must extend between {least:e} and {most:e}, but extend {extent:e}: change their unit"
    )]
    Extent {
        /// Largest side of the bounding box, in the points' unit.
        extent: f64,
        /// Smallest extent allowed.
        least: f64,
        /// Largest extent allowed.
        most: f64,
    },

    /// An option or argument is out of its range.
    ///
    /// ```
    /// use neurbs::{Error, som::Lattice};
    /// let error = Lattice::quad(1, 8).unwrap_err();
    /// assert!(matches!(error, Error::Parameter { name: "grid", .. }));
    /// assert!(error.to_string().contains("got (1, 8)"));
    /// ```
    #[error("{name} must be {must}, got {got}")]
    Parameter {
        /// Name of the option or argument.
        name: &'static str,
        /// The condition.
        must: String,
        /// The value that was given.
        got: String,
    },

    /// A knot vector is invalid, or does not match its degree.
    ///
    /// ```
    /// use neurbs::{Error, nurbs::KnotVector};
    /// let error = KnotVector::new(1, vec![0.0, 0.0, 1.0, 0.5]).unwrap_err();
    /// assert!(error.to_string().contains("knot 3 is 0.5 after 1"));
    /// ```
    #[error("a knot vector of degree {degree} must {must}, but {got}")]
    Knots {
        /// The degree.
        degree: usize,
        /// The condition.
        must: &'static str,
        /// The value that was given.
        got: String,
    },

    /// Control points, weights and knots do not match.
    ///
    /// ```
    /// use neurbs::{DVec3, Error, nurbs::{KnotVector, NurbsSurface}};
    /// let knots = KnotVector::clamped_uniform(1, 2)?;
    /// let error = NurbsSurface::new(vec![DVec3::ZERO; 3], None, knots.clone(), knots).unwrap_err();
    /// assert!(error.to_string().contains("3 control points"));
    /// # Ok::<(), Error>(())
    /// ```
    #[error("a control net must {must}, but {got}")]
    Net {
        /// The condition.
        must: &'static str,
        /// The value that was given.
        got: String,
    },

    /// A loop of a face is open, crosses itself, or lies in the wrong place.
    ///
    /// ```
    /// use neurbs::{DVec3, Error, Face, nurbs::{NurbsCurve, NurbsSurface}};
    /// let plane = NurbsSurface::plane(DVec3::ZERO, DVec3::X, DVec3::Y)?;
    /// let open = vec![NurbsCurve::line(DVec3::ZERO, DVec3::X)?];
    /// let error = Face::trimmed(plane, vec![open]).unwrap_err();
    /// assert!(error.to_string().contains("loop 0 of a face must be closed"));
    /// # Ok::<(), Error>(())
    /// ```
    #[error("loop {index} of a face must {must}, but {got}")]
    Loop {
        /// The index of the loop; 0 is the outer one.
        index: usize,
        /// The condition.
        must: &'static str,
        /// The curve or place that breaks it.
        got: String,
    },

    /// Faces do not fit together in a shell.
    ///
    /// ```
    /// use neurbs::{DVec3, Error, Face, NurbsSurface, Shell};
    /// let plane = Face::whole(NurbsSurface::plane(DVec3::ZERO, DVec3::X, DVec3::Y)?)?;
    /// let error = Shell::new(vec![plane.clone(), plane], None).unwrap_err();
    /// assert!(matches!(error, Error::Shell { .. }));
    /// # Ok::<(), Error>(())
    /// ```
    #[error("a shell must {must}, but {got}")]
    Shell {
        /// The condition.
        must: &'static str,
        /// The faces and the place that break it.
        got: String,
    },

    /// A call needs more memory than is available.
    ///
    /// ```
    /// let what = "a lattice of 4000 × 4000 nodes".to_string();
    /// let error = neurbs::Error::Memory { what, bytes: 8_192_000_000 };
    /// assert_eq!(
    ///     error.to_string(),
    ///     "a lattice of 4000 × 4000 nodes needs about 8.2 GB of memory, more than is available: \
    ///      ask for less"
    /// );
    /// ```
    #[error(
        "{what} needs about {:.1} GB of memory, more than is available: ask for less",
        *bytes as f64 / 1e9
    )]
    Memory {
        /// What needs the memory.
        what: String,
        /// Bytes that it needs.
        bytes: u128,
    },

    /// The observer stopped a long job.
    ///
    /// ```
    /// use neurbs::{DVec3, Error, ReconstructOptions, reconstruct};
    /// use std::ops::ControlFlow;
    /// let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ONE];
    /// let stop = |_: &neurbs::Progress| ControlFlow::Break(());
    /// let result = reconstruct(&corners, &ReconstructOptions::default(), &mut { stop });
    /// assert!(matches!(result, Err(Error::Interrupted)));
    /// ```
    #[error("the job was stopped by its observer")]
    Interrupted,

    /// A file could not be written.
    ///
    /// ```
    /// let full: neurbs::Error = std::io::Error::other("disk full").into();
    /// assert_eq!(full.to_string(), "disk full");
    /// ```
    #[error(transparent)]
    Io(#[from] std::io::Error),
}

/// A result of this crate.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// The error of an option or argument: `{name} must be {must}, got {got}`.
    pub(crate) fn parameter(
        name: &'static str,
        must: impl Into<String>,
        got: impl std::fmt::Display,
    ) -> Self {
        Self::Parameter { name, must: must.into(), got: got.to_string() }
    }
}

/// Checks that an option is a positive, finite number.
pub(crate) fn positive(name: &'static str, value: f64) -> Result<f64> {
    if value > 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(Error::parameter(name, "positive and finite", Short(value)))
    }
}
