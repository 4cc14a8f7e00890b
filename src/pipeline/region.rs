//! The region of the plane that places fill, and the map that makes a rectangle of it.

use glam::{DVec2, DVec3};

use super::corners::{self, corners};
use super::outline::{Squared, bounds};
use super::start::whole;
use super::strip::{self, Sides};
use crate::cloud::{area, hull};
use crate::fit::Arms;

/// Cells of the raster that would cover the convex hull.
const CELLS: f64 = 900.0;

/// Radius of the blur that makes a density of places, in their mean spacings, and the share of the
/// usual density at which the region ends. A straight border moves out by a little less than a
/// spacing, and corners become round.
const BLUR: f64 = 1.2;
const LEVEL: f64 = 0.25;

/// Width of the empty frame around the places, in radii of the blur.
const FRAME: f64 = 3.0;

/// Cracks on either side over which the outline's stairs are smoothed.
const STAIRS: usize = 3;

/// Sweeps of successive over-relaxation at most, and the change at which they end.
const SWEEPS: usize = 400;
const SETTLED: f64 = 1e-5;

/// The sides of a cell: right, upper, left, lower.
const AROUND: [DVec2; 4] = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y];

/// A raster of square cells, those that belong to the region connected and without holes.
pub(super) struct Region {
    origin: DVec2,
    /// Radius of the blur.
    radius: f64,
    cell: f64,
    cols: usize,
    inside: Vec<bool>,
}

/// A side of a cell of the region beyond which lies none: the cell, and to which side.
type Crack = (usize, usize);

impl Region {
    /// The region that places fill; `None` if they have no area or lie in pieces.
    pub(super) fn of(places: &[DVec2]) -> Option<Self> {
        let hull = area(&hull(places));
        let cell = (hull / CELLS).sqrt();
        let radius = BLUR * (hull / places.len() as f64).sqrt();
        if cell.is_nan() || cell <= 0.0 {
            return None;
        }
        let (low, high) = bounds(places);
        let frame = DVec2::splat(FRAME * radius + 2.0 * cell);
        let size = ((high - low + 2.0 * frame) / cell).floor() + 2.0;
        let (cols, rows) = (whole(size.x), whole(size.y));
        let inside = vec![false; rows * cols];
        // In the middle, so that the region of mirrored places is mirrored, too.
        let origin = 0.5 * (low + high - cell * size);
        let mut region = Self { origin, radius, cell, cols, inside };
        let mut density = vec![0.0; rows * cols];
        for &place in places {
            region.around(place).into_iter().for_each(|(at, share)| density[at] += share);
        }
        let density = blurred(&density, cols, radius / cell);
        let mut usual: Vec<f64> = places
            .iter()
            .map(|&p| region.around(p).into_iter().map(|(at, share)| share * density[at]).sum())
            .collect();
        let middle = usual.len() / 2;
        let usual = *usual.select_nth_unstable_by(middle, f64::total_cmp).1;
        let dense: Vec<bool> = density.iter().map(|value| *value > LEVEL * usual).collect();
        let outer = region.connected(0, |at| !dense[at]);
        region.inside = outer.iter().map(|outer| !outer).collect();
        let first = region.inside.iter().position(|&inside| inside)?;
        let whole = region.connected(first, |at| region.inside[at]);
        (whole == region.inside).then_some(region)
    }

    /// The four cells whose middles lie around a place, with their bilinear shares.
    fn around(&self, place: DVec2) -> [(usize, f64); 4] {
        let local = (place - self.origin) / self.cell - 0.5;
        let low = local.floor();
        let t = local - low;
        let at = whole(low.y) * self.cols + whole(low.x);
        [
            (at, (1.0 - t.x) * (1.0 - t.y)),
            (at + 1, t.x * (1.0 - t.y)),
            (at + self.cols, (1.0 - t.x) * t.y),
            (at + self.cols + 1, t.x * t.y),
        ]
    }

    /// The cell on one side of another; the raster's frame has none beyond.
    fn neighbor(&self, at: usize, side: usize) -> Option<usize> {
        let (x, y) = (at % self.cols, at / self.cols);
        let rows = self.inside.len() / self.cols;
        let (x, y) = match side % 4 {
            0 => (x + 1, y),
            1 => (x, y + 1),
            2 => (x.checked_sub(1)?, y),
            _ => (x, y.checked_sub(1)?),
        };
        (x < self.cols && y < rows).then_some(y * self.cols + x)
    }

    /// The cells that hang together with one, side by side.
    fn connected(&self, first: usize, belongs: impl Fn(usize) -> bool) -> Vec<bool> {
        let mut reached = vec![false; self.inside.len()];
        let mut next = vec![first];
        reached[first] = true;
        while let Some(at) = next.pop() {
            for beside in (0..4).filter_map(|side| self.neighbor(at, side)) {
                if !reached[beside] && belongs(beside) {
                    reached[beside] = true;
                    next.push(beside);
                }
            }
        }
        reached
    }

    /// The cracks between the region and the rest, counter-clockwise.
    fn outline(&self) -> Vec<Crack> {
        let lowest = self.inside.iter().position(|&inside| inside).unwrap_or(0);
        let first = (lowest, 3);
        let mut cracks = vec![first];
        loop {
            let (cell, side) = cracks[cracks.len() - 1];
            let ahead = self.neighbor(cell, side + 1);
            let beyond = ahead.and_then(|ahead| self.neighbor(ahead, side));
            let next = match (ahead, beyond) {
                (Some(ahead), Some(beyond)) if self.inside[ahead] => {
                    if self.inside[beyond] {
                        (beyond, (side + 3) % 4)
                    } else {
                        (ahead, side)
                    }
                }
                _ => (cell, (side + 1) % 4),
            };
            if next == first {
                break;
            }
            cracks.push(next);
        }
        // From the corner of a cell that is farthest from the middle, so that the outline of mirrored places is the
        // same the other way round.
        let sum: DVec2 = cracks.iter().map(|&crack| self.middle(crack)).sum();
        let middle = sum / cracks.len() as f64;
        let distance = |crack: Crack| {
            let along = 0.5 * self.cell * AROUND[(crack.1 + 1) % 4];
            (self.middle(crack) - along).distance_squared(middle)
        };
        let farther = |&a: &usize, &b: &usize| distance(cracks[a]).total_cmp(&distance(cracks[b]));
        let farthest = (0..cracks.len()).max_by(farther);
        cracks.rotate_left(farthest.unwrap_or(0));
        cracks
    }

    /// The middle of a crack.
    fn middle(&self, (cell, side): Crack) -> DVec2 {
        let at = DVec2::new((cell % self.cols) as f64, (cell / self.cols) as f64) + 0.5;
        self.origin + self.cell * (at + 0.5 * AROUND[side])
    }

    pub(super) fn area(&self) -> f64 {
        self.inside.iter().filter(|inside| **inside).count() as f64 * self.cell * self.cell
    }

    /// The bent strip that the region is, if it is one; each place is that of a point in space.
    pub(super) fn strip(&self, places: &[DVec2], points: &[DVec3], sides: Sides) -> Option<Arms> {
        let (line, step, _) = self.line(&self.outline(), strip::CANDIDATES);
        let window = sides.window(self.radius / step);
        let turns = strip::turns(&line, window, places, points);
        strip::within(&line, &turns, window, sides)
    }

    /// The places in the unit square that the region is mapped to conformally, its long side along u.
    pub(super) fn rectified(&self, places: &[DVec2]) -> Squared {
        let cracks = self.outline();
        let (line, _, starts) = self.line(&cracks, corners::CANDIDATES);
        let starts = corners(&line).map(|corner| starts[corner]);
        let side = |i: usize| (starts.iter().filter(|&&start| start <= i).count() + 3) % 4;
        let mut ends = vec![[None; 4]; self.inside.len()];
        for (i, &(cell, at)) in cracks.iter().enumerate() {
            ends[cell][at] = Some(side(i));
        }
        let ((u, along), (v, across)) =
            rayon::join(|| self.harmonic(&ends, 3, 1), || self.harmonic(&ends, 0, 2));
        let place = |&place: &DVec2| {
            let shares = self.around(place);
            let mean = |values: &[f64]| shares.iter().map(|&(at, s)| s * values[at]).sum::<f64>();
            let uv = DVec2::new(mean(&u), mean(&v));
            if along > across { DVec2::new(uv.y, 1.0 - uv.x) } else { uv }
        };
        let uv = places.iter().map(place).collect();
        // Each energy would be the other's inverse, if the outline's stairs did not cost both.
        let ratio = (along / across).sqrt();
        Squared::filled(uv, ratio.max(ratio.recip()), &[])
    }

    /// So many places along the outline at equal distances, this distance, and the number of the
    /// first crack behind each.
    fn line(&self, cracks: &[Crack], places: usize) -> (Vec<DVec2>, f64, Vec<usize>) {
        let count = cracks.len();
        let middle = |i: usize| self.middle(cracks[i % count]);
        let window = 2 * STAIRS + 1;
        let smooth = |i: usize| (0..window).map(|k| middle(i + k)).sum::<DVec2>() / window as f64;
        let line: Vec<DVec2> = (0..count).map(|i| smooth(i + count - STAIRS)).collect();
        let length = |i: usize| line[(i + count - 1) % count].distance(line[i % count]);
        // From halfway between the last and the first.
        let mut along = vec![0.5 * length(0)];
        for i in 1..count {
            along.push(along[i - 1] + length(i));
        }
        let step = (along[count - 1] + 0.5 * length(0)) / places as f64;
        let behind = |k: usize| along.partition_point(|&a| a < step * k as f64);
        let at = |k: usize| {
            let next = behind(k);
            let to = along.get(next).map_or(step * places as f64 + along[0], |&along| along);
            let share = (to - step * k as f64) / length(next);
            line[next % count].lerp(line[(next + count - 1) % count], share)
        };
        ((0..places).map(at).collect(), step, (0..places).map(behind).collect())
    }

    /// The function that is harmonic in the region, 0 at one side, 1 at another, and flows along
    /// the others; and its energy. Cells just outside continue it.
    fn harmonic(&self, ends: &[[Option<usize>; 4]], zero: usize, one: usize) -> (Vec<f64>, f64) {
        let count = self.inside.len();
        let held = |side: usize| match side {
            side if side == zero => Some(0.0),
            side if side == one => Some(1.0),
            _ => None,
        };
        // As on a chessboard, first the black and then the white ones: those of one colour do not wait for one another.
        let white = |&at: &usize| (at / self.cols + at % self.cols) % 2 == 1;
        let inside = (0..count).filter(|&at| self.inside[at]);
        let (white, mut cells): (Vec<usize>, Vec<usize>) = inside.partition(white);
        cells.extend(white);
        // What lies beyond a crack counts by what is held there: the place behind all is 0.
        let stencil = |&at: &usize| {
            let mut cell = Stencil { at, beside: [count; 4], held: 0.0, weight: 0.0 };
            for (side, end) in ends[at].iter().enumerate() {
                if let Some(end) = *end {
                    // The middle of a crack is half as far as that of a neighbour.
                    cell.held += 2.0 * held(end).unwrap_or(0.0);
                    cell.weight += held(end).map_or(0.0, |_| 2.0);
                } else {
                    cell.beside[side] = self.neighbor(at, side).unwrap_or(count);
                    cell.weight += 1.0;
                }
            }
            cell
        };
        let stencils: Vec<Stencil> = cells.iter().map(stencil).collect();
        let mut values = vec![0.5; count];
        values.push(0.0);
        let side = (cells.len() as f64).sqrt();
        let relaxation = 2.0 / (1.0 + std::f64::consts::PI / (2.0 * side));
        for _ in 0..SWEEPS {
            let mut largest = 0.0_f64;
            for cell in &stencils {
                let sum = cell.held + cell.beside.iter().map(|&at| values[at]).sum::<f64>();
                let change = relaxation * (sum / cell.weight - values[cell.at]);
                values[cell.at] += change;
                largest = largest.max(change.abs());
            }
            if largest < SETTLED {
                break;
            }
        }
        // The energy is what flows out at the side that is held at 1.
        let mut energy = 0.0;
        let mut beyond = vec![(0.0, 0.0); count];
        for &at in &cells {
            for (side, end) in ends[at].iter().enumerate() {
                let Some(end) = *end else { continue };
                if end == one {
                    energy += 2.0 * (1.0 - values[at]);
                }
                if let Some(outside) = self.neighbor(at, side) {
                    let value = held(end).map_or(values[at], |held| 2.0 * held - values[at]);
                    beyond[outside] = (beyond[outside].0 + value, beyond[outside].1 + 1.0);
                }
            }
        }
        for (value, (sum, count)) in values.iter_mut().zip(beyond) {
            if count > 0.0 {
                *value = sum / count;
            }
        }
        (values, energy)
    }
}

/// A cell's equation: its value is the mean of those beside it and of those held.
struct Stencil {
    at: usize,
    beside: [usize; 4],
    held: f64,
    weight: f64,
}

/// Blurs a raster by a Gaussian of this radius in cells.
fn blurred(values: &[f64], cols: usize, radius: f64) -> Vec<f64> {
    let reach = whole((3.0 * radius).ceil());
    let kernel: Vec<f64> =
        (0..=reach).map(|k| (-0.5 * (k as f64 / radius).powi(2)).exp()).collect();
    let rows = values.len() / cols;
    let along = |values: &[f64], count: usize, stride: usize, other: usize, skip: usize| {
        let mut sums = vec![0.0; values.len()];
        for line in 0..other {
            for i in 0..count {
                let near = i.saturating_sub(reach)..(i + reach + 1).min(count);
                let terms = near.map(|k| kernel[k.abs_diff(i)] * values[line * skip + k * stride]);
                sums[line * skip + i * stride] = terms.sum();
            }
        }
        sums
    };
    let across = along(values, cols, 1, rows, cols);
    along(&across, rows, cols, cols, 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Places evenly over a part of the square from -1 to 1.
    fn scattered(part: impl Fn(DVec2) -> bool) -> Vec<DVec2> {
        let spread = |i: usize| {
            let at = |share: f64| 2.0 * (0.5 + share * i as f64).fract() - 1.0;
            DVec2::new(at(0.754_877_666_246_693), at(0.569_840_290_998_053))
        };
        (0..1200).map(spread).filter(|&place| part(place)).collect()
    }

    #[test]
    fn a_disc_fills_a_square_evenly() {
        let places = scattered(|p| p.length() < 1.0);
        let Squared { uv, aspect, .. } = Region::of(&places).unwrap().rectified(&places);
        assert!((1.0..1.05).contains(&aspect), "{aspect}");
        let (low, high) = bounds(&uv);
        assert!(low.max_element() < 0.12 && high.min_element() > 0.88, "{low} {high}");
        // Near the corners, too, which a square around the disc would leave empty.
        let near = |corner: DVec2| uv.iter().any(|uv| uv.distance(corner) < 0.3);
        assert!([DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE].into_iter().all(near));
    }

    #[test]
    fn bent_strips_are_unbent() {
        // An L has six corners: the ends of its arms become those of a rectangle, and the corners
        // where it bends come to lie across each other, in the middles of the long sides.
        let places = scattered(|p| p.x < 0.0 || p.y < 0.0);
        let Squared { uv, aspect, .. } = Region::of(&places).unwrap().rectified(&places);
        assert!((2.0..4.0).contains(&aspect), "{aspect}");
        let at = |place: DVec2| {
            let nearer = |&i: &usize, &j: &usize| {
                places[i].distance(place).total_cmp(&places[j].distance(place))
            };
            uv[(0..places.len()).min_by(nearer).unwrap()]
        };
        let bends = [at(DVec2::NEG_ONE), at(DVec2::splat(-0.05))];
        assert!(bends.iter().all(|uv| (0.3..0.7).contains(&uv.x)), "{bends:?}");
        assert!((bends[0].y - bends[1].y).abs() > 0.6, "{bends:?}");
    }

    #[test]
    fn mirrored_places_are_mapped_alike() {
        let lopsided = |p: DVec2| p.length() < 1.0 && (p.x < 0.3 || p.y < 0.1);
        let places = scattered(lopsided);
        let found = Region::of(&places).unwrap().rectified(&places);
        for mirror in [DVec2::new(-1.0, 1.0), DVec2::new(1.0, -1.0), DVec2::NEG_ONE] {
            let mirrored: Vec<DVec2> = places.iter().map(|&place| mirror * place).collect();
            let Squared { uv, aspect, .. } = Region::of(&mirrored).unwrap().rectified(&mirrored);
            assert!((aspect / found.aspect - 1.0).abs() < 1e-4, "{aspect} {}", found.aspect);
            // Up to which sides come first.
            let turned = |u: bool, v: bool, uv: DVec2| {
                let flipped = |is, at: f64| if is { 1.0 - at } else { at };
                DVec2::new(flipped(u, uv.x), flipped(v, uv.y))
            };
            let off = |(u, v): (bool, bool)| {
                let pairs = uv.iter().zip(&found.uv);
                pairs.map(|(&a, &b)| turned(u, v, a).distance(b)).fold(0.0, f64::max)
            };
            let ways = [(false, false), (true, false), (false, true), (true, true)];
            let off = ways.map(off).into_iter().fold(f64::INFINITY, f64::min);
            assert!(off < 1e-3, "{off}");
        }
    }

    #[test]
    fn neighbours_stay_neighbours() {
        let places = scattered(|p| p.x < 0.0 || p.y < 0.0);
        let Squared { uv, aspect, .. } = Region::of(&places).unwrap().rectified(&places);
        assert!(aspect > 1.2, "{aspect}");
        for (i, a) in places.iter().enumerate() {
            for (j, b) in places.iter().enumerate().filter(|(_, b)| a.distance(**b) < 0.1) {
                assert!(uv[i].distance(uv[j]) < 0.25, "{a} {b} {} {}", uv[i], uv[j]);
            }
        }
    }

    #[test]
    fn holes_are_closed_and_pieces_refused() {
        let ring = scattered(|p| (0.4..1.0).contains(&p.length()));
        let region = Region::of(&ring).unwrap();
        let middle = region.around(DVec2::ZERO)[0].0;
        assert!(region.inside[middle]);
        assert!(Region::of(&scattered(|p| p.x.abs() > 0.5)).is_none());
        assert!(Region::of(&[DVec2::ZERO, DVec2::X, DVec2::new(2.0, 0.0)]).is_none());
    }
}
