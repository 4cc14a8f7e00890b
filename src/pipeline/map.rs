//! The self-organizing map of a reconstruction: it learns the points from an ordered start.

use glam::{DVec2, DVec3};

use crate::chart::Kind;
use crate::cloud::{Frame, even_sample, items_at};
use crate::error::Result;
use crate::numeric::whole;
use crate::nurbs::{NurbsSurface, Outside};
use crate::progress::Observer;
use crate::som::{Cells, Init, Kernel, Lattice, Schedule, SelfOrganizingMap, SomOptions, Topology};

/// Points that a map learns, at most.
const LEARNED: usize = 20_000;

/// Points for each node, at least, so that the map does not follow single ones.
const POINTS_PER_NODE: usize = 3;

/// Nodes around a closed direction, at least: fewer may shrink to nothing.
const AROUND: usize = 12;

/// Epochs, and the radius in cells at their begin and end.
const EPOCHS: u64 = 10;
const RADIUS: (f64, f64) = (1.0, 0.7);

/// A map that has learned points, and those.
pub(super) struct LearnedMap {
    pub(super) map: SelfOrganizingMap,
    sample: Vec<DVec3>,
}

impl LearnedMap {
    /// From nodes on a surface over [0, 1]², with a lattice like its control net.
    pub(super) fn on_surface(
        points: &[DVec3],
        surface: &NurbsSurface,
        kind: Kind,
        net: (usize, usize),
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let lattice = lattice(net, points.len(), kind)?;
        let (rows, cols) = lattice.shape();
        let closed = kind.closed();
        // A node of an open lattice is the middle of what it stands for.
        let along = |node: usize, count: usize, closed: bool| {
            (node as f64 + if closed { 0.0 } else { 0.5 }) / count as f64
        };
        let place = |at: usize| {
            DVec2::new(along(at / cols, rows, closed.0), along(at % cols, cols, closed.1))
        };
        let uv: Vec<DVec2> = (0..rows * cols).map(place).collect();
        let mut nodes = vec![DVec3::ZERO; uv.len()];
        surface.evaluate(&uv, &mut nodes, Outside::Refuse, observer)?;
        Self::learn(points, lattice, Init::Given(nodes), observer)
    }

    /// From any start.
    pub(super) fn learn(
        points: &[DVec3],
        lattice: Lattice,
        init: Init,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let sample = items_at(points, &even_sample(points, LEARNED));
        let options = SomOptions {
            init,
            kernel: Some(Kernel::Linear),
            radius: Some(Schedule::Exponential { start: RADIUS.0, end: RADIUS.1 }),
            epochs: Some(EPOCHS),
            min_change: Some(f64::MIN_POSITIVE),
            ..SomOptions::default()
        };
        let map = SelfOrganizingMap::fit(&sample, lattice, &options, observer)?;
        Ok(Self { map, sample })
    }

    /// The map in the frame of the given points, as it would have been learned there.
    pub(super) fn in_given_frame(
        &self,
        frame: &Frame,
        observer: &mut dyn Observer,
    ) -> Result<SelfOrganizingMap> {
        let given = |points: &[DVec3]| -> Vec<DVec3> {
            points.iter().map(|&point| frame.to_given(point)).collect()
        };
        let init = Init::Given(given(&self.map.codebook()));
        let options = SomOptions { init, ..SomOptions::default() };
        let (sample, lattice) = (given(&self.sample), self.map.lattice.clone());
        let mut own = SelfOrganizingMap::new(&sample, lattice, &options, observer)?;
        own.steps = self.map.steps;
        own.stopped_by = self.map.stopped_by;
        own.reached = self.map.reached;
        own.change = self.map.change.map(|change| frame.length_to_given(change));
        own.error = self.map.error.map(|error| frame.length_to_given(error));
        Ok(own)
    }
}

/// A lattice like a net, with enough nodes for what is closed and few enough for the points.
pub(super) fn lattice(net: (usize, usize), points: usize, kind: Kind) -> Result<Lattice> {
    let (around_u, around_v) = kind.closed();
    let least = |around| if around { AROUND } else { 3 };
    let least = (least(around_u), least(around_v));
    let net = (net.0.max(least.0), net.1.max(least.1));
    let most = (points / POINTS_PER_NODE).max(least.0 * least.1) as f64;
    let shrink = (most / (net.0 * net.1) as f64).sqrt().min(1.0);
    let side = |count: usize, least| whole(count as f64 * shrink).max(least);
    grid((side(net.0, least.0), side(net.1, least.1)), kind)
}

/// A lattice of so many rows and columns, closed as the kind is.
pub(super) fn grid((rows, cols): (usize, usize), kind: Kind) -> Result<Lattice> {
    let topology = match kind.closed() {
        (false, _) => Topology::Sheet,
        (true, false) => Topology::Tube,
        (true, true) => Topology::Torus,
    };
    Lattice::grid(rows, cols, Cells::Quad, topology)
}
