//! Local planes of one size for the whole cloud: normals, flatness and the noise floor.

use glam::DVec3;
use rayon::prelude::*;

use super::settings::ObserveSettings;
use crate::cloud::{KdTree, Neighbor, Plane};
use crate::numeric::median;

/// Points on which the sizes are compared.
const COMPARED: usize = 500;

/// Thickness over width of a cloud, in those of the best size so far, from which on larger planes
/// only bridge the surface's bends.
const WORSE: f64 = 2.0;

/// Planes through each point and its nearest neighbours.
#[derive(Clone, Debug)]
pub struct LocalPlanes {
    /// Neighbours in each plane, the point itself not counted.
    pub size: usize,
    /// Unit normals.
    pub normals: Vec<DVec3>,
    /// Thickness of each neighbourhood over its width: its third principal deviation over its
    /// second.
    pub flatness: Vec<f64>,
    /// Whether they are flatter than as many points that fill a volume: else they say nothing of
    /// normals and noise.
    pub tell: bool,
    /// Root mean square distance of each neighbourhood from its plane: noise, and curvature over it.
    pub thickness: Vec<f64>,
    /// Whether each neighbourhood is no line: planes through lines have any normal.
    pub spread: Vec<bool>,
    /// Median distance of points from their planes, by root mean square: noise, or curvature where
    /// there is none.
    pub noise: f64,
}

impl LocalPlanes {
    /// The planes of the size with the least median thickness over width, beside what chance makes of a
    /// volume. Larger planes see through noise that exceeds the spacing; they must be flatter by a
    /// margin, since they bridge bends.
    pub(super) fn of(points: &[DVec3], tree: &KdTree<'_>, settings: &ObserveSettings) -> Self {
        let most = (points.len() / 8).max(settings.least_plane + 4).min(points.len() - 1);
        let compared: Vec<u32> =
            (0..).take(points.len()).step_by(points.len().div_ceil(COMPARED)).collect();
        let mut size = settings.least_plane.min(most);
        let mut best = (f64::INFINITY, size);
        while size <= most.min(settings.largest_plane) {
            let planes = planes(points, tree, &compared, size);
            let flat = relative(&planes, size);
            if flat < settings.flatter * best.0 {
                best = (flat, size);
            } else if flat > WORSE * best.0 {
                break;
            }
            size += size / 2;
        }
        Self::of_size(points, tree, best.1, settings)
    }

    fn of_size(
        points: &[DVec3],
        tree: &KdTree<'_>,
        size: usize,
        settings: &ObserveSettings,
    ) -> Self {
        let all: Vec<u32> = (0..).take(points.len()).collect();
        let planes = planes(points, tree, &all, size);
        // A plane takes three degrees of freedom from its points.
        let freedom = (size + 1) as f64 / (size.max(4) - 2) as f64;
        let squares = planes.iter().map(|plane| plane.deviations[2].powi(2));
        Self {
            size,
            tell: points.len() < settings.few || relative(&planes, size) < settings.thick,
            normals: planes.iter().map(Plane::normal).collect(),
            flatness: planes.iter().map(flatness).collect(),
            thickness: planes.iter().map(|p| p.deviations[2] * freedom.sqrt()).collect(),
            spread: planes.iter().map(|plane| !plane.is_line()).collect(),
            noise: (median(squares) * freedom).sqrt(),
        }
    }
}

fn flatness(plane: &Plane) -> f64 {
    let [_, width, thickness] = plane.deviations;
    if width > 0.0 { thickness / width } else { 1.0 }
}

/// The median flatness of planes through so many neighbours, in that of points that fill a volume: by
/// chance, few of these lie nearer to a plane, 1 - 1 / √n times their width.
fn relative(planes: &[Plane], size: usize) -> f64 {
    median(planes.iter().map(flatness)) / (1.0 - 1.0 / (size.max(2) as f64).sqrt())
}

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

    /// Points on a grid with heights that look random.
    fn noisy(side: u32, noise: f64) -> Vec<DVec3> {
        let height = |i: u32| (f64::from(i) * 0.618_033_988_75).fract() - 0.5;
        (0..side * side)
            .map(|i| DVec3::new(f64::from(i / side), f64::from(i % side), noise * height(i * i)))
            .collect()
    }

    #[test]
    fn noise_larger_than_the_spacing_is_measured() {
        let points = noisy(40, 4.0);
        let planes = LocalPlanes::of(&points, &KdTree::new(&points), &ObserveSettings::default());
        // Uniform noise of width 4 has the deviation 4 / √12.
        let expected = 4.0 / 12.0_f64.sqrt();
        assert!((planes.noise / expected - 1.0).abs() < 0.2, "{} {expected}", planes.noise);
        let upright = planes.normals.iter().filter(|normal| normal.z.abs() > 0.8).count();
        assert!(10 * upright > 9 * points.len(), "{upright}");
    }

    #[test]
    fn clean_points_keep_small_planes() {
        let points = noisy(40, 0.0);
        let planes = LocalPlanes::of(&points, &KdTree::new(&points), &ObserveSettings::default());
        assert_eq!((planes.size, planes.noise), (6, 0.0));
    }
}
