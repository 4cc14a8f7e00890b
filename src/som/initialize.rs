//! Node positions before training (section 4.2 of the paper).

use glam::DVec3;

use super::frame::Frame;
use super::lattice::Lattice;
use super::nearest_lists::Lookup;
use super::options::Init;
use super::random::Random;
use super::sampling::{place_nodes, subsample};
use super::{ordered_start, search};
use crate::cloud::{self, Bounds};
use crate::error::{Error, Result};
use crate::progress::InterruptCheck;

/// Extent of the paper's "small" random values, as a share of the bounding box's diagonal.
const RANDOM_SPREAD: f64 = 0.01;

/// Number of the paper's clusters: enough to separate a dense region, few enough that each has many
/// points.
const N_CLUSTERS: usize = 8;

/// Iterations of k-means. An approximate result suffices.
const KMEANS_ROUNDS: usize = 20;

/// Largest number of points used for k-means and for comparing starts.
const MAX_SAMPLE: usize = 20_000;

/// The initial node positions in the points' unit, for points within `bounds`.
pub(super) fn nodes(
    points: &[DVec3],
    bounds: &Bounds,
    lattice: &Lattice,
    init: &Init,
    random: &mut Random,
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<Vec<DVec3>> {
    let center = match init {
        Init::Pca => return ordered_start::principal(points, lattice, check_interrupt),
        Init::Geodesic => return ordered_start::geodesic(points, lattice, random, check_interrupt),
        Init::Auto => return better_order(points, lattice, random, check_interrupt),
        Init::Given(nodes) => return check_given(nodes, lattice).map(|()| nodes.clone()),
        Init::Centroid => cloud::interruptible_centroid(points, check_interrupt)?,
        Init::DensestCluster => densest_cluster(points, check_interrupt)?,
        Init::Random => DVec3::ZERO,
    };
    let spread = RANDOM_SPREAD * bounds.diagonal();
    let mut offset = || spread * (random.unit() - 0.5);
    place_nodes(lattice.len(), check_interrupt, |_| {
        center + DVec3::new(offset(), offset(), offset())
    })
}

/// The geodesic start or the principal-plane start, whichever fits the points better.
fn better_order(
    points: &[DVec3],
    lattice: &Lattice,
    random: &mut Random,
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<Vec<DVec3>> {
    let geodesic = ordered_start::geodesic(points, lattice, random, check_interrupt)?;
    let plane = ordered_start::principal(points, lattice, check_interrupt)?;
    let sample = subsample(points, MAX_SAMPLE);
    let geodesic_misfit = misfit(&geodesic, lattice, &sample, check_interrupt)?;
    let plane_misfit = misfit(&plane, lattice, &sample, check_interrupt)?;
    Ok(if plane_misfit < geodesic_misfit { plane } else { geodesic })
}

/// How badly nodes fit points, for comparison of starts. It is the share of points whose two
/// nearest nodes are not adjacent, plus the mean distance to the nearest node in mean lattice
/// spacings.
fn misfit(
    nodes: &[DVec3],
    lattice: &Lattice,
    points: &[DVec3],
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<f64> {
    let bounds = Bounds::of(points);
    let spacing = bounds.diagonal() / (lattice.len() as f64).sqrt();
    let frame = Frame::of(&bounds);
    let local: Vec<DVec3> = nodes.iter().map(|&node| frame.apply(node)).collect();
    let look = |lookup: &mut Lookup<'_>, point: DVec3| {
        let [first, second] = lookup.nearest_two(point);
        (!lattice.adjacent(first, second), local[first].distance(point))
    };
    let mut sum = 0.0;
    let take = |piece: &[(bool, f64)]| {
        sum += piece.iter().map(|&(torn, far)| f64::from(torn) + far / spacing).sum::<f64>();
    };
    search::query(&local, &frame, (points, &bounds), 2, &mut |_| check_interrupt(), look, take)?;
    Ok(sum / points.len() as f64)
}

fn check_given(nodes: &[DVec3], lattice: &Lattice) -> Result<()> {
    if nodes.len() != lattice.len() {
        let must = format!("{} positions, one for each node", lattice.len());
        return Err(Error::parameter("init", must, nodes.len()));
    }
    match nodes.iter().find(|node| !node.is_finite()) {
        Some(node) => Err(Error::parameter("init", "finite", node)),
        None => Ok(()),
    }
}

/// The centroid of the cluster with the most points, by Lloyd's k-means.
fn densest_cluster(points: &[DVec3], check_interrupt: &mut InterruptCheck<'_>) -> Result<DVec3> {
    let sample = subsample(points, MAX_SAMPLE);
    let mut centers = subsample(&sample, N_CLUSTERS);
    let mut counts = vec![0; centers.len()];
    for _ in 0..KMEANS_ROUNDS {
        check_interrupt()?;
        let mut sums = vec![DVec3::ZERO; centers.len()];
        counts.fill(0);
        for &point in &sample {
            let distance = |&i: &usize| centers[i].distance_squared(point);
            let nearest = (0..centers.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
            let nearest = nearest.unwrap_or(0);
            sums[nearest] += point - sample[0];
            counts[nearest] += 1;
        }
        for ((center, sum), &count) in centers.iter_mut().zip(sums).zip(&counts) {
            if count > 0 {
                *center = sample[0] + sum / f64::from(count);
            }
        }
    }
    let densest = (0..centers.len()).max_by_key(|&i| (counts[i], std::cmp::Reverse(i)));
    Ok(centers[densest.unwrap_or(0)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn densest_cluster_finds_the_dense_region() {
        let mut random = Random::new(5);
        let mut unit = || random.unit();
        let cluster: Vec<DVec3> = (0..900)
            .map(|i| {
                let offset = DVec3::new(unit(), unit(), unit());
                if i % 3 == 0 { 10.0 * offset } else { DVec3::new(8.0, 2.0, 5.0) + 0.2 * offset }
            })
            .collect();
        let center = densest_cluster(&cluster, &mut || Ok(())).unwrap();
        assert!(center.distance(DVec3::new(8.1, 2.1, 5.1)) < 0.5, "{center}");
    }

    #[test]
    fn auto_start_is_the_better_of_geodesic_and_pca() {
        let check_interrupt = &mut || Ok(());
        let mut random = Random::new(8);
        let lattice = Lattice::quad(20, 8).unwrap();
        let mut chosen = |arc: f64, gap: f64| {
            let mut point = || {
                let (angle, z) = (arc * random.unit(), 2.0 * random.unit());
                let radius = 1.0 + gap * angle;
                DVec3::new(radius * angle.cos(), radius * angle.sin(), z)
            };
            let points: Vec<DVec3> = (0..1500).map(|_| point()).collect();
            let mut misfit_of = |init| {
                let bounds = Bounds::of(&points);
                let start =
                    nodes(&points, &bounds, &lattice, &init, &mut Random::new(1), check_interrupt)
                        .unwrap();
                misfit(&start, &lattice, &points, check_interrupt).unwrap()
            };
            [misfit_of(Init::Auto), misfit_of(Init::Geodesic), misfit_of(Init::Pca)]
        };
        // Five sixths of a turn; then two turns whose layers nearly touch.
        let [auto, geodesic, plane] = chosen(5.2, 0.0);
        assert!(auto == geodesic && geodesic < plane, "{auto} {geodesic} {plane}");
        let [auto, geodesic, plane] = chosen(12.5, 0.002);
        assert_eq!(auto, geodesic.min(plane));
    }

    #[test]
    fn random_starts_are_near_their_center() {
        let points = [DVec3::splat(100.0), DVec3::splat(101.0), DVec3::new(100.0, 101.0, 100.0)];
        let lattice = Lattice::quad(3, 3).unwrap();
        for (init, center) in
            [(Init::Centroid, cloud::centroid(&points)), (Init::Random, DVec3::ZERO)]
        {
            let (bounds, mut random) = (Bounds::of(&points), Random::new(0));
            let check_interrupt = &mut || Ok(());
            let start =
                nodes(&points, &bounds, &lattice, &init, &mut random, check_interrupt).unwrap();
            assert!(start.iter().all(|node| node.distance(center) < 0.02));
            assert!(start[0] != start[1]);
        }
    }
}
