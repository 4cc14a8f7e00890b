//! Other surfaces, where the first folds over, runs away or has nothing of the shape of its points.

use std::cmp::Ordering;

use super::candidate::{Candidate, Learned, Placed, Wanted};
use super::feet::feet;
use super::flaws::Flaws;
use super::job::{Fit, Job};
use super::own_frame::OwnFrame;
use super::report::Clock;
use super::shape::Shape;
use super::start::{OrderedStart, learn, split};
use super::{Start, heights, round};
use crate::cloud::{Plane, upward};
use crate::error::{Error, Result};
use crate::fit::{ApproximateOptions, Approximation, EndedBy, Growth, approximate, diameter};
use crate::progress::Observer;
use crate::topology::Kind;

/// Distance of a surface from its points, by root mean square and as a share of their diameter, up to which it may
/// be what they lie on, and from which on it is not taken instead of a nearer one without flaws.
const LIKE: f64 = 0.05;
const UNLIKE: f64 = 0.1;

/// Sides of smaller nets, in turn: what bends less often folds over less.
const SIDES: [usize; 4] = [12, 8, 6, 4];

/// The net of a round tube or torus.
const ROUND: (usize, usize) = (8, 8);

/// Of more points, which take seconds, the first surface is enough that is no farther from them than the one with flaws.
const MANY: usize = 2000;

/// How wild a surface is.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Wildness {
    /// Not at all.
    Tame,
    /// It is farther from its points than the gaps between them explain, though near their hull, or has nothing of their
    /// shape.
    Away,
    /// It folds over, or runs out of their hull.
    Wild,
}

impl Wildness {
    /// Of a surface with these flaws.
    fn of(fit: &Fit, flaws: &Flaws, job: &Job<'_>) -> Self {
        if flaws.are_wild(job) {
            Self::Wild
        } else if flaws.count() > 0 || job.rms(&fit.distances) > UNLIKE * diameter(job.points) {
            Self::Away
        } else {
            Self::Tame
        }
    }
}

impl<'a> Wanted<'a> {
    /// The surface, or, where it has flaws or is far from its points, another one without flaws of its kind; or the
    /// sheet instead of what seemed to be closed, as a band with one side does.
    pub(super) fn or_sound(
        &self,
        found: Candidate<'a>,
        clock: &mut Clock,
        observer: &mut dyn Observer,
    ) -> Result<Candidate<'a>> {
        let Self { options, .. } = self;
        let free = options.fairness.is_none() && options.init == Start::Auto;
        let flat = found.job.shape.base.is_some();
        if !free || flat || self.layers.is_some() || self.is_sound(&found) {
            return Ok(found);
        }
        let kind = found.job.shape.kind;
        let found = self.or_other(found, clock, observer)?;
        if kind == Kind::Sheet {
            return self.or_over_plane(found, clock, observer);
        }
        if options.kind.is_some() {
            return self.or_round(found, observer);
        }
        if self.is_sound(&found) {
            return Ok(found);
        }
        let sheet = self.candidate(Shape::new(Kind::Sheet, None), None, clock, observer);
        let sheet = sheet.and_then(|sheet| self.or_sound(sheet, clock, observer));
        self.tamer(found, sheet)
    }

    /// Whether a surface may be what its points lie on.
    fn is_sound(&self, found: &Candidate<'_>) -> bool {
        found.flaws.count() == 0 && found.error() <= LIKE * self.size()
    }

    /// Whether a surface keeps the tolerance that was asked for.
    fn keeps(&self, found: &Candidate<'_>) -> bool {
        let tolerance = self.growth.and_then(|growth| growth.tolerance);
        tolerance.is_some_and(|tolerance| found.job.largest(&found.fit.distances) <= tolerance)
    }

    /// This surface, or another that is less wild, if it is nearer, or not far, and keeps a tolerance that this one keeps,
    /// or if this one is wild; or that is as wild, and keeps a tolerance that this one does not, or else is nearer.
    fn tamer(&self, found: Candidate<'a>, other: Result<Candidate<'a>>) -> Result<Candidate<'a>> {
        let other = match other {
            Ok(other) => other,
            Err(Error::Interrupted) => return Err(Error::Interrupted),
            Err(_) => return Ok(found),
        };
        let (kept, keeps) = (self.keeps(&found), self.keeps(&other));
        let (wildness, error) = (found.wildness(), other.error());
        let better = match other.wildness().cmp(&wildness) {
            Ordering::Less if wildness == Wildness::Wild => true,
            Ordering::Less => (keeps || !kept) && error < found.error().max(UNLIKE * self.size()),
            Ordering::Equal if keeps == kept => error < found.error(),
            Ordering::Equal => keeps,
            Ordering::Greater => false,
        };
        Ok(if better { other } else { found })
    }

    /// The surface, or the nearest without flaws from another start, or else from any start with a smaller net,
    /// unless the net was given.
    fn or_other(
        &self,
        found: Candidate<'a>,
        clock: &mut Clock,
        observer: &mut dyn Observer,
    ) -> Result<Candidate<'a>> {
        let (placed, like) = (self.placed, LIKE * self.size());
        let observer: &mut dyn Observer = &mut OwnFrame { frame: placed.frame, observer };
        let kind = found.job.shape.kind;
        let many = placed.points.len() > MANY;
        let near = if many { found.error().min(like) } else { 0.0 };
        let enough = |best: &Candidate<'_>| {
            best.wildness() == Wildness::Tame && (best.error() <= near || self.keeps(best))
        };
        let starts = match kind {
            Kind::Sheet => self.other_starts(None, observer)?,
            // Of one that was found out, a sheet is tried before.
            _ if self.options.kind.is_some() => vec![self.round_start(&found.job, observer)?],
            _ => Vec::new(),
        };
        let learned = |start: OrderedStart| {
            let map = learn(&placed.sample, &start, observer)?;
            Ok(Learned { map, net: start.net, creases: start.creases })
        };
        let mut begun: Vec<Learned> = starts.into_iter().map(learned).collect::<Result<_>>()?;
        clock.lap("training");
        let (rows, cols) = found.job.different(&found.fit.surface);
        let (map, creases) = (found.map.clone(), found.job.creases.clone());
        begun.push(Learned { map, net: (rows, cols), creases });
        let (ended_by, mut best) = (found.fit.ended_by, found);
        // Where the tolerance ended the growth, a net that grows as if there were none may keep it, too.
        let free = self.growth.filter(|growth| growth.tolerance.is_some() && self.keeps(&best));
        let free = free.map(|growth| Growth { tolerance: None, ..growth });
        let others = begun[..begun.len() - 1].iter().map(|learned| (learned, self.growth));
        let freed = begun.iter().rev().filter(|_| free.is_some()).map(|learned| (learned, free));
        for (learned, growth) in others.chain(freed) {
            if !enough(&best) {
                let shape = Shape::new(kind, None);
                let other = self.fitted(learned.clone(), shape, growth, clock, observer);
                best = self.tamer(best, other)?;
            }
        }
        let smaller = |side: &usize| free.is_some() || side * side < rows * cols;
        for side in SIDES.into_iter().filter(smaller) {
            let fine = best.wildness() == Wildness::Tame && best.error() <= like;
            if fine || self.growth.is_none() {
                break;
            }
            for learned in &begun {
                let (rows, cols) = learned.map.lattice.shape();
                let net = split(side * side, rows as f64 / cols as f64);
                let (learned, shape) = (Learned { net, ..learned.clone() }, Shape::new(kind, None));
                let other = self.fitted(learned, shape, None, clock, observer);
                best = self.tamer(best, other)?;
            }
        }
        // What kept the net of the first from growing, unless it need grow no more, keeps a smaller one from the
        // tolerance.
        let ended_by = match (best.fit.ended_by, ended_by) {
            (EndedBy::Grid, first) if first != EndedBy::Tolerance => first,
            (own, _) => own,
        };
        Ok(Candidate { fit: Fit { ended_by, ..best.fit }, ..best })
    }

    /// The sheet, or, if it has flaws or is far from the points that count, heights over a principal plane of these: they
    /// pass between what lies above one another, but neither fold over nor run out of the hull.
    fn or_over_plane(
        &self,
        found: Candidate<'a>,
        clock: &mut Clock,
        observer: &mut dyn Observer,
    ) -> Result<Candidate<'a>> {
        let points = found.job.counted();
        let mut best = found;
        // The one nearest to them first.
        for up in Plane::of(points.iter().copied()).axes.into_iter().rev() {
            if best.wildness() == Wildness::Tame {
                break;
            }
            let base = heights::rectangle(&points, upward(up));
            let shape = Shape::new(Kind::Height, Some(base));
            let heights = self.candidate(shape, None, clock, observer);
            best = self.tamer(best, heights)?;
        }
        Ok(best)
    }

    /// The map that begins round, of a tube or a torus.
    fn round_start(&self, job: &Job<'_>, observer: &mut dyn Observer) -> Result<OrderedStart> {
        let &Self { placed: Placed { frame, sample, .. }, budget, options, .. } = self;
        let (kind, topology) = (job.shape.kind, job.shape.closed());
        let chart = frame.undo_chart(round::around(&job.counted(), kind, ROUND));
        let count = sample.len();
        OrderedStart::of(count, sample, budget, topology, Some(&chart), frame, options, observer)
    }

    /// The tube or torus, or, if it is wild or far from the points, the round one, if that is less wild or nearer.
    fn or_round(&self, found: Candidate<'a>, observer: &mut dyn Observer) -> Result<Candidate<'a>> {
        if found.wildness() == Wildness::Tame {
            return Ok(found);
        }
        let Candidate { placed, job, fit, .. } = &found;
        let net = if self.growth.is_none() { job.different(&fit.surface) } else { ROUND };
        let chart = round::around(&job.counted(), job.shape.kind, net);
        let options = ApproximateOptions {
            net,
            degree: (job.degree(net.0), job.degree(net.1)),
            closed: job.shape.closed().closed(),
            border: 0.0,
            ..ApproximateOptions::default()
        };
        let Approximation { surface, fairness, .. } =
            approximate(&chart.points, &chart.uv, None, &options, observer)?;
        let (uv, distances) = feet(&surface, &placed.points, observer)?;
        let &Fit { iterations, ended_by, .. } = fit;
        let round = Fit { surface, base: None, uv, distances, fairness, iterations, ended_by };
        let flaws = job.flaws(&round, observer)?;
        let better = match Wildness::of(&round, &flaws, job).cmp(&found.wildness()) {
            Ordering::Equal => job.rms(&round.distances) < job.rms(&fit.distances),
            order => order == Ordering::Less,
        };
        Ok(if better { Candidate { fit: round, flaws, ..found } } else { found })
    }
}

impl Candidate<'_> {
    /// Whether it folds over or runs out of its points' hull.
    pub(super) fn is_wild(&self) -> bool {
        self.wildness() == Wildness::Wild
    }

    fn wildness(&self) -> Wildness {
        Wildness::of(&self.fit, &self.flaws, &self.job)
    }
}
