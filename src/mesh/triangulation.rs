//! Triangulations of a cell's outline.
//!
//! The outline has the four corners of the cell, and on its sides the corners of neighboring cells.
//! All of them become corners of triangles, so no vertex lies on an edge.

#![expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]

use glam::DVec3;

use super::cell_mesh::{Corner, Face};
use crate::nurbs::Bending;

/// A triangulation of an outline, in 32 bits: large meshes have many of them.
///
/// A diagonal of the cell splits the outline into two chains of corners. All new edges go from one
/// chain to the other: each step advances on one of the chains and adds a triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Triangulation {
    /// From the lowest bit on:
    ///
    /// - 1 bit: whether the chains start at the corner (1, 0) of the cell instead of (0, 0);
    /// - up to bit [`STEP_BITS`]: for each step, whether it is on the counter-clockwise chain;
    /// - the other bits: the number of corners.
    ///
    /// An outline of four corners has no steps to choose. It stores the certified distance of its
    /// two triangles instead, as a share of the tolerance, in units of 1 / ([`MAX_SHARE`] - 1).
    bits: u32,
}

/// Bits for the diagonal and the steps.
const STEP_BITS: u32 = 27;

/// The largest share of the tolerance that fits into the bits of the steps.
const MAX_SHARE: u32 = (1 << (STEP_BITS - 1)) - 1;

/// Corners of an outline at most: there are no bits for the steps of more.
pub(super) const MAX_CORNERS: usize = 28;

/// Corners of a cell: an outline without vertices on its sides.
const CELL_CORNERS: usize = 4;

impl Triangulation {
    /// Number of corners of the outline; zero if there is no triangulation yet.
    pub(super) fn corner_count(self) -> usize {
        (self.bits >> STEP_BITS) as usize
    }

    /// A triangulation with a small deviation from the surface and short edges.
    ///
    /// Each new edge is the better of two: its cost is the sag of the surface relative to
    /// `tolerance` plus its length relative to the size of the outline. `ends` are the indices of
    /// the cell's corners, counter-clockwise from (0, 0).
    #[inline(always)]
    pub(super) fn best(
        corners: &[Corner],
        ends: [usize; 4],
        bending: Bending,
        tolerance: f64,
    ) -> Self {
        let extent = diameter(corners).max(f64::MIN_POSITIVE);
        let cost = |i: usize, j: usize| {
            let (a, b) = (corners[i], corners[j]);
            bending.sag(b.at - a.at) / tolerance + a.point.distance(b.point) / extent
        };
        let [a, b, c, d] = ends;
        let second = cost(a, c) <= cost(b, d);
        Self::by_steps(ends, corners.len(), second, |right, left| {
            cost(right.1, left.0) <= cost(right.0, left.1)
        })
    }

    /// The triangulation with the steps that `choose` returns (see [`for_each_face`]).
    #[inline(always)]
    fn by_steps(
        ends: [usize; 4],
        count: usize,
        second: bool,
        mut choose: impl FnMut((usize, usize), (usize, usize)) -> bool,
    ) -> Self {
        let (mut steps, mut bit) = (u32::from(second), 1);
        let choose = |right: (usize, usize), left: (usize, usize)| {
            let with = choose(right, left);
            steps |= u32::from(with).checked_shl(bit).unwrap_or(0);
            bit += 1;
            with
        };
        for_each_face(ends, count, second, choose, |_| ());
        Self { bits: steps | u32::try_from(count).unwrap_or(u32::MAX) << STEP_BITS }
    }

    /// Stores the certified distance as a share of the tolerance, if the outline has four corners.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share")]
    #[inline(always)]
    pub(super) fn with_certified_share(self, share: f64) -> Self {
        if self.corner_count() > CELL_CORNERS {
            return self;
        }
        // Rounded up, so that the stored share is an upper bound.
        let units = 1 + (share.min(1.0) * f64::from(MAX_SHARE - 1)) as u32;
        Self { bits: self.bits | units << 1 }
    }

    /// The certified distance of a triangulation of four corners, as a share of the tolerance.
    pub(super) fn certified_share(self) -> Option<f64> {
        let units = self.bits >> 1 & MAX_SHARE;
        (self.corner_count() == CELL_CORNERS).then(|| f64::from(units) / f64::from(MAX_SHARE - 1))
    }

    /// A triangulation of an outline with more corners that keeps the diagonal of this one.
    ///
    /// Each other new edge is the shorter of two.
    pub(super) fn extended(self, corners: &[Corner], ends: [usize; 4]) -> Self {
        let second = self.bits & 1 == 1;
        let diagonal = if second { (ends[2], ends[0]) } else { (ends[1], ends[3]) };
        let length = |i: usize, j: usize| corners[i].point.distance_squared(corners[j].point);
        let mut before = true;
        Self::by_steps(ends, corners.len(), second, |right, left| {
            let at = (right.0 == diagonal.0, left.0 == diagonal.1);
            before &= at != (true, true);
            // A chain that has reached the diagonal waits for the other one.
            if before && at.0 != at.1 {
                return at.1;
            }
            length(right.1, left.0) <= length(right.0, left.1)
        })
    }

    /// Appends the triangles; `ends` are the indices of the cell's corners in the outline.
    #[inline(always)]
    pub(super) fn faces(self, ends: [usize; 4], faces: &mut Vec<Face>) {
        let mut steps = self.bits >> 1;
        let choose = |_, _| {
            let with = steps & 1 == 1;
            steps >>= 1;
            with
        };
        for_each_face(ends, self.corner_count(), self.bits & 1 == 1, choose, |face| {
            faces.push(face);
        });
    }
}

/// Walks along both chains and calls `push` with each triangle.
///
/// Where both chains can advance, `choose` returns whether the counter-clockwise one does. Its
/// arguments are the two possible steps as (from, to): on the counter-clockwise chain, on the
/// other.
#[inline(always)]
fn for_each_face(
    ends: [usize; 4],
    count: usize,
    second: bool,
    mut choose: impl FnMut((usize, usize), (usize, usize)) -> bool,
    mut push: impl FnMut(Face),
) {
    let (from, to) = if second { (ends[1], ends[3]) } else { (ends[0], ends[2]) };
    let next = |i: usize| if i + 1 == count { 0 } else { i + 1 };
    let previous = |i: usize| if i == 0 { count - 1 } else { i - 1 };
    let (mut right, mut left) = (next(from), previous(from));
    let (last_right, last_left) = (previous(to), next(to));
    push([from, right, left]);
    while (right, left) != (last_right, last_left) {
        let (next_right, next_left) = (next(right), previous(left));
        let with = left == last_left
            || (right != last_right && choose((right, next_right), (left, next_left)));
        if with {
            push([right, next_right, left]);
            right = next_right;
        } else {
            push([right, next_left, left]);
            left = next_left;
        }
    }
    push([right, to, left]);
}

/// The diagonal of the bounding box of an outline.
#[inline(always)]
fn diameter(corners: &[Corner]) -> f64 {
    let first = corners[0].point;
    let grow = |(low, high): (DVec3, DVec3), c: &Corner| (low.min(c.point), high.max(c.point));
    let (low, high) = corners.iter().fold((first, first), grow);
    low.distance(high)
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::super::cell_mesh::UNIT_SQUARE;
    use super::*;

    fn outline(places: &[(f64, f64)]) -> Vec<Corner> {
        let corner = |&(x, y): &(f64, f64)| Corner {
            at: DVec2::new(x, y),
            point: DVec3::new(x, y, 0.3 * x * y),
        };
        places.iter().map(corner).collect()
    }

    #[test]
    fn triangles_fill_the_outline_and_have_positive_area() {
        let sides = [
            vec![(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)],
            vec![(0.0, 0.0), (0.5, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)],
            vec![
                (0.0, 0.0),
                (1.0, 0.0),
                (1.0, 0.25),
                (1.0, 0.5),
                (1.0, 1.0),
                (0.5, 1.0),
                (0.0, 1.0),
            ],
            vec![
                (0.0, 0.0),
                (0.5, 0.0),
                (1.0, 0.0),
                (1.0, 0.5),
                (1.0, 1.0),
                (0.5, 1.0),
                (0.0, 1.0),
                (0.0, 0.5),
            ],
        ];
        for places in &sides {
            let corners = outline(places);
            for (uu, uv, vv) in
                [(1.0, 0.0, 1.0), (0.0, 1.0, 0.0), (0.0, -1.0, 0.0), (-3.0, 0.1, 1.0)]
            {
                let mut faces = vec![];
                let ends = UNIT_SQUARE.map(|at| corners.iter().position(|c| c.at == at).unwrap());
                let triangulation =
                    Triangulation::best(&corners, ends, Bending { uu, uv, vv }, 0.01);
                triangulation.faces(ends, &mut faces);
                assert_eq!(faces.len(), corners.len() - 2);
                let area = |face: &Face| {
                    let [a, b, c] = face.map(|i| corners[i].at);
                    (b - a).perp_dot(c - a) / 2.0
                };
                assert!(faces.iter().all(|face| area(face) > 0.0), "{faces:?}");
                assert!((faces.iter().map(area).sum::<f64>() - 1.0).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn extended_triangulations_keep_the_diagonal() {
        let places = [
            (0.0, 0.0),
            (0.3, 0.0),
            (1.0, 0.0),
            (1.0, 0.25),
            (1.0, 0.5),
            (1.0, 1.0),
            (0.5, 1.0),
            (0.0, 1.0),
            (0.0, 0.5),
        ];
        let corners = outline(&places);
        let ends = UNIT_SQUARE.map(|at| corners.iter().position(|c| c.at == at).unwrap());
        for (bending, diagonal) in [(1.0, [1, 3]), (-1.0, [0, 2])] {
            let bending = Bending { uu: 1.0, uv: 0.5 * bending, vv: 1.0 };
            let square = outline(&UNIT_SQUARE.map(|at| (at.x, at.y)));
            let triangulation =
                Triangulation::best(&square, [0, 1, 2, 3], bending, 0.01).with_certified_share(0.3);
            let share = triangulation.certified_share().unwrap();
            assert!((0.3..0.3 + 1e-7).contains(&share), "{share}");
            let mut faces = vec![];
            let extended = triangulation.extended(&corners, ends).with_certified_share(0.3);
            extended.faces(ends, &mut faces);
            assert_eq!((extended.certified_share(), faces.len()), (None, corners.len() - 2));
            let [a, b] = diagonal.map(|k| ends[k]);
            let along = faces.iter().filter(|face| face.contains(&a) && face.contains(&b));
            assert_eq!(along.count(), 2, "{faces:?}");
        }
        assert_eq!(Triangulation::default().certified_share(), None);
    }
}
