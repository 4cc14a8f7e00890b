//! The triangles of one cell: corners on its outline and faces between them.

use glam::{DVec2, DVec3};

/// The corners of the unit square, counter-clockwise.
pub(super) const UNIT_SQUARE: [DVec2; 4] =
    [DVec2::new(0.0, 0.0), DVec2::new(1.0, 0.0), DVec2::new(1.0, 1.0), DVec2::new(0.0, 1.0)];

/// A vertex on the outline of a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    /// Its parameters, in the unit square of the cell.
    pub at: DVec2,
    /// Its position in space.
    pub point: DVec3,
}

/// A triangle: indices of three corners, counter-clockwise.
pub(super) type Face = [usize; 3];

/// The triangles of a cell: corners and faces.
pub(super) type CellMesh<'a> = (&'a [Corner], &'a [Face]);
