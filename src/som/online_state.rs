//! The state of online training between presentations, which is saved with the map.

use glam::DVec3;

use super::presentation_order::PresentationOrder;

/// State of online training between presentations.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct OnlineState {
    pub(super) order: PresentationOrder,
    /// Whether each point was on the lattice at its last presentation.
    pub(super) on_lattice: Vec<bool>,
    /// Node positions at the start of the epoch.
    pub(super) epoch_start: Vec<DVec3>,
    /// Sum of the distances from points to their winners in this epoch.
    pub(super) distance: f64,
}

impl OnlineState {
    pub(super) fn new(order: PresentationOrder, nodes: &[DVec3]) -> Self {
        let on_lattice = vec![false; order.points];
        Self { order, on_lattice, epoch_start: nodes.to_vec(), distance: 0.0 }
    }
}
