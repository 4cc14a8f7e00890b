//! Memory that dividing needs, kept by each thread.

use std::cell::RefCell;

use glam::{DVec2, DVec4};
use pulp::Arch;

use super::certify::{Corner, Face, Workspace};
use super::located::Located;
use super::piece::Piece;
use crate::nurbs::MAX_ORDER;

/// Memory that dividing needs.
#[derive(Debug, Default)]
pub(super) struct Desk {
    /// The vector instructions that may be used.
    pub arch: Arch,
    /// The pieces whose nets are on the desk.
    pub pieces: Vec<Piece>,
    /// Nets, one behind the other: those of the pieces around the one being looked at.
    pub nets: Vec<DVec4>,
    /// The control points of the last net in space, in the first three lanes.
    pub points: Vec<DVec4>,
    /// Where in the unit square of a piece of several patches they lie.
    pub places: Vec<DVec2>,
    /// Where its columns lie.
    pub columns: [Located; MAX_ORDER],
    pub part: Vec<DVec4>,
    pub corners: Vec<Corner>,
    pub faces: Vec<Face>,
    pub work: Workspace,
    /// The largest certified distance of a finished piece.
    pub deviation: f64,
}

thread_local! {
    /// Each thread keeps its desk: small meshes would spend much of their time on asking for memory.
    static DESK: RefCell<Desk> = RefCell::default();
}

impl Desk {
    /// What `work`, which must not ask for it again, does at the desk of this thread, and the largest
    /// distance that it has certified.
    pub(super) fn with<T>(work: impl FnOnce(&mut Self) -> T) -> (T, f64) {
        DESK.with_borrow_mut(|desk| {
            desk.deviation = 0.0;
            (work(desk), desk.deviation)
        })
    }
}
