//! The points that a surface is fitted to.

use std::cmp::Ordering;

use glam::DVec3;
use rayon::prelude::*;

use super::ReconstructOptions;
use super::own_frame::Frame;
use super::units::Units;
use crate::cloud::{
    self, EvenSample, Fate, Neighborhoods, NoData, Pieces, across_lines, hang_together,
    pieces_across, rough_sample,
};
use crate::diagnostic::Diagnostic;
use crate::error::{Error, Result};
use crate::progress::{self, Observer, Progress, Stage};
use crate::validate;

/// A surface is fitted to this many points at most, chosen evenly over space: enough for as many
/// control points as are allowed by default, and little memory beside that of many more points.
const MOST: usize = 1 << 20;

/// Points, evenly over space, that tell what the cloud is like, and how many of these whether it
/// falls into pieces.
const TELLING: (usize, usize) = (20_000, 4000);

/// How many times smaller than the largest a piece may be that is as good as the largest to choose.
const LARGE: usize = 3;

/// Points that a piece has at least, and one of how many of all: fewer are no surface, but strays that
/// cleaning could not tell from one.
const FEWEST: usize = 4;
const RAREST: usize = 1000;

/// Points that are chosen from between two reports.
const PORTION: usize = 1 << 17;

/// The points that a surface is fitted to, by what their coordinates count, in an order that depends neither on how they came nor on
/// how they lie in space: from the farthest from the centroid to the nearest, so that equal steps
/// in it are spread evenly over the cloud.
pub(super) struct Counted {
    pub(super) points: Vec<DVec3>,
    /// What each one's squared distance counts; `None`: 1.
    pub(super) weights: Option<Vec<f64>>,
    /// Their places in the cloud.
    pub(super) indices: Vec<u32>,
    /// Some of them, evenly over space, in such an order too.
    pub(super) telling: Vec<DVec3>,
    /// What is near each of these, if they are few.
    pub(super) known: Option<Neighborhoods>,
    /// How many points were merged with others, and how many left out as gross outliers, of those
    /// that were looked at.
    pub(super) duplicates: usize,
    pub(super) outliers: usize,
    /// What is known of their pieces, if they do not hang together.
    pub(super) apart: Option<Apart>,
    /// Whether only few points have shown that they do.
    glimpsed: bool,
    /// Those that show a surface where all are in ropes.
    across: Option<Vec<DVec3>>,
    /// Whether points lie in two layers closer together than their spacing.
    pub(super) double: bool,
    /// Whether there are more points than were looked at.
    pub(super) thinned: bool,
    pub(super) diagnostics: Vec<Diagnostic>,
}

/// What is known of points that do not hang together.
pub(super) struct Apart {
    /// Points of each, the largest first.
    pub(super) sizes: Vec<usize>,
    /// What they are, if they are layers.
    pub(super) layers: Layers,
    /// How many are not much smaller than the largest.
    pub(super) large: usize,
}

/// Pieces that may lie above one another.
#[derive(Clone, Copy)]
pub(super) struct Layers {
    /// The normal of the plane nearest to the largest.
    pub(super) normal: DVec3,
    /// The smallest distance between two.
    pub(super) gap: f64,
}

impl Layers {
    pub(super) fn within(self, frame: &Frame) -> Self {
        Self { normal: frame.direction(self.normal), gap: frame.counted_length(self.gap) }
    }
}

impl Apart {
    fn of(found: &Pieces, points: &[DVec3]) -> Option<Self> {
        let fewest = FEWEST.max(points.len() / RAREST);
        if found.sizes.iter().filter(|&&size| size >= fewest).count() < 2 {
            return None;
        }
        let large = found.sizes.iter().filter(|&&size| LARGE * size >= found.sizes[0]).count();
        let layers = Layers { normal: found.normal_of_largest(points), gap: found.gap };
        Some(Self { sizes: found.sizes.clone(), layers, large })
    }
}

impl Counted {
    pub(super) fn of(
        cloud: &[DVec3],
        no_data: Option<NoData>,
        units: &Units,
        options: &ReconstructOptions<'_>,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let of_cloud = |indices: &[u32]| -> Vec<DVec3> {
            indices.iter().map(|&index| units.apply(cloud[index as usize])).collect()
        };
        let mut indices = looked_at(cloud, observer)?;
        let given = indices.len();
        indices.retain(|&index| !no_data.is_some_and(|found| found.has(cloud[index as usize])));
        let (mut duplicates, mut outliers) = (0, given - indices.len());
        let mut diagnostics = Vec::new();
        if let Some(NoData { value, count, .. }) = no_data {
            diagnostics.push(Diagnostic::NoData { value, count });
        }
        if units.differ() && options.axis_scale.is_none() {
            diagnostics.push(Diagnostic::MixedUnits { scale: units.by.recip().to_array() });
        }
        let mut weights = options.weights.map(|weights| of(weights, &indices));
        if let Some(given) = &mut weights {
            let counts: Vec<bool> = given.iter().map(|weight| *weight > 0.0).collect();
            keep(&mut indices, &counts);
            keep(given, &counts);
            cloud::check(&of_cloud(&indices))?;
        }
        if options.clean {
            let found = cloud::clean(&of_cloud(&indices), observer)?;
            duplicates = found.count(Fate::Duplicate);
            outliers += found.count(Fate::Outlier);
            if !found.multiplicity.is_empty() {
                let given = weights.take().map(|weights| of(&weights, &found.kept));
                let counted = found.multiplicity.iter().enumerate();
                let weight = |i: usize| given.as_ref().map_or(1.0, |given| given[i]);
                weights = Some(counted.map(|(i, &n)| f64::from(n) * weight(i)).collect());
            } else if let Some(given) = weights {
                weights = Some(of(&given, &found.kept));
            }
            indices = of(&indices, &found.kept);
        }
        let mut points = of_cloud(&indices);
        let mut telling = telling_of(&points);
        let (mut one, mut known, mut across) = (false, None, None);
        if options.component.is_none() {
            let few = rough_sample(&telling, TELLING.1);
            let near;
            (one, near) = hang_together(&few, observer)?;
            known = Some(near).filter(|_| few.len() == telling.len());
        }
        let found = if one {
            None
        } else {
            let found;
            (found, across) = pieces_across(&points, observer)?;
            Some(found)
        };
        let glimpsed = found.is_none() && telling.len() > TELLING.1;
        let mut apart = None;
        match (options.component, found) {
            (None, None) => {}
            (None, Some(found)) => apart = Apart::of(&found, &points),
            (Some(piece), Some(found)) if piece < found.sizes.len() => {
                let chosen: Vec<bool> =
                    found.labels.iter().map(|&label| label as usize == piece).collect();
                keep(&mut indices, &chosen);
                keep(&mut points, &chosen);
                telling = telling_of(&points);
                if across.is_some() {
                    across = pieces_across(&telling, observer)?.1;
                }
                if let Some(weights) = &mut weights {
                    keep(weights, &chosen);
                }
            }
            (Some(piece), found) => {
                let count = found.map_or(1, |found| found.sizes.len());
                let must = format!("less than the number of components, {count}");
                return Err(Error::parameter("component", must, piece));
            }
        }
        // What is left must still be a surface.
        cloud::check(&points)?;
        let double = validate::double_layer(&telling, observer)?;
        let order = outwards_from_centroid(&points);
        Ok(Self {
            points: of(&points, &order),
            weights: weights.map(|weights| of(&weights, &order)),
            indices: of(&indices, &order),
            telling,
            known,
            duplicates,
            outliers,
            apart,
            glimpsed,
            across,
            double: double.is_some(),
            thinned: cloud.len() > MOST,
            diagnostics,
        })
    }

    /// The points in a frame, and all that is known of them in the order that they have there.
    pub(super) fn outwards_in(&mut self, frame: &Frame) -> Vec<DVec3> {
        let local = frame.counted(&self.points);
        let order = outwards(&local, DVec3::ZERO);
        self.points = of(&self.points, &order);
        self.indices = of(&self.indices, &order);
        self.weights = self.weights.as_ref().map(|weights| of(weights, &order));
        of(&local, &order)
    }

    /// Looks for pieces that few points do not show: layers farther apart than the spacing of all
    /// points, but not than that of few.
    pub(super) fn look_for_layers(&mut self, observer: &mut dyn Observer) -> Result<()> {
        if self.glimpsed && !hang_together(&self.telling, observer)?.0 {
            let found;
            (found, self.across) = pieces_across(&self.points, observer)?;
            self.apart = Apart::of(&found, &self.points);
        }
        Ok(())
    }

    /// Looks at points in lines as far apart along these as across, if they are in lines: slopes are those
    /// of the surface then, not of a line.
    pub(super) fn look_across_lines(&mut self) -> bool {
        let looked = || across_lines(&self.telling, self.known.as_ref(), None);
        let few = self.across.take().or_else(looked);
        if let Some(few) = &few {
            (self.telling, self.known) = (of(few, &outwards_from_centroid(few)), None);
        }
        few.is_some()
    }

    /// The places in the cloud of points that do not count, ascending.
    pub(super) fn others(&self, cloud: usize) -> Vec<u32> {
        let mut counts = vec![false; cloud];
        self.indices.iter().for_each(|&index| counts[index as usize] = true);
        (0..).zip(counts).filter(|(_, counts)| !counts).map(|(index, _)| index).collect()
    }
}

/// All points, or as many as a surface is fitted to.
fn looked_at(cloud: &[DVec3], observer: &mut dyn Observer) -> Result<Vec<u32>> {
    if cloud.len() <= MOST {
        return Ok((0..).take(cloud.len()).collect());
    }
    let mut sample = EvenSample::new(MOST);
    for portion in cloud.chunks(PORTION) {
        let (step, total) = (sample.seen(), cloud.len());
        let progress = Progress::of_stage(Stage::Cleaning, step, total as u64, total);
        let mut listen = || progress::report(observer, &progress);
        listen()?;
        sample.look_at(portion, &mut listen)?;
    }
    #[expect(clippy::cast_possible_truncation, reason = "no more points fit into memory")]
    Ok(sample.indices().into_iter().map(|index| index as u32).collect())
}

/// Some points, evenly over space, that tell what all are like.
fn telling_of(points: &[DVec3]) -> Vec<DVec3> {
    let some = rough_sample(points, TELLING.0);
    of(&some, &outwards_from_centroid(&some))
}

/// The items at these places.
pub(super) fn of<T: Copy>(items: &[T], indices: &[u32]) -> Vec<T> {
    indices.iter().map(|&index| items[index as usize]).collect()
}

fn keep<T>(items: &mut Vec<T>, kept: &[bool]) {
    let mut kept = kept.iter();
    items.retain(|_| kept.next().copied().unwrap_or(false));
}

/// At most `count` items at equal steps.
pub(super) fn every<T>(items: &[T], count: usize) -> impl Iterator<Item = &T> {
    let taken = items.len().min(count);
    (0..taken).map(move |i| &items[i * items.len() / taken])
}

fn outwards_from_centroid(points: &[DVec3]) -> Vec<u32> {
    outwards(points, cloud::centroid(points))
}

/// The order of points from the farthest to the nearest.
fn outwards(points: &[DVec3], centre: DVec3) -> Vec<u32> {
    let mut keyed: Vec<(f64, u32)> =
        (0..).zip(points).map(|(index, point)| (point.distance_squared(centre), index)).collect();
    let coordinates = |index: u32| points[index as usize].to_array();
    keyed.par_sort_unstable_by(|a, b| {
        let [x, y] = [a, b].map(|key| coordinates(key.1));
        let places = x.iter().zip(&y).map(|(x, y)| x.total_cmp(y));
        let equal = b.0.total_cmp(&a.0);
        places.fold(equal, Ordering::then).then(a.1.cmp(&b.1))
    });
    keyed.into_iter().map(|(_, index)| index).collect()
}
