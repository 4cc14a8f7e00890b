//! Starts over sheets that are wound up, in the order of the ways along them.

use glam::{DVec2, DVec3};

use super::outline::Squared;
use super::start::{
    LEAST_SIDE, MOST_CROSSING, OrderedStart, POINTS_PER_NODE, lattice, net, split, unit_square,
};
use super::{Aspect, ReconstructOptions};
use crate::cloud::{Roads, own_sample};
use crate::error::Result;
use crate::progress::{self, Observer, Stage};
use crate::som::{self, Topology, Unrolled};
use crate::topology::{Lengthwise, lengthwise};

/// Points of a sheet that may be wound up so tightly that fewer miss the way around.
const CLOSELY: [usize; 2] = [6000, 20_000];

/// How many times as many points tell where folds are: all of them would tell more of noise.
const BETWEEN: usize = 4;

/// How many times as many nodes as control points the lattice over such a sheet has: its nodes must not be
/// as far apart as the windings.
const FINER: usize = 4;

/// How many times closer the nodes are along a sheet than across: it is wound up along itself.
const ALONG: f64 = 2.0;

/// Some points of a sheet, and the ways between them.
pub(super) struct Unwound {
    pub(super) few: Vec<DVec3>,
    roads: Roads,
    /// The flat map that keeps the lengths of these ways; `None` if they have no two dimensions.
    pub(super) flat: Option<Unrolled>,
}

impl Unwound {
    /// By so many points of a sample.
    pub(super) fn of(sample: &[DVec3], count: usize, observer: &mut dyn Observer) -> Result<Self> {
        let (few, more) = (own_sample(sample, count), own_sample(sample, BETWEEN * count));
        let mut listen = progress::listener(observer, Stage::Training, few.len());
        let roads = Roads::of(&few, &more, &mut listen)?;
        let flat = som::unroll_along(&few, &roads, &mut listen)?;
        Ok(Self { few, roads, flat })
    }

    /// By enough points of a sample for hardly any way to lead to another winding, if it has so many.
    pub(super) fn closely(sample: &[DVec3], observer: &mut dyn Observer) -> Result<Self> {
        let [few, more] = CLOSELY;
        let found = Self::of(sample, few, observer)?;
        let enough = found.flat.as_ref().is_none_or(|flat| flat.crossing <= MOST_CROSSING);
        if enough { Ok(found) } else { Self::of(sample, more, observer) }
    }

    /// In order over the flat map.
    pub(super) fn unrolled(
        &self,
        count: usize,
        budget: (usize, usize),
        options: &ReconstructOptions<'_>,
        observer: &mut dyn Observer,
    ) -> Result<Option<OrderedStart>> {
        let Some(flat) = &self.flat else { return Ok(None) };
        let Squared { uv, aspect, creases } = unit_square(count, &self.few, &flat.places);
        let start = self.start(&uv, aspect, count, budget, options, observer)?;
        Ok(Some(OrderedStart { creases, ..start }))
    }

    /// In order from one end to the other, and across.
    pub(super) fn lengthwise(
        &self,
        count: usize,
        budget: (usize, usize),
        options: &ReconstructOptions<'_>,
        observer: &mut dyn Observer,
    ) -> Result<Option<OrderedStart>> {
        let found = lengthwise(&self.few, &self.roads.graph);
        let Some(Lengthwise { uv, aspect }) = found else { return Ok(None) };
        self.start(&uv, aspect, count, budget, options, observer).map(Some)
    }

    /// Where the points have these parameters: with many nodes, which stay near their points, as those that
    /// many points draw at would leave a winding for the middle of it, and a net that follows the bends
    /// before it grows.
    fn start(
        &self,
        uv: &[DVec2],
        aspect: f64,
        count: usize,
        budget: (usize, usize),
        options: &ReconstructOptions<'_>,
        observer: &mut dyn Observer,
    ) -> Result<OrderedStart> {
        let nodes = (FINER * budget.0 * budget.1).min(count / POINTS_PER_NODE);
        let nodes = nodes.max(LEAST_SIDE * LEAST_SIDE);
        let shape = match options.aspect {
            Aspect::Data => split(nodes, ALONG * aspect),
            Aspect::Fixed => budget,
        };
        let lattice = lattice(shape, count, Topology::Sheet)?;
        let nodes = som::spread_out_closely(&self.few, uv, &lattice, observer)?;
        let free = options.grid.is_none();
        let net = if free { lattice.shape() } else { net(budget, aspect, options) };
        Ok(OrderedStart::new(lattice, nodes, net))
    }
}
