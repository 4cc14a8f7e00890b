//! How the outline of a piece is cut into triangles.
//!
//! A piece is a rectangle of the parameters. On its sides stand, besides its own four corners, the
//! corners of its neighbours: with all of them in its triangles no vertex is left on an edge.

#![expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]

use glam::DVec3;

use super::certify::{Corner, Face};
use crate::nurbs::Bending;

/// How an outline is cut: two chains of corners, from one corner of the piece to the opposite one,
/// are joined like a zip; all new edges run between the chains.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Zip {
    /// The lowest bit: whether the chains begin at the corner (1, 0) instead of (0, 0). The next,
    /// from below: whether the next step is on the chain that runs with the outline. From
    /// [`STEPS`] on: how many corners the outline has. Four leave no choice of steps; in their place
    /// stands the share of the tolerance that the two triangles were proven to lie within, in parts
    /// of [`SHARES`]. All in one number, because large meshes have many of them.
    bits: u32,
}

/// Bits for the steps, and the lowest one.
const STEPS: u32 = 27;

/// The whole tolerance, as large as there is room for in place of the steps.
const SHARES: u32 = (1 << (STEPS - 1)) - 1;

/// Most corners of an outline: a [`Zip`] holds the steps of no more.
pub(super) const MOST_CORNERS: usize = 28;

impl Zip {
    /// How many corners the outline has.
    pub(super) fn corners(self) -> usize {
        (self.bits >> STEPS) as usize
    }

    /// The best cut of an outline that has the piece's own corners at these places,
    /// counter-clockwise in the parameters from the corner (0, 0): of each new edge the one that the
    /// surface bends less over, against `tolerance`, and that is shorter, against the outline.
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
        let second = cost(ends[0], ends[2]) <= cost(ends[1], ends[3]);
        Self::chosen(ends, corners.len(), second, |right, left| {
            cost(right.1, left.0) <= cost(right.0, left.1)
        })
    }

    /// The cut whose steps `choose` says.
    #[inline(always)]
    fn chosen(
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
        zip(ends, count, second, choose, |_| ());
        Self { bits: steps | u32::try_from(count).unwrap_or(u32::MAX) << STEPS }
    }

    /// The same cut of four corners, with the share of the tolerance that it was proven to lie within.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share")]
    #[inline(always)]
    pub(super) fn proven(self, share: f64) -> Self {
        if self.corners() > 4 {
            return self;
        }
        // What is cut off is less than one part.
        let parts = 1 + (share.min(1.0) * f64::from(SHARES - 1)) as u32;
        Self { bits: self.bits | parts << 1 }
    }

    /// The share of the tolerance that a cut of four corners was proven to lie within.
    pub(super) fn share(self) -> Option<f64> {
        let parts = self.bits >> 1 & SHARES;
        (self.corners() == 4).then(|| f64::from(parts) / f64::from(SHARES - 1))
    }

    /// A cut of an outline with more corners that keeps the diagonal of this one of four: of each
    /// other new edge the shorter one.
    pub(super) fn grown(self, corners: &[Corner], ends: [usize; 4]) -> Self {
        let second = self.bits & 1 == 1;
        let diagonal = if second { (ends[2], ends[0]) } else { (ends[1], ends[3]) };
        let length = |i: usize, j: usize| corners[i].point.distance_squared(corners[j].point);
        let mut before = true;
        Self::chosen(ends, corners.len(), second, |right, left| {
            let at = (right.0 == diagonal.0, left.0 == diagonal.1);
            before &= at != (true, true);
            // A chain that has come to the diagonal waits there for the other one.
            if before && at.0 != at.1 {
                return at.1;
            }
            length(right.1, left.0) <= length(right.0, left.1)
        })
    }

    /// Appends the triangles of the cut of an outline that has the piece's own corners at these
    /// places.
    #[inline(always)]
    pub(super) fn faces(self, ends: [usize; 4], faces: &mut Vec<Face>) {
        let mut steps = self.bits >> 1;
        let choose = |_, _| {
            let with = steps & 1 == 1;
            steps >>= 1;
            with
        };
        zip(ends, self.corners(), self.bits & 1 == 1, choose, |face| faces.push(face));
    }
}

/// Runs along the chains. Where both may go on, `choose` says which: it gets the ends of both
/// possible steps, (here, there) on the chain that runs with the outline and on the other one.
#[inline(always)]
fn zip(
    ends: [usize; 4],
    count: usize,
    second: bool,
    mut choose: impl FnMut((usize, usize), (usize, usize)) -> bool,
    mut push: impl FnMut(Face),
) {
    let (from, to) = if second { (ends[1], ends[3]) } else { (ends[0], ends[2]) };
    let ahead = |i: usize| if i + 1 == count { 0 } else { i + 1 };
    let behind = |i: usize| if i == 0 { count - 1 } else { i - 1 };
    let (mut right, mut left) = (ahead(from), behind(from));
    let (last_right, last_left) = (behind(to), ahead(to));
    push([from, right, left]);
    while (right, left) != (last_right, last_left) {
        let (next_right, next_left) = (ahead(right), behind(left));
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

    use super::super::bernstein::UNIT;
    use super::*;

    fn outline(places: &[(f64, f64)]) -> Vec<Corner> {
        let corner = |&(x, y): &(f64, f64)| Corner {
            at: DVec2::new(x, y),
            point: DVec3::new(x, y, 0.3 * x * y),
        };
        places.iter().map(corner).collect()
    }

    #[test]
    fn triangles_fill_the_outline_and_none_is_flat() {
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
                let ends = UNIT.map(|at| corners.iter().position(|c| c.at == at).unwrap());
                let cut = Zip::best(&corners, ends, Bending { uu, uv, vv }, 0.01);
                cut.faces(ends, &mut faces);
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
    fn cuts_grow_about_their_diagonal() {
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
        let ends = UNIT.map(|at| corners.iter().position(|c| c.at == at).unwrap());
        for (bending, diagonal) in [(1.0, [1, 3]), (-1.0, [0, 2])] {
            let bending = Bending { uu: 1.0, uv: 0.5 * bending, vv: 1.0 };
            let square = outline(&UNIT.map(|at| (at.x, at.y)));
            let cut = Zip::best(&square, [0, 1, 2, 3], bending, 0.01).proven(0.3);
            let share = cut.share().unwrap();
            assert!((0.3..0.3 + 1e-7).contains(&share), "{share}");
            let mut faces = vec![];
            let grown = cut.grown(&corners, ends).proven(0.3);
            grown.faces(ends, &mut faces);
            assert_eq!((grown.share(), faces.len()), (None, corners.len() - 2));
            let [a, b] = diagonal.map(|k| ends[k]);
            let along = faces.iter().filter(|face| face.contains(&a) && face.contains(&b));
            assert_eq!(along.count(), 2, "{faces:?}");
        }
        assert_eq!(Zip::default().share(), None);
    }
}
