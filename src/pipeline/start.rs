//! The map from an ordered start.

use glam::{DVec2, DVec3};

use super::outline::{self, Squared};
use super::own_frame::Frame;
use super::unwound::Unwound;
use super::{Aspect, ReconstructOptions, Start};
use crate::cloud::own_sample;
use crate::error::Result;
use crate::progress::Observer;
use crate::som::{
    self, Init, Kernel, Lattice, Schedule, SelfOrganizingMap, SomOptions, Topology, Unrolled,
};
use crate::topology::{Chart, disc};

/// Points that distances along the surface are found for.
const UNROLLED: usize = 1000;

/// Share of the ways between neighbours that may lead to other folds where the first so many points are
/// enough.
pub(super) const MOST_CROSSING: f64 = 0.002;

/// Points that the angles around a body are found for.
const ON_DISC: usize = 2500;

/// Points without which the corners of an outline are too doubtful to bend a surface there.
pub(super) const TELLING: usize = 600;

/// Least number of points to a node, so that the map does not follow single ones.
pub(super) const POINTS_PER_NODE: usize = 3;

/// Epochs of the map from its ordered start, and the radius it begins and ends with, in cells.
const EPOCHS: u64 = 10;
const RADIUS: (f64, f64) = (1.0, 0.7);

/// By how much distances on a graph widen a sheet at most: a map that is narrower still is so in its
/// middle only, as that of a spindle.
const MOST_WIDENED: f64 = 1.25;

/// Control points that what goes around a tube has, where there are enough: with six of them a circle is a
/// thousandth of its radius off, with ten a tenth of that.
const AROUND: f64 = 10.0;

/// Nodes both ways around the lattice of a torus, at least, however few control points and points there are: rings of
/// eight may shrink to nothing, or turn over half the way along. Around a tube are as many where points are so few that
/// there would be no eight.
const RING: usize = 12;
const FEW: usize = 300;

/// How many times farther apart control points along a tube are at most than around it, where that is free and there
/// are enough points: a long one bends where its net could not follow.
const STRETCHED: f64 = 2.0;

/// Points for each control point of the net that growth begins with.
pub(super) const POINTS_PER_FIRST: usize = 2;

/// Least number of control points in a direction for which a degree is kept.
pub(super) const LEAST_SIDE: usize = 4;

/// Where the lattice lies before it learns, and the net that the surface will have.
pub(super) struct OrderedStart {
    pub(super) lattice: Lattice,
    pub(super) nodes: Vec<DVec3>,
    pub(super) net: (usize, usize),
    /// Where along u the surface has creases.
    pub(super) creases: Vec<f64>,
    /// How many times longer than wide the flat map is that orders it, without creases.
    pub(super) aspect: Option<f64>,
    /// Of a sheet that is wound up, in whose order it is.
    pub(super) unwound: Option<Unwound>,
}

impl OrderedStart {
    /// Without creases, and not over a flat map.
    pub(super) fn new(lattice: Lattice, nodes: Vec<DVec3>, net: (usize, usize)) -> Self {
        Self { lattice, nodes, net, creases: Vec::new(), aspect: None, unwound: None }
    }

    /// For so many points in a frame, by some of them, and what is known of how the surface closes.
    #[expect(
        clippy::too_many_arguments,
        reason = "what is known of the points, and what is wanted"
    )]
    pub(super) fn of(
        count: usize,
        sample: &[DVec3],
        budget: (usize, usize),
        topology: Topology,
        chart: Option<&Chart>,
        frame: &Frame,
        options: &ReconstructOptions<'_>,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let split = |aspect: f64| net(budget, aspect, options);
        if let Start::Given { nodes, shape: (rows, cols) } = options.init {
            let lattice = Lattice::grid(rows, cols, som::Cells::Quad, topology)?;
            let nodes = nodes.iter().map(|&node| frame.apply(node)).collect();
            let net = split(rows as f64 / cols as f64);
            return Ok(Self::new(lattice, nodes, net));
        }
        if let Some(chart) = chart {
            let ratio = chart.lengths.0 / chart.lengths.1;
            let net = if chart.closed_v {
                split(ratio.powf(0.25))
            } else {
                around_tube(budget, ratio, count, options)
            };
            let lattice = lattice(net, count, topology)?;
            let nodes = frame.counted(&chart.lattice(lattice.shape()));
            return Ok(Self::new(lattice, nodes, net));
        }
        if topology == Topology::Sheet && options.init != Start::Pca {
            let sheet = Unwound::of(sample, UNROLLED, observer)?;
            if let Some(flat) = sheet.flat {
                if flat.crossing <= MOST_CROSSING {
                    return Self::over_flat(count, &sheet.few, flat, budget, options, observer);
                }
                let wound = Unwound::closely(sample, observer)?;
                if let Some(start) = wound.unrolled(count, budget, options, observer)? {
                    return Ok(Self { unwound: Some(wound), ..start });
                }
            }
        }
        let net = split(1.0);
        let lattice = lattice(net, count, topology)?;
        let start = SomOptions { init: Init::Pca, seed: options.seed, ..SomOptions::default() };
        let nodes = SelfOrganizingMap::new(sample, lattice.clone(), &start, observer)?.codebook();
        Ok(Self::new(lattice, nodes, net))
    }

    /// In order over the flat map of some of so many points.
    fn over_flat(
        count: usize,
        few: &[DVec3],
        Unrolled { places, .. }: Unrolled,
        budget: (usize, usize),
        options: &ReconstructOptions<'_>,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let Squared { uv, aspect, creases } = unit_square(count, few, &places);
        let over = Self::over(count, few, &uv, net(budget, aspect, options), observer)?;
        let aspect = creases.is_empty().then_some(aspect);
        Ok(Self { creases, aspect, ..over })
    }

    /// Over the disc that a body is which is closed but for an opening; `None` if it is none.
    pub(super) fn over_disc(
        count: usize,
        sample: &[DVec3],
        budget: (usize, usize),
        options: &ReconstructOptions<'_>,
        observer: &mut dyn Observer,
    ) -> Result<Option<Self>> {
        let few = own_sample(sample, ON_DISC);
        let Some(places) = disc(&few, observer)? else { return Ok(None) };
        // In the middle of the square: that its corners are empty shows that it ends in a round outline.
        let uv: Vec<DVec2> = places.iter().map(|place| 0.5 + 0.5 * place).collect();
        Ok(Some(Self::over(count, &few, &uv, net(budget, 1.0, options), observer)?))
    }

    /// In order over a rectangle where some of so many points have these parameters.
    pub(super) fn over(
        count: usize,
        some: &[DVec3],
        uv: &[DVec2],
        net: (usize, usize),
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let lattice = lattice(net, count, Topology::Sheet)?;
        let nodes = som::spread_out(some, uv, &lattice, observer)?;
        Ok(Self::new(lattice, nodes, net))
    }

    /// Splits the budget by how many times longer than wide a sheet is along the map that has learned
    /// it: distances on a graph, by which it was ordered, go zigzag, which widens it.
    pub(super) fn split_as(
        &mut self,
        map: &SelfOrganizingMap,
        budget: (usize, usize),
        options: &ReconstructOptions<'_>,
    ) {
        let Some(flat) = self.aspect else { return };
        let aspect = aspect(map);
        if (flat..=MOST_WIDENED * flat).contains(&aspect) {
            self.net = net(budget, aspect, options);
        }
    }
}

/// What a flat map of some of so many points makes of the unit square.
pub(super) fn unit_square(count: usize, some: &[DVec3], places: &[DVec2]) -> Squared {
    outline::unit_square(places, (count >= TELLING).then_some(some))
}

/// How many times longer than wide a map's lattice is along itself, its outer cells included: nodes lie
/// in the middle of what they stand for.
fn aspect(map: &SelfOrganizingMap) -> f64 {
    let (rows, cols) = map.lattice.shape();
    let nodes = map.codebook();
    let step = |at: usize, stride: usize| nodes[at].distance(nodes[at + stride]);
    let along_u = (0..(rows - 1) * cols).map(|at| step(at, cols)).sum::<f64>();
    let inner = (0..rows * cols).filter(|at| at % cols < cols - 1);
    let along_v = inner.map(|at| step(at, 1)).sum::<f64>();
    // The mean step along u times the rows, by the mean one along v times the columns.
    let (steps_u, steps_v) = ((rows - 1) * cols, rows * (cols - 1));
    (along_u * (rows * steps_v) as f64) / (along_v * (cols * steps_u) as f64)
}

/// The whole number of a size that is not negative.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
pub(super) fn whole(size: f64) -> usize {
    size as usize
}

/// The net of a surface so many times longer than wide.
pub(super) fn net(
    budget: (usize, usize),
    aspect: f64,
    options: &ReconstructOptions<'_>,
) -> (usize, usize) {
    match options.aspect {
        Aspect::Data => split(budget.0 * budget.1, aspect),
        Aspect::Fixed => budget,
    }
}

/// The net of a tube that is so many times longer around than along, through so many points.
fn around_tube(
    budget: (usize, usize),
    ratio: f64,
    points: usize,
    options: &ReconstructOptions<'_>,
) -> (usize, usize) {
    let around = whole(AROUND);
    let along = whole(AROUND / (STRETCHED * ratio)).min(points / (POINTS_PER_FIRST * around));
    let longer = options.grid.is_none() && around * along > budget.0 * budget.1;
    let budget = if longer { (around, along) } else { budget };
    // What goes all the way round bends as often whatever its length, and the error of cubic splines falls with the
    // fourth power of their number.
    let enough = AROUND * AROUND / (budget.0 * budget.1) as f64;
    net(budget, ratio.max(enough), options)
}

/// A budget of control points in rows and columns, for a surface so many times longer than wide.
pub(super) fn split(budget: usize, aspect: f64) -> (usize, usize) {
    let most = (budget / LEAST_SIDE).max(LEAST_SIDE);
    let rows = whole((budget as f64 * aspect).sqrt().round()).clamp(LEAST_SIDE, most);
    let cols = (budget / rows).max(LEAST_SIDE);
    // What is left over may be enough for another row.
    ((budget / cols).max(LEAST_SIDE), cols)
}

/// A lattice like the net, but with enough nodes for what is closed and few enough for the points.
pub(super) fn lattice(net: (usize, usize), points: usize, topology: Topology) -> Result<Lattice> {
    let least = match topology {
        Topology::Torus => (RING, RING),
        Topology::Tube if points < FEW => (RING, 3),
        Topology::Sheet | Topology::Tube => (3, 3),
    };
    let net = (net.0.max(least.0), net.1.max(least.1));
    let most = (points / POINTS_PER_NODE).max(9).max(least.0 * least.1) as f64;
    let shrink = (most / (net.0 * net.1) as f64).sqrt().min(1.0);
    let side = |count: usize, least| whole(count as f64 * shrink).max(least);
    Lattice::grid(side(net.0, least.0), side(net.1, least.1), som::Cells::Quad, topology)
}

pub(super) fn learn(
    sample: &[DVec3],
    start: &OrderedStart,
    observer: &mut dyn Observer,
) -> Result<SelfOrganizingMap> {
    let options = SomOptions {
        init: Init::Given(start.nodes.clone()),
        kernel: Some(Kernel::Linear),
        radius: Some(Schedule::Exponential { start: RADIUS.0, end: RADIUS.1 }),
        epochs: Some(EPOCHS),
        min_change: Some(f64::MIN_POSITIVE),
        ..SomOptions::default()
    };
    SelfOrganizingMap::fit(sample, start.lattice.clone(), &options, observer)
}

/// The map in the points' own frame, as it would have been learned there.
pub(super) fn in_own_frame(
    map: &SelfOrganizingMap,
    sample: &[DVec3],
    frame: &Frame,
    observer: &mut dyn Observer,
) -> Result<SelfOrganizingMap> {
    let points: Vec<DVec3> = sample.iter().map(|&point| frame.undo(point)).collect();
    let nodes = map.codebook().into_iter().map(|node| frame.undo(node)).collect();
    let options = SomOptions { init: Init::Given(nodes), ..SomOptions::default() };
    let mut own = SelfOrganizingMap::new(&points, map.lattice.clone(), &options, observer)?;
    own.steps = map.steps;
    own.stopped_by = map.stopped_by;
    own.reached = map.reached;
    own.change = map.change.map(|change| frame.length(change));
    own.error = map.error.map(|error| frame.length(error));
    Ok(own)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;

    #[test]
    fn aspects_count_outer_cells_and_bends() {
        // Twelve cells around a half cylinder of length 6 π, five of 2 along it.
        let node = |at: usize| {
            let angle = std::f64::consts::PI * ((at / 5) as f64 + 0.5) / 12.0;
            DVec3::new(6.0 * angle.cos(), 6.0 * angle.sin(), 2.0 * (at % 5) as f64)
        };
        let nodes: Vec<DVec3> = (0..60).map(node).collect();
        let lattice = Lattice::grid(12, 5, som::Cells::Quad, Topology::Sheet).unwrap();
        let options = SomOptions { init: Init::Given(nodes.clone()), ..SomOptions::default() };
        let map = SelfOrganizingMap::new(&nodes, lattice, &options, &mut Silent).unwrap();
        let wanted = 0.6 * std::f64::consts::PI;
        assert!((aspect(&map) / wanted - 1.0).abs() < 0.01, "{}", aspect(&map));
    }
}
