//! Lists of a triangulation's triangles around each place.

use super::triangulation::{NONE, Triangulation};
use crate::numeric::index;

/// For each place, the triangles around it, or the places next to it.
#[derive(Clone, Debug)]
pub(super) struct Lists {
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl Lists {
    /// The lists of pairs (place, item), items in the order of the pairs.
    fn of(places: usize, pairs: impl Iterator<Item = (u32, u32)> + Clone) -> Self {
        let mut starts = vec![0_u32; places + 1];
        for (place, _) in pairs.clone() {
            starts[place as usize + 1] += 1;
        }
        for place in 0..places {
            starts[place + 1] += starts[place];
        }
        let mut next = starts.clone();
        let mut items = vec![0; starts[places] as usize];
        for (place, item) in pairs {
            items[next[place as usize] as usize] = item;
            next[place as usize] += 1;
        }
        Self { starts, items }
    }

    /// The triangles around each place.
    pub(super) fn triangles(places: usize, all: &Triangulation) -> Self {
        let corners = all.corners.iter().enumerate();
        Self::of(places, corners.flat_map(|(t, corners)| corners.map(|place| (place, index(t)))))
    }

    /// The places next to each place, along sides of the triangles that are kept.
    pub(super) fn places(places: usize, all: &Triangulation, keep: &[bool]) -> Self {
        let kept = all.corners.iter().zip(&all.neighbors).zip(keep).filter(|(_, keep)| **keep);
        let sides = kept.flat_map(|((corners, neighbors), _)| {
            (0..3).flat_map(move |k| {
                let (b, c) = (corners[(k + 1) % 3], corners[(k + 2) % 3]);
                let other = neighbors[k];
                let alone = other == NONE || !keep[other as usize];
                [Some((b, c)), alone.then_some((c, b))].into_iter().flatten()
            })
        });
        Self::of(places, sides)
    }

    /// The number of places.
    pub(super) fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// The list of a place.
    pub(super) fn at(&self, place: usize) -> &[u32] {
        &self.items[self.starts[place] as usize..self.starts[place + 1] as usize]
    }
}
