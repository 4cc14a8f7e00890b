//! Where the nodes are before training (the paper's section 4.2).

use glam::DVec3;
use rand::RngExt;
use rand_pcg::Pcg64;

use crate::point_cloud::{self, Bounds};

/// "Small" random values: the start's spread as a share of the diagonal of the bounding box.
const SPREAD: f64 = 0.01;

/// Small random values around the centroid of the points (section 4, step 1).
pub(super) fn around_centroid(points: &[DVec3], nodes: usize, rng: &mut Pcg64) -> Vec<DVec3> {
    let centre = point_cloud::centroid(points);
    let spread = SPREAD * Bounds::of(points).diagonal();
    let mut offset = || spread * (rng.random::<f64>() - 0.5);
    (0..nodes).map(|_| centre + DVec3::new(offset(), offset(), offset())).collect()
}
