//! Local planes: normals, flatness and the noise floor, from neighborhoods of one size.

use glam::DVec3;
use rayon::prelude::*;

use super::settings::ObserveSettings;
use crate::cloud::{KdTree, Neighbor, Plane};
use crate::numeric::median;

/// The planes nearest to each point and its neighbors.
#[derive(Clone, Debug)]
pub struct LocalPlanes {
    /// Neighbors in each plane, without the point itself.
    pub size: usize,
    /// Unit normals.
    pub normals: Vec<DVec3>,
    /// Flatness of each neighborhood: its third principal deviation over its second.
    pub flatness: Vec<f64>,
    /// Whether the planes are clearly flatter than points that fill a volume. Otherwise normals and
    /// noise mean nothing.
    pub reliable: bool,
    /// Root mean square distance of each neighborhood from its plane, due to noise and curvature.
    pub thickness: Vec<f64>,
    /// Whether each neighborhood is two-dimensional. The normal of a line's plane is arbitrary.
    pub spread: Vec<bool>,
    /// Root of the median squared distance of neighborhoods from their planes: the noise, or
    /// curvature if there is no noise.
    pub noise: f64,
}

impl LocalPlanes {
    /// The planes of the size with the least median flatness, relative to points that fill a
    /// volume.
    ///
    /// Larger planes average noise that exceeds the spacing. They must be flatter by a margin,
    /// since they bridge bends.
    pub(super) fn of(points: &[DVec3], tree: &KdTree<'_>, settings: &ObserveSettings) -> Self {
        let most = (points.len() / 8).max(settings.min_plane + 4).min(points.len() - 1);
        let compared: Vec<u32> = (0..)
            .take(points.len())
            .step_by(points.len().div_ceil(settings.compared_planes))
            .collect();
        let mut size = settings.min_plane.min(most);
        let mut best = (f64::INFINITY, size);
        while size <= most.min(settings.max_plane) {
            let planes = planes(points, tree, &compared, size);
            let flat = relative_flatness(&planes, size);
            if flat < settings.flatter_ratio * best.0 {
                best = (flat, size);
            } else if flat > settings.worse_ratio * best.0 {
                break;
            }
            size += size / 2;
        }
        Self::of_size(points, tree, best.1, settings)
    }

    /// The planes of this size through all points.
    fn of_size(
        points: &[DVec3],
        tree: &KdTree<'_>,
        size: usize,
        settings: &ObserveSettings,
    ) -> Self {
        let all: Vec<u32> = (0..).take(points.len()).collect();
        let planes = planes(points, tree, &all, size);
        // A plane has three degrees of freedom, which its points lose.
        let freedom = (size + 1) as f64 / (size.max(4) - 2) as f64;
        let squares = planes.iter().map(|plane| plane.deviations[2].powi(2));
        Self {
            size,
            reliable: points.len() < settings.min_points
                || relative_flatness(&planes, size) < settings.max_thickness,
            normals: planes.iter().map(Plane::normal).collect(),
            flatness: planes.iter().map(flatness).collect(),
            thickness: planes.iter().map(|p| p.deviations[2] * freedom.sqrt()).collect(),
            spread: planes.iter().map(|plane| !plane.is_line()).collect(),
            noise: (median(squares) * freedom).sqrt(),
        }
    }
}

/// The third principal deviation over the second; 1 if the second is 0.
fn flatness(plane: &Plane) -> f64 {
    let [_, width, thickness] = plane.deviations;
    if width > 0.0 { thickness / width } else { 1.0 }
}

/// The median flatness of planes through `size` neighbors, over that of points that fill a volume.
///
/// Of n such points, the plane nearest to them leaves a flatness of about 1 - 1 / √n.
fn relative_flatness(planes: &[Plane], size: usize) -> f64 {
    median(planes.iter().map(flatness)) / (1.0 - 1.0 / (size.max(2) as f64).sqrt())
}

/// The planes through the points `of` and their `size` nearest neighbors.
fn planes(points: &[DVec3], tree: &KdTree<'_>, of: &[u32], size: usize) -> Vec<Plane> {
    let plane = |found: &mut Vec<Neighbor>, &index: &u32| {
        tree.nearest_to(index, size, found);
        let around = found.iter().map(|near| points[near.index as usize]);
        Plane::of(around.chain([points[index as usize]]))
    };
    of.par_iter().map_init(Vec::new, plane).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points on a grid with pseudorandom heights.
    fn noisy(side: u32, noise: f64) -> Vec<DVec3> {
        let height = |i: u32| (f64::from(i) * 0.618_033_988_75).fract() - 0.5;
        (0..side * side)
            .map(|i| DVec3::new(f64::from(i / side), f64::from(i % side), noise * height(i * i)))
            .collect()
    }

    #[test]
    fn noise_that_exceeds_the_spacing_is_measured() {
        let points = noisy(40, 4.0);
        let planes = LocalPlanes::of(&points, &KdTree::new(&points), &ObserveSettings::default());
        // Uniform noise of width 4 has the deviation 4 / √12.
        let expected = 4.0 / 12.0_f64.sqrt();
        assert!((planes.noise / expected - 1.0).abs() < 0.2, "{} {expected}", planes.noise);
        let upright = planes.normals.iter().filter(|normal| normal.z.abs() > 0.8).count();
        assert!(10 * upright > 9 * points.len(), "{upright}");
    }

    #[test]
    fn points_without_noise_get_the_smallest_planes() {
        let points = noisy(40, 0.0);
        let planes = LocalPlanes::of(&points, &KdTree::new(&points), &ObserveSettings::default());
        assert_eq!((planes.size, planes.noise), (6, 0.0));
    }
}
