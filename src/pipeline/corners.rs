//! The corners of an outline that is to become that of a rectangle.

use glam::DVec2;

/// Places along an outline at which corners are looked for.
pub(super) const CANDIDATES: usize = 52;

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

/// The four of a closed line's places, equally far from one another along it, that are most like
/// the corners of a rectangle: the line turns there by right angles, and opposite sides are equally
/// long.
pub(super) fn corners(line: &[DVec2]) -> [usize; 4] {
    let (count, turns) = (line.len(), turns(line));
    let wrongs: Vec<f64> = turns.iter().map(|turn| WRONG * (1.0 - turn).powi(2)).collect();
    // What the outline has turned by before each candidate, half of what it does there included, twice around.
    let (mut before, mut turned) = (0.0, Vec::new());
    for i in 0..2 * count + TURN {
        let turn = turns[i % count] / TURN as f64;
        turned.push(before + 0.5 * turn);
        before += turn;
    }
    let parts = |from: usize, to: usize| {
        let inner = (to - from).saturating_sub(2 * TURN);
        // The same from either end.
        let along = |part: usize| {
            let rest = PARTS - part;
            if part < rest { inner * part / PARTS } else { inner - inner * rest / PARTS }
        };
        let turned = |part: usize| turned[from + TURN + along(part)];
        std::array::from_fn::<_, PARTS, _>(|part| turned(part + 1) - turned(part))
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Places at equal distances along an outline with these corners, from so far along it.
    fn places(outline: &[(f64, f64)], from: f64) -> Vec<DVec2> {
        let at = |i: usize| DVec2::from(outline[i % outline.len()]);
        let length = |i: usize| at(i).distance(at(i + 1));
        let whole: f64 = (0..outline.len()).map(length).sum();
        let place = |k: usize| {
            let mut along = (from + whole * k as f64 / CANDIDATES as f64) % whole;
            let mut side = 0;
            while along > length(side) {
                along -= length(side);
                side += 1;
            }
            at(side).lerp(at(side + 1), along / length(side))
        };
        (0..CANDIDATES).map(place).collect()
    }

    #[test]
    fn those_of_a_rectangle_are_found() {
        let outline = [(0.0, 0.0), (16.0, 0.0), (16.0, 10.0), (0.0, 10.0)];
        let line = places(&outline, 3.0);
        let found = corners(&line).map(|corner| line[corner]);
        for corner in outline.map(DVec2::from) {
            assert!(found.iter().any(|found| found.distance(corner) < 1e-9), "{found:?}");
        }
    }

    #[test]
    fn they_are_the_same_the_other_way_round() {
        // Of a square with a step in one side, lopsided.
        let outline = [(0.0, 0.0), (13.0, 0.0), (13.0, 9.0), (8.0, 9.0), (8.0, 12.0), (-1.0, 11.0)];
        for from in [0.0, 0.4, 5.3] {
            let line = places(&outline, from);
            // From the same place back.
            let back: Vec<DVec2> = (0..CANDIDATES)
                .map(|k| line[(CANDIDATES - k) % CANDIDATES] * DVec2::new(-1.0, 1.0))
                .collect();
            let mut found = corners(&line);
            let mut others = corners(&back).map(|corner| (CANDIDATES - corner) % CANDIDATES);
            found.sort_unstable();
            others.sort_unstable();
            assert_eq!(found, others);
        }
    }
}
