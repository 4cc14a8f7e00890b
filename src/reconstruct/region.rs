//! The region of the plane that places fill, and the map that makes a rectangle of it.

use glam::{DVec2, DVec3};

use super::outline::{Squared, bounds};
use super::start::whole;
use super::strip::{self, Sides};
use crate::fit::Arms;
use crate::point_cloud::{area, hull};

/// Cells of the raster that would cover the convex hull.
const CELLS: f64 = 900.0;

/// Radius of the blur that makes a density of places, in their mean spacings, and the share of the
/// usual density at which the region ends. A straight border moves out by a little less than a
/// spacing, and corners become round.
const BLUR: f64 = 1.2;
const LEVEL: f64 = 0.25;

/// Width of the empty frame around the places, in radii of the blur.
const FRAME: f64 = 3.0;

/// Places along the outline at which corners are looked for.
const CANDIDATES: usize = 48;

/// Candidates on either side over which an outline turns at a corner.
const TURN: usize = CANDIDATES / 16;

/// What it costs if the outline does not turn by a right angle at a corner, times the square of what
/// is missing.
const WRONG: f64 = 1.0;

/// What it costs if opposite sides are not equally long, or the rectangle is no square: each times the
/// logarithm of the ratio.
const UNEVEN: f64 = 1.5;
const LONG: f64 = 0.3;

/// What it costs, for outlines that turn inwards somewhere, where opposite sides do not bend alike:
/// each right angle by which one of their parts turns more than that across. A bent strip is unbent,
/// but a step in one side would stay.
const UNLIKE: f64 = 0.5;

/// Right angles by which an outline turns inwards not by chance.
const INWARDS: f64 = 0.3;

/// Parts of a side that are compared.
const PARTS: usize = 3;

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
        let size = (high - low + 2.0 * frame) / cell;
        let (cols, rows) = (whole(size.x) + 2, whole(size.y) + 2);
        let inside = vec![false; rows * cols];
        let mut region = Self { origin: low - frame, radius, cell, cols, inside };
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
                return cracks;
            }
            cracks.push(next);
        }
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
        let (line, _, starts) = self.line(&cracks, CANDIDATES);
        let starts = corners(&line, &turns(&line)).map(|corner| starts[corner]);
        let side = |i: usize| (starts.iter().filter(|&&start| start <= i).count() + 3) % 4;
        let mut ends = vec![[None; 4]; self.inside.len()];
        for (i, &(cell, at)) in cracks.iter().enumerate() {
            ends[cell][at] = Some(side(i));
        }
        let ((u, energy), (v, _)) =
            rayon::join(|| self.harmonic(&ends, 3, 1), || self.harmonic(&ends, 0, 2));
        let place = |&place: &DVec2| {
            let shares = self.around(place);
            let mean = |values: &[f64]| shares.iter().map(|&(at, s)| s * values[at]).sum::<f64>();
            let uv = DVec2::new(mean(&u), mean(&v));
            if energy > 1.0 { DVec2::new(uv.y, 1.0 - uv.x) } else { uv }
        };
        let uv = places.iter().map(place).collect();
        Squared::filled(uv, energy.max(1.0 / energy), &[])
    }

    /// So many places along the outline at equal distances, this distance, and the number of the
    /// crack at each.
    fn line(&self, cracks: &[Crack], places: usize) -> (Vec<DVec2>, f64, Vec<usize>) {
        let count = cracks.len();
        let middle = |i: usize| {
            let (cell, side) = cracks[i % count];
            let at = DVec2::new((cell % self.cols) as f64, (cell / self.cols) as f64) + 0.5;
            self.origin + self.cell * (at + 0.5 * AROUND[side])
        };
        let window = 2 * STAIRS + 1;
        let smooth = |i: usize| (0..window).map(|k| middle(i + k)).sum::<DVec2>() / window as f64;
        let line: Vec<DVec2> = (0..count).map(|i| smooth(i + count - STAIRS)).collect();
        let mut along = vec![0.0];
        for i in 0..count {
            along.push(along[i] + line[i].distance(line[(i + 1) % count]));
        }
        let step = along[count] / places as f64;
        let at = |k: usize| along.partition_point(|&a| a < step * k as f64).min(count - 1);
        let starts: Vec<usize> = (0..places).map(at).collect();
        (starts.iter().map(|&start| line[start]).collect(), step, starts)
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

/// By how much a closed line turns to the left around each of its places, in right angles, one at
/// most.
fn turns(line: &[DVec2]) -> Vec<f64> {
    let count = line.len();
    let turn = |i: usize| {
        let [before, here, after] = [i + count - TURN, i, i + TURN].map(|k| line[k % count]);
        let angle = (here - before).angle_to(after - here);
        (angle / std::f64::consts::FRAC_PI_2).min(1.0)
    };
    (0..count).map(turn).collect()
}

/// The four of a closed line's places, equally far from one another along it, that are most like
/// the corners of a rectangle: the line turns there by right angles, and opposite sides are equally
/// long.
fn corners(line: &[DVec2], turns: &[f64]) -> [usize; 4] {
    let count = line.len();
    let wrongs: Vec<f64> = turns.iter().map(|turn| WRONG * (1.0 - turn).powi(2)).collect();
    // What the outline has turned by before each candidate, twice around.
    let mut turned = vec![0.0];
    (0..2 * count + TURN).for_each(|i| turned.push(turned[i] + turns[i % count] / TURN as f64));
    let parts = |from: usize, to: usize| {
        let inner = (to - from).saturating_sub(2 * TURN);
        let before = |part: usize| turned[from + TURN + inner * part / PARTS];
        std::array::from_fn::<_, PARTS, _>(|part| before(part + 1) - before(part))
    };
    let bent = turns.iter().any(|turn| *turn < -INWARDS);
    let unlike = |side: [f64; PARTS], across: [f64; PARTS]| {
        side.iter().zip(across.iter().rev()).map(|(a, b)| (a + b).abs()).sum::<f64>()
    };
    let logs: Vec<f64> = (0..=count).map(|length| (length as f64).ln()).collect();
    let mut best = (f64::NEG_INFINITY, [0; 4]);
    for a in 0..count {
        for b in a + TURN..count {
            for c in b + TURN..count {
                // Whatever the fourth is, three cost too much.
                if wrongs[a] + wrongs[b] + wrongs[c] >= -best.0 {
                    continue;
                }
                for d in c + TURN..count {
                    if a + count - d < TURN {
                        continue;
                    }
                    let [ab, bc, cd, da] = [b - a, c - b, d - c, a + count - d];
                    let uneven = (logs[ab] - logs[cd]).abs() + (logs[bc] - logs[da]).abs();
                    let long = (logs[ab + cd] - logs[bc + da]).abs();
                    let wrong = wrongs[a] + wrongs[b] + wrongs[c] + wrongs[d];
                    let worth = -wrong - UNEVEN * uneven - LONG * long;
                    if worth <= best.0 {
                        continue;
                    }
                    let worth = if bent {
                        let sides = unlike(parts(a, b), parts(c, d));
                        let ends = unlike(parts(b, c), parts(d, a + count));
                        worth - UNLIKE * (sides + ends)
                    } else {
                        worth
                    };
                    if worth > best.0 {
                        best = (worth, [a, b, c, d]);
                    }
                }
            }
        }
    }
    best.1
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
