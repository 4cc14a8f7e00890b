//! What is fitted to which points, and the fit.

use glam::{DVec2, DVec3};

use super::counted::Layers;
use super::feet::feet;
use super::flaws::Flaws;
use super::robust::{self, Robust};
use super::shape::Shape;
use super::{ReconstructOptions, heights};
use crate::cloud::{KdTree, centroid};
use crate::error::{Error, Result};
use crate::fit::{
    self, ApproximateOptions, Approximation, Base, EndedBy, Growth, approximate, continued,
    diameter,
};
use crate::nurbs::NurbsSurface;
use crate::progress::Observer;
use crate::topology::Kind;
use crate::validate::OUTSIDE;

/// How far the surface goes on beyond the points by default, in their mean spacings.
pub(super) const BORDER: f64 = 0.5;

/// Fits without the outliers that the last one showed, and at most, where it shows another one: what draws at a
/// surface makes its distance usual around it, until it is let go.
const ROBUST_FITS: usize = 2;
const MOST_ROBUST_FITS: usize = 4;

/// How far points in pieces may lie from a surface through all of these: as a share of their diameter, and
/// by root mean square, of the pieces' distance, which a surface in the middle is half of away.
const BETWEEN_PIECES: f64 = 0.05;
const NO_MIDDLE: f64 = 0.15;

/// Share of the points that may be outliers for the fairness of heights to be the one found with
/// them: more may have led it astray.
const FEW_OUTLIERS: f64 = 0.01;

/// Share of the heights' standard deviation by which a surface misses them that are none: it passes through the
/// middle of what lies above one another.
const UNLIKE: f64 = 0.2;

/// Points in a frame, to which a surface is fitted.
pub(super) struct Job<'a> {
    pub(super) points: &'a [DVec3],
    pub(super) weights: Option<Vec<f64>>,
    /// Where the map has them; nothing for heights.
    pub(super) uv: Vec<DVec2>,
    /// Where along u the surface has creases.
    pub(super) creases: Vec<f64>,
    pub(super) shape: Shape,
    /// What its pieces may be, if they do not hang together.
    pub(super) layers: Option<Layers>,
    pub(super) options: &'a ReconstructOptions<'a>,
}

/// A surface near them.
pub(super) struct Fit {
    pub(super) surface: NurbsSurface,
    /// What it stands on, of heights.
    pub(super) base: Option<Base>,
    pub(super) uv: Vec<DVec2>,
    pub(super) distances: Vec<f64>,
    pub(super) fairness: f64,
    pub(super) iterations: usize,
    pub(super) ended_by: EndedBy,
}

impl From<Approximation> for Fit {
    fn from(found: Approximation) -> Self {
        let Approximation { surface, uv, distances, fairness, iterations, ended_by, .. } = found;
        Self { surface, base: None, uv, distances, fairness, iterations, ended_by }
    }
}

impl<'a> Job<'a> {
    pub(super) fn weight(&self, index: usize) -> f64 {
        self.weights.as_ref().map_or(1.0, |weights| weights[index])
    }

    /// The points that have weight.
    pub(super) fn counted(&self) -> Vec<DVec3> {
        (0..self.points.len()).filter(|&i| self.weight(i) > 0.0).map(|i| self.points[i]).collect()
    }

    /// The degree that a side of the net has room for.
    pub(super) fn degree(&self, side: usize) -> usize {
        self.options.degree.min(side - 1)
    }

    pub(super) fn border(&self) -> f64 {
        self.options.border.unwrap_or(BORDER)
    }

    /// The fit, without outliers and with free weights as far as the options say.
    pub(super) fn done(
        &mut self,
        net: (usize, usize),
        growth: Option<Growth>,
        observer: &mut dyn Observer,
    ) -> Result<(Fit, Flaws)> {
        let given = self.weights.clone();
        if growth.is_some() && self.layers.is_some() && self.shape.base.is_none() {
            // Through pieces between which a small net folds a larger one grows in vain.
            let small = self.fit(net, None, self.options.fairness, None, observer)?;
            let small = self.flattened(small, None, observer)?;
            if small.1.count() > 0 {
                return Ok(self.across_pieces(given, net, growth, observer)?.unwrap_or(small));
            }
        }
        let mut fit = self.fit(net, growth, self.options.fairness, None, observer)?;
        let mut tree = None;
        let tolerance = growth.and_then(|growth| growth.tolerance);
        for turn in 0..if self.options.robust { MOST_ROBUST_FITS } else { 0 } {
            let found = robust::weights(self.points, &fit.distances, &mut tree, observer)?;
            let Some(found) = found else { break };
            let counts = |index: usize| self.weight(index) > 0.0;
            // What is near and hardly farther than others has changed nothing, unless a net grew for it.
            let doubtful = turn >= ROBUST_FITS || found.slight && growth.is_none();
            if doubtful && !found.has_another(&fit.distances, counts) {
                break;
            }
            let Robust { weights, slight } = found;
            let outliers = weights.iter().filter(|weight| **weight == 0.0).count();
            let few = outliers as f64 <= FEW_OUTLIERS * weights.len() as f64;
            self.weights = Some(product(given.as_deref(), weights));
            let kept = few && (slight || self.shape.base.is_some());
            let again = if kept && tolerance.is_none() {
                // So few have not led it astray, but perhaps ended its growth, unless that was to end where the
                // farthest of them was near enough. The parameters of heights cannot be led astray, but those of
                // others by few that are far from the surface.
                let net = self.different(&fit.surface);
                let growth = growth.filter(|_| turn == 0);
                self.fit_of_rest(net, growth, Some(&fit), observer)?.map(|again| {
                    let ended_by = if growth.is_some() { again.ended_by } else { fit.ended_by };
                    let iterations = fit.iterations + again.iterations;
                    Fit { iterations, ended_by, ..again }
                })
            } else {
                None
            };
            if let Some(again) = again {
                fit = again;
                continue;
            }
            let again = self.fit(net, growth, self.options.fairness, None, observer)?;
            let free = tolerance.is_none() && again.ended_by != EndedBy::Noise;
            if free && self.rms(&again.distances) > self.rms(&fit.distances) {
                // They have not drawn at it, nor made its net grow.
                break;
            }
            fit = again;
        }
        if self.weights != given {
            let found = robust::weights(self.points, &fit.distances, &mut tree, observer)?;
            self.count_again(found.as_ref(), given.as_deref());
        }
        let (mut fit, mut flaws) = self.flattened(fit, growth, observer)?;
        if self.options.robust {
            (fit, flaws) =
                self.without_hidden(fit, flaws, given.as_deref(), growth, &mut tree, observer)?;
        }
        if flaws.spoil(&fit)
            && let Some(found) = self.across_pieces(given, net, growth, observer)?
        {
            (fit, flaws) = found;
        }
        if self.options.rational {
            fit = self.with_free_weights(fit, net, growth, observer)?;
            flaws = self.flaws(&fit, observer)?;
        }
        Ok((fit, flaws))
    }

    /// The fit, or another one without an outlier that only shows now that nothing folds up to it any more.
    fn without_hidden(
        &mut self,
        mut fit: Fit,
        mut flaws: Flaws,
        given: Option<&[f64]>,
        growth: Option<Growth>,
        tree: &mut Option<KdTree<'a>>,
        observer: &mut dyn Observer,
    ) -> Result<(Fit, Flaws)> {
        let free = growth.is_none_or(|growth| growth.tolerance.is_none());
        let free = free && robust::may_stray(self.points, &fit.distances);
        if !free && self.weights.as_deref() == given {
            return Ok((fit, flaws));
        }
        let mut found = robust::weights(self.points, &fit.distances, tree, observer)?;
        let counts = |index: usize| self.weight(index) > 0.0;
        let hidden = |found: &mut Robust| free && found.has_stray(&fit.distances, counts);
        if let Some(Robust { weights, .. }) = found.take_if(hidden) {
            self.weights = Some(product(given, weights));
            let net = self.different(&fit.surface);
            if let Some(again) = self.fit_of_rest(net, None, None, observer)? {
                let again = Fit { ended_by: fit.ended_by, ..again };
                (fit, flaws) = self.flattened(again, growth, observer)?;
            }
            found = robust::weights(self.points, &fit.distances, tree, observer)?;
        }
        let before = self.weights.clone();
        self.count_again(found.as_ref(), given);
        if self.weights != before {
            // Whether points are folded where the surface is, others tell now.
            (fit, flaws) = self.flattened(fit, growth, observer)?;
        }
        Ok((fit, flaws))
    }

    /// The fit of the points that outliers leave, from the one that is known already; `None` if they do not hold
    /// so large a net.
    fn fit_of_rest(
        &self,
        net: (usize, usize),
        growth: Option<Growth>,
        known: Option<&Fit>,
        observer: &mut dyn Observer,
    ) -> Result<Option<Fit>> {
        match self.fit(net, growth, self.options.fairness, known, observer) {
            Ok(again) => Ok(Some(again)),
            Err(Error::Interrupted) => Err(Error::Interrupted),
            Err(_) => Ok(None),
        }
    }

    /// Points that were let go count again, as was `given`, if they are no outliers of the surface that has become.
    fn count_again(&mut self, found: Option<&Robust>, given: Option<&[f64]>) {
        let Some(weights) = &mut self.weights else { return };
        for (i, weight) in weights.iter_mut().enumerate().filter(|(_, weight)| **weight == 0.0) {
            *weight =
                found.map_or(1.0, |found| found.weights[i]) * given.map_or(1.0, |given| given[i]);
        }
    }

    /// A fit with this fairness, from the one that is known already.
    pub(super) fn fit(
        &self,
        net: (usize, usize),
        growth: Option<Growth>,
        fairness: Option<f64>,
        known: Option<&Fit>,
        observer: &mut dyn Observer,
    ) -> Result<Fit> {
        if let Some(base) = &self.shape.base {
            return heights::fit(self, base, net, growth, fairness, known, observer);
        }
        if let Some(known) = known {
            let (from, weights) = (self.flat(known), self.weights.as_deref());
            return Ok(continued(self.points, weights, &from, fairness, growth, observer)?.into());
        }
        let options = ApproximateOptions {
            net,
            degree: (self.degree(net.0), self.degree(net.1)),
            closed: self.shape.closed().closed(),
            fairness,
            border: self.border(),
            creases: self.creases.clone(),
            growth,
            ..ApproximateOptions::default()
        };
        let found =
            approximate(self.points, &self.uv, self.weights.as_deref(), &options, observer)?;
        Ok(found.into())
    }

    /// Heights over the largest of several pieces, if they have no flaws and are near all points: layers
    /// that are close have no order in which one sheet could go through all, but a middle.
    fn across_pieces(
        &mut self,
        given: Option<Vec<f64>>,
        net: (usize, usize),
        growth: Option<Growth>,
        observer: &mut dyn Observer,
    ) -> Result<Option<(Fit, Flaws)>> {
        let free = self.shape.kind == Kind::Sheet && self.options.fairness.is_none();
        let Some(layers) = self.layers.filter(|_| free) else { return Ok(None) };
        let base = Some(heights::rectangle(self.points, layers.normal));
        let heights = Shape::new(Kind::Height, base);
        let (shape, weights) = (
            std::mem::replace(&mut self.shape, heights),
            std::mem::replace(&mut self.weights, given),
        );
        let fit = self.fit(net, growth, None, None, observer)?;
        let (fit, flaws) = self.flattened(fit, growth, observer)?;
        if flaws.count() == 0 && self.near_pieces(&fit) && self.through_pieces(&fit) {
            return Ok(Some((fit, flaws)));
        }
        (self.shape, self.weights) = (shape, weights);
        Ok(None)
    }

    /// Whether a surface is near all points, where they are in pieces.
    pub(super) fn near_pieces(&self, fit: &Fit) -> bool {
        let limit = BETWEEN_PIECES * diameter(self.points);
        self.layers.is_none() || self.largest(&fit.distances) <= limit
    }

    /// Whether points are hardly the heights along z that a surface is of, if it is of heights.
    pub(super) fn misses_heights(&self, fit: &Fit) -> bool {
        if self.shape.kind != Kind::Height {
            return false;
        }
        let mean = centroid(self.points).z;
        let heights: Vec<f64> = self.points.iter().map(|point| point.z - mean).collect();
        self.rms(&fit.distances) > UNLIKE * self.rms(&heights)
    }

    /// Whether a surface goes through the pieces that there are, and not between them.
    pub(super) fn through_pieces(&self, fit: &Fit) -> bool {
        self.layers.is_none_or(|Layers { gap, .. }| self.rms(&fit.distances) <= NO_MIDDLE * gap)
    }

    pub(super) fn flaws(&self, fit: &Fit, observer: &mut dyn Observer) -> Result<Flaws> {
        Flaws::of(&fit.surface, &fit.uv, self, OUTSIDE, observer)
    }

    /// Rows and columns of the net; in closed directions the different ones.
    pub(super) fn different(&self, surface: &NurbsSurface) -> (usize, usize) {
        let (rows, cols) = surface.shape();
        let (closed_u, closed_v) = self.shape.closed().closed();
        let repeated = |closed, degree| if closed { degree } else { 0 };
        (
            rows - repeated(closed_u, surface.knots_u().degree()),
            cols - repeated(closed_v, surface.knots_v().degree()),
        )
    }

    /// The fit with weights of the control points, where that is better; and of a net that may grow
    /// the one it began with, where weights make that as good.
    fn with_free_weights(
        &self,
        grown: Fit,
        first: (usize, usize),
        growth: Option<Growth>,
        observer: &mut dyn Observer,
    ) -> Result<Fit> {
        if let Some(growth) = growth
            && grown.surface.shape() != first
        {
            let small = self.fit(first, None, self.options.fairness, None, observer)?;
            let small = self.freed(small, observer)?;
            let good = match growth.tolerance {
                Some(tolerance) => self.largest(&small.distances) <= tolerance,
                None => self.rms(&small.distances) <= self.rms(&grown.distances),
            };
            if good {
                let ended_by = growth.tolerance.map_or(EndedBy::Exact, |_| EndedBy::Tolerance);
                return Ok(Fit { ended_by, ..small });
            }
        }
        self.freed(grown, observer)
    }

    fn freed(&self, fit: Fit, observer: &mut dyn Observer) -> Result<Fit> {
        let surface = fit::rational(&fit.surface, self.points, self.weights.as_deref(), observer)?;
        if surface == fit.surface {
            return Ok(fit);
        }
        let (uv, distances) = feet(&surface, self.points, observer)?;
        Ok(Fit { surface, uv, distances, ..fit })
    }

    /// The largest of distances that count.
    pub(super) fn largest(&self, distances: &[f64]) -> f64 {
        let counts = |i: &usize| self.weight(*i) > 0.0;
        (0..distances.len()).filter(counts).map(|i| distances[i].abs()).fold(0.0, f64::max)
    }

    pub(super) fn rms(&self, distances: &[f64]) -> f64 {
        let squares = distances.iter().enumerate().map(|(i, d)| self.weight(i) * d * d);
        let weights: f64 = (0..distances.len()).map(|i| self.weight(i)).sum();
        (squares.sum::<f64>() / weights).sqrt()
    }
}

fn product(weights: Option<&[f64]>, others: Vec<f64>) -> Vec<f64> {
    match weights {
        Some(weights) => weights.iter().zip(&others).map(|(a, b)| a * b).collect(),
        None => others,
    }
}
