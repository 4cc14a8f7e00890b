//! Scratch memory for subdividing cells, kept by each thread.

use std::cell::RefCell;

use glam::{DVec2, DVec4};
use pulp::Arch;

use super::basis_weights::BasisWeights;
use super::cell::Cell;
use super::cell_mesh::{Corner, Face};
use super::certify::Certifier;

/// Samples of a cell of several patches along one direction, at most.
pub(super) const MAX_SAMPLES: usize = 4;

/// Scratch memory for subdividing cells.
#[derive(Debug, Default)]
pub(super) struct Workspace {
    /// The vector instructions of this processor.
    pub arch: Arch,
    /// A stack of cells to be subdivided.
    pub cells: Vec<Cell>,
    /// The control nets of these cells, one after the other.
    pub nets: Vec<DVec4>,
    /// The last net projected to space, or samples of a cell of several patches.
    ///
    /// The first three lanes are the coordinates.
    pub points: Vec<DVec4>,
    /// The parameters of the samples in the unit square of the cell.
    pub sample_uv: Vec<DVec2>,
    /// The basis weights of the columns of samples.
    pub columns: [BasisWeights; MAX_SAMPLES],
    /// The control net of a range of patches.
    pub part: Vec<DVec4>,
    /// The outline of the current cell.
    pub corners: Vec<Corner>,
    /// The triangles of the current cell.
    pub faces: Vec<Face>,
    pub certifier: Certifier,
    /// The largest certified distance of a finished cell.
    pub deviation: f64,
}

thread_local! {
    /// The workspace of this thread: for small meshes, allocation would dominate the time.
    static WORKSPACE: RefCell<Workspace> = RefCell::default();
}

impl Workspace {
    /// Runs `work` with this thread's workspace; returns its result and the largest certified
    /// distance.
    ///
    /// `work` must not call this function.
    pub(super) fn with<T>(work: impl FnOnce(&mut Self) -> T) -> (T, f64) {
        WORKSPACE.with_borrow_mut(|workspace| {
            workspace.deviation = 0.0;
            (work(workspace), workspace.deviation)
        })
    }
}
