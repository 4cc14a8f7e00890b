//! Tree of rectangles in the plane, for finding those that contain a place.

use glam::DVec2;

/// A tree of rectangles with a value for each.
#[derive(Debug)]
pub(super) struct PlaneTree<T> {
    /// In depth-first order, so that a search needs no stack.
    nodes: Vec<Node>,
    values: Vec<T>,
}

#[derive(Debug)]
struct Node {
    low: DVec2,
    high: DVec2,
    /// The index of the first node after those below this one.
    next: usize,
    /// The index of its value, if it is a leaf.
    value: Option<u32>,
}

/// The smallest and largest corner of a rectangle.
pub(super) type Rectangle = [DVec2; 2];

impl<T> PlaneTree<T> {
    /// Builds a tree in O(n log n): halves the rectangles by their middles along the longer side of
    /// all. The tree has fewer than 2³² of them.
    pub(super) fn new(items: Vec<(Rectangle, T)>) -> Self {
        let (rectangles, values): (Vec<Rectangle>, Vec<T>) = items.into_iter().unzip();
        let mut order: Vec<u32> = (0..).take(rectangles.len()).collect();
        let mut nodes = Vec::with_capacity(2 * order.len());
        if !order.is_empty() {
            add_nodes(&rectangles, &mut order, &mut nodes);
        }
        Self { nodes, values }
    }

    /// The values of the rectangles that contain a place, borders included.
    pub(super) fn at(&self, place: DVec2) -> impl Iterator<Item = &T> {
        let mut index = 0;
        std::iter::from_fn(move || {
            while let Some(node) = self.nodes.get(index) {
                // Not a negated comparison: NaN is in no rectangle.
                let inside = node.low.x <= place.x
                    && place.x <= node.high.x
                    && node.low.y <= place.y
                    && place.y <= node.high.y;
                index = if inside { index + 1 } else { node.next };
                if let Some(value) = node.value.filter(|_| inside) {
                    return Some(&self.values[value as usize]);
                }
            }
            None
        })
    }
}

/// Appends the nodes of a tree of some of the rectangles.
fn add_nodes(rectangles: &[Rectangle], some: &mut [u32], nodes: &mut Vec<Node>) {
    let corners = some.iter().map(|&index| rectangles[index as usize]);
    let [low, high] = corners
        .reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
        .expect("only called with a rectangle");
    let index = nodes.len();
    let value = (some.len() == 1).then_some(some[0]);
    nodes.push(Node { low, high, next: index + 1, value });
    if value.is_some() {
        return;
    }
    let extent = high - low;
    let place = |index: &u32| {
        let [low, high] = rectangles[*index as usize];
        if extent.x >= extent.y { low.x + high.x } else { low.y + high.y }
    };
    let half = some.len() / 2;
    // Equal middles are ordered by index, so that the tree is always the same.
    some.select_nth_unstable_by(half, |a, b| place(a).total_cmp(&place(b)).then(a.cmp(b)));
    let (first, second) = some.split_at_mut(half);
    add_nodes(rectangles, first, nodes);
    add_nodes(rectangles, second, nodes);
    nodes[index].next = nodes.len();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tree_finds_the_rectangles_of_a_search_through_all() {
        let number = |k: u32| f64::from(k.wrapping_mul(2_654_435_761) >> 20) / 4096.0;
        let place = |k: u32| DVec2::new(number(2 * k), number(2 * k + 1));
        let rectangle = |k: u32| [place(k), place(k) + 0.2 * place(k + 7)];
        let all: Vec<(Rectangle, u32)> = (0..200).map(|k| (rectangle(k), k)).collect();
        let tree = PlaneTree::new(all);
        for k in 0..500 {
            let at = place(k + 1000);
            let inside = |k: &u32| {
                let [low, high] = rectangle(*k);
                low.cmple(at).all() && at.cmple(high).all()
            };
            let mut found: Vec<u32> = tree.at(at).copied().collect();
            found.sort_unstable();
            assert_eq!(found, (0..200).filter(inside).collect::<Vec<_>>());
        }
        assert_eq!(tree.at(DVec2::NAN).count(), 0);
        assert_eq!(PlaneTree::<u32>::new(vec![]).at(DVec2::ZERO).count(), 0);
    }
}
