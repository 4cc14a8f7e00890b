//! Other surfaces, where the first folds over, runs away or has nothing of the shape of its points.

use super::Start;
use super::candidate::{Candidate, Learned, Wanted};
use super::job::Fit;
use super::own_frame::OwnFrame;
use super::report::Clock;
use super::shape::Shape;
use super::start::{OrderedStart, learn, split};
use crate::error::{Error, Result};
use crate::fit::{EndedBy, Growth};
use crate::progress::Observer;
use crate::topology::Kind;

/// Distance of a surface from its points, by root mean square and as a share of their diameter, up to which it may
/// be what they lie on, and from which on it is not taken instead of a nearer one with flaws.
const LIKE: f64 = 0.05;
const UNLIKE: f64 = 0.1;

/// Sides of smaller nets, in turn: what bends less often folds over less.
const SIDES: [usize; 4] = [12, 8, 6, 4];

/// Of more points, which take seconds, the first surface is enough that is no farther from them than the one with flaws.
const MANY: usize = 2000;

/// The nearest surface without flaws so far.
struct Alternatives<'a, 'b> {
    wanted: &'b Wanted<'a>,
    kind: Kind,
    best: Option<Candidate<'a>>,
    /// How near another one must be.
    limit: f64,
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
        if kind == Kind::Sheet || options.topology.is_some() || self.is_sound(&found) {
            return Ok(found);
        }
        let sheet = self.candidate(Shape::new(Kind::Sheet, None), None, clock, observer);
        let sheet = sheet.and_then(|sheet| self.or_sound(sheet, clock, observer));
        let most = UNLIKE * self.size();
        found.or_nearer(sheet, 1.0, most)
    }

    /// Whether a surface may be what its points lie on.
    fn is_sound(&self, found: &Candidate<'_>) -> bool {
        !found.flaws.spoil(&found.fit) && found.error() <= LIKE * self.size()
    }

    /// The surface, or the nearest without flaws from another start, or else from any start with a smaller net,
    /// unless the net was given.
    fn or_other(
        &self,
        found: Candidate<'a>,
        clock: &mut Clock,
        observer: &mut dyn Observer,
    ) -> Result<Candidate<'a>> {
        let (placed, size) = (self.placed, self.size());
        let observer: &mut dyn Observer = &mut OwnFrame { frame: placed.frame, observer };
        let kind = found.job.shape.kind;
        let limit = found.error().max(UNLIKE * size);
        let many = placed.points.len() > MANY;
        let enough = if many { found.error().min(LIKE * size) } else { 0.0 };
        let mut others = Alternatives { wanted: self, kind, best: None, limit };
        let starts = match kind {
            Kind::Sheet => self.other_starts(None, observer)?,
            _ => Vec::new(),
        };
        let learned = |start: OrderedStart| {
            let map = learn(&placed.sample, &start, observer)?;
            Ok(Learned { map, net: start.net, creases: start.creases })
        };
        let mut begun: Vec<Learned> = starts.into_iter().map(learned).collect::<Result<_>>()?;
        clock.lap("training");
        for learned in &begun {
            if others.limit > enough {
                others.consider(learned.clone(), self.growth, clock, observer)?;
            }
        }
        let (rows, cols) = found.job.different(&found.fit.surface);
        let (map, creases) = (found.map.clone(), found.job.creases.clone());
        begun.push(Learned { map, net: (rows, cols), creases });
        for side in SIDES.into_iter().filter(|side| side * side < rows * cols) {
            if others.limit <= LIKE * size || self.growth.is_none() {
                break;
            }
            for learned in &begun {
                let (rows, cols) = learned.map.lattice.shape();
                let net = split(side * side, rows as f64 / cols as f64);
                others.consider(Learned { net, ..learned.clone() }, None, clock, observer)?;
            }
        }
        let Some(best) = others.best else { return Ok(found) };
        // What kept the net of the first from growing keeps a smaller one from the tolerance.
        let ended_by = match best.fit.ended_by {
            EndedBy::Grid => found.fit.ended_by,
            ended_by => ended_by,
        };
        Ok(Candidate { fit: Fit { ended_by, ..best.fit }, ..best })
    }
}

impl Alternatives<'_, '_> {
    fn consider(
        &mut self,
        learned: Learned,
        growth: Option<Growth>,
        clock: &mut Clock,
        observer: &mut dyn Observer,
    ) -> Result<()> {
        let shape = Shape::new(self.kind, None);
        match self.wanted.fitted(learned, shape, growth, clock, observer) {
            Ok(other) if other.flaws.count() == 0 && other.error() < self.limit => {
                self.limit = other.error();
                self.best = Some(other);
            }
            Err(Error::Interrupted) => return Err(Error::Interrupted),
            _ => {}
        }
        Ok(())
    }
}
