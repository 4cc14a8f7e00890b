//! Loops that cannot be shrunk: persistent cohomology in dimension 1.
//!
//! V. de Silva, D. Morozov, M. Vejdemo-Johansson, *Persistent cohomology and circular coordinates*
//! (Discrete & Computational Geometry 45, 2011); the bookkeeping by annotations of edges is that of
//! J.-D. Boissonnat, T. Dey, C. Maria, *The compressed annotation matrix* (2013).

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
    let mut complex = Annotations::default();
    let mut joined: Vec<u32> = (0..).take(vertices).collect();
    // For each vertex its neighbours, ascending, and the edges to them.
    let mut neighbors: Vec<Vec<(u32, u32)>> = vec![Vec::new(); vertices];
    for (number, edge) in (0_u32..).zip(edges) {
        let (a, b) = (root(&mut joined, edge.from), root(&mut joined, edge.to));
        complex.add_edge(a == b);
        joined[a.max(b) as usize] = a.min(b);
        let mut others = neighbors[edge.to as usize].as_slice();
        for &(vertex, at_from) in &neighbors[edge.from as usize] {
            let nearer = others.iter().take_while(|(other, _)| *other < vertex).count();
            others = &others[nearer..];
            let Some(&(_, at_to)) = others.first().filter(|(other, _)| *other == vertex) else {
                continue;
            };
            // The boundary of i < j < k is jk - ik + ij.
            complex.add_triangle(if vertex < edge.from {
                [(number, 1), (at_to, -1), (at_from, 1)]
            } else if vertex < edge.to {
                [(at_to, 1), (number, -1), (at_from, 1)]
            } else {
                [(at_to, 1), (at_from, -1), (number, 1)]
            });
        }
        for (own, other) in [(edge.from, edge.to), (edge.to, edge.from)] {
            let list = &mut neighbors[own as usize];
            list.insert(list.partition_point(|(vertex, _)| *vertex < other), (other, number));
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
#[derive(Default)]
struct Annotations {
    of_edges: Vec<Vec<(u32, i64)>>,
    /// For each class the edge that closed it, and edges that may count in it; none if it is dead.
    classes: Vec<(u32, Vec<u32>)>,
    /// What counts around a triangle; kept for its memory.
    around: Vec<(u32, i64)>,
}

impl Annotations {
    fn add_edge(&mut self, closes: bool) {
        let edge = u32::try_from(self.of_edges.len()).unwrap_or(u32::MAX);
        if closes {
            let class = u32::try_from(self.classes.len()).unwrap_or(u32::MAX);
            self.of_edges.push(vec![(class, 1)]);
            self.classes.push((edge, vec![edge]));
        } else {
            self.of_edges.push(Vec::new());
        }
    }

    /// Fills a triangle: what counts around it is no loop any more, and the youngest class in it
    /// dies.
    fn add_triangle(&mut self, sides: [(u32, i64); 3]) {
        let Self { of_edges, classes, around } = self;
        around.clear();
        for (edge, sign) in sides {
            add(around, &of_edges[edge as usize], sign);
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
}
