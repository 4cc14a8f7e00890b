//! Loops that cannot be shrunk: persistent cohomology in dimension 1.
//!
//! V. de Silva, D. Morozov, M. Vejdemo-Johansson, *Persistent cohomology and circular coordinates*
//! (Discrete & Computational Geometry 45, 2011); the bookkeeping by annotations of edges is that of
//! J.-D. Boissonnat, T. Dey, C. Maria, *The compressed annotation matrix* (2013).

use super::pairs::{Pairs, set};

/// Coefficients are counted modulo this prime. With 2 alone a loop that is walked twice would count
/// as none; a larger one than this makes no difference to loops of point clouds.
const PRIME: i64 = 47;

/// An edge of the complex, from its lower vertex to its higher one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Edge {
    pub(super) from: u32,
    pub(super) to: u32,
    pub(super) length: f64,
}

/// A class of loops: how often each edge counts around it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Cocycle {
    /// Length of the edge that closed the loop.
    pub(super) birth: f64,
    /// For each edge of the complex, in the order in which they were given.
    pub(super) values: Vec<i32>,
}

/// The loops that remain when all edges and all triangles between them are there (the
/// Vietoris-Rips complex at the length of the longest edge). Edges come in ascending length.
pub(super) fn loops(vertices: usize, edges: &[Edge]) -> Vec<Cocycle> {
    let mut complex = Annotations::of(vertices);
    let mut joined: Vec<u32> = (0..).take(vertices).collect();
    // All edges, and those that count somewhere, of which there are few.
    let [mut near, mut counting] = [Pairs::none(vertices), Pairs::none(vertices)];
    for edge in edges {
        let (a, b) = (root(&mut joined, edge.from), root(&mut joined, edge.to));
        joined[a.max(b) as usize] = a.min(b);
        let both = || near.of(edge.from).iter().zip(near.of(edge.to)).map(|(from, to)| from & to);
        let counts = match set(both()).next() {
            Some(vertex) => complex.add_filled(edge, vertex),
            None => complex.add_edge(edge, a == b),
        };
        // Around a triangle whose sides count nowhere counts nothing.
        let sides = counting.of(edge.from).iter().zip(counting.of(edge.to));
        let sides = sides.map(|(from, to)| if counts { u64::MAX } else { from | to });
        for vertex in set(both().zip(sides).map(|(both, sides)| both & sides)) {
            complex.add_triangle(edge, vertex);
        }
        near.join(edge.from, edge.to);
        if counts {
            counting.join(edge.from, edge.to);
        }
    }
    complex.alive(edges)
}

/// The lowest vertex of a component, so far; ways to it are halved.
fn root(joined: &mut [u32], mut vertex: u32) -> u32 {
    while joined[vertex as usize] != vertex {
        joined[vertex as usize] = joined[joined[vertex as usize] as usize];
        vertex = joined[vertex as usize];
    }
    vertex
}

/// For each edge the classes that it counts in, with coefficients from 1 to `PRIME - 1`.
struct Annotations {
    of_edges: Vec<Vec<(u32, i64)>>,
    /// For each vertex the higher ones to which edges lead that counted when they were added, ascending, and the
    /// numbers of these.
    counting: Vec<Vec<(u32, u32)>>,
    /// For each class the edge that closed it, and edges that may count in it; none if it is dead.
    classes: Vec<(u32, Vec<u32>)>,
    /// What counts around a triangle; kept for its memory.
    around: Vec<(u32, i64)>,
}

impl Annotations {
    fn of(vertices: usize) -> Self {
        let counting = vec![Vec::new(); vertices];
        Self { of_edges: Vec::new(), counting, classes: Vec::new(), around: Vec::new() }
    }

    /// Adds an edge that is no side of a triangle, and says whether it counts: it does if it closes a loop.
    fn add_edge(&mut self, edge: &Edge, closes: bool) -> bool {
        let class = u32::try_from(self.classes.len()).unwrap_or(u32::MAX);
        if closes {
            self.classes.push((self.next(), Vec::new()));
        }
        self.push(edge, if closes { vec![(class, 1)] } else { Vec::new() })
    }

    /// Adds an edge together with the triangle over this vertex, and says whether it counts: as what goes there does,
    /// so that nothing counts around the triangle.
    fn add_filled(&mut self, edge: &Edge, vertex: u32) -> bool {
        let mut own = Vec::new();
        for (side, sign) in self.by_way_of(edge, vertex) {
            add(&mut own, &self.of_edges[side], sign);
        }
        self.push(edge, own)
    }

    /// Adds an edge that counts so, and says whether it does.
    fn push(&mut self, edge: &Edge, own: Vec<(u32, i64)>) -> bool {
        let (number, counts) = (self.next(), !own.is_empty());
        for &(class, _) in &own {
            self.classes[class as usize].1.push(number);
        }
        if counts {
            let from = &mut self.counting[edge.from as usize];
            from.insert(from.partition_point(|(to, _)| *to < edge.to), (edge.to, number));
        }
        self.of_edges.push(own);
        counts
    }

    /// The number of the next edge.
    fn next(&self) -> u32 {
        u32::try_from(self.of_edges.len()).unwrap_or(u32::MAX)
    }

    /// The edges that may count on the way from an edge's lower vertex to its higher one by way of another, and how
    /// often.
    fn by_way_of(&self, edge: &Edge, vertex: u32) -> impl Iterator<Item = (usize, i64)> + use<> {
        let side = |from: u32, to: u32| {
            let higher = &self.counting[from.min(to) as usize];
            let at = higher.binary_search_by_key(&from.max(to), |(vertex, _)| *vertex).ok()?;
            Some((higher[at].1 as usize, if from < to { 1 } else { -1 }))
        };
        [side(edge.from, vertex), side(vertex, edge.to)].into_iter().flatten()
    }

    /// Fills a triangle over the last edge: what counts around it is no loop any more, and the youngest class in it
    /// dies.
    fn add_triangle(&mut self, edge: &Edge, vertex: u32) {
        let sides = self.by_way_of(edge, vertex);
        let Self { of_edges, classes, around, .. } = self;
        around.clear();
        for (side, sign) in sides.chain([(of_edges.len() - 1, -1)]) {
            add(around, &of_edges[side], sign);
        }
        let Some(&(youngest, coefficient)) = around.last() else { return };
        let inverse = inverse(coefficient);
        for edge in std::mem::take(&mut classes[youngest as usize].1) {
            let own = &mut of_edges[edge as usize];
            let Ok(at) = own.binary_search_by_key(&youngest, |&(class, _)| class) else { continue };
            let factor = -own[at].1 * inverse;
            add(own, around, factor);
            for &(class, _) in &around[..around.len() - 1] {
                classes[class as usize].1.push(edge);
            }
        }
    }

    fn alive(&self, edges: &[Edge]) -> Vec<Cocycle> {
        let living = (0_u32..).zip(&self.classes).filter(|(_, (_, members))| !members.is_empty());
        let cocycle = |(class, (edge, _)): (u32, &(u32, Vec<u32>))| {
            let value = |own: &Vec<(u32, i64)>| {
                let at = own.binary_search_by_key(&class, |&(class, _)| class);
                let value = at.map_or(0, |at| own[at].1);
                // Modulo the prime, -1 looks like 46.
                let lifted = if 2 * value > PRIME { value - PRIME } else { value };
                i32::try_from(lifted).unwrap_or(0)
            };
            let values = self.of_edges.iter().map(value).collect();
            Cocycle { birth: edges[*edge as usize].length, values }
        };
        living.map(cocycle).collect()
    }
}

/// `sum += factor * other`, both sorted by class and without zeros.
fn add(sum: &mut Vec<(u32, i64)>, other: &[(u32, i64)], factor: i64) {
    for &(class, value) in other {
        let value = (value * factor).rem_euclid(PRIME);
        match sum.binary_search_by_key(&class, |&(class, _)| class) {
            Ok(at) => {
                sum[at].1 = (sum[at].1 + value) % PRIME;
                if sum[at].1 == 0 {
                    sum.remove(at);
                }
            }
            Err(at) if value != 0 => sum.insert(at, (class, value)),
            Err(_) => {}
        }
    }
}

/// The number whose product with `value` is 1 (Fermat's little theorem).
fn inverse(value: i64) -> i64 {
    (1..PRIME - 1).fold(1, |product, _| product * value % PRIME)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(count: u32, reach: u32) -> Vec<Edge> {
        let mut edges: Vec<Edge> = (0..count)
            .flat_map(|i| (1..=reach).map(move |step| (i, (i + step) % count, f64::from(step))))
            .map(|(a, b, length)| Edge { from: a.min(b), to: a.max(b), length })
            .collect();
        edges.sort_by(|a, b| a.length.total_cmp(&b.length));
        edges
    }

    #[test]
    fn a_ring_has_a_loop_until_it_is_filled() {
        let found = loops(12, &ring(12, 3));
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].birth, 1.0);
        // Walked along its twelve short edges, the loop counts once.
        let edges = ring(12, 3);
        let around: i32 = (0..12)
            .map(|i| {
                let to = (i + 1) % 12;
                let (low, high) = (i.min(to), i.max(to));
                let at = edges.iter().position(|e| (e.from, e.to) == (low, high)).unwrap();
                if low == i { found[0].values[at] } else { -found[0].values[at] }
            })
            .sum();
        assert_eq!(around.abs(), 1);
        // Edges of a third of the ring's length fill it.
        assert!(loops(12, &ring(12, 4)).is_empty());
    }

    #[test]
    fn cocycles_vanish_around_triangles() {
        let edges = ring(20, 5);
        let found = loops(20, &edges);
        let value = |a: u32, b: u32| {
            edges
                .iter()
                .position(|e| (e.from, e.to) == (a.min(b), a.max(b)))
                .map(|at| if a < b { found[0].values[at] } else { -found[0].values[at] })
        };
        for i in 0..20 {
            let (j, k) = ((i + 2) % 20, (i + 4) % 20);
            let around = value(i, j).unwrap() + value(j, k).unwrap() + value(k, i).unwrap();
            assert_eq!(around, 0);
        }
    }

    #[test]
    fn two_rings_side_by_side_have_two_loops() {
        let mut edges = ring(10, 2);
        let second: Vec<Edge> = edges
            .iter()
            .map(|e| Edge { from: e.from + 10, to: e.to + 10, length: e.length })
            .collect();
        edges.extend(second);
        edges.sort_by(|a, b| a.length.total_cmp(&b.length));
        assert_eq!(loops(20, &edges).len(), 2);
    }

    /// The rank of rows of numbers modulo the prime (Gauss).
    fn rank(mut rows: Vec<Vec<i64>>) -> usize {
        let mut rank = 0;
        for column in 0..rows.first().map_or(0, Vec::len) {
            let Some(at) = (rank..rows.len()).find(|&row| rows[row][column] != 0) else { continue };
            rows.swap(rank, at);
            let pivot = rows[rank].clone();
            for row in &mut rows[rank + 1..] {
                let times = row[column] * inverse(pivot[column]);
                for (own, pivot) in row.iter_mut().zip(&pivot) {
                    *own = (*own - times * pivot).rem_euclid(PRIME);
                }
            }
            rank += 1;
        }
        rank
    }

    #[test]
    fn loops_are_as_many_as_ranks_say() {
        let mut all = 0;
        for cloud in 0..40 {
            let place = |i: u32| {
                let part =
                    |step: f64| (step * f64::from(i * i) + 0.37 * step * f64::from(cloud)).fract();
                (part(0.754_877_666_246_693), part(0.569_840_290_998_053))
            };
            let vertices = 60;
            let length = |a: u32, b: u32| {
                let ((x, y), (x2, y2)) = (place(a), place(b));
                (x - x2).hypot(y - y2)
            };
            let pairs = (0..vertices).flat_map(|b| (0..b).map(move |a| (a, b)));
            let mut edges: Vec<Edge> = pairs
                .map(|(from, to)| Edge { from, to, length: length(from, to) })
                .filter(|edge| edge.length < 0.14 + 0.002 * f64::from(cloud))
                .collect();
            edges.sort_by(|a, b| a.length.total_cmp(&b.length));
            let found = loops(vertices as usize, &edges);

            let number =
                |a: u32, b: u32| edges.iter().position(|edge| (edge.from, edge.to) == (a, b));
            let ends = |edge: &Edge| {
                let mut row = vec![0; vertices as usize];
                (row[edge.from as usize], row[edge.to as usize]) = (PRIME - 1, 1);
                row
            };
            let mut triangles = Vec::new();
            for (ab, edge) in edges.iter().enumerate() {
                for c in edge.to + 1..vertices {
                    let sides = number(edge.from, c).zip(number(edge.to, c));
                    triangles.extend(sides.map(|(ac, bc)| (ab, ac, bc)));
                }
            }
            let boundary = |&(ab, ac, bc): &(usize, usize, usize)| {
                let mut row = vec![0; edges.len()];
                (row[ab], row[ac], row[bc]) = (1, PRIME - 1, 1);
                row
            };
            let filled = rank(triangles.iter().map(boundary).collect());
            let betti = edges.len() - rank(edges.iter().map(ends).collect()) - filled;
            assert_eq!(found.len(), betti, "{cloud}");
            all += betti;
            // Each is one of a basis, and vanishes around each triangle.
            let residues = |cocycle: &Cocycle| -> Vec<i64> {
                cocycle.values.iter().map(|&value| i64::from(value).rem_euclid(PRIME)).collect()
            };
            let values: Vec<Vec<i64>> = found.iter().map(residues).collect();
            let around = |values: &Vec<i64>, &(ab, ac, bc): &(usize, usize, usize)| {
                (values[ab] - values[ac] + values[bc]).rem_euclid(PRIME)
            };
            assert!(values.iter().all(|values| triangles.iter().all(|t| around(values, t) == 0)));
            assert_eq!(rank(values), betti);
        }
        assert!(all > 60, "{all}");
    }
}
