//! The self-organizing map of a reconstruction, trained from nodes that are already in order.

use glam::{DVec2, DVec3};

use super::settings::MapSettings;
use crate::chart::Kind;
use crate::cloud::{Frame, even_sample, items_at};
use crate::error::Result;
use crate::numeric::whole;
use crate::nurbs::{NurbsSurface, Outside};
use crate::progress::Observer;
use crate::som::{Cells, Init, Kernel, Lattice, Schedule, SelfOrganizingMap, SomOptions, Topology};

const SETTINGS: MapSettings = MapSettings::STANDARD;

/// A trained map with the points and the nodes that its training started with.
pub(super) struct TrainedMap {
    pub(super) map: SelfOrganizingMap,
    sample: Vec<DVec3>,
    start: Vec<DVec3>,
}

impl TrainedMap {
    /// Trains a map from nodes on a surface over [0, 1]². Its lattice has about the shape of the
    /// surface's net.
    pub(super) fn on_surface(
        points: &[DVec3],
        surface: &NurbsSurface,
        kind: Kind,
        net: (usize, usize),
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let lattice = lattice_like(net, points.len(), kind)?;
        let (rows, cols) = lattice.shape();
        let closed = kind.closed();
        // A node of an open lattice is the middle of its cell.
        let along = |node: usize, count: usize, closed: bool| {
            (node as f64 + if closed { 0.0 } else { 0.5 }) / count as f64
        };
        let place = |at: usize| {
            DVec2::new(along(at / cols, rows, closed.0), along(at % cols, cols, closed.1))
        };
        let uv: Vec<DVec2> = (0..rows * cols).map(place).collect();
        let mut nodes = vec![DVec3::ZERO; uv.len()];
        surface.evaluate(&uv, &mut nodes, Outside::Refuse, observer)?;
        Self::train(points, lattice, nodes, observer)
    }

    /// Trains a map from these nodes.
    pub(super) fn train(
        points: &[DVec3],
        lattice: Lattice,
        start: Vec<DVec3>,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let sample = items_at(points, &even_sample(points, SETTINGS.max_points));
        let map = SelfOrganizingMap::fit(&sample, lattice, &options(start.clone()), observer)?;
        Ok(Self { map, sample, start })
    }

    /// The map in the frame of the given points, with the state that training there would leave,
    /// and the options of that training.
    pub(super) fn in_given_frame(
        &self,
        frame: &Frame,
        observer: &mut dyn Observer,
    ) -> Result<(SelfOrganizingMap, SomOptions)> {
        let given = |points: &[DVec3]| -> Vec<DVec3> {
            points.iter().map(|&point| frame.to_given(point)).collect()
        };
        let ended = options(given(&self.map.codebook()));
        let (sample, lattice) = (given(&self.sample), self.map.lattice.clone());
        let mut own = SelfOrganizingMap::new(&sample, lattice, &ended, observer)?;
        own.steps = self.map.steps;
        own.stopped_by = self.map.stopped_by;
        own.reached = self.map.reached;
        own.change = self.map.change.map(|change| frame.length_to_given(change));
        own.error = self.map.error.map(|error| frame.length_to_given(error));
        Ok((own, options(given(&self.start))))
    }
}

/// The options of a training that starts with these nodes, which are in order.
fn options(start: Vec<DVec3>) -> SomOptions {
    let radius = Schedule::Exponential { start: SETTINGS.start_radius, end: SETTINGS.end_radius };
    SomOptions {
        init: Init::Given(start),
        kernel: Some(Kernel::Linear),
        radius: Some(radius),
        epochs: Some(SETTINGS.epochs),
        min_change: Some(f64::MIN_POSITIVE),
        ..SomOptions::default()
    }
}

/// A lattice of about the shape of a net: enough nodes around closed directions, and enough points
/// for each node.
fn lattice_like(net: (usize, usize), points: usize, kind: Kind) -> Result<Lattice> {
    let (closed_u, closed_v) = kind.closed();
    let least = |closed| if closed { SETTINGS.min_around } else { SETTINGS.min_side };
    let least = (least(closed_u), least(closed_v));
    let net = (net.0.max(least.0), net.1.max(least.1));
    let most = (points / SETTINGS.points_per_node).max(least.0 * least.1) as f64;
    let shrink = (most / (net.0 * net.1) as f64).sqrt().min(1.0);
    let side = |count: usize, least| whole(count as f64 * shrink).max(least);
    lattice((side(net.0, least.0), side(net.1, least.1)), kind)
}

/// A lattice of these rows and columns that closes as the kind does.
pub(super) fn lattice((rows, cols): (usize, usize), kind: Kind) -> Result<Lattice> {
    let topology = match kind.closed() {
        (false, _) => Topology::Sheet,
        (true, false) => Topology::Tube,
        (true, true) => Topology::Torus,
    };
    Lattice::grid(rows, cols, Cells::Quad, topology)
}
