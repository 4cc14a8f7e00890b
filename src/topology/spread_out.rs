//! Points spread out over a cloud.

use glam::DVec3;

/// Points whose farthest one is kept in mind.
const GROUP: usize = 64;

/// `count` points, each as far as can be from those chosen before, the first of several that are, and how far the
/// farthest of the others is from them (T. F. Gonzalez, *Clustering to minimize the maximum intercluster distance*,
/// 1985).
pub(super) fn spread_out(points: &[DVec3], count: usize) -> (Vec<u32>, f64) {
    // Along the longest side of their box, where those near to one follow one another.
    let low = points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let axis = (high - low).max_position();
    let mut order: Vec<u32> = (0..).zip(points).map(|(index, _)| index).collect();
    order.sort_by(|&a, &b| points[a as usize][axis].total_cmp(&points[b as usize][axis]));
    let sorted: Vec<DVec3> = order.iter().map(|&index| points[index as usize]).collect();

    let mut chosen = Vec::with_capacity(count);
    let mut nearest = vec![f64::INFINITY; points.len()];
    let farther = |nearest: &[f64], a: usize, b: usize| {
        nearest[a].total_cmp(&nearest[b]).then(order[b].cmp(&order[a]))
    };
    // The farthest of each group.
    let mut groups: Vec<usize> = (0..points.len()).step_by(GROUP).collect();
    let mut next = order.iter().position(|&index| index == 0).unwrap_or(0);
    while chosen.len() < count {
        chosen.push(order[next]);
        let (from, reach) = (sorted[next], nearest[next].sqrt());
        // Points farther along are not nearer to it than any is to those before.
        let first = sorted.partition_point(|point| from[axis] - point[axis] > reach) / GROUP;
        let end = sorted.partition_point(|point| point[axis] - from[axis] <= reach);
        for (group, farthest) in (first..end.div_ceil(GROUP)).zip(&mut groups[first..]) {
            let range = group * GROUP..points.len().min((group + 1) * GROUP);
            for (nearest, point) in nearest[range.clone()].iter_mut().zip(&sorted[range.clone()]) {
                *nearest = nearest.min(point.distance_squared(from));
            }
            *farthest = range.max_by(|&a, &b| farther(&nearest, a, b)).unwrap_or(0);
        }
        let farthest = groups.iter().copied().max_by(|&a, &b| farther(&nearest, a, b));
        next = farthest.unwrap_or(0);
    }
    (chosen, nearest[next].sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same, by looking at all points each time.
    fn by_looking_at_all(points: &[DVec3], count: usize) -> (Vec<u32>, f64) {
        let (mut chosen, mut next) = (vec![], 0);
        let mut nearest = vec![f64::INFINITY; points.len()];
        while chosen.len() < count {
            chosen.push(u32::try_from(next).unwrap());
            for (nearest, point) in nearest.iter_mut().zip(points) {
                *nearest = nearest.min(point.distance_squared(points[next]));
            }
            let most = nearest.iter().copied().fold(0.0, f64::max);
            next = nearest.iter().position(|&nearest| nearest == most).unwrap();
        }
        (chosen, nearest.into_iter().fold(0.0, f64::max).sqrt())
    }

    #[test]
    fn each_is_the_first_of_those_farthest_from_all_before() {
        let scattered = |i: u32| {
            let [x, y] = [0.754_877_666, 0.569_840_291].map(|step| (step * f64::from(i)).fract());
            DVec3::new(y, 3.0 * x, (5.0 * x).sin())
        };
        let grid = |i: u32| DVec3::new(f64::from(i * 37 % 40), f64::from(i * 37 % 1600 / 40), 1.0);
        for points in [(0..1999).map(scattered).collect::<Vec<_>>(), (0..1600).map(grid).collect()]
        {
            for count in [1, 2, 60, 400] {
                assert_eq!(spread_out(&points, count), by_looking_at_all(&points, count));
            }
        }
        assert_eq!(spread_out(&[DVec3::X; 3], 2), (vec![0, 0], 0.0));
    }
}
