//! Nets that grow until a tolerance holds, or until more control points would follow noise.

use glam::{DVec2, DVec3};

use super::correct::Foot;
use super::fitting::Fitting;
use super::lengths::lengths;
use super::options::Growth;
use super::outcome::{Approximation, EndedBy};
use super::refine;
use super::residuals::are_noise;
use super::space::SplineSpace;
use crate::error::Result;
use crate::nurbs::NurbsSurface;

/// Share of the squared error that the spans hold which are divided; where the net may not become so large,
/// those are which hold this share of it, and so on down to the least, and growth ends there.
const DIVIDED: f64 = 0.85;
const LEAST_DIVIDED: f64 = 0.01;

/// Share of its error that cross-validation must expect after growing at most, for the growth to
/// go on.
pub(super) const LEAST_GAIN: f64 = 0.95;

/// Least number of points for each control point of a net that grows: with fewer, points left out are
/// further off, since cross-validation does not know of the freedom that their parameters have.
const POINTS_PER_CONTROL_POINT: usize = 3;

/// Of so many points, one is enough: otherwise few points would not get a net that can follow their bends.
pub(super) const FEW: usize = 256;

/// Root mean square error, as a share of the points' diameter, below which nobody sees what more control
/// points would do.
pub(crate) const EXACT: f64 = 1e-5;

/// Whether a finer surface, on which points have these parameters, may take the place of the one
/// before.
pub(crate) type Accept<'a> = &'a dyn Fn(&NurbsSurface, &[DVec2]) -> Result<bool>;

/// What a net grows to.
pub(crate) struct Grown {
    /// The finest.
    pub(crate) finest: Approximation,
    /// The last one before the first that was not accepted, if there is one.
    pub(crate) accepted: Option<Approximation>,
}

impl Fitting<'_> {
    /// The approximation by this surface, or by what it grows to.
    pub(super) fn grown(
        mut self,
        surface: NurbsSurface,
        growth: Option<Growth>,
        accept: Accept<'_>,
    ) -> Result<Grown> {
        let mut accepted = None;
        let (surface, ended_by) = match growth {
            Some(growth) => self.grow(surface, growth, accept, &mut accepted)?,
            None => (surface, EndedBy::Grid),
        };
        let finest = self.end(surface, ended_by);
        Ok(Grown { finest, accepted })
    }

    /// Divides spans and solves again until the tolerance holds or something forbids more. With a
    /// tolerance, it ends at the first net that is not accepted; without, this only keeps the one
    /// before.
    fn grow(
        &mut self,
        mut surface: NurbsSurface,
        growth: Growth,
        accept: Accept<'_>,
        accepted: &mut Option<Approximation>,
    ) -> Result<(NurbsSurface, EndedBy)> {
        let counted = (0..self.points.len()).filter(|&i| self.weight(i) > 0.0).count();
        let held = (counted / POINTS_PER_CONTROL_POINT).max(counted.min(FEW));
        let exact = EXACT * diameter(self.points);
        // A finer net begins no rougher than the one before.
        self.left = 1.0;
        self.limit = self.limit.div_ceil(2) - 1;
        loop {
            let feet = self.correct(&surface, 2);
            let far = |foot: &Foot| growth.tolerance.is_none_or(|most| foot.offset.length() > most);
            let counts = |i: usize| self.weight(i) > 0.0;
            let within = feet.iter().enumerate().all(|(i, foot)| !(far(foot) && counts(i)));
            if within {
                return Ok((surface, EndedBy::Tolerance));
            }
            if growth.tolerance.is_none() && self.rms(&feet) <= exact {
                return Ok((surface, EndedBy::Exact));
            }
            if growth.tolerance.is_none() && self.are_noise(&feet) {
                return Ok((surface, EndedBy::Noise));
            }
            let error = |foot: &Foot| if far(foot) { foot.offset.length_squared() } else { 0.0 };
            let knots = [surface.knots_u().clone(), surface.knots_v().clone()];
            let space = SplineSpace::new(knots, self.closed)?;
            let lengths = lengths(&surface);
            let refined = |share| refine::refined(&space, &feet, error, lengths, share);
            let (mut finer, mut share, mut ended_by) = (refined(DIVIDED)?, DIVIDED, EndedBy::Noise);
            let limit = growth.most.min(held);
            while finer.as_ref().is_some_and(|finer| finer.unknowns() > limit) {
                let few = held < growth.most;
                ended_by = if few { EndedBy::Points } else { EndedBy::MaxControlPoints };
                share *= DIVIDED;
                finer = if share < LEAST_DIVIDED { None } else { refined(share)? };
            }
            let Some(finer) = finer else {
                let smallest = ended_by == EndedBy::Noise;
                return Ok((surface, if smallest { EndedBy::Points } else { ended_by }));
            };
            let before = (self.score, self.uv.clone());
            let next = self.descend(&finer, surface.clone())?;
            if growth.tolerance.is_none()
                && let (Some(old), Some(new)) = (before.0, self.score)
                && (new.error > LEAST_GAIN * old.error || new.error_of_blocks > old.error_of_blocks)
            {
                (self.score, self.uv) = before;
                return Ok((surface, ended_by));
            }
            if accepted.is_none() && !accept(&next, &self.uv)? {
                let after = (self.score, std::mem::take(&mut self.uv));
                (self.score, self.uv) = before;
                if growth.tolerance.is_some() {
                    return Ok((surface, EndedBy::Defects));
                }
                *accepted = Some(self.end(surface, EndedBy::Defects));
                (self.score, self.uv) = after;
            }
            surface = next;
            if share < DIVIDED {
                return Ok((surface, ended_by));
            }
        }
    }
}

impl Fitting<'_> {
    /// Whether the distances of the points that count are noise, which a finer net would follow.
    fn are_noise(&self, feet: &[Foot]) -> bool {
        let counted = feet.iter().enumerate().filter(|(i, _)| self.weight(*i) > 0.0);
        let (uv, distances): (Vec<DVec2>, Vec<f64>) =
            counted.map(|(_, foot)| (foot.uv, foot.offset.dot(foot.normal))).unzip();
        are_noise(&uv, &distances)
    }
}

/// Twice the distance of the farthest point from the mean of all: unlike the diagonal of their box, it does not
/// hang on how they are turned.
pub(crate) fn diameter(points: &[DVec3]) -> f64 {
    let mean = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
    2.0 * points.iter().map(|point| point.distance(mean)).fold(0.0, f64::max)
}
