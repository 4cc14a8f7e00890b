//! Batch training on a cloud whose parts lie in several files, processes or machines.

use glam::DVec3;

use super::batch;
use super::batch_sums::BatchSums;
use super::lattice::Lattice;
use super::map::SelfOrganizingMap;
use super::options::{SomOptions, Training};
use super::sampling::start_indices;
use super::stop_criterion::StoppedBy;
use crate::cloud::{self, Bounds};
use crate::error::{Error, Result};
use crate::progress::Observer;

impl SelfOrganizingMap {
    /// Indices of the points, of `count` in all, that determine the initial positions, ascending.
    /// They are all points, or some 2^16 of more.
    ///
    /// ```
    /// use neurbs::SelfOrganizingMap;
    /// assert_eq!(SelfOrganizingMap::start_indices(4), [0, 1, 2, 3]);
    /// assert_eq!(SelfOrganizingMap::start_indices(10_000_000).len(), 65_360);
    /// ```
    #[must_use]
    pub fn start_indices(count: u64) -> Vec<u64> {
        start_indices(count)
    }

    /// An untrained map for a cloud of `count` points within `bounds`, from the points at
    /// [`Self::start_indices`]. It is the map that [`Self::new`] makes of all points.
    ///
    /// With [`Self::sums`] of parts, [`BatchSums::merge`] and [`Self::train_epoch`], training has
    /// the bits of [`Self::fit`].
    ///
    /// ```
    /// use neurbs::{DVec3, cloud::Bounds, progress::Silent};
    /// use neurbs::som::{Lattice, SelfOrganizingMap, SomOptions};
    /// let point = |i| DVec3::new(f64::from(i % 20), f64::from(i / 20), f64::from(i % 7));
    /// let points: Vec<DVec3> = (0..400).map(point).collect();
    /// let (lattice, options) = (Lattice::quad(5, 6)?, SomOptions::default());
    /// let (bounds, silent) = (Bounds::of(&points), &mut Silent);
    /// let whole = lattice.clone();
    /// let mut som = SelfOrganizingMap::for_parts(&bounds, &points, 400, lattice, &options, silent)?;
    /// loop {
    ///     let mut sums = som.sums(&points[..150], silent)?;
    ///     sums.merge(&som.sums(&points[150..], silent)?)?;
    ///     if som.train_epoch(&sums, silent)? {
    ///         break;
    ///     }
    /// }
    /// assert_eq!(som, SelfOrganizingMap::fit(&points, whole, &options, silent)?);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Self::new`]; [`Error::Parameter`] if another number of points is at the start.
    pub fn for_parts(
        bounds: &Bounds,
        start: &[DVec3],
        count: u64,
        lattice: Lattice,
        options: &SomOptions,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let needed = start_indices(count).len();
        if start.len() != needed {
            let must = format!("{needed} points, those of start_indices({count})");
            return Err(Error::parameter("start", must, start.len()));
        }
        cloud::checked_bounds(start, observer)?;
        Self::within(bounds, start, count, lattice, options, observer)
    }

    /// Ends an epoch of batch training with the sums over all points, as [`Self::train`] does.
    /// Returns whether the training has ended; then sums have no effect.
    ///
    /// # Errors
    ///
    /// - [`Error::Parameter`] if the sums belong to another map or state, or are not over all
    ///   points, or training is online.
    /// - [`Error::Interrupted`] if the observer stops after this epoch.
    pub fn train_epoch(&mut self, sums: &BatchSums, observer: &mut dyn Observer) -> Result<bool> {
        if self.training() == Training::Online {
            return Err(Error::parameter("training", "batch for points in parts", "online"));
        }
        if self.stopped_by == StoppedBy::Unfinished {
            sums.check(&self.frame, self.nodes.len(), self.steps)?;
            if sums.points() != self.plan.epoch_points {
                let must = format!("over all {} points", self.plan.epoch_points);
                return Err(Error::parameter("sums", must, sums.points()));
            }
            batch::train_epoch(self, sums, observer)?;
        }
        Ok(self.stopped_by != StoppedBy::Unfinished)
    }
}

#[cfg(test)]
mod tests {
    use super::super::sampling::START_POINTS;
    use super::*;

    #[test]
    fn starts_have_one_point_of_each_run() {
        for count in [1, 7, 65_536, 65_537, 200_000, 10_000_000] {
            let indices = start_indices(count);
            assert!(indices.len() <= START_POINTS && 2 * indices.len() as u64 >= count.min(65_536));
            assert!(indices.windows(2).all(|pair| pair[0] < pair[1]));
            assert!(indices.last().is_some_and(|last| *last < count));
        }
        // Every column of a grid is there.
        let mut columns: Vec<u64> = start_indices(1_000_000).iter().map(|i| i % 1000).collect();
        columns.sort_unstable();
        columns.dedup();
        assert_eq!(columns.len(), 1000);
    }
}
