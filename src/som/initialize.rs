//! Where the nodes are before training (the paper's section 4.2).

use glam::DVec3;

use super::lattice::Lattice;
use super::options::Init;
use super::ordered_start;
use super::random::Random;
use crate::error::{Error, Result};
use crate::point_cloud::{self, Bounds};

/// "Small" random values: the start's spread as a share of the diagonal of the bounding box.
const SPREAD: f64 = 0.01;

/// "Some clusters": enough that one of them is a dense place, few enough that each is a crowd.
const CLUSTERS: usize = 8;

/// Rounds of the clustering; it need not be perfect.
const ROUNDS: usize = 20;

/// Points that the clustering looks at; more of them would not move its centres visibly.
const SAMPLE: usize = 20_000;

/// The nodes' places in the points' unit.
pub(super) fn nodes(
    points: &[DVec3],
    lattice: &Lattice,
    init: &Init,
    random: &mut Random,
) -> Result<Vec<DVec3>> {
    let around = |centre: DVec3, random: &mut Random| {
        let spread = SPREAD * Bounds::of(points).diagonal();
        let mut offset = || spread * (random.unit() - 0.5);
        (0..lattice.len()).map(|_| centre + DVec3::new(offset(), offset(), offset())).collect()
    };
    Ok(match init {
        Init::Pca => ordered_start::principal(points, lattice),
        Init::Geodesic => ordered_start::geodesic(points, lattice, random),
        Init::Centroid => around(point_cloud::centroid(points), random),
        Init::DensestCluster => around(densest_cluster(points), random),
        Init::Random => around(DVec3::ZERO, random),
        Init::Given(nodes) => {
            check_given(nodes, lattice)?;
            nodes.clone()
        }
    })
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
fn densest_cluster(points: &[DVec3]) -> DVec3 {
    let sample = evenly(points, SAMPLE);
    let mut centres = evenly(&sample, CLUSTERS);
    let mut counts = vec![0; centres.len()];
    for _ in 0..ROUNDS {
        let mut sums = vec![DVec3::ZERO; centres.len()];
        counts.fill(0);
        for &point in &sample {
            let distance = |&i: &usize| centres[i].distance_squared(point);
            let nearest = (0..centres.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
            let nearest = nearest.unwrap_or(0);
            sums[nearest] += point - sample[0];
            counts[nearest] += 1;
        }
        for ((centre, sum), &count) in centres.iter_mut().zip(sums).zip(&counts) {
            if count > 0 {
                *centre = sample[0] + sum / f64::from(count);
            }
        }
    }
    let densest = (0..centres.len()).max_by_key(|&i| (counts[i], std::cmp::Reverse(i)));
    centres[densest.unwrap_or(0)]
}

/// At most `count` of the points, at equal distances in their order.
pub(super) fn evenly(points: &[DVec3], count: usize) -> Vec<DVec3> {
    points.iter().copied().step_by(points.len().div_ceil(count).max(1)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_densest_cluster_is_the_crowd() {
        let mut random = Random::new(5);
        let mut unit = || random.unit();
        let crowd: Vec<DVec3> = (0..900)
            .map(|i| {
                let offset = DVec3::new(unit(), unit(), unit());
                if i % 3 == 0 { 10.0 * offset } else { DVec3::new(8.0, 2.0, 5.0) + 0.2 * offset }
            })
            .collect();
        let centre = densest_cluster(&crowd);
        assert!(centre.distance(DVec3::new(8.1, 2.1, 5.1)) < 0.5, "{centre}");
    }

    #[test]
    fn random_starts_lie_where_they_should() {
        let points = [DVec3::splat(100.0), DVec3::splat(101.0), DVec3::new(100.0, 101.0, 100.0)];
        let lattice = Lattice::quad(3, 3).unwrap();
        for (init, centre) in
            [(Init::Centroid, point_cloud::centroid(&points)), (Init::Random, DVec3::ZERO)]
        {
            let start = nodes(&points, &lattice, &init, &mut Random::new(0)).unwrap();
            assert!(start.iter().all(|node| node.distance(centre) < 0.02));
            assert!(start[0] != start[1]);
        }
    }
}
