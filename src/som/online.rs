//! Training with one point at a time: the paper's algorithm.

use glam::DVec3;

use super::candidates::Walk;
use super::field::Field;
use super::graph::Visits;
use super::lattice::Distances;
use super::options::Neighborhood;
use super::presentation::Order;
use super::smoothing::edges_within;
use super::{SelfOrganizingMap, StoppedBy, search};
use crate::cloud::Bounds;
use crate::error::Result;
use crate::progress::Observer;

/// Pairs of point and node compared between two reports: a few milliseconds.
const VISITS_PER_REPORT: usize = 1 << 22;

/// What a node costs that is visited along the edges of a graph, in such comparisons.
const EDGE_COST: usize = 16;

/// What online training remembers between presentations.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct OnlineState {
    pub(super) order: Order,
    /// Whether each point lay on the lattice when it was last presented.
    pub(super) on_lattice: Vec<bool>,
    /// Where the nodes were when the epoch began.
    pub(super) epoch_start: Vec<DVec3>,
    /// Sum of the distances from points to their winners since then.
    pub(super) distance: f64,
}

impl OnlineState {
    pub(super) fn new(order: Order, nodes: &[DVec3]) -> Self {
        let on_lattice = vec![false; order.points];
        Self { order, on_lattice, epoch_start: nodes.to_vec(), distance: 0.0 }
    }
}

/// Runs the paper's steps 2 to 7 until a criterion ends them.
pub(super) fn train(
    map: &mut SelfOrganizingMap,
    points: &[DVec3],
    bounds: &Bounds,
    observer: &mut dyn Observer,
) -> Result<()> {
    on_field(map, points.len(), observer, |map, state, field, observer| {
        present_points(map, state, field, (points, bounds), observer)
    })
}

/// Presents points that come and go, each once: those of a distribution or of a chunk.
pub(super) fn present_chunk(
    map: &mut SelfOrganizingMap,
    points: &[DVec3],
    observer: &mut dyn Observer,
) -> Result<()> {
    on_field(map, 0, observer, |map, state, field, observer| {
        let report_every = steps_per_report(map);
        let mut visits = Visits::default();
        for &point in points {
            if map.steps.is_multiple_of(report_every) {
                map.report(observer)?;
            }
            let point = map.frame.apply(point);
            state.distance += present(map, field, &mut visits, point).sqrt();
            if map.steps.is_multiple_of(map.plan.epoch_steps) {
                end_epoch(map, state, field, observer)?;
            }
        }
        Ok(())
    })
}

/// Lends a job the nodes as a field, and takes over where it has left them, however it ended.
fn on_field(
    map: &mut SelfOrganizingMap,
    points: usize,
    observer: &mut dyn Observer,
    job: impl FnOnce(
        &mut SelfOrganizingMap,
        &mut OnlineState,
        &mut Field,
        &mut dyn Observer,
    ) -> Result<()>,
) -> Result<()> {
    let mut field = Field::new(&map.nodes, &map.lattice, &mut || map.report(observer))?;
    map.report(observer)?;
    let mut state = match map.online.take() {
        Some(state) => state,
        None => OnlineState::new(Order::new(map.plan.presentation, points), &map.nodes),
    };
    let result = job(map, &mut state, &mut field, observer);
    map.nodes.iter_mut().zip(field.positions()).for_each(|(node, place)| *node = place);
    map.online = Some(state);
    result
}

fn steps_per_report(map: &SelfOrganizingMap) -> u64 {
    let cost = match map.lattice.distances() {
        Distances::Grid(_) => 1,
        Distances::Graph(_) => EDGE_COST,
    };
    (VISITS_PER_REPORT / (cost * map.lattice.len())).max(1) as u64
}

/// The step at which the epoch that has begun will end.
fn next_epoch_end(map: &SelfOrganizingMap) -> u64 {
    (map.steps / map.plan.epoch_steps + 1) * map.plan.epoch_steps
}

fn present_points(
    map: &mut SelfOrganizingMap,
    state: &mut OnlineState,
    field: &mut Field,
    (points, bounds): (&[DVec3], &Bounds),
    observer: &mut dyn Observer,
) -> Result<()> {
    let report_every = steps_per_report(map);
    let reach_squared = map.plan.reach * map.plan.reach;
    let mut visits = Visits::default();
    let (mut report_at, mut epoch_end) = (map.steps, next_epoch_end(map));
    while map.stopped_by == StoppedBy::Unfinished {
        if map.steps >= report_at {
            map.report(observer)?;
            report_at += report_every;
        }
        // STEP 2
        let Some(index) = state.order.next(&mut map.random) else {
            map.stopped_by = StoppedBy::Reached;
            break;
        };
        let point = map.frame.apply(points[index]);
        // STEPS 3 to 6
        let squared = present(map, field, &mut visits, point);
        state.distance += squared.sqrt();
        let reached = squared <= reach_squared;
        let before = std::mem::replace(&mut state.on_lattice[index], reached);
        map.reached = map.reached + usize::from(reached) - usize::from(before);
        if reached && map.steps >= map.plan.ordered_at {
            state.order.retire();
        }
        // STEP 7
        let mut shown = Ok(());
        if map.steps == epoch_end {
            epoch_end = next_epoch_end(map);
            shown = end_epoch(map, state, field, observer);
            if map.reached == points.len() {
                // A step since may have drawn a node away from a point: look again at all.
                count_reached(map, state, field, (points, bounds), observer)?;
            }
            if map.reached == points.len() {
                map.stopped_by = StoppedBy::Reached;
            } else if map.settled() {
                map.stopped_by = StoppedBy::Settled;
            }
        }
        map.stop_at_last_step();
        shown?;
    }
    count_reached(map, state, field, (points, bounds), observer)?;
    map.report(observer)
}

/// The paper's steps 3 to 6: the winner, its neighbourhood, and their move. Returns the square of
/// the winner's distance before.
fn present(
    map: &mut SelfOrganizingMap,
    field: &mut Field,
    visits: &mut Visits,
    point: DVec3,
) -> f64 {
    map.steps += 1;
    let plan = &map.plan;
    let gain = plan.gain.at(map.steps, plan.max_steps);
    let radius = plan.radius_at(map.steps);
    if plan.neighborhood == Neighborhood::Gaussian {
        field.set_radius(radius);
    }
    let (winner, squared) = field.nearest(point);
    match (plan.neighborhood, map.lattice.distances()) {
        (Neighborhood::Gaussian, Distances::Grid(_)) => {
            field.attract_gaussian(winner, point, gain);
        }
        (Neighborhood::Gaussian, Distances::Graph(graph)) => {
            graph.visit(winner, usize::MAX, visits, |node, hops| {
                // The winner itself moves even when the radius is zero.
                let distance = if hops == 0 { 0.0 } else { hops as f64 / radius };
                field.attract(node..node + 1, point, gain * (-0.5 * distance * distance).exp());
            });
        }
        (Neighborhood::Bubble, Distances::Grid(grid)) => {
            let attract = |nodes| field.attract(nodes, point, gain);
            grid.visit_ball(winner, edges_within(radius), attract);
        }
        (Neighborhood::Bubble, Distances::Graph(graph)) => {
            let attract = |node, _| field.attract(node..node + 1, point, gain);
            graph.visit(winner, edges_within(radius), visits, attract);
        }
    }
    squared
}

/// Notes what an epoch has changed, and shows it.
fn end_epoch(
    map: &mut SelfOrganizingMap,
    state: &mut OnlineState,
    field: &Field,
    observer: &mut dyn Observer,
) -> Result<()> {
    let mut farthest: f64 = 0.0;
    for (start, now) in state.epoch_start.iter_mut().zip(field.positions()) {
        farthest = farthest.max(start.distance_squared(now));
        *start = now;
    }
    map.change = Some(farthest.sqrt());
    map.error = Some(std::mem::take(&mut state.distance) / map.plan.epoch_steps as f64);
    map.show(&state.epoch_start, observer)
}

/// Counts the points that lie on the lattice as it is.
fn count_reached(
    map: &mut SelfOrganizingMap,
    state: &mut OnlineState,
    field: &Field,
    (points, bounds): (&[DVec3], &Bounds),
    observer: &mut dyn Observer,
) -> Result<()> {
    let nodes: Vec<DVec3> = field.positions().collect();
    let reach_squared = map.plan.reach * map.plan.reach;
    let on_lattice = |walk: &mut Walk<'_>, point| walk.nearest(point).1 <= reach_squared;
    let mut found = Vec::with_capacity(points.len());
    let take = |piece: &[bool]| found.extend_from_slice(piece);
    let mut report = |_| map.report(observer);
    search::ask(&nodes, &map.frame, (points, bounds), 1, &mut report, on_lattice, take)?;
    map.reached = found.iter().filter(|&&reached| reached).count();
    state.on_lattice = found;
    Ok(())
}
