//! Triangulates a cell with the vertices on its sides, which are corners of its neighbors.

use glam::{DVec2, DVec4};
use pulp::Arch;

use super::block::{Block, GridPoint, fraction};
use super::cell::{Cell, Direction};
use super::cell_mesh::{CellMesh, Corner, UNIT_SQUARE};
use super::certify::{Certifier, ball_bound};
use super::chord::Chord;
use super::lanes::larger;
use super::net::Net;
use super::subdivider::Subdivider;
use super::surface_part::SurfacePart;
use super::triangulation::{MAX_CORNERS, Triangulation};
use super::workspace::Workspace;

/// Certified share of the tolerance above which extending a triangulation is not tried.
///
/// The remaining share is too small for new vertices off the old edges.
const MAX_EXTENDED_SHARE: f64 = 0.9;

impl Subdivider<'_> {
    /// Triangulates a cell with all vertices on its outline.
    ///
    /// Returns the direction to split the cell in if the triangles exceed the limits, or if the
    /// outline has too many vertices.
    pub(super) fn triangulate(
        &self,
        block: Block,
        cell: &mut Cell,
        outline: &[GridPoint],
        workspace: &mut Workspace,
    ) -> Option<Direction> {
        if outline.len() > MAX_CORNERS {
            self.load(block, *cell, workspace);
            return Some(self.split_direction(cell, &workspace.points));
        }
        let ends = cell.corner_indices(outline.iter().copied());
        let more = outline.len() > ends.len();
        let share = cell.triangulation.certified_share();
        let share = share.filter(|share| more && *share < MAX_EXTENDED_SHARE);
        let share = share.filter(|_| self.limits.only_distance());
        if let Some(share) = share {
            self.place_corners((block, *cell), outline, false, workspace);
            if self.extend(cell, ends, share, workspace) {
                return None;
            }
        }
        self.load(block, *cell, workspace);
        let tolerance = self.limits.tolerance;
        let (predicted, bending) = self.predicted_split(cell, &workspace.points);
        if predicted.is_some() {
            return predicted;
        }
        if share.is_none() {
            self.place_corners((block, *cell), outline, true, workspace);
        }
        let Workspace {
            arch,
            nets,
            points,
            sample_uv,
            part,
            corners,
            faces,
            certifier,
            deviation,
            ..
        } = workspace;
        let single = cell.is_single();
        let triangulation = Triangulation::best(corners, ends, bending, tolerance);
        faces.clear();
        triangulation.faces(ends, faces);
        let mesh = (&corners[..], &faces[..]);
        let distance = if !single {
            let samples = (&points[..], &sample_uv[..]);
            self.distance_of_patches(block, *cell, samples, mesh, (*arch, part, certifier))
        } else if certifier.start(mesh) {
            let whole = SurfacePart::whole(Net::single(nets, self.nets.degrees));
            arch.dispatch(certifier.certify(self.conversion, whole, mesh, tolerance))
        } else {
            ball_bound(Net::single(nets, self.nets.degrees), mesh)
        };
        let direction = self.required_split((block, *cell), outline, mesh, (distance, points));
        if direction.is_none() {
            cell.triangulation = triangulation.with_certified_share(distance / tolerance);
            *deviation = deviation.max(distance);
        }
        direction
    }

    /// Writes the corners of an outline to the workspace.
    ///
    /// The corners of the cell are taken from its net if it is `loaded`.
    fn place_corners(
        &self,
        (block, cell): (Block, Cell),
        outline: &[GridPoint],
        loaded: bool,
        workspace: &mut Workspace,
    ) {
        workspace.corners.clear();
        for &(u, v) in outline {
            let at = DVec2::new(fraction(u, cell.u), fraction(v, cell.v));
            let end = UNIT_SQUARE.iter().position(|corner| *corner == at).filter(|_| loaded);
            let point = match end {
                Some(end) => workspace.points[self.corner_indices(&cell)[end]].truncate(),
                None => self.point(block, (u, v)).project(),
            };
            workspace.corners.push(Corner { at, point });
        }
    }

    /// Extends the two certified triangles of a cell by new vertices on its sides.
    ///
    /// Returns false and keeps the old ones if the result folds or could exceed the tolerance.
    ///
    /// The new triangles keep the diagonal: they result from moving the new vertices off the
    /// straight sides. No point of the triangles moves farther than the vertices, so the distance
    /// from the surface increases by at most that. `share` is the certified share of the tolerance.
    fn extend(
        &self,
        cell: &mut Cell,
        ends: [usize; 4],
        share: f64,
        Workspace { corners, faces, certifier, deviation, .. }: &mut Workspace,
    ) -> bool {
        let tolerance = self.limits.tolerance;
        let mut moved = 0.0;
        for (k, &start) in ends.iter().enumerate() {
            let (end, last) = match ends.get(k + 1) {
                Some(&end) => (end, end),
                None => (0, corners.len()),
            };
            let side = Chord::new(corners[start].point, corners[end].point);
            for corner in &corners[start + 1..last] {
                moved = larger(moved, side.distance_squared(corner.point));
            }
        }
        let distance = share * tolerance + moved.sqrt();
        if distance > tolerance {
            return false;
        }
        let triangulation = cell.triangulation.extended(corners, ends);
        faces.clear();
        triangulation.faces(ends, faces);
        let flat = certifier.start((&corners[..], &faces[..]));
        if flat {
            cell.triangulation = triangulation;
            *deviation = deviation.max(distance);
        }
        flat
    }

    /// The certified distance of a cell of several patches.
    ///
    /// A result above the tolerance means only that the tolerance could not be certified.
    ///
    /// `samples` are surface points and their parameters in the unit square of the cell.
    fn distance_of_patches(
        &self,
        block: Block,
        cell: Cell,
        samples: (&[DVec4], &[DVec2]),
        mesh: CellMesh<'_>,
        (arch, net, certifier): (Arch, &mut Vec<DVec4>, &mut Certifier),
    ) -> f64 {
        let limit = self.limits.tolerance;
        if !certifier.start(mesh) || certifier.exceeds(samples, mesh, limit) {
            return f64::INFINITY;
        }
        let mut most = 0.0;
        for range in cell.patch_ranges() {
            net.clear();
            let part = self.surface_part(block, &range, net);
            most = arch.dispatch(certifier.certify(self.conversion, part, mesh, limit));
            if most > limit {
                break;
            }
        }
        most
    }
}
