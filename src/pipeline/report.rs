//! How a reconstruction went.

use std::time::Duration;

use crate::fit::EndedBy;
use crate::som::{SelfOrganizingMap, StoppedBy};
use crate::topology::Kind;

/// How a reconstruction went. Lengths are in the points' unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Number of points.
    pub points: usize,
    /// Number of points that count: the rest are outliers, duplicates or of other pieces.
    pub inliers: usize,
    /// Length of the diagonal of the points' bounding box.
    pub diagonal: f64,
    /// Rows and columns of the control net.
    pub grid: (usize, usize),
    /// Degrees in u and v.
    pub degree: (usize, usize),
    /// How far the points that count (the inliers) are from the surface.
    pub distances: Distances,
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
    /// What kind of surface it is.
    pub topology: Kind,
    /// Why, if that was found out.
    pub topology_reason: Option<String>,
    /// Points that were merged with others, of those that were looked at.
    pub duplicates: usize,
    /// Points that were left out: far from all that their neighbours could form, or from the
    /// surface.
    pub outliers: usize,
    /// How the map was trained.
    pub training: TrainingReport,
    /// What the user should know, in words.
    pub warnings: Vec<String>,
    /// Time spent, stage by stage.
    pub times: Vec<(&'static str, Duration)>,
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

/// Shares of the points for which [`Distances::percentiles`] says how far away they are at most,
/// in percent.
pub const PERCENTILES: [u32; 4] = [50, 90, 95, 99];

/// What can be said of many distances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distances {
    /// Root of the mean square.
    pub rms: f64,
    /// The largest.
    pub max: f64,
    /// At each of [`PERCENTILES`] the distance that so many percent of the points keep.
    pub percentiles: [f64; 4],
}

impl Distances {
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

/// A clock that is read at the end of each stage.
pub(super) struct Clock {
    last: std::time::Instant,
    times: Vec<(&'static str, Duration)>,
}

impl Clock {
    pub(super) fn start() -> Self {
        Self { last: std::time::Instant::now(), times: Vec::new() }
    }

    /// Ends a stage, perhaps once more.
    pub(super) fn lap(&mut self, stage: &'static str) {
        let now = std::time::Instant::now();
        let spent = now - self.last;
        match self.times.iter_mut().find(|(other, _)| *other == stage) {
            Some((_, before)) => *before += spent,
            None => self.times.push((stage, spent)),
        }
        self.last = now;
    }

    pub(super) fn times(self) -> Vec<(&'static str, Duration)> {
        self.times
    }
}
