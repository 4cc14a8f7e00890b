//! How the outline of a piece is cut into triangles.
//!
//! A piece is a rectangle of the parameters. On its sides stand, besides its own four corners, the
//! corners of its neighbours: with all of them in its triangles no vertex is left on an edge.

use glam::{DVec2, DVec3, DVec4};

use super::certify::{Corner, Face};

/// How the surface bends over the unit square of a net: the second derivatives of its height above
/// the plane of the diagonals.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bending {
    uu: f64,
    uv: f64,
    vv: f64,
}

impl Bending {
    /// Of a net of degrees p and q: the mean of its second differences.
    pub(super) fn of(net: &[DVec4], (p, q): (usize, usize)) -> Self {
        let width = q + 1;
        let point = |i: usize, j: usize| net[i * width + j].truncate() / net[i * width + j].w;
        let across = (point(p, q) - point(0, 0)).cross(point(0, q) - point(p, 0));
        let normal = across.normalize_or_zero();
        let height = |i: usize, j: usize| normal.dot(point(i, j));
        let (mut uu, mut vv) = (0.0, 0.0);
        for j in 0..=q {
            // Second differences telescope to the difference of the first ones at the ends.
            uu += height(p, j) - height(p - 1, j) - height(1, j) + height(0, j);
        }
        for i in 0..=p {
            vv += height(i, q) - height(i, q - 1) - height(i, 1) + height(i, 0);
        }
        let twist = height(p, q) - height(p, 0) - height(0, q) + height(0, 0);
        Self { uu: uu * p as f64 / (q + 1) as f64, uv: twist, vv: vv * q as f64 / (p + 1) as f64 }
    }

    /// About how far the surface leaves the chord over this step, in the unit square, at most.
    fn sag(&self, step: DVec2) -> f64 {
        let Self { uu, uv, vv } = self;
        (uu * step.x * step.x + 2.0 * uv * step.x * step.y + vv * step.y * step.y).abs() / 8.0
    }
}

/// Appends the triangles of an outline, counter-clockwise in the parameters, that begins at the
/// corner (0, 0): of each new edge the one that the surface bends less over, against `tolerance`,
/// and that is shorter, against the outline.
pub(super) fn triangulate(
    corners: &[Corner],
    bending: Bending,
    tolerance: f64,
    faces: &mut Vec<Face>,
) {
    let n = corners.len();
    let extent = diameter(corners).max(f64::MIN_POSITIVE);
    let cost = |i: usize, j: usize| {
        let (a, b) = (corners[i], corners[j]);
        bending.sag(b.at - a.at) / tolerance + a.point.distance(b.point) / extent
    };
    let corner = |at: DVec2| corners.iter().position(|corner| corner.at == at).unwrap_or(0);
    let [c0, c1, c2, c3] = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
        .map(|(x, y)| corner(DVec2::new(x, y)));
    // Two chains from one corner to the opposite one, joined like a zip; the edges between them
    // run across.
    let from = if cost(c0, c2) <= cost(c1, c3) { c1 } else { c0 };
    let to = if from == c1 { c3 } else { c2 };
    let ahead = |i: usize| (i + 1) % n;
    let behind = |i: usize| (i + n - 1) % n;
    let (mut right, mut left) = (ahead(from), behind(from));
    faces.push([from, right, left]);
    let (last_right, last_left) = (behind(to), ahead(to));
    while (right, left) != (last_right, last_left) {
        let advance_right = left == last_left
            || (right != last_right && cost(ahead(right), left) <= cost(right, behind(left)));
        if advance_right {
            faces.push([right, ahead(right), left]);
            right = ahead(right);
        } else {
            faces.push([right, behind(left), left]);
            left = behind(left);
        }
    }
    faces.push([right, to, left]);
}

fn diameter(corners: &[Corner]) -> f64 {
    let first = corners[0].point;
    let grow = |(low, high): (DVec3, DVec3), c: &Corner| (low.min(c.point), high.max(c.point));
    let (low, high) = corners.iter().fold((first, first), grow);
    low.distance(high)
}

#[cfg(test)]
mod tests {
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
            vec![(0.0, 0.0), (1.0, 0.0), (1.0, 0.25), (1.0, 0.5), (1.0, 1.0), (0.5, 1.0), (0.0, 1.0)],
            vec![(0.0, 0.0), (0.5, 0.0), (1.0, 0.0), (1.0, 0.5), (1.0, 1.0), (0.5, 1.0), (0.0, 1.0), (0.0, 0.5)],
        ];
        for places in &sides {
            let corners = outline(places);
            for (uu, uv, vv) in [(1.0, 0.0, 1.0), (0.0, 1.0, 0.0), (0.0, -1.0, 0.0), (-3.0, 0.1, 1.0)] {
                let mut faces = vec![];
                triangulate(&corners, Bending { uu, uv, vv }, 0.01, &mut faces);
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
}
