//! Training with one point at a time: the paper's algorithm.

use glam::DVec3;
use rand::SeedableRng;
use rand_pcg::Pcg64;

use super::bmu::{Nodes, VISITS_PER_REPORT};
use super::{Lattice, Plan, SelfOrganizingMap, StoppedBy, initialize, presentation};
use crate::error::Result;
use crate::progress::{self, Observer, Progress, Stage};

/// Runs the paper's steps 1 to 7.
pub(super) fn train(
    points: &[DVec3],
    lattice: Lattice,
    plan: &Plan,
    observer: &mut dyn Observer,
) -> Result<SelfOrganizingMap> {
    let mut rng = Pcg64::seed_from_u64(plan.seed);
    // STEP 1
    let mut nodes = Nodes::new(&initialize::around_centroid(points, lattice.len(), &mut rng));
    let mut epoch = Epoch::new(points.len(), &nodes);
    let report_every = (VISITS_PER_REPORT / lattice.len()).max(1) as u64;
    let reach_squared = plan.reach * plan.reach;
    let mut stopped_by = StoppedBy::MaxSteps;
    let mut step = 0;
    while step < plan.max_steps {
        if step % report_every == 0 {
            progress::report(observer, &epoch.progress(step, plan.max_steps))?;
        }
        step += 1;
        // STEP 2
        let index = presentation::random(points.len(), &mut rng);
        let point = points[index];
        // STEPS 3 and 4
        let (winner, distance_squared) = nodes.nearest(point);
        epoch.note(index, distance_squared <= reach_squared);
        // STEPS 5 and 6
        let gain = plan.gain.at(step);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "the paper's radius counts whole edges; it lies between 0 and the diameter"
        )]
        let radius = if step < plan.ordered_at { plan.radius.at(step) as usize } else { 0 };
        for range in lattice.neighborhood(winner, radius) {
            nodes.attract(range, point, gain);
        }
        // STEP 7
        if step % plan.epoch == 0 {
            epoch.finish(&nodes);
            if epoch.reached == points.len() {
                // A step since may have drawn a node away from a point: look again at all.
                let now = epoch.progress(step, plan.max_steps);
                let mut report = || progress::report(observer, &now);
                nodes.visit_distances(points, &mut report, |index, distance_squared| {
                    epoch.note(index, distance_squared <= reach_squared);
                })?;
            }
            if epoch.reached == points.len() {
                stopped_by = StoppedBy::Reached;
                break;
            }
            if step >= plan.ordered_at
                && epoch.change.is_some_and(|change| change <= plan.min_change)
            {
                stopped_by = StoppedBy::Settled;
                break;
            }
        }
    }
    progress::report(observer, &epoch.progress(step, plan.max_steps))?;
    Ok(SelfOrganizingMap {
        lattice,
        codebook: nodes.positions().collect(),
        steps: step,
        ordered_at: plan.ordered_at,
        stopped_by,
        reached: epoch.reached,
        change: epoch.change,
    })
}

/// What is known of the points and the lattice since the last epoch.
struct Epoch {
    /// Whether each point lay on the lattice when it was last presented.
    on_lattice: Vec<bool>,
    /// How many of them did.
    reached: usize,
    /// Where the nodes were when the epoch began.
    start: Vec<DVec3>,
    /// Largest move of a node during the last finished epoch.
    change: Option<f64>,
}

impl Epoch {
    fn new(points: usize, nodes: &Nodes) -> Self {
        Self {
            on_lattice: vec![false; points],
            reached: 0,
            start: nodes.positions().collect(),
            change: None,
        }
    }

    fn note(&mut self, index: usize, on_lattice: bool) {
        let before = std::mem::replace(&mut self.on_lattice[index], on_lattice);
        self.reached = self.reached + usize::from(on_lattice) - usize::from(before);
    }

    fn finish(&mut self, nodes: &Nodes) {
        let mut farthest: f64 = 0.0;
        for (start, now) in self.start.iter_mut().zip(nodes.positions()) {
            farthest = farthest.max(start.distance_squared(now));
            *start = now;
        }
        self.change = Some(farthest.sqrt());
    }

    fn progress(&self, step: u64, total: u64) -> Progress {
        Progress {
            stage: Stage::Training,
            step,
            total,
            change: self.change,
            reached: self.reached,
            points: self.on_lattice.len(),
        }
    }
}
