//! Where the nodes are before training (the paper's section 4.2).

use glam::DVec3;

use super::candidates::Walk;
use super::frame::Frame;
use super::lattice::Lattice;
use super::options::Init;
use super::random::Random;
use super::{ordered_start, search};
use crate::cloud::{self, Bounds};
use crate::error::{Error, Result};
use crate::progress::Listen;

/// "Small" random values: the start's spread as a share of the diagonal of the bounding box.
const SPREAD: f64 = 0.01;

/// "Some clusters": enough that one of them is a dense place, few enough that each is a crowd.
const CLUSTERS: usize = 8;

/// Rounds of the clustering; it need not be perfect.
const ROUNDS: usize = 20;

/// Points that the clustering looks at; more of them would not move its centres visibly.
const SAMPLE: usize = 20_000;

/// Nodes placed between two reports: a few milliseconds.
const NODES_PER_REPORT: usize = 1 << 16;

/// The nodes' places in the points' unit, for points within `bounds`.
pub(super) fn nodes(
    points: &[DVec3],
    bounds: &Bounds,
    lattice: &Lattice,
    init: &Init,
    random: &mut Random,
    listen: &mut Listen<'_>,
) -> Result<Vec<DVec3>> {
    let centre = match init {
        Init::Pca => return ordered_start::principal(points, lattice, listen),
        Init::Geodesic => return ordered_start::geodesic(points, lattice, random, listen),
        Init::Auto => return better_order(points, lattice, random, listen),
        Init::Given(nodes) => return check_given(nodes, lattice).map(|()| nodes.clone()),
        Init::Centroid => cloud::interruptible_centroid(points, listen)?,
        Init::DensestCluster => densest_cluster(points, listen)?,
        Init::Random => DVec3::ZERO,
    };
    let spread = SPREAD * bounds.diagonal();
    let mut offset = || spread * (random.unit() - 0.5);
    place(lattice.len(), listen, |_| centre + DVec3::new(offset(), offset(), offset()))
}

/// Places nodes one after the other.
pub(super) fn place(
    nodes: usize,
    listen: &mut Listen<'_>,
    mut place: impl FnMut(usize) -> DVec3,
) -> Result<Vec<DVec3>> {
    let mut places = Vec::with_capacity(nodes);
    for first in (0..nodes).step_by(NODES_PER_REPORT) {
        listen()?;
        places.extend((first..nodes.min(first + NODES_PER_REPORT)).map(&mut place));
    }
    Ok(places)
}

/// The geodesic start or the principal plane, whichever suits the points better.
fn better_order(
    points: &[DVec3],
    lattice: &Lattice,
    random: &mut Random,
    listen: &mut Listen<'_>,
) -> Result<Vec<DVec3>> {
    let geodesic = ordered_start::geodesic(points, lattice, random, listen)?;
    let plane = ordered_start::principal(points, lattice, listen)?;
    let sample = evenly(points, SAMPLE);
    let geodesic_unfit = unfitness(&geodesic, lattice, &sample, listen)?;
    let plane_unfit = unfitness(&plane, lattice, &sample, listen)?;
    Ok(if plane_unfit < geodesic_unfit { plane } else { geodesic })
}

/// How badly nodes suit points: the share of points whose two nearest nodes are no neighbours, plus
/// the mean distance to the nearest, in mean spacings of the lattice.
fn unfitness(
    nodes: &[DVec3],
    lattice: &Lattice,
    points: &[DVec3],
    listen: &mut Listen<'_>,
) -> Result<f64> {
    let bounds = Bounds::of(points);
    let spacing = bounds.diagonal() / (lattice.len() as f64).sqrt();
    let frame = Frame::of(&bounds);
    let local: Vec<DVec3> = nodes.iter().map(|&node| frame.apply(node)).collect();
    let look = |walk: &mut Walk<'_>, point: DVec3| {
        let [first, second] = walk.nearest_two(point);
        (!lattice.adjacent(first, second), local[first].distance(point))
    };
    let mut sum = 0.0;
    let take = |piece: &[(bool, f64)]| {
        sum += piece.iter().map(|&(torn, far)| f64::from(torn) + far / spacing).sum::<f64>();
    };
    search::ask(&local, &frame, (points, &bounds), 2, &mut |_| listen(), look, take)?;
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
fn densest_cluster(points: &[DVec3], listen: &mut Listen<'_>) -> Result<DVec3> {
    let sample = evenly(points, SAMPLE);
    let mut centres = evenly(&sample, CLUSTERS);
    let mut counts = vec![0; centres.len()];
    for _ in 0..ROUNDS {
        listen()?;
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
    Ok(centres[densest.unwrap_or(0)])
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
        let centre = densest_cluster(&crowd, &mut || Ok(())).unwrap();
        assert!(centre.distance(DVec3::new(8.1, 2.1, 5.1)) < 0.5, "{centre}");
    }

    #[test]
    fn the_better_order_unrolls_a_roll_and_keeps_off_a_short_circuit() {
        let listen = &mut || Ok(());
        let mut random = Random::new(8);
        let lattice = Lattice::quad(20, 8).unwrap();
        let mut chosen = |arc: f64, gap: f64| {
            let mut point = || {
                let (angle, z) = (arc * random.unit(), 2.0 * random.unit());
                let radius = 1.0 + gap * angle;
                DVec3::new(radius * angle.cos(), radius * angle.sin(), z)
            };
            let points: Vec<DVec3> = (0..1500).map(|_| point()).collect();
            let mut unfit = |init| {
                let bounds = Bounds::of(&points);
                let start =
                    nodes(&points, &bounds, &lattice, &init, &mut Random::new(1), listen).unwrap();
                unfitness(&start, &lattice, &points, listen).unwrap()
            };
            [unfit(Init::Auto), unfit(Init::Geodesic), unfit(Init::Pca)]
        };
        // Five sixths of a turn; then two turns whose layers nearly touch.
        let [auto, geodesic, plane] = chosen(5.2, 0.0);
        assert!(auto == geodesic && geodesic < plane, "{auto} {geodesic} {plane}");
        let [auto, geodesic, plane] = chosen(12.5, 0.002);
        assert_eq!(auto, geodesic.min(plane));
    }

    #[test]
    fn random_starts_lie_where_they_should() {
        let points = [DVec3::splat(100.0), DVec3::splat(101.0), DVec3::new(100.0, 101.0, 100.0)];
        let lattice = Lattice::quad(3, 3).unwrap();
        for (init, centre) in
            [(Init::Centroid, cloud::centroid(&points)), (Init::Random, DVec3::ZERO)]
        {
            let (bounds, mut random) = (Bounds::of(&points), Random::new(0));
            let listen = &mut || Ok(());
            let start = nodes(&points, &bounds, &lattice, &init, &mut random, listen).unwrap();
            assert!(start.iter().all(|node| node.distance(centre) < 0.02));
            assert!(start[0] != start[1]);
        }
    }
}
