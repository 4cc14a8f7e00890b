//! Online training: the paper's algorithm, one point at a time.

use glam::DVec3;

use super::graph::Visits;
use super::lattice::Distances;
use super::map::SelfOrganizingMap;
use super::nearest_lists::Lookup;
use super::online_state::OnlineState;
use super::options::Neighborhood;
use super::presentation_order::PresentationOrder;
use super::search;
use super::simd_nodes::SimdNodes;
use super::smoothing::edges_within;
use super::stop_criterion::StoppedBy;
use crate::cloud::Bounds;
use crate::error::Result;
use crate::progress::Observer;

/// Comparisons of a point with a node between two reports, a few milliseconds.
const VISITS_PER_REPORT: usize = 1 << 22;

/// Cost of visiting a node along the edges of a graph, in comparisons.
const EDGE_COST: usize = 16;

/// Runs the paper's steps 2 to 7 until a stop criterion is met.
pub(super) fn train(
    map: &mut SelfOrganizingMap,
    points: &[DVec3],
    bounds: &Bounds,
    observer: &mut dyn Observer,
) -> Result<()> {
    with_simd_nodes(map, points.len(), observer, |map, state, simd_nodes, observer| {
        present_points(map, state, simd_nodes, (points, bounds), observer)
    })
}

/// Presents each point of a chunk once, in order.
pub(super) fn present_chunk(
    map: &mut SelfOrganizingMap,
    points: &[DVec3],
    observer: &mut dyn Observer,
) -> Result<()> {
    with_simd_nodes(map, 0, observer, |map, state, simd_nodes, observer| {
        let report_every = steps_per_report(map);
        let mut visits = Visits::default();
        for &point in points {
            if map.steps.is_multiple_of(report_every) {
                map.report(observer)?;
            }
            let point = map.frame.apply(point);
            state.distance += present(map, simd_nodes, &mut visits, point).sqrt();
            if map.steps.is_multiple_of(map.plan.epoch_steps) {
                end_epoch(map, state, simd_nodes, observer)?;
            }
        }
        Ok(())
    })
}

/// Runs `job` on the nodes in SIMD layout, and copies their positions back when it ends,
/// interrupted or not.
fn with_simd_nodes(
    map: &mut SelfOrganizingMap,
    points: usize,
    observer: &mut dyn Observer,
    job: impl FnOnce(
        &mut SelfOrganizingMap,
        &mut OnlineState,
        &mut SimdNodes,
        &mut dyn Observer,
    ) -> Result<()>,
) -> Result<()> {
    let mut simd_nodes = SimdNodes::new(&map.nodes, &map.lattice, &mut || map.report(observer))?;
    map.report(observer)?;
    let mut state = match map.online.take() {
        Some(state) => state,
        None => OnlineState::new(PresentationOrder::new(map.plan.presentation, points), &map.nodes),
    };
    let result = job(map, &mut state, &mut simd_nodes, observer);
    map.nodes.iter_mut().zip(simd_nodes.positions()).for_each(|(node, place)| *node = place);
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

/// The step at which the current epoch ends.
fn next_epoch_end(map: &SelfOrganizingMap) -> u64 {
    (map.steps / map.plan.epoch_steps + 1) * map.plan.epoch_steps
}

fn present_points(
    map: &mut SelfOrganizingMap,
    state: &mut OnlineState,
    simd_nodes: &mut SimdNodes,
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
        let squared = present(map, simd_nodes, &mut visits, point);
        state.distance += squared.sqrt();
        let reached = squared <= reach_squared;
        let before = std::mem::replace(&mut state.on_lattice[index], reached);
        map.reached = map.reached + usize::from(reached) - usize::from(before);
        if reached && map.steps >= map.plan.ordered_at {
            state.order.remove_presented();
        }
        // STEP 7
        let mut shown = Ok(());
        if map.steps == epoch_end {
            epoch_end = next_epoch_end(map);
            shown = end_epoch(map, state, simd_nodes, observer);
            if map.reached == points.len() {
                // Later steps may have moved a node away from a point: check all points again.
                count_reached(map, state, simd_nodes, (points, bounds), observer)?;
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
    count_reached(map, state, simd_nodes, (points, bounds), observer)?;
    map.report(observer)
}

/// The paper's steps 3 to 6: finds the winner and moves its neighborhood. Returns the winner's
/// squared distance before the move.
fn present(
    map: &mut SelfOrganizingMap,
    simd_nodes: &mut SimdNodes,
    visits: &mut Visits,
    point: DVec3,
) -> f64 {
    map.steps += 1;
    let plan = &map.plan;
    let gain = plan.gain.at(map.steps, plan.max_steps);
    let radius = plan.radius_at(map.steps);
    if plan.neighborhood == Neighborhood::Gaussian {
        simd_nodes.set_radius(radius);
    }
    let (winner, squared) = simd_nodes.nearest(point);
    match (plan.neighborhood, map.lattice.distances()) {
        (Neighborhood::Gaussian, Distances::Grid(_)) => {
            simd_nodes.attract_gaussian(winner, point, gain);
        }
        (Neighborhood::Gaussian, Distances::Graph(graph)) => {
            graph.visit(winner, usize::MAX, visits, |node, hops| {
                // The winner itself moves even if the radius is zero.
                let distance = if hops == 0 { 0.0 } else { hops as f64 / radius };
                simd_nodes.attract(
                    node..node + 1,
                    point,
                    gain * (-0.5 * distance * distance).exp(),
                );
            });
        }
        (Neighborhood::Bubble, Distances::Grid(grid)) => {
            let attract = |nodes| simd_nodes.attract(nodes, point, gain);
            grid.visit_ball(winner, edges_within(radius), attract);
        }
        (Neighborhood::Bubble, Distances::Graph(graph)) => {
            let attract = |node, _| simd_nodes.attract(node..node + 1, point, gain);
            graph.visit(winner, edges_within(radius), visits, attract);
        }
    }
    squared
}

/// Records the change and error of an epoch, and reports it.
fn end_epoch(
    map: &mut SelfOrganizingMap,
    state: &mut OnlineState,
    simd_nodes: &SimdNodes,
    observer: &mut dyn Observer,
) -> Result<()> {
    let mut farthest: f64 = 0.0;
    for (start, now) in state.epoch_start.iter_mut().zip(simd_nodes.positions()) {
        farthest = farthest.max(start.distance_squared(now));
        *start = now;
    }
    map.change = Some(farthest.sqrt());
    map.error = Some(std::mem::take(&mut state.distance) / map.plan.epoch_steps as f64);
    map.report_epoch(&state.epoch_start, observer)
}

/// Recounts the points on the lattice at its current position.
fn count_reached(
    map: &mut SelfOrganizingMap,
    state: &mut OnlineState,
    simd_nodes: &SimdNodes,
    (points, bounds): (&[DVec3], &Bounds),
    observer: &mut dyn Observer,
) -> Result<()> {
    let nodes: Vec<DVec3> = simd_nodes.positions().collect();
    let reach_squared = map.plan.reach * map.plan.reach;
    let on_lattice = |lookup: &mut Lookup<'_>, point| lookup.nearest(point).1 <= reach_squared;
    let mut found = Vec::with_capacity(points.len());
    let take = |piece: &[bool]| found.extend_from_slice(piece);
    let mut report = |_| map.report(observer);
    search::query(&nodes, &map.frame, (points, bounds), 1, &mut report, on_lattice, take)?;
    map.reached = found.iter().filter(|&&reached| reached).count();
    state.on_lattice = found;
    Ok(())
}
