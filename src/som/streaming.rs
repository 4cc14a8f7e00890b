//! Training on points in chunks, in constant memory: parts of a large cloud, or samples of a
//! distribution.

use glam::DVec3;

use super::batch_sums::BatchSums;
use super::lattice::Lattice;
use super::map::SelfOrganizingMap;
use super::options::{SomOptions, Training};
use super::stop_criterion::StoppedBy;
use super::{batch, online};
use crate::cloud::{self, Bounds};
use crate::error::{Error, Result};
use crate::progress::Observer;

/// Points per node in an epoch of a distribution. The standard error of their mean is a sixth of
/// their standard deviation.
const EPOCH_PER_NODE: usize = 32;

/// Fewest points in an epoch of a distribution.
const MIN_EPOCH: usize = 4096;

/// Points drawn at a time: 1.5 MB.
const MAX_DRAW: usize = 1 << 16;

/// A function that draws the requested number of points from a distribution; see
/// [`SelfOrganizingMap::fit_distribution`].
pub type Sampler<'a> = dyn FnMut(usize) -> Result<Vec<DVec3>> + 'a;

impl SelfOrganizingMap {
    /// An untrained map for points in chunks. The first chunk determines the initial positions and
    /// the defaults of `reach` and `min_change`; it is not learned yet.
    ///
    /// ```
    /// # use neurbs::{DVec3, progress::Silent};
    /// # use neurbs::som::{Lattice, SelfOrganizingMap, SomOptions};
    /// # let point = |i| DVec3::new(f64::from(i % 20), f64::from(i / 20), f64::from(i % 7));
    /// # let points: Vec<DVec3> = (0..400).map(point).collect();
    /// let (lattice, options) = (Lattice::quad(5, 6)?, SomOptions::default());
    /// let mut som = SelfOrganizingMap::for_chunks(&points[..100], lattice, &options, &mut Silent)?;
    /// for chunk in points.chunks(100) {
    ///     let sums = som.sums(chunk, &mut Silent)?;
    ///     som.learn(&sums, &mut Silent)?;
    /// }
    /// assert_eq!(som.steps, 4);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Self::new`].
    pub fn for_chunks(
        first: &[DVec3],
        lattice: Lattice,
        options: &SomOptions,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let epoch = (EPOCH_PER_NODE * lattice.len()).max(MIN_EPOCH) as u64;
        let bounds = cloud::checked_bounds(first, observer)?;
        Self::within(&bounds, first, epoch, lattice, options, observer)
    }

    /// The sums over points of a batch epoch, or of any part of it. Merge parts with
    /// [`BatchSums::merge`] in any order; [`Self::learn`] then ends the epoch.
    ///
    /// ```
    /// use neurbs::{DVec3, progress::Silent};
    /// use neurbs::som::{Lattice, SelfOrganizingMap, SomOptions};
    /// let points: Vec<DVec3> = (0..400)
    ///     .map(|i| DVec3::new(f64::from(i % 20), f64::from(i / 20), f64::from(i % 7)))
    ///     .collect();
    /// let lattice = Lattice::quad(5, 5)?;
    /// let options = SomOptions::default();
    /// let mut som = SelfOrganizingMap::new(&points, lattice, &options, &mut Silent)?;
    /// let whole = som.sums(&points, &mut Silent)?;
    /// let mut parts = som.sums(&points[150..], &mut Silent)?;
    /// parts.merge(&som.sums(&points[..150], &mut Silent)?)?;
    /// assert_eq!(parts, whole);
    /// som.learn(&parts, &mut Silent)?;
    /// assert_eq!(som.steps, 1);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// - [`Error::NotFinite`] for a point that is not finite.
    /// - [`Error::Parameter`] if a point lies more than some hundred extents outside the first
    ///   points.
    /// - [`Error::Interrupted`] if the observer stops it.
    pub fn sums(&self, points: &[DVec3], observer: &mut dyn Observer) -> Result<BatchSums> {
        let bounds = self.check_chunk(points, observer)?;
        let ordered = batch::order(self, points, &bounds, observer)?;
        batch::accumulate(self, &ordered, observer)
    }

    /// Ends an epoch of batch training: moves the nodes to the smoothed means of the sums. The
    /// radius is that of the next step.
    ///
    /// ```
    /// # use neurbs::{DVec3, progress::Silent};
    /// # use neurbs::som::{Lattice, SelfOrganizingMap, SomOptions};
    /// # let point = |i| DVec3::new(f64::from(i % 20), f64::from(i / 20), f64::from(i % 7));
    /// # let points: Vec<DVec3> = (0..400).map(point).collect();
    /// let (lattice, options) = (Lattice::quad(5, 6)?, SomOptions::default());
    /// let mut som = SelfOrganizingMap::new(&points, lattice, &options, &mut Silent)?;
    /// let sums = som.sums(&points, &mut Silent)?;
    /// som.learn(&sums, &mut Silent)?;
    /// // They were sums of the lattice before.
    /// assert!(som.learn(&sums, &mut Silent).is_err());
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if the sums are empty, or belong to another map or state;
    /// [`Error::Interrupted`] if the observer stops after this epoch.
    pub fn learn(&mut self, sums: &BatchSums, observer: &mut dyn Observer) -> Result<()> {
        sums.check(&self.frame, self.nodes.len(), self.steps)?;
        if sums.points() == 0 {
            return Err(Error::parameter("sums", "of at least one point", "none"));
        }
        batch::end_epoch(self, sums, observer)?
    }

    /// Presents points in online training, each once, in order. Gain and radius continue from the
    /// steps already done.
    ///
    /// ```
    /// # use neurbs::{DVec3, progress::Silent};
    /// # use neurbs::som::{Lattice, SelfOrganizingMap, SomOptions, Training};
    /// # let point = |i| DVec3::new(f64::from(i % 20), f64::from(i / 20), f64::from(i % 7));
    /// # let points: Vec<DVec3> = (0..400).map(point).collect();
    /// let options = SomOptions { training: Training::Online, ..SomOptions::default() };
    /// let mut som = SelfOrganizingMap::new(&points, Lattice::quad(5, 6)?, &options, &mut Silent)?;
    /// som.present(&points[..100], &mut Silent)?;
    /// assert_eq!(som.steps, 100);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Self::sums`]. Presentations before an interruption are kept.
    pub fn present(&mut self, points: &[DVec3], observer: &mut dyn Observer) -> Result<()> {
        self.check_chunk(points, observer)?;
        online::present_chunk(self, points, observer)
    }

    /// Learns a distribution from a sampler, which returns the requested number of points. At most
    /// 65,536 points are in memory at a time.
    ///
    /// The first points determine the initial positions, as in [`Self::for_chunks`]. An epoch has
    /// 32 points per node, at least 4096. Training ends when the nodes have settled or all steps
    /// are done. `reach` is not used, because the points of a distribution are never all on the
    /// lattice (section 4 of the paper).
    ///
    /// ```
    /// use neurbs::{DVec3, progress::Silent};
    /// use neurbs::som::{Lattice, SelfOrganizingMap, SomOptions};
    /// let mut drawn = 0_u32;
    /// let mut sampler = |count: usize| {
    ///     let points = (0..count).map(|_| {
    ///         drawn += 1;
    ///         let (x, y) = (f64::from(drawn) * 0.618_034, f64::from(drawn) * 0.754_878);
    ///         DVec3::new(x.fract(), y.fract(), 0.0)
    ///     });
    ///     Ok(points.collect())
    /// };
    /// let (lattice, options) = (Lattice::quad(8, 8)?, SomOptions::default());
    /// let som = SelfOrganizingMap::fit_distribution(&mut sampler, lattice, &options, &mut Silent)?;
    /// assert!(som.error.is_some_and(|error| error < 0.1));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// - Those of the sampler.
    /// - [`Error::Parameter`] if it returns another number of points than requested.
    /// - [`Error::NotFinite`] for a point that is not finite.
    /// - [`Error::Interrupted`] if the observer stops it.
    pub fn fit_distribution(
        sampler: &mut Sampler<'_>,
        lattice: Lattice,
        options: &SomOptions,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let first = draw(sampler, MIN_EPOCH)?;
        let mut map = Self::for_chunks(&first, lattice, options, observer)?;
        map.train_on_distribution(sampler, observer)?;
        Ok(map)
    }

    /// Continues training on a distribution until the nodes have settled or all steps are done.
    /// Start with [`Self::for_chunks`].
    ///
    /// # Errors
    ///
    /// As [`Self::fit_distribution`]. The map keeps the finished epochs. If the sampler then
    /// continues with the points after those, the result has the same bits as without the
    /// interruption.
    pub fn train_on_distribution(
        &mut self,
        sampler: &mut Sampler<'_>,
        observer: &mut dyn Observer,
    ) -> Result<()> {
        let epoch = usize::try_from(self.plan.epoch_points).unwrap_or(usize::MAX);
        while self.stopped_by == StoppedBy::Unfinished {
            // An interrupted epoch is undone as a whole, so that it can be drawn again.
            let before = self.clone();
            let shown =
                self.draw_epoch(epoch, sampler, observer).inspect_err(|_| *self = before)?;
            if self.settled() {
                self.stopped_by = StoppedBy::Settled;
            }
            self.stop_at_last_step();
            shown?;
        }
        Ok(())
    }

    /// Draws and learns one epoch. The inner result is the observer's answer after it.
    fn draw_epoch(
        &mut self,
        epoch: usize,
        sampler: &mut Sampler<'_>,
        observer: &mut dyn Observer,
    ) -> Result<Result<()>> {
        let mut sums = BatchSums::new(self.frame, self.nodes.len(), self.steps);
        let left = usize::try_from(self.plan.max_steps.saturating_sub(self.steps));
        let (total, online) = match self.plan.training {
            Training::Batch => (epoch, false),
            Training::Online => (epoch.min(left.unwrap_or(usize::MAX)), true),
        };
        let mut drawn = 0;
        while drawn < total {
            let points = draw(sampler, MAX_DRAW.min(total - drawn))?;
            drawn += points.len();
            if online {
                self.present(&points, observer)?;
            } else {
                sums.merge(&self.sums(&points, observer)?)?;
            }
        }
        if online { Ok(Ok(())) } else { batch::end_epoch(self, &sums, observer) }
    }

    /// Checks later points and returns their bounds.
    fn check_chunk(&self, points: &[DVec3], observer: &mut dyn Observer) -> Result<Bounds> {
        if points.is_empty() {
            return Err(Error::parameter("points", "at least one", "none"));
        }
        let bounds = cloud::finite_bounds(points, &mut || self.report(observer))?;
        self.frame.check(&bounds)?;
        Ok(bounds)
    }
}

fn draw(sampler: &mut Sampler<'_>, count: usize) -> Result<Vec<DVec3>> {
    let points = sampler(count)?;
    if points.len() == count {
        return Ok(points);
    }
    let must = format!("a source of as many points as asked for, {count}");
    Err(Error::parameter("sampler", must, points.len()))
}
