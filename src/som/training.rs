//! Training on a whole cloud, by the batch map or the paper's online algorithm.

use glam::DVec3;

use super::frame::Frame;
use super::lattice::Lattice;
use super::map::SelfOrganizingMap;
use super::options::{SomOptions, Training};
use super::{batch, online};
use crate::cloud::{self, Bounds};
use crate::error::{Error, Result};
use crate::progress::Observer;

impl SelfOrganizingMap {
    /// Trains a lattice on scattered points: [`Self::new`], then [`Self::train`].
    ///
    /// ```
    /// # use neurbs::{DVec3, progress::Silent};
    /// # use neurbs::som::{Lattice, SelfOrganizingMap, SomOptions};
    /// # let point = |i| DVec3::new(f64::from(i % 20), f64::from(i / 20), f64::from(i % 7));
    /// # let points: Vec<DVec3> = (0..400).map(point).collect();
    /// let options = SomOptions { epochs: Some(10), ..SomOptions::default() };
    /// let som = SelfOrganizingMap::fit(&points, Lattice::quad(5, 6)?, &options, &mut Silent)?;
    /// assert_eq!((som.steps, som.codebook().len()), (10, 30));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Those of [`Self::new`]; [`Error::Interrupted`] if the observer stops it.
    pub fn fit(
        points: &[DVec3],
        lattice: Lattice,
        options: &SomOptions,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let bounds = cloud::checked_bounds(points, observer)?;
        Self::fit_within(&bounds, points, lattice, options, observer)
    }

    /// As [`Self::fit`], for checked points within `bounds`.
    pub(crate) fn fit_within(
        bounds: &Bounds,
        points: &[DVec3],
        lattice: Lattice,
        options: &SomOptions,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let mut map = Self::over(bounds, points, lattice, options, observer)?;
        map.train_within(bounds, points, observer)?;
        Ok(map)
    }

    /// Continues the training on the map's own points until one of step 7's criteria ends it. A
    /// finished map stays unchanged.
    ///
    /// The same seed gives the same bits on any number of threads. On a grid, a step of online
    /// training costs O(m), an epoch of batch training O(n log m + m (rows + cols)).
    ///
    /// ```
    /// # use neurbs::{DVec3, progress::Silent};
    /// # use neurbs::som::{Lattice, SelfOrganizingMap, SomOptions};
    /// # let point = |i| DVec3::new(f64::from(i % 20), f64::from(i / 20), f64::from(i % 7));
    /// # let points: Vec<DVec3> = (0..400).map(point).collect();
    /// # let (lattice, options) = (Lattice::quad(5, 6)?, SomOptions::default());
    /// # let mut som = SelfOrganizingMap::fit(&points, lattice, &options, &mut Silent)?;
    /// // It has ended, and stays as it is.
    /// let before = som.clone();
    /// som.train(&points, &mut Silent)?;
    /// assert_eq!(som, before);
    /// assert!(som.train(&points[1..], &mut Silent).is_err());
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// - [`Error::Interrupted`] if the observer stops it. The map then keeps its state, and
    ///   training can continue with the same result as without the interruption.
    /// - [`Error::Parameter`] if these are not the points that the map was created for.
    pub fn train(&mut self, points: &[DVec3], observer: &mut dyn Observer) -> Result<()> {
        let bounds = cloud::finite_bounds(points, &mut || self.report(observer))?;
        let same =
            points.len() as u64 == self.plan.epoch_points && Frame::of(&bounds) == self.frame;
        if !same {
            let must = format!("the {} points that the map was made for", self.plan.epoch_points);
            return Err(Error::parameter("points", must, format!("{} others", points.len())));
        }
        self.train_within(&bounds, points, observer)
    }

    fn train_within(
        &mut self,
        bounds: &Bounds,
        points: &[DVec3],
        observer: &mut dyn Observer,
    ) -> Result<()> {
        match self.plan.training {
            Training::Batch => batch::train(self, points, bounds, observer),
            Training::Online => online::train(self, points, bounds, observer),
        }
    }
}
