//! Pinches: places where the border of a region touches itself.

use super::adjacency::Lists;
use super::settings::RegionSettings;
use super::triangulation::{NONE, Triangulation};

const SETTINGS: RegionSettings = RegionSettings::STANDARD;

/// Makes the border of what is kept simple: at each place with several fans of triangles, the
/// smallest closed gap is filled; where all gaps are open, the smallest fan is left out.
pub(super) fn mend_pinches(all: &Triangulation, around: &Lists, keep: &mut [bool]) {
    for round in 0..2 * SETTINGS.mending_rounds {
        let mut changed = false;
        for place in 0..around.len() {
            let kept = fans(all, around.at(place), place, |t| keep[t]);
            if kept.len() < 2 {
                continue;
            }
            changed = true;
            let gaps = fans(all, around.at(place), place, |t| !keep[t]);
            let closed =
                gaps.iter().filter(|fan| !fan.is_open).min_by_key(|gap| gap.triangles.len());
            // Filling and leaving out may take turns; leaving out alone ends.
            if let Some(gap) = closed.filter(|_| round < SETTINGS.mending_rounds) {
                gap.triangles.iter().for_each(|t| keep[*t as usize] = true);
            } else if let Some(fan) = kept.iter().min_by_key(|fan| fan.triangles.len()) {
                fan.triangles.iter().for_each(|t| keep[*t as usize] = false);
            }
        }
        if !changed {
            return;
        }
    }
}

/// Triangles around a place that follow each other.
struct Fan {
    triangles: Vec<u32>,
    /// Whether it ends at the hull.
    is_open: bool,
}

/// The fans of those triangles around a place that belong to a set.
fn fans(
    all: &Triangulation,
    around: &[u32],
    place: usize,
    belongs: impl Fn(usize) -> bool,
) -> Vec<Fan> {
    let mut left: Vec<u32> = around.iter().copied().filter(|t| belongs(*t as usize)).collect();
    let mut fans = vec![];
    while let Some(first) = left.pop() {
        let mut fan = Fan { triangles: vec![first], is_open: false };
        let mut next = 0;
        while next < fan.triangles.len() {
            let t = fan.triangles[next] as usize;
            next += 1;
            for k in 0..3 {
                // The side opposite to the place leads away from it.
                if all.corners[t][k] as usize == place {
                    continue;
                }
                let other = all.neighbors[t][k];
                if other == NONE {
                    fan.is_open = true;
                } else if let Some(at) = left.iter().position(|t| *t == other) {
                    left.swap_remove(at);
                    fan.triangles.push(other);
                }
            }
        }
        fans.push(fan);
    }
    fans
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fan of six triangles around place 0, with places 1 to 6 around.
    fn fan() -> Triangulation {
        let corners = (0..6).map(|k| [0, k + 1, (k + 1) % 6 + 1]).collect();
        let neighbors = (0..6).map(|k| [NONE, (k + 1) % 6, (k + 5) % 6]).collect();
        Triangulation { corners, neighbors }
    }

    fn mended(mut keep: [bool; 6]) -> [bool; 6] {
        let fan = fan();
        mend_pinches(&fan, &Lists::triangles(7, &fan), &mut keep);
        keep
    }

    #[test]
    fn smaller_gaps_are_filled() {
        assert_eq!(
            mended([true, false, true, true, false, false]),
            [true, true, true, true, false, false]
        );
        let simple = [true, true, true, true, false, false];
        assert_eq!(mended(simple), simple);
    }

    #[test]
    fn open_gaps_leave_the_larger_fan() {
        // Two fans that share place 0 on the hull, without triangles between them.
        let corners = vec![[0, 1, 2], [0, 2, 3], [0, 4, 5]];
        let neighbors = vec![[NONE, 1, NONE], [NONE, NONE, 0], [NONE; 3]];
        let all = Triangulation { corners, neighbors };
        let mut keep = [true; 3];
        mend_pinches(&all, &Lists::triangles(6, &all), &mut keep);
        assert_eq!(keep, [true, true, false]);
    }
}
