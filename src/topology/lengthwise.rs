//! A long sheet, in order along itself and across.
//!
//! Distances along a surface have a flat map only where it can be unrolled. What flows from one end of a
//! long sheet to the other finds its way however it is wound or bent: the potential of that flow grows
//! along the sheet, and the conjugate one, by which the flow is shared, across it.

use glam::{DVec2, DVec3};

use super::axis::ranked;
use super::conjugate::Conjugate;
use super::laplacian::Laplacian;
use super::start::{between_rims, rims};
use crate::cloud::NeighborGraph;

/// One of so many points lies at an end, into which or from which it flows.
const END: usize = 50;

/// The middle of the sheet, in quarters of its points from one end to the other: the flow is even there.
const MIDDLE: [usize; 2] = [1, 3];

/// A long sheet in order.
pub(crate) struct Lengthwise {
    /// For each point its place in `[0, 1]²`, along the sheet and across.
    pub(crate) uv: Vec<DVec2>,
    /// How many times longer than wide it is.
    pub(crate) aspect: f64,
}

/// Points that are joined to those near them along a sheet, evenly over it, in order; `None` if the sheet
/// has no two dimensions.
///
/// The ends are those points that are farthest from one another. Equal areas have equally many points,
/// from one end to the other, so that places along the sheet are shares of them.
pub(crate) fn lengthwise(points: &[DVec3], graph: &NeighborGraph) -> Option<Lengthwise> {
    let last = |from: u32| {
        let distances = graph.distances_from(&[from]);
        let mut ranked: Vec<u32> = (0..).zip(points).map(|(index, _)| index).collect();
        ranked.sort_by(|&a, &b| distances[b as usize].total_cmp(&distances[a as usize]));
        ranked
    };
    let first = last(*last(0).first()?);
    let second = last(*first.first()?);
    let count = points.len().div_ceil(END);
    let mut flow = vec![0.0; points.len()];
    for (&from, &to) in first.iter().zip(&second).take(count) {
        flow[from as usize] += 1.0;
        flow[to as usize] -= 1.0;
    }
    let potential = Laplacian::of_neighbors(graph).solve(&flow);
    let step = |from: usize, to: usize| potential[to] - potential[from];
    let across = Conjugate::of(points, graph, step).coordinate();
    let ranked = ranked(&potential);
    let mut along = vec![0.0; points.len()];
    for (rank, &point) in ranked.iter().enumerate() {
        along[point] = (rank as f64 + 0.5) / points.len() as f64;
    }
    let [from, to] = MIDDLE.map(|quarters| potential[ranked[quarters * points.len() / 4]]);
    let length = 4.0 * (to - from) / (MIDDLE[1] - MIDDLE[0]) as f64;
    let [low, high] = rims(&along, &across);
    let width = |(low, high): (&u32, &u32)| across[*high as usize] - across[*low as usize];
    let mut widths: Vec<f64> = low.iter().zip(&high).map(width).collect();
    widths.sort_by(f64::total_cmp);
    let aspect = length / widths[widths.len() / 2];
    aspect.is_finite().then(|| Lengthwise { uv: between_rims(&along, &across), aspect })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;

    #[test]
    fn a_helicoid_is_in_order_from_end_to_end() {
        // Three turns, whose outer rim is four times as long as the inner one: laid flat, the sheet would
        // cover itself.
        let part = |i: u32, step: f64| (0.5 + step * f64::from(i)).fract();
        let flat =
            (0..3000).map(|i| (part(i, 0.754_877_666_246_693), part(i, 0.569_840_290_998_053)));
        // As many points everywhere, though turns are longer farther out.
        let flat: Vec<(f64, f64)> = flat.map(|(t, s)| (t, (0.04 + 0.96 * s).sqrt())).collect();
        let place = |&(t, r): &(f64, f64)| {
            (r * DVec2::from_angle(3.0 * std::f64::consts::TAU * t)).extend(1.8 * t)
        };
        let points: Vec<DVec3> = flat.iter().map(place).collect();
        let graph = NeighborGraph::of(&points, 8, &mut Silent).unwrap();
        let Lengthwise { uv, aspect } = lengthwise(&points, &graph).unwrap();
        assert!((8.0..16.0).contains(&aspect), "{aspect}");
        let likeness = |a: &dyn Fn(usize) -> f64, b: &dyn Fn(usize) -> f64| {
            let mean = |f: &dyn Fn(usize) -> f64| (0..3000).map(f).sum::<f64>() / 3000.0;
            let (of_a, of_b) = (mean(a), mean(b));
            let moment = |f: &dyn Fn(usize) -> f64, m: f64, g: &dyn Fn(usize) -> f64, n: f64| {
                mean(&|i| (f(i) - m) * (g(i) - n))
            };
            moment(a, of_a, b, of_b) / (moment(a, of_a, a, of_a) * moment(b, of_b, b, of_b)).sqrt()
        };
        let along = likeness(&|i| uv[i].x, &|i| flat[i].0).abs();
        // A helicoid flows evenly over the inverse hyperbolic sine of the radius by its pitch.
        let pitch = 1.8 / (3.0 * std::f64::consts::TAU);
        let across = likeness(&|i| uv[i].y, &|i| (flat[i].1 / pitch).asinh()).abs();
        assert!(along > 0.999 && across > 0.9, "{along}, {across}");
    }

    #[test]
    fn points_on_a_line_have_no_two_dimensions() {
        let points: Vec<DVec3> = (0..200).map(|i| DVec3::X * f64::from(i)).collect();
        let graph = NeighborGraph::of(&points, 8, &mut Silent).unwrap();
        assert!(lengthwise(&points, &graph).is_none());
    }
}
