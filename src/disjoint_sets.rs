//! Disjoint sets (union-find).

use crate::numeric::index;

/// A disjoint-set forest. Of two united sets, the lower root becomes the root.
pub(crate) struct DisjointSets {
    parents: Vec<u32>,
}

impl DisjointSets {
    /// Each of `count` elements is a set of its own.
    pub(crate) fn new(count: usize) -> Self {
        Self { parents: (0..).take(count).collect() }
    }

    /// The root of an element's set: its first element.
    pub(crate) fn root(&mut self, mut element: u32) -> u32 {
        while self.parents[element as usize] != element {
            // Path halving.
            let parent = self.parents[self.parents[element as usize] as usize];
            self.parents[element as usize] = parent;
            element = parent;
        }
        element
    }

    /// Unites the sets of two elements.
    pub(crate) fn unite(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parents[a.max(b) as usize] = a.min(b);
    }

    /// The root of each element's set.
    pub(crate) fn roots(&mut self) -> Vec<u32> {
        (0..self.parents.len()).map(|element| self.root(index(element))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_root_of_a_set_is_its_first_element() {
        let mut sets = DisjointSets::new(6);
        sets.unite(5, 3);
        sets.unite(4, 5);
        sets.unite(1, 0);
        assert_eq!(sets.roots(), [0, 0, 2, 3, 3, 3]);
    }
}
