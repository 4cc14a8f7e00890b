//! Borders: the closed chains of places around a region and its holes.

use std::collections::HashMap;

use glam::{DVec2, DVec3};

use super::places::Places;
use super::region::Region;
use super::settings::BorderSettings;
use super::triangulation::{NONE, Triangulation};
use crate::numeric::median;

const SETTINGS: BorderSettings = BorderSettings::STANDARD;

/// A closed chain of places, with the region on its left.
#[derive(Clone, Debug)]
pub(super) struct Border {
    /// The piece of the region that it bounds.
    pub piece: u32,
    /// Parameters, unwrapped: they go on through seams.
    pub uv: Vec<DVec2>,
    /// The way in (u, v) from the start once around to it; zero unless it winds around.
    pub shift: DVec2,
    /// Points of the surface.
    pub points: Vec<DVec3>,
    /// Tangents along u and v.
    pub tangents: Vec<[DVec3; 2]>,
    /// Distance along the chain in space; one more than places, the last is the length.
    pub along: Vec<f64>,
    /// The median spacing.
    pub spacing: f64,
    /// Per place, how far behind the true border it lies, in space.
    pub depth: Vec<f64>,
}

impl Border {
    /// The borders of a region, by their first place.
    pub(super) fn all(
        places: &Places,
        triangulation: &Triangulation,
        region: &Region,
    ) -> Vec<Self> {
        let mut after = HashMap::new();
        let mut starts = vec![];
        for (t, piece) in region.pieces.iter().enumerate() {
            let Some(piece) = piece else { continue };
            for k in 0..3 {
                let other = triangulation.neighbors[t][k];
                if other == NONE || region.pieces[other as usize].is_none() {
                    let corners = triangulation.corners[t];
                    let (from, to) = (corners[(k + 1) % 3], corners[(k + 2) % 3]);
                    after.insert(from, to);
                    starts.push((from, *piece));
                }
            }
        }
        starts.sort_unstable();
        let cells = cell_areas(places, triangulation, region);
        let mut borders = vec![];
        for (start, piece) in starts {
            let mut chain = vec![];
            let mut at = start;
            while let Some(next) = after.remove(&at) {
                chain.push(at);
                at = next;
            }
            if chain.len() > 2 {
                borders.push(Self::of(places, region, &cells, (piece, &chain)));
            }
        }
        borders
    }

    fn of(places: &Places, region: &Region, cells: &[f64], (piece, chain): (u32, &[u32])) -> Self {
        let mut uv = vec![places.uv[chain[0] as usize]];
        let mut along = vec![0.0];
        for k in 1..=chain.len() {
            let (a, b) = (chain[k - 1] as usize, chain[k % chain.len()] as usize);
            uv.push(uv[k - 1] + places.rectangle.way(places.uv[a], places.uv[b]));
            along.push(along[k - 1] + places.points[a].distance(places.points[b]));
        }
        let way = uv[chain.len()] - uv[0];
        uv.pop();
        // Exactly a number of turns.
        let size = places.rectangle.size();
        let turns = (way / size).round();
        let shift = DVec2::new(
            if places.rectangle.closed[0] { turns.x * size.x } else { 0.0 },
            if places.rectangle.closed[1] { turns.y * size.y } else { 0.0 },
        );
        let pick = |of: &[f64]| -> Vec<f64> { chain.iter().map(|k| of[*k as usize]).collect() };
        let spacing = median(pick(&region.spacing));
        let lattice = depths(&pick(cells), &along, SETTINGS.depth_window * spacing);
        let times =
            1.0 + (SETTINGS.random_depth - 1.0) * region.irregularity.powi(SETTINGS.depth_exponent);
        let depth = lattice.into_iter().map(|depth| times * depth).collect();
        Self {
            piece,
            uv,
            shift,
            points: chain.iter().map(|k| places.points[*k as usize]).collect(),
            tangents: chain.iter().map(|k| places.tangents[*k as usize]).collect(),
            along,
            spacing,
            depth,
        }
    }

    pub(super) fn len(&self) -> usize {
        self.uv.len()
    }

    /// The parameters of a place whose index may be some turns ahead.
    pub(super) fn uv_at(&self, k: usize) -> DVec2 {
        self.uv[k % self.len()] + self.shift * (k / self.len()) as f64
    }

    /// The distance along the chain of a place whose index may be some turns ahead.
    pub(super) fn along_at(&self, k: usize) -> f64 {
        self.along[k % self.len()] + self.length() * (k / self.len()) as f64
    }

    /// The length in space.
    pub(super) fn length(&self) -> f64 {
        self.along[self.len()]
    }

    /// Twice the area in (u, v) of the polygon; positive around a region, negative around a hole.
    pub(super) fn signed_area(&self) -> f64 {
        let origin = self.uv[0];
        let next = |k: usize| self.uv.get(k + 1).map_or(self.shift, |at| at - origin);
        (0..self.len()).map(|k| (self.uv[k] - origin).perp_dot(next(k))).sum()
    }

    /// Whether it winds around a closed direction.
    pub(super) fn winds(&self) -> bool {
        self.shift != DVec2::ZERO
    }

    /// Whether it bounds a hole.
    pub(super) fn is_hole(&self) -> bool {
        !self.winds() && self.signed_area() < 0.0
    }

    /// The signed distance along the chain from one place to another, the shorter way.
    pub(super) fn distance(&self, from: usize, to: usize) -> f64 {
        let (way, length) = (self.along[to] - self.along[from], self.length());
        way - length * (way / length).round()
    }
}

/// Per place, the area that belongs to one place: twice the mean area of the triangles around.
///
/// A triangulation has two triangles a place.
fn cell_areas(places: &Places, triangulation: &Triangulation, region: &Region) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); places.len()];
    let kept =
        triangulation.corners.iter().zip(&region.pieces).filter(|(_, piece)| piece.is_some());
    let kept: Vec<&[u32; 3]> = kept.map(|(corners, _)| corners).collect();
    for corners in &kept {
        let [a, b, c] = corners.map(|place| places.points[place as usize]);
        let area = 0.5 * (b - a).cross(c - a).length();
        for place in *corners {
            let sum = &mut sums[*place as usize];
            *sum = (sum.0 + area, sum.1 + 1.0);
        }
    }
    // A wider mean is steadier.
    for _ in 0..SETTINGS.cell_rings {
        let mut wider = vec![(0.0, 0.0); places.len()];
        for corners in &kept {
            let parts = corners.map(|place| sums[place as usize]);
            let sum = parts.iter().fold((0.0, 0.0), |sum, part| (sum.0 + part.0, sum.1 + part.1));
            for place in *corners {
                let wide = &mut wider[*place as usize];
                *wide = (wide.0 + sum.0, wide.1 + sum.1);
            }
        }
        sums = wider
            .iter()
            .map(|(area, count)| (area / f64::max(*count, 1.0), f64::from(*count > 0.0)))
            .collect();
    }
    sums.into_iter().map(|(area, count)| 2.0 * area / f64::max(count, 1.0)).collect()
}

/// Per place of a chain, its mean depth behind the true border on a lattice, by Pick's theorem: a
/// border place stands for half a cell outside of the polygon. Sums run over a window along the
/// chain. In a random scatter, discs bridge gaps and leave more than half a cell outside.
fn depths(cells: &[f64], along: &[f64], window: f64) -> Vec<f64> {
    let (count, length) = (cells.len(), along[cells.len()]);
    let half = (0.5 * window).min(0.5 * length);
    // Cells and lengths summed from the start, over three turns.
    let mut sums = vec![0.0];
    for k in 0..3 * count {
        sums.push(sums[k] + 0.5 * cells[k % count]);
    }
    let at = |k: usize| along[k % count] + length * (k / count) as f64;
    let (mut first, mut last) = (0, 0);
    let mut depth = |k: usize| {
        let middle = at(k + count);
        while at(first) < middle - half {
            first += 1;
        }
        while last + 1 < 3 * count && at(last + 1) <= middle + half {
            last += 1;
        }
        // The places at both ends count half, as the sides there do.
        let ends = 0.5 * (0.5 * cells[first % count] + 0.5 * cells[last % count]);
        let sum = sums[last + 1] - sums[first] - ends;
        if last > first { sum / (at(last) - at(first)) } else { 0.0 }
    };
    (0..count).map(&mut depth).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_of_a_lattice_are_half_a_step_deep() {
        // Lines that are three steps apart: half a gap along them, half a step across.
        let (cells, along): (Vec<f64>, Vec<f64>) = (0..=40).map(|k| (3.0, f64::from(k))).unzip();
        let depth = depths(&cells[..40], &along, 8.0);
        assert!(depth.iter().all(|depth| (depth - 1.5).abs() < 1e-12), "{depth:?}");
        let across: Vec<f64> = along.iter().map(|l| 3.0 * l).collect();
        let depth = depths(&cells[..40], &across, 24.0);
        assert!(depth.iter().all(|depth| (depth - 0.5).abs() < 1e-12), "{depth:?}");
    }
}
