//! Surfaces of different shapes near the same points, of which one is the result.

use glam::DVec3;

use super::counted::{Layers, every};
use super::flaws::Flaws;
use super::job::{Fit, Job};
use super::own_frame::{Frame, OwnFrame};
use super::report::Clock;
use super::shape::Shape;
use super::start::{OrderedStart, learn, net};
use super::unwound::Unwound;
use super::{ReconstructOptions, Start, heights};
use crate::error::{Error, Result};
use crate::fit::{Growth, bounded, diameter};
use crate::progress::Observer;
use crate::som::{self, SelfOrganizingMap};
use crate::topology::{Chart, Cloud, Kind};

/// How far beyond the lattice's border points may lie, in cells.
const EXTRAPOLATION: f64 = 0.75;

/// Topographic error of a map from an ordered start that shows a short circuit between layers, or a surface
/// that has no flat map: of two dozen maps in order, of noisy sheets too, none has any, nor half of it of two
/// that are stretched over more than half a sphere.
const TORN: f64 = 0.005;

/// So many points may be out of order by chance, and the map still be the better one, up to this error; and if
/// so many more are than in another, that one is better.
const BY_CHANCE: (f64, f64) = (5.0, 0.02);

/// Points that the map learns from: more would not move it visibly.
const MAP_POINTS: usize = 20_000;

/// How near to its points a surface is that no other need be looked for, as a share of their diameter; and how
/// near another is, as a share of its distances, that is taken instead: a sheet instead of steep heights, or a tube
/// instead of a sheet.
const NEAR: f64 = 2e-5;
pub(super) const NEARER: f64 = 0.8;

/// Points in a frame.
pub(super) struct Placed {
    pub(super) frame: Frame,
    pub(super) points: Vec<DVec3>,
    /// Some of them, which the map learns from.
    pub(super) sample: Vec<DVec3>,
    /// Some, by which its start is ordered, where that is not by those.
    across_lines: Option<Vec<DVec3>>,
}

impl Placed {
    pub(super) fn new(frame: Frame, points: Vec<DVec3>, across_lines: Option<&[DVec3]>) -> Self {
        let sample = every(&points, MAP_POINTS).copied().collect();
        let across_lines = across_lines.map(|points| frame.counted(points));
        Self { frame, points, sample, across_lines }
    }
}

/// What a surface is wanted for.
#[derive(Clone, Copy)]
pub(super) struct Wanted<'a> {
    pub(super) placed: &'a Placed,
    pub(super) weights: Option<&'a [f64]>,
    pub(super) layers: Option<Layers>,
    /// The points that have shown of what kind it is.
    pub(super) seen: Option<&'a Cloud>,
    pub(super) budget: (usize, usize),
    pub(super) growth: Option<Growth>,
    pub(super) options: &'a ReconstructOptions<'a>,
}

/// A map, and the net that a surface begins with.
#[derive(Clone)]
pub(super) struct Learned {
    pub(super) map: SelfOrganizingMap,
    pub(super) net: (usize, usize),
    pub(super) creases: Vec<f64>,
}

/// A surface, and the map that it began with.
pub(super) struct Candidate<'a> {
    pub(super) placed: &'a Placed,
    pub(super) map: SelfOrganizingMap,
    pub(super) job: Job<'a>,
    pub(super) fit: Fit,
    pub(super) flaws: Flaws,
}

impl<'a> Wanted<'a> {
    /// The surface of this shape.
    pub(super) fn candidate(
        &self,
        shape: Shape,
        chart: Option<&Chart>,
        clock: &mut Clock,
        observer: &mut dyn Observer,
    ) -> Result<Candidate<'a>> {
        let &Self { placed: Placed { frame, sample, .. }, budget, options, .. } = self;
        let observer: &mut dyn Observer = &mut OwnFrame { frame: *frame, observer };
        let count = sample.len();
        let around_circle = self.around_circle(&shape);
        let chart = around_circle.as_ref().or(chart);
        let mut start = if let Some(base) = &shape.base {
            let (uv, aspect) = heights::places(sample, base);
            OrderedStart::over(count, sample, &uv, net(budget, aspect, options), observer)?
        } else {
            OrderedStart::of(
                count,
                self.ordering(),
                budget,
                shape.closed(),
                chart,
                frame,
                options,
                observer,
            )?
        };
        clock.lap("ordering");
        let map = self.learned(&mut start, &shape, observer)?;
        start.split_as(&map, budget, options);
        let OrderedStart { net, creases, .. } = start;
        self.fitted(Learned { map, net, creases }, shape, self.growth, clock, observer)
    }

    /// The surface of this shape that begins with this map, in the points' frame.
    pub(super) fn fitted(
        &self,
        learned: Learned,
        shape: Shape,
        growth: Option<Growth>,
        clock: &mut Clock,
        observer: &mut dyn Observer,
    ) -> Result<Candidate<'a>> {
        let &Self { placed: placed @ Placed { points, .. }, layers, options, .. } = self;
        let Learned { map, net, creases } = learned;
        let uv = if shape.base.is_some() {
            Vec::new()
        } else {
            let places = map.parametrize(points, EXTRAPOLATION, observer)?;
            bounded(&places, shape.closed().closed())
        };
        clock.lap("training");
        let weights = self.weights.map(<[f64]>::to_vec);
        let mut job = Job { points, weights, uv, creases, shape, layers, options };
        let (fit, flaws) = job.done(net, growth, observer)?;
        clock.lap("fitting");
        Ok(Candidate { placed, map, job, fit, flaws })
    }

    /// The sheet instead of steep heights that were found out, if it is clearly nearer to the points: its map
    /// has more room for what is steep.
    pub(super) fn or_sheet(
        &self,
        heights: Candidate<'a>,
        clock: &mut Clock,
        observer: &mut dyn Observer,
    ) -> Result<Candidate<'a>> {
        if heights.error() <= self.near_enough() {
            return Ok(heights);
        }
        let sheet = self.candidate(Shape::new(Kind::Sheet, None), None, clock, observer);
        heights.or_nearer(sheet, NEARER, 0.0)
    }

    /// The surface through all points with the given net, or that is closed in one direction more, where that was not
    /// seen at first, or another one where it has flaws.
    pub(super) fn or_better(
        &self,
        found: Candidate<'a>,
        clock: &mut Clock,
        observer: &mut dyn Observer,
    ) -> Result<Candidate<'a>> {
        let found = self.or_tube(found, clock, observer)?;
        let found = self.or_torus(found, clock, observer)?;
        self.or_sound(found, clock, observer)
    }

    /// How near to its points a surface is that no other need be looked for.
    pub(super) fn near_enough(&self) -> f64 {
        NEAR * self.size()
    }

    /// The points' diameter, as their coordinates count.
    pub(super) fn size(&self) -> f64 {
        self.placed.frame.length(diameter(&self.placed.points))
    }

    /// Points by which the map's start is ordered.
    fn ordering(&self) -> &'a [DVec3] {
        self.placed.across_lines.as_deref().unwrap_or(&self.placed.sample)
    }

    /// The map from an ordered start, or, where that of a sheet is torn, from another that is clearly less so.
    fn learned(
        &self,
        start: &mut OrderedStart,
        shape: &Shape,
        observer: &mut dyn Observer,
    ) -> Result<SelfOrganizingMap> {
        let sample = &self.placed.sample;
        let mut map = learn(sample, start, observer)?;
        if self.options.init != Start::Auto || shape.kind != Kind::Sheet {
            return Ok(map);
        }
        let torn = map.topographic_error(sample, observer)?;
        let (stray, most) = BY_CHANCE;
        let by_chance = stray / sample.len() as f64;
        if torn <= by_chance.clamp(TORN, most) {
            return Ok(map);
        }
        let mut least = torn - by_chance;
        for other in self.other_starts(start.unwound.take(), observer)? {
            let learned = learn(sample, &other, observer)?;
            let error = learned.topographic_error(sample, observer)?;
            if error < least {
                (*start, map, least) = (other, learned, error);
            }
        }
        Ok(map)
    }

    /// Starts of a sheet beside the first: in the principal plane, from more points or from end to end, as it may be
    /// wound up, unless the first was already, and over a disc, as it may go around a body.
    pub(super) fn other_starts(
        &self,
        unwound: Option<Unwound>,
        observer: &mut dyn Observer,
    ) -> Result<Vec<OrderedStart>> {
        let &Self { placed: Placed { frame, sample, .. }, budget, options, .. } = self;
        let (count, ordering) = (sample.len(), self.ordering());
        let flat = ReconstructOptions { init: Start::Pca, ..*options };
        let sheet = som::Topology::Sheet;
        let mut others =
            vec![OrderedStart::of(count, ordering, budget, sheet, None, frame, &flat, observer)?];
        let sheet = if let Some(sheet) = unwound {
            sheet
        } else {
            let sheet = Unwound::closely(ordering, observer)?;
            others.extend(sheet.unrolled(count, budget, options, observer)?);
            sheet
        };
        others.extend(OrderedStart::over_disc(count, ordering, budget, options, observer)?);
        others.extend(sheet.lengthwise(count, budget, options, observer)?);
        Ok(others)
    }
}

impl<'a> Candidate<'a> {
    /// This one, or another without flaws whose distance is less than this share of its own, or than another
    /// distance.
    pub(super) fn or_nearer(
        self,
        other: Result<Candidate<'a>>,
        share: f64,
        near: f64,
    ) -> Result<Candidate<'a>> {
        let enough = (share * self.error()).max(near);
        match other {
            Ok(other) if other.flaws.count() == 0 && other.error() < enough => Ok(other),
            Err(Error::Interrupted) => Err(Error::Interrupted),
            _ => Ok(self),
        }
    }

    /// How far it is from the points that count, as their coordinates do.
    pub(super) fn error(&self) -> f64 {
        self.placed.frame.length(self.job.rms(&self.fit.distances))
    }
}
