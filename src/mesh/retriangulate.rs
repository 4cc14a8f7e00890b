//! How a piece is cut into triangles with all the vertices that neighbours have put on its sides.

use glam::{DVec2, DVec4};
use pulp::Arch;

use super::bernstein::UNIT;
use super::certify::{self, Corner, Faces, Part, Workspace};
use super::chord::Chord;
use super::desk::Desk;
use super::divider::{Divider, share};
use super::net::Net;
use super::outline::{MOST_CORNERS, Zip};
use super::piece::{Block, Direction, Piece};
use super::stitch::Place;
use super::triangle::larger;

/// Share of the tolerance from which on a proof leaves so little that new vertices hardly ever keep
/// within it.
const GROWS: f64 = 0.9;

impl Divider<'_> {
    /// Cuts a piece with all the vertices on its outline into triangles. The direction to divide it
    /// in because they do not meet the limits, or because they are too many; `None` if they do.
    pub(super) fn check(
        &self,
        block: Block,
        piece: &mut Piece,
        outline: &[Place],
        desk: &mut Desk,
    ) -> Option<Direction> {
        if outline.len() > MOST_CORNERS {
            self.load(block, *piece, desk);
            return Some(self.steeper(piece, &desk.points));
        }
        let ends = piece.ends(outline.iter().copied());
        let share = piece.cut.share().filter(|share| outline.len() > 4 && *share < GROWS);
        let share = share.filter(|_| self.limits.only_distance());
        if let Some(share) = share {
            self.place((block, *piece), outline, false, desk);
            if self.grow(piece, ends, share, desk) {
                return None;
            }
        }
        self.load(block, *piece, desk);
        let tolerance = self.limits.tolerance;
        let (bent, bending) = self.bent(piece, &desk.points);
        if bent.is_some() {
            return bent;
        }
        if share.is_none() {
            self.place((block, *piece), outline, true, desk);
        }
        let Desk { arch, nets, points, places, part, corners, faces, work, deviation, .. } = desk;
        let single = piece.is_single();
        let cut = Zip::best(corners, ends, bending, tolerance);
        faces.clear();
        cut.faces(ends, faces);
        let mesh = (&corners[..], &faces[..]);
        let distance = if !single {
            self.distance_of_patches(block, *piece, (points, places), mesh, (*arch, part, work))
        } else if work.begin(mesh) {
            let whole = Part::whole(Net::single(nets, self.nets.degrees));
            arch.dispatch(work.certify(self.bernstein, whole, mesh, tolerance))
        } else {
            certify::ball(Net::single(nets, self.nets.degrees), mesh)
        };
        let direction = self.unfit((block, *piece), outline, mesh, (distance, points));
        if direction.is_none() {
            piece.cut = cut.proven(distance / tolerance);
            *deviation = deviation.max(distance);
        }
        direction
    }

    /// Puts the corners of an outline on the desk; those of the piece are known if it is loaded.
    fn place(
        &self,
        (block, piece): (Block, Piece),
        outline: &[Place],
        loaded: bool,
        desk: &mut Desk,
    ) {
        desk.corners.clear();
        for &(u, v) in outline {
            let at = DVec2::new(share(u, piece.u), share(v, piece.v));
            let end = UNIT.iter().position(|corner| *corner == at).filter(|_| loaded);
            let point = match end {
                Some(end) => desk.points[self.ends(&piece)[end]].truncate(),
                None => self.point(block, (u, v)).project(),
            };
            desk.corners.push(Corner { at, point });
        }
    }

    /// Whether the triangles that a piece was proven with hold with new vertices on its sides: then it
    /// is cut into triangles with them.
    ///
    /// Triangles that keep the edge between the two come from them by moving the new vertices off
    /// their sides. No point moves further than these do, so neither does the distance from the
    /// surface grow by more.
    fn grow(
        &self,
        piece: &mut Piece,
        ends: [usize; 4],
        share: f64,
        Desk { corners, faces, work, deviation, .. }: &mut Desk,
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
                moved = larger(moved, side.squared(corner.point));
            }
        }
        let distance = share * tolerance + moved.sqrt();
        if distance > tolerance {
            return false;
        }
        let cut = piece.cut.grown(corners, ends);
        faces.clear();
        cut.faces(ends, faces);
        let sheet = work.begin((&corners[..], &faces[..]));
        if sheet {
            piece.cut = cut;
            *deviation = deviation.max(distance);
        }
        sheet
    }

    /// The certified distance of a piece of several patches, on which these points lie at these places,
    /// or anything above the tolerance.
    fn distance_of_patches(
        &self,
        block: Block,
        piece: Piece,
        points: (&[DVec4], &[DVec2]),
        mesh: Faces<'_>,
        (arch, net, work): (Arch, &mut Vec<DVec4>, &mut Workspace),
    ) -> f64 {
        let limit = self.limits.tolerance;
        if !work.begin(mesh) || work.misses(points, mesh, limit) {
            return f64::INFINITY;
        }
        let mut most = 0.0;
        for of_piece in piece.parts() {
            net.clear();
            let part = self.part(block, &of_piece, net);
            most = arch.dispatch(work.certify(self.bernstein, part, mesh, limit));
            if most > limit {
                break;
            }
        }
        most
    }
}
