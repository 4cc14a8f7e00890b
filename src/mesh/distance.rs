//! Distances from points to a mesh.
//!
//! A bounding volume hierarchy of boxes, split at the median of the longest side. The search visits
//! the nearer box first and skips boxes that are farther than the nearest triangle so far.

use glam::DVec3;
use rayon::prelude::*;

use super::MeshView;
use crate::error::{Error, Result};
use crate::progress::{self, Observer, Progress, Stage};
use crate::worker_pool::{self, for_each_task};

/// Triangles of a leaf at most.
const MAX_LEAF_TRIANGLES: usize = 4;

/// Triangles above which both branches of a node are built in parallel.
const MIN_PARALLEL_TRIANGLES: usize = 1 << 13;

/// Points between two calls of the observer.
const POINTS_PER_REPORT: usize = 1 << 15;

/// Points that a thread takes at a time.
const POINTS_PER_TASK: usize = 1 << 8;

/// A search structure for distances from points to a mesh.
///
/// ```
/// use neurbs::{DVec3, mesh::{DistanceSearch, TessellateOptions}, nurbs::NurbsSurface};
/// use neurbs::progress::Silent;
/// let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0)?;
/// let mesh = sphere.tessellate(&TessellateOptions::default(), &mut Silent)?;
/// let search = DistanceSearch::new(mesh.view());
/// let distance = search.distance(DVec3::X * 3.0);
/// assert!((distance - 2.0).abs() <= mesh.max_deviation.unwrap_or(0.0));
/// # Ok::<(), neurbs::Error>(())
/// ```
#[derive(Debug)]
pub struct DistanceSearch {
    /// The corners of the triangles, in the order of the leaves.
    triangles: Vec<[DVec3; 3]>,
    root: Option<Node>,
}

/// A node of the tree: a box and its content.
#[derive(Debug)]
struct Node {
    low: DVec3,
    high: DVec3,
    content: Content,
}

#[derive(Debug)]
enum Content {
    Nodes(Box<[Node; 2]>),
    /// Start and end of a range of triangles.
    Leaf(usize, usize),
}

impl DistanceSearch {
    /// Builds the tree of a mesh: O(n log n).
    #[must_use]
    pub fn new(mesh: MeshView<'_>) -> Self {
        let corners = |triangle: &[u32; 3]| triangle.map(|i| mesh.vertices[i as usize]);
        worker_pool::install(|| {
            let mut triangles: Vec<_> = mesh.triangles.par_iter().map(corners).collect();
            let root = (!triangles.is_empty()).then(|| Node::build(&mut triangles, 0));
            Self { triangles, root }
        })
    }

    /// The distance from a point to the nearest triangle; infinite if there is none.
    #[must_use]
    pub fn distance(&self, point: DVec3) -> f64 {
        self.search(point, &mut vec![])
    }

    /// The distances of many points, in parallel, written to `out`.
    ///
    /// # Errors
    ///
    /// [`Error::NotFinite`] for a point that is not finite; [`Error::Parameter`] if `out` and
    /// `points` differ in length; [`Error::Interrupted`] if the observer stops it.
    pub fn distances(
        &self,
        points: &[DVec3],
        out: &mut [f64],
        observer: &mut dyn Observer,
    ) -> Result<()> {
        if out.len() != points.len() {
            let must = format!("of length {}, one for each point", points.len());
            return Err(Error::parameter("out", must, out.len()));
        }
        if let Some(index) = points.iter().position(|point| !point.is_finite()) {
            return Err(Error::NotFinite { index, point: points[index] });
        }
        let total = points.len() as u64;
        let groups = points.chunks(POINTS_PER_REPORT).zip(out.chunks_mut(POINTS_PER_REPORT));
        for (index, (points, out)) in groups.enumerate() {
            let done = (index * POINTS_PER_REPORT) as u64;
            let at = Progress::of_stage(Stage::Measuring, done, total, 0);
            progress::report(observer, &at)?;
            for_each_task(points.iter().zip(out), POINTS_PER_TASK, |stack, (&point, out)| {
                *out = self.search(point, stack);
            });
        }
        progress::report(observer, &Progress::of_stage(Stage::Measuring, total, total, 0))
    }

    /// The distance from a point; `stack` is scratch memory.
    fn search<'a>(&'a self, point: DVec3, stack: &mut Vec<(f64, &'a Node)>) -> f64 {
        let mut best = f64::INFINITY;
        stack.clear();
        stack.extend(self.root.iter().map(|root| (0.0, root)));
        while let Some((bound, node)) = stack.pop() {
            if bound >= best {
                continue;
            }
            match &node.content {
                Content::Nodes(nodes) => {
                    let [a, b] =
                        [&nodes[0], &nodes[1]].map(|node| (node.bound_squared(point), node));
                    stack.extend(if a.0 <= b.0 { [b, a] } else { [a, b] });
                }
                Content::Leaf(from, to) => {
                    let squares = self.triangles[*from..*to].iter();
                    let squares = squares.map(|t| closest_point(point, *t).distance_squared(point));
                    best = squares.fold(best, f64::min);
                }
            }
        }
        best.sqrt()
    }
}

impl Node {
    /// Builds the tree over triangles and sorts them; `first` is the index of the first one.
    fn build(triangles: &mut [[DVec3; 3]], first: usize) -> Self {
        let start = triangles[0][0];
        let grow = |(low, high): (DVec3, DVec3), p: &DVec3| (low.min(*p), high.max(*p));
        let (low, high) = triangles.iter().flatten().fold((start, start), grow);
        let count = triangles.len();
        if count <= MAX_LEAF_TRIANGLES {
            return Self { low, high, content: Content::Leaf(first, first + count) };
        }
        let size = high - low;
        let axis = [size.x, size.y, size.z].iter().position(|side| *side == size.max_element());
        let axis = axis.unwrap_or(0);
        let key = |t: &[DVec3; 3]| t[0][axis] + t[1][axis] + t[2][axis];
        triangles.select_nth_unstable_by(count / 2, |a, b| key(a).total_cmp(&key(b)));
        let (left, right) = triangles.split_at_mut(count / 2);
        let middle = first + count / 2;
        let (left, right) = if count > MIN_PARALLEL_TRIANGLES {
            rayon::join(|| Self::build(left, first), || Self::build(right, middle))
        } else {
            (Self::build(left, first), Self::build(right, middle))
        };
        Self { low, high, content: Content::Nodes(Box::new([left, right])) }
    }

    /// A squared lower bound of the distance from a point to the triangles in the box.
    fn bound_squared(&self, point: DVec3) -> f64 {
        (self.low - point).max(point - self.high).max(DVec3::ZERO).length_squared()
    }
}

/// The closest point of a triangle (C. Ericson, *Real-Time Collision Detection*, section 5.1.5).
fn closest_point(point: DVec3, [a, b, c]: [DVec3; 3]) -> DVec3 {
    let (ab, ac) = (b - a, c - a);
    let from_a = point - a;
    let (d1, d2) = (ab.dot(from_a), ac.dot(from_a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let from_b = point - b;
    let (d3, d4) = (ab.dot(from_b), ac.dot(from_b));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + d1 / (d1 - d3) * ab;
    }
    let from_c = point - c;
    let (d5, d6) = (ab.dot(from_c), ac.dot(from_c));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + d2 / (d2 - d6) * ac;
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
    }
    a + (vb * ab + vc * ac) / (va + vb + vc)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn points(count: usize) -> impl Strategy<Value = Vec<DVec3>> {
        let number = || -1.0..1.0_f64;
        let point = (number(), number(), number()).prop_map(|(x, y, z)| DVec3::new(x, y, z));
        proptest::collection::vec(point, count)
    }

    proptest! {
        /// The tree finds the minimum over all triangles, and no sampled point is nearer.
        #[test]
        fn distances_are_the_minimum_over_all_triangles(vertices in points(30), at in points(10)) {
            let triangles: Vec<[u32; 3]> = (0..28).map(|i| [i, i + 1, i + 2]).collect();
            let (normals, uv) = (vec![], vec![]);
            let view = MeshView {
                vertices: &vertices, triangles: &triangles, normals: &normals, uv: &uv,
            };
            let search = DistanceSearch::new(view);
            for point in at {
                let mut best = f64::INFINITY;
                let mut sampled = f64::INFINITY;
                for triangle in vertices.windows(3) {
                    let [a, b, c] = [triangle[0], triangle[1], triangle[2]];
                    best = best.min(closest_point(point, [a, b, c]).distance(point));
                    for (s, t) in (0..=20).flat_map(|s| (0..=20 - s).map(move |t| (s, t))) {
                        let (s, t) = (f64::from(s) / 20.0, f64::from(t) / 20.0);
                        sampled = sampled.min((a + s * (b - a) + t * (c - a)).distance(point));
                    }
                }
                prop_assert!((search.distance(point) - best).abs() < 1e-15);
                prop_assert!(best <= sampled + 1e-15 && sampled < best + 0.15);
            }
        }
    }
}
