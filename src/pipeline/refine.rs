//! The best hypothesis becomes the surface: map, boundary, knots, robust weights, tolerance.

use glam::{DVec2, DVec3};

use super::fitted::Fitted;
use super::map::LearnedMap;
use super::net_shape::net_shape;
use super::options::ReconstructOptions;
use super::outliers::outlier_weights;
use super::start::Start;
use crate::chart::Kind;
use crate::error::{Error, Result};
use crate::fit::{
    Accept, ApproximateOptions, BasePlane, FittedSurface, Growth, HeightOptions, approximate,
    bounded, continued, cutoff_distance, grow_heights, project, rational,
};
use crate::nurbs::ClosestPointSearch;
use crate::progress::Observer;

/// How far outer cells of the map go on for points beyond them, in cells.
const EXTRAPOLATION: f64 = 0.75;

/// How far the surface goes on beyond the points by default, in their mean spacings.
const BORDER: f64 = 0.5;

/// Weight of the fairness of heights that follow a tolerance: it only fills what points leave open.
const LEAST_FAIRNESS: f64 = 1e-9;

/// Fits in which outliers are let go, at most, beside the first.
const REWEIGHTED: usize = 2;

/// What is refined: all points of the local frame, and how they shall lie on a surface.
#[derive(Clone, Copy)]
pub(super) struct Refinement<'a> {
    pub(super) points: &'a [DVec3],
    /// What each squared distance counts; `None`: 1.
    pub(super) weights: Option<&'a [f64]>,
    pub(super) kind: Kind,
    /// Of heights: the plane's axes and the direction of the heights.
    pub(super) heights: Option<[DVec3; 3]>,
    /// Lengths of the surface along u and v.
    pub(super) lengths: [f64; 2],
    /// The noise of the points, and their spacing.
    pub(super) noise: f64,
    pub(super) spacing: f64,
    /// The tolerance in the local frame.
    pub(super) tolerance: Option<f64>,
    pub(super) options: &'a ReconstructOptions<'a>,
}

impl Refinement<'_> {
    /// The surface with the net that growth begins with, from where the points lie on a coarse one.
    pub(super) fn fit(&self, start: &Start, observer: &mut dyn Observer) -> Result<Fitted> {
        let weights = self.robust(&start.distances, self.spacing, observer)?;
        let fitted = if self.heights.is_some() {
            self.heights_with(self.net(), weights, None, self.options.fairness, observer)?
        } else {
            self.sheet(&bounded(&start.uv, self.kind.closed()), weights, observer)?
        };
        self.reweighted(fitted, REWEIGHTED, observer)
    }

    /// The surface with a net that grows as far as the points hold it; and, if finer ones were not
    /// accepted, the last one before. Nets of a given size stay.
    pub(super) fn grown(
        &self,
        small: Fitted,
        accept: Accept<'_>,
        observer: &mut dyn Observer,
    ) -> Result<(Fitted, Option<Fitted>)> {
        if self.options.grid.is_some() {
            return Ok((small, None));
        }
        if self.heights.is_some() {
            let grown = self.heights(small.weights, observer)?;
            return Ok((self.reweighted(grown, REWEIGHTED, observer)?, None));
        }
        let (weights, fairness) = (small.weights.clone(), self.options.fairness);
        self.continued(&small, weights, fairness, self.growth(), accept, observer)
    }

    /// The surface that one becomes with other weights.
    fn on(
        &self,
        known: &Fitted,
        weights: Vec<f64>,
        fairness: Option<f64>,
        observer: &mut dyn Observer,
    ) -> Result<Fitted> {
        Ok(self.continued(known, weights, fairness, None, &|_, _| Ok(true), observer)?.0)
    }

    /// The same with a net that may grow; and the last one before, if finer ones were not accepted.
    fn continued(
        &self,
        known: &Fitted,
        weights: Vec<f64>,
        fairness: Option<f64>,
        growth: Option<Growth>,
        accept: Accept<'_>,
        observer: &mut dyn Observer,
    ) -> Result<(Fitted, Option<Fitted>)> {
        let from = FittedSurface {
            surface: &known.surface,
            uv: &known.uv,
            closed: self.kind.closed(),
            fairness: known.fairness,
        };
        let (points, given) = (self.points, Some(weights.as_slice()));
        let found = continued(points, given, &from, fairness, growth, accept, observer)?;
        let accepted = found.accepted.map(|found| Fitted::new(found, weights.clone()));
        Ok((Fitted::new(found.finest, weights), accepted))
    }

    /// The same surface without the outliers that it shows, in so many turns at most.
    fn reweighted(
        &self,
        mut fitted: Fitted,
        turns: usize,
        observer: &mut dyn Observer,
    ) -> Result<Fitted> {
        for _ in 0..turns {
            let weights = self.robust(&fitted.distances, 0.0, observer)?;
            if same_outliers(&weights, &fitted.weights) {
                break;
            }
            fitted = if self.heights.is_some() {
                let (net, fairness) = (fitted.surface.shape(), Some(fitted.fairness));
                let again = self.heights_with(net, weights, None, fairness, observer)?;
                Fitted { ended_by: fitted.ended_by, ..again }
            } else {
                self.on(&fitted, weights, self.options.fairness, observer)?
            };
        }
        Ok(fitted)
    }

    /// The surface from a map alone.
    pub(super) fn fit_map(&self, map: &LearnedMap, observer: &mut dyn Observer) -> Result<Fitted> {
        let weights = self.robust(&[], 0.0, observer)?;
        let fitted = if self.heights.is_some() {
            self.heights(weights, observer)?
        } else {
            let uv = map.map.parametrize(self.points, EXTRAPOLATION, observer)?;
            self.sheet(&bounded(&uv, self.kind.closed()), weights, observer)?
        };
        Ok(self.grown(fitted, &|_, _| Ok(true), observer)?.0)
    }

    /// The surface with this fairness and the net that it has.
    pub(super) fn smoother(
        &self,
        known: &Fitted,
        fairness: f64,
        observer: &mut dyn Observer,
    ) -> Result<Fitted> {
        self.on(known, known.weights.clone(), Some(fairness), observer)
    }

    /// The surface within the tolerance, if there is one and a nearer surface is found: its net
    /// grows on until the tolerance holds. It is nearer both by root mean square and at most.
    pub(super) fn within_tolerance(
        &self,
        fitted: &Fitted,
        accept: Accept<'_>,
        observer: &mut dyn Observer,
    ) -> Result<Option<Fitted>> {
        let Some(tolerance) = self.tolerance else { return Ok(None) };
        let growth = Growth { tolerance: Some(tolerance), most: self.options.max_control_points };
        let mut best: Option<Fitted> = None;
        // With next to no fairness few points are followed, too.
        for fairness in [self.options.fairness, Some(LEAST_FAIRNESS)] {
            let from = best.as_ref().unwrap_or(fitted);
            if from.max() <= tolerance {
                break;
            }
            let weights = from.weights.clone();
            let nearer = if self.heights.is_some() {
                self.heights_with(self.net(), weights, Some(growth), fairness, observer)
            } else {
                let grown = Some(growth);
                self.continued(from, weights, fairness, grown, accept, observer).map(|all| all.0)
            };
            match nearer {
                Err(Error::Interrupted) => return Err(Error::Interrupted),
                Ok(nearer) if nearer.max() <= from.max() && nearer.rms() <= from.rms() => {
                    best = Some(nearer);
                }
                _ => {}
            }
        }
        Ok(best)
    }

    /// The weights that were given, less what outliers lose. No distance under `least` or within the
    /// noise makes an outlier.
    fn robust(
        &self,
        distances: &[f64],
        least: f64,
        observer: &mut dyn Observer,
    ) -> Result<Vec<f64>> {
        let mut weights =
            self.weights.map_or_else(|| vec![1.0; self.points.len()], <[f64]>::to_vec);
        if self.options.robust
            && !distances.is_empty()
            && let Some(found) = outlier_weights(
                self.points,
                distances,
                least.max(cutoff_distance(self.noise)),
                observer,
            )?
        {
            weights.iter_mut().zip(found).for_each(|(weight, share)| *weight *= share);
        }
        Ok(weights)
    }

    fn growth(&self) -> Option<Growth> {
        let free = self.options.grid.is_none();
        free.then_some(Growth { tolerance: None, most: self.options.max_control_points })
    }

    fn degree(&self, (rows, cols): (usize, usize)) -> (usize, usize) {
        (self.options.degree.min(rows - 1), self.options.degree.min(cols - 1))
    }

    pub(super) fn net(&self) -> (usize, usize) {
        net_shape(self.points.len(), self.kind, self.lengths, self.options)
    }

    fn sheet(
        &self,
        uv: &[DVec2],
        weights: Vec<f64>,
        observer: &mut dyn Observer,
    ) -> Result<Fitted> {
        let net = self.net();
        let options = ApproximateOptions {
            net,
            degree: self.degree(net),
            closed: self.kind.closed(),
            fairness: self.options.fairness,
            border: self.options.border.unwrap_or(BORDER),
            ..ApproximateOptions::default()
        };
        let found = approximate(self.points, uv, Some(&weights), &options, observer)?;
        Ok(Fitted::new(found, weights))
    }

    fn heights(&self, weights: Vec<f64>, observer: &mut dyn Observer) -> Result<Fitted> {
        self.heights_with(self.net(), weights, self.growth(), self.options.fairness, observer)
    }

    /// Heights whose net grows if it may.
    fn heights_with(
        &self,
        net: (usize, usize),
        weights: Vec<f64>,
        growth: Option<Growth>,
        fairness: Option<f64>,
        observer: &mut dyn Observer,
    ) -> Result<Fitted> {
        let [along, across, up] = self.heights.unwrap_or(DVec3::AXES);
        let base = BasePlane { axes: [along, across], up };
        let options = HeightOptions { net, degree: self.degree(net), fairness };
        let most = net.0 * net.1;
        let growth = growth.unwrap_or(Growth { tolerance: None, most });
        let (fit, ended_by) =
            grow_heights(self.points, Some(&weights), &base, &options, growth, observer)?;
        let (uv, distances) = project(&fit.surface, (false, false), self.points, &fit.uv);
        let squares = |all: &[f64]| {
            all.iter().zip(&weights).map(|(off, weight)| weight * off * off).sum::<f64>()
        };
        let slope = squares(&distances) / squares(&fit.residuals);
        let expected = fit.expected.is_finite().then_some(slope * fit.expected);
        let (surface, fairness) = (fit.surface, fit.fairness);
        Ok(Fitted { surface, uv, distances, weights, fairness, expected, iterations: 1, ended_by })
    }

    /// The surface with weights of the control points, where that is nearer.
    pub(super) fn rational(&self, fitted: Fitted, observer: &mut dyn Observer) -> Result<Fitted> {
        let weights = Some(fitted.weights.as_slice());
        let surface = rational(&fitted.surface, self.points, weights, observer)?;
        if surface == fitted.surface {
            return Ok(fitted);
        }
        let (uv, distances) =
            ClosestPointSearch::new(&surface)?.closest_parameters(self.points, observer)?;
        Ok(Fitted { surface, uv, distances, ..fitted })
    }
}

/// Whether two sets of weights let the same points go.
fn same_outliers(some: &[f64], others: &[f64]) -> bool {
    some.iter().zip(others).all(|(a, b)| (*a == 0.0) == (*b == 0.0))
}
