//! How a reconstruction went.

use std::time::Duration;

use glam::DVec3;

use super::candidate::Candidate;
use crate::chart::Kind;
use crate::diagnostic::Diagnostic;
use crate::fit::EndedBy;
use crate::som::{SelfOrganizingMap, StoppedBy};

/// How a reconstruction went. Lengths are in the points' unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Number of points.
    pub points: usize,
    /// Number of points used in the fit, merged duplicates among them.
    pub inliers: usize,
    /// Length of the diagonal of the points' bounding box.
    pub diagonal: f64,
    /// Rows and columns of the control net.
    pub grid: (usize, usize),
    /// Degrees in u and v.
    pub degree: (usize, usize),
    /// How far the inliers are from the surface.
    pub deviations: Deviations,
    /// The tolerance that was asked for.
    pub tolerance: Option<f64>,
    /// Share of the inliers that lie within the tolerance; `None` without one.
    pub within: Option<f64>,
    /// What ended the growth of the net.
    pub ended_by: EndedBy,
    /// Weight of the fairness that the fit ended with; `None` if nothing was fitted.
    pub fairness: Option<f64>,
    /// Solutions for the control net.
    pub iterations: usize,
    /// The kind of surface.
    pub kind: Kind,
    /// The direction of the heights in the points' frame, of a height field.
    pub direction: Option<DVec3>,
    /// What each coordinate was divided by for the fit; 1 unless the axes have different units.
    pub axis_scale: DVec3,
    /// Whether the surface has no defects.
    pub valid: bool,
    /// Whether the tolerance, if there was one, is reached. Of the paper's method: whether training
    /// ended by itself.
    pub converged: bool,
    /// Every hypothesis with its score and why it lost, the best first.
    pub candidates: Vec<Candidate>,
    /// What the user should know.
    pub diagnostics: Vec<Diagnostic>,
    /// Points that lie where others do and were merged with them.
    pub duplicates: usize,
    /// Points that were left out as outliers: far from their neighbours, or from the surface.
    /// Points with a no-data value are among them.
    pub outliers: usize,
    /// How the map was trained.
    pub training: TrainingReport,
    /// Wall time of each stage in seconds; their sum is that of the whole job.
    pub seconds: Vec<(&'static str, f64)>,
}

impl Report {
    /// Adds what the stages leave of the whole job's time.
    pub(super) fn account_for(&mut self, elapsed: Duration) {
        let known: f64 = self.seconds.iter().map(|(_, seconds)| seconds).sum();
        self.seconds.push(("other", (elapsed.as_secs_f64() - known).max(0.0)));
    }
}

/// How a map was trained.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrainingReport {
    /// Steps made: presentations of online training, epochs of batch training.
    pub steps: u64,
    /// The paper's t₀; see [`SelfOrganizingMap::ordered_at`].
    pub ordered_at: u64,
    /// What ended the training.
    pub stopped_by: StoppedBy,
    /// Points on the lattice at the end; see [`SelfOrganizingMap::reached`].
    pub reached: usize,
    /// Largest move of a node during the last epoch; `None` if not even one was finished.
    pub change: Option<f64>,
    /// Mean distance from a point to its nearest node.
    pub quantization_error: f64,
}

impl TrainingReport {
    pub(super) fn of(som: &SelfOrganizingMap, quantization_error: f64) -> Self {
        Self {
            steps: som.steps,
            ordered_at: som.ordered_at,
            stopped_by: som.stopped_by,
            reached: som.reached,
            change: som.change,
            quantization_error,
        }
    }
}

/// Shares of the points for which [`Deviations::percentiles`] says how far away they are at most,
/// in percent.
pub const PERCENTILES: [u32; 4] = [50, 90, 95, 99];

/// What can be said of many distances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviations {
    /// Root of the mean square.
    pub rms: f64,
    /// The largest.
    pub max: f64,
    /// At each of [`PERCENTILES`] the distance that so many percent of the points keep.
    pub percentiles: [f64; 4],
}

impl Deviations {
    /// Of these distances; zeros of none.
    pub(super) fn of(mut distances: Vec<f64>) -> Self {
        if distances.is_empty() {
            return Self { rms: 0.0, max: 0.0, percentiles: [0.0; 4] };
        }
        let count = distances.len();
        let squares: f64 = distances.iter().map(|distance| distance * distance).sum();
        let max = distances.iter().copied().fold(0.0, f64::max);
        let mut rank = |percent: u32| {
            let place = (count * percent as usize).div_ceil(100) - 1;
            *distances.select_nth_unstable_by(place, f64::total_cmp).1
        };
        let percentiles = PERCENTILES.map(&mut rank);
        Self { rms: (squares / count as f64).sqrt(), max, percentiles }
    }
}
