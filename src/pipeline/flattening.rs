//! Surfaces that fold over or run away, though their points do not, mended.

use glam::DVec2;

use super::flaws::Flaws;
use super::job::{Fit, Job};
use crate::error::Result;
use crate::fit::{self, Approximation, EndedBy, Flat, Growth};
use crate::nurbs::NurbsSurface;
use crate::progress::Observer;
use crate::validate::{Body, OUTSIDE, excursion};

/// How much more fairness than cross-validation has found is tried, one after the other, where a
/// surface has flaws: where a net cannot follow what bends more than it can, cross-validation sees
/// no use in any; the most leaves hardly more than a plane, and so few folds if any. The first are tried
/// last where a fit takes long and hardly ever has too much of it, because it is relaxed: for all but
/// heights.
const FLATTENINGS: [f64; 9] = [1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9];
const TRIED_LAST: usize = 2;

/// Share of the flaws that more fairness must leave at most to be worth what it takes the surface away from
/// its points, where it does not leave none.
const CLEARLY_FEWER: f64 = 0.75;

/// A surface with more flaws is hardly ever turned the right way in all of them.
const FEW_FLAWS: usize = 10;

/// Share of its area that a surface may have lost to where no points are, while it was flattened.
const EMPTIER: f64 = 0.02;

/// Shares of the points' longest chord by which a surface without flaws sticks out of their hull if another one is
/// looked for, in turn, and how far that may be from them, as a share of its own distance by root mean square.
const STICKING_OUT: [(f64, f64); 2] = [(0.25, 2.0), (0.2, 1.2)];

/// How many times farther than before from its points a mended surface is not far from them, by root mean square, and
/// the share of that which a turn back to them leaves at most for another.
const NOT_FAR: f64 = 1.1;
const WORTH_A_TURN: f64 = 0.95;

/// The least of these shares.
const LEAST_OUTSIDE: f64 = STICKING_OUT[STICKING_OUT.len() - 1].0;

impl Job<'_> {
    /// The fit without the flaws that its points do not have, as far as there is one, and drawn in where it sticks out
    /// of their hull. Keeps a tolerance that was kept, and stays near pieces: it may have no way through them.
    pub(super) fn flattened(
        &self,
        fit: Fit,
        growth: Option<Growth>,
        observer: &mut dyn Observer,
    ) -> Result<(Fit, Flaws)> {
        // What has no flaws by the least bound has none by the others.
        let none = Flaws::of(&fit.surface, &fit.uv, self, LEAST_OUTSIDE, observer)?;
        if none.count() == 0 {
            return Ok((fit, none));
        }
        let flaws = self.flaws(&fit, observer)?;
        if self.options.fairness.is_some() {
            return Ok((fit, flaws));
        }
        let (fit, flaws) = match self.mended(&fit, flaws.count(), OUTSIDE, observer)? {
            Some(found) => self.kept(fit, flaws, found, growth, observer)?,
            None => (fit, flaws),
        };
        if flaws.count() > 0 || self.shape.base.is_some() {
            return Ok((fit, flaws));
        }
        let mut best = (fit, flaws);
        for (outside, as_near) in STICKING_OUT {
            if let Some(found) = self.sticking_out_less(&best.0, outside, as_near, observer)? {
                best = self.kept(best.0, best.1, found, growth, observer)?;
            }
        }
        Ok(best)
    }

    /// The fit drawn in where it sticks out of the points' hull, if it does, and is hardly farther from them then.
    fn sticking_out_less(
        &self,
        fit: &Fit,
        outside: f64,
        as_near: f64,
        observer: &mut dyn Observer,
    ) -> Result<Option<Fit>> {
        let inspect = &mut self.inspection(outside);
        let count = inspect(&fit.surface, &fit.uv, observer)?.len();
        if count == 0 {
            return Ok(None);
        }
        let Some(found) = self.mended(fit, count, outside, observer)? else { return Ok(None) };
        let left = inspect(&found.surface, &found.uv, observer)?.len();
        let fewer = (left as f64) < CLEARLY_FEWER * count as f64;
        let as_near = self.rms(&found.distances) <= as_near * self.rms(&fit.distances);
        if !(fewer && as_near && self.flaws(&found, observer)?.count() == 0) {
            return Ok(None);
        }
        // A corner that lies on the surface instead, where that goes on, covers it twice.
        let mut area = |fit: &Fit| Body::of(&fit.surface, observer).map(|body| body.area);
        let smaller = area(&found)? <= area(fit)?;
        let mut farthest =
            |fit: &Fit| excursion(&fit.surface, self.points, observer).map(|found| found.distance);
        let nearer = farthest(&found)? < farthest(fit)?;
        Ok((smaller && nearer).then_some(found))
    }

    /// The fit turned the right way, where it folds over in few places and the points do not, or, where
    /// that fails or it runs away, with more fairness: the least that leaves no flaw, or hardly more than
    /// the fewest and then unfolded, everywhere, then less wherever it makes none. It has so many flaws,
    /// where it may lie outside of the points' hull by such a share of their longest chord.
    fn mended(
        &self,
        fit: &Fit,
        count: usize,
        outside: f64,
        observer: &mut dyn Observer,
    ) -> Result<Option<Fit>> {
        let few = (1..=FEW_FLAWS).contains(&count) && self.shape.base.is_none();
        if few && let Some(turned) = self.turned(fit, fit.fairness, outside, observer)? {
            return Ok(Some(turned));
        }
        let net = self.different(&fit.surface);
        let (mut flat, mut fewest) = (None, count);
        let mut flattenings = FLATTENINGS;
        if self.shape.base.is_none() {
            flattenings.rotate_left(TRIED_LAST);
        }
        let inspect = &mut self.inspection(outside);
        for flattening in flattenings {
            if fewest == 0 {
                break;
            }
            let fairness = Some(flattening * fit.fairness);
            let flatter = self.fit(net, None, fairness, None, observer)?;
            let left = inspect(&flatter.surface, &flatter.uv, observer)?.len();
            if (left as f64) < CLEARLY_FEWER * fewest as f64 {
                (flat, fewest) = (Some(flatter), left);
            }
        }
        if fewest > 0 {
            flat = self.unfolded(flat.as_ref().unwrap_or(fit), outside, observer)?.or(flat);
        }
        let Some(flat) = flat else { return Ok(None) };
        let found = self.relaxed(&flat, fit.fairness, outside, observer)?;
        let found = self.drawn_in(found, fit, outside, observer)?;
        self.brought_back(found, fit, outside, observer).map(Some)
    }

    /// A mended fit, brought back to the points where it went far away from them: with no more fairness than before it
    /// was flattened, and turned wherever that folds it over, in turns, as long as they bring it nearer.
    fn brought_back(
        &self,
        mut mended: Fit,
        folded: &Fit,
        outside: f64,
        observer: &mut dyn Observer,
    ) -> Result<Fit> {
        let near = NOT_FAR * self.rms(&folded.distances);
        let mut error = self.rms(&mended.distances);
        let fine = error <= near || self.shape.base.is_some();
        if fine || Flaws::of(&mended.surface, &mended.uv, self, outside, observer)?.count() > 0 {
            return Ok(mended);
        }
        while error > near {
            let fairness = folded.fairness;
            let Some(found) = self.turned(&mended, fairness, outside, observer)? else { break };
            let nearer = self.rms(&found.distances);
            if nearer > WORTH_A_TURN * error {
                break;
            }
            error = nearer;
            mended = Fit { iterations: mended.iterations + found.iterations, ..found };
        }
        Ok(mended)
    }

    /// What was found instead of a fit with these flaws, or the fit, if that alone keeps a tolerance or
    /// is near pieces.
    fn kept(
        &self,
        fit: Fit,
        flaws: Flaws,
        found: Fit,
        growth: Option<Growth>,
        observer: &mut dyn Observer,
    ) -> Result<(Fit, Flaws)> {
        let tolerance = growth.and_then(|growth| growth.tolerance);
        let tolerance = tolerance.filter(|_| fit.ended_by == EndedBy::Tolerance);
        let kept = tolerance.is_none_or(|limit| self.largest(&found.distances) <= limit);
        if !(kept && self.near_pieces(&found)) {
            return Ok((fit, flaws));
        }
        let flaws = self.flaws(&found, observer)?;
        let iterations = fit.iterations + found.iterations;
        Ok((Fit { ended_by: fit.ended_by, iterations, ..found }, flaws))
    }

    /// The fit with this fairness, turned the right way where it has flaws, if that leaves none.
    fn turned(
        &self,
        fit: &Fit,
        fairness: f64,
        outside: f64,
        observer: &mut dyn Observer,
    ) -> Result<Option<Fit>> {
        let (flat, weights) = (Flat { fairness, ..self.flat(fit) }, self.weights.as_deref());
        let inspect = &mut self.inspection(outside);
        let found = fit::turned(self.points, weights, &flat, inspect, observer)?;
        let Some(found) = found.map(Fit::from) else { return Ok(None) };
        // What no point holds may have gone out from there.
        let before = excursion(&fit.surface, self.points, observer)?;
        let after = excursion(&found.surface, self.points, observer)?;
        Ok((after.distance <= before.distance.max(before.reach)).then_some(found))
    }

    /// The fit with less fairness, down to `aim`, wherever that makes no flaws.
    fn relaxed(
        &self,
        fit: &Fit,
        aim: f64,
        outside: f64,
        observer: &mut dyn Observer,
    ) -> Result<Fit> {
        let (flat, weights) = (self.flat(fit), self.weights.as_deref());
        let inspect = &mut self.inspection(outside);
        let found = fit::relaxed(self.points, weights, &flat, aim, inspect, observer)?;
        Ok(Fit { iterations: fit.iterations + found.iterations, ..found.into() })
    }

    /// A relaxed fit drawn in to where the points end, and relaxed again, if it went out from there when
    /// it was flattened: what no point holds stays flat.
    fn drawn_in(
        &self,
        relaxed: Fit,
        folded: &Fit,
        outside: f64,
        observer: &mut dyn Observer,
    ) -> Result<Fit> {
        if self.shape.base.is_some() {
            return Ok(relaxed);
        }
        let mut empty =
            |fit: &Fit| excursion(&fit.surface, self.points, observer).map(|found| found.share);
        if empty(&relaxed)? <= empty(folded)? + EMPTIER {
            return Ok(relaxed);
        }
        let (flat, weights) = (self.flat(&relaxed), self.weights.as_deref());
        let restricted = fit::restricted(self.points, weights, &flat, self.border(), observer)?;
        let iterations = relaxed.iterations + restricted.iterations;
        let restricted = Fit { iterations, ..restricted.into() };
        let flaws = Flaws::of(&restricted.surface, &restricted.uv, self, outside, observer)?;
        let drawn_in = if flaws.count() == 0 {
            restricted
        } else {
            let Some(unfolded) = self.unfolded(&restricted, outside, observer)? else {
                return Ok(relaxed);
            };
            unfolded
        };
        self.relaxed(&drawn_in, folded.fairness, outside, observer)
    }

    /// The fit farther from the points around its flaws, if that leaves none.
    fn unfolded(
        &self,
        fit: &Fit,
        outside: f64,
        observer: &mut dyn Observer,
    ) -> Result<Option<Fit>> {
        let (flat, weights) = (self.flat(fit), self.weights.as_deref());
        let inspect = &mut self.inspection(outside);
        let found = fit::unfolded(self.points, weights, &flat, inspect, observer)?;
        let iterations = |found: &Approximation| fit.iterations + found.iterations;
        Ok(found.map(|found| Fit { iterations: iterations(&found), ..found.into() }))
    }

    pub(super) fn flat<'a>(&self, fit: &'a Fit) -> Flat<'a> {
        let &Fit { ref surface, ref uv, fairness, .. } = fit;
        Flat { surface, uv, fairness, closed: self.shape.closed().closed() }
    }

    /// Where a surface has flaws.
    fn inspection(
        &self,
        outside: f64,
    ) -> impl FnMut(&NurbsSurface, &[DVec2], &mut dyn Observer) -> Result<Vec<DVec2>> {
        move |surface, uv, observer| Ok(Flaws::of(surface, uv, self, outside, observer)?.places())
    }
}
