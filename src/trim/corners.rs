//! Candidates for corners: places where a border turns at once.

use glam::{DVec2, DVec3};

use super::border::Border;
use super::normal_matrix::NormalMatrix;
use super::settings::CornerSettings;
use crate::numeric::median;

const SETTINGS: CornerSettings = CornerSettings::STANDARD;

/// Places where a border may have corners.
#[derive(Clone, Debug)]
pub(super) struct Candidates {
    /// Places on the border, in order.
    pub corners: Vec<usize>,
    /// Variance of the border's places around smooth curves, in space.
    pub variance: f64,
}

impl Candidates {
    /// The candidates of a border.
    ///
    /// Through the places within an arm's length, two curved arms are fitted that turn into each
    /// other within a width. The squares with small and with large widths say how sharp the turn
    /// is.
    pub(super) fn of(border: &Border) -> Self {
        let spacing = border.spacing;
        let floor = (SETTINGS.noise_floor * spacing).powi(2);
        let arm = (SETTINGS.arm * spacing).min(border.length() / SETTINGS.arms_per_loop);
        if arm < SETTINGS.min_arm * spacing {
            return Self { corners: vec![], variance: floor };
        }
        let turns = (0..border.len()).map(|k| Turn::of(&around(border, k, arm), arm, spacing));
        let turns: Vec<Turn> = turns.collect();
        let variance = floor + median(turns.iter().map(|turn| turn.variance));
        let mut order: Vec<usize> =
            (0..border.len()).filter(|k| turns[*k].sharpness > 0.0).collect();
        order.sort_by(|a, b| turns[*b].sharpness.total_cmp(&turns[*a].sharpness));
        let mut corners: Vec<usize> = vec![];
        for k in order {
            let near =
                |other: &usize| border.distance(*other, k).abs() < SETTINGS.distance * spacing;
            if !corners.iter().any(near) {
                corners.push(k);
            }
        }
        corners.sort_unstable();
        Self { corners, variance }
    }
}

/// The places within an arm's length of a place: distance along the border, and position in the
/// tangent plane.
fn around(border: &Border, k: usize, arm: f64) -> Vec<(f64, DVec2)> {
    let count = border.len();
    let [by_u, by_v] = border.tangents[k];
    let x = by_u.normalize_or(DVec3::X);
    let y = (by_v - by_v.dot(x) * x).normalize_or(x.any_orthonormal_vector());
    let at = |other: usize| {
        let away = border.points[other] - border.points[k];
        (border.distance(k, other), DVec2::new(away.dot(x), away.dot(y)))
    };
    let near = |place: &(f64, DVec2)| place.0.abs() <= arm;
    let back = (1..count).map(|j| at((k + count - j) % count));
    let mut places: Vec<_> = back.take_while(|place| near(place) && place.0 < 0.0).collect();
    places.reverse();
    let ahead = (0..count).map(|j| at((k + j) % count));
    places.extend(ahead.take_while(|place| near(place) && place.0 >= 0.0));
    places
}

/// How a border turns at a place.
#[derive(Clone, Copy, Debug, Default)]
struct Turn {
    /// How clearly it turns at once; 0 if it does not.
    sharpness: f64,
    /// Variance of the places around the better arms.
    variance: f64,
}

impl Turn {
    fn of(places: &[(f64, DVec2)], arm: f64, spacing: f64) -> Self {
        if places.len() < SETTINGS.min_places {
            return Self::default();
        }
        let best = |widths: &[f64]| {
            let fits = widths.iter().filter_map(|width| Arms::fit(places, arm, width * spacing));
            fits.min_by(|a, b| a.squares.total_cmp(&b.squares))
        };
        let (Some(sharp), Some(wide)) = (best(&SETTINGS.sharp_widths), best(&SETTINGS.wide_widths))
        else {
            return Self::default();
        };
        let count = places.len() as f64;
        let floor = count * (SETTINGS.noise_floor * spacing).powi(2);
        let ratio = (sharp.squares + floor) / (wide.squares + floor);
        let turns = sharp.angle > SETTINGS.angle.to_radians() && ratio < SETTINGS.ratio;
        Self {
            sharpness: if turns { sharp.angle * (2.0 - ratio) } else { 0.0 },
            variance: sharp.squares.min(wide.squares) / (count - 4.0),
        }
    }
}

/// Two arms and the turn between them.
#[derive(Clone, Copy, Debug)]
struct Arms {
    angle: f64,
    squares: f64,
}

impl Arms {
    /// The arms through places: a parabola in the distance along the border, plus a hinge that is
    /// rounded within a width.
    fn fit(places: &[(f64, DVec2)], arm: f64, width: f64) -> Option<Self> {
        let hinge = |l: f64| {
            if l.abs() < width { (l * l + width * width) / (2.0 * width) } else { l.abs() }
        };
        let terms = |l: f64| [1.0, l / arm, hinge(l) / arm, (l / arm).powi(2)];
        let mut rights = [[0.0; 4]; 2];
        let mut matrix = NormalMatrix::new(4);
        for (l, at) in places {
            let terms = terms(*l);
            for i in 0..4 {
                (0..=i).for_each(|j| matrix.add(i, j, terms[i] * terms[j]));
                (0..2).for_each(|d| rights[d][i] += terms[i] * at[d]);
            }
        }
        let solved = rights.iter_mut().all(|right| matrix.clone().solve(right));
        let term = |i: usize| DVec2::new(rights[0][i], rights[1][i]);
        let square = |(l, at): &(f64, DVec2)| {
            let terms = terms(*l);
            (0..4).map(|i| terms[i] * term(i)).sum::<DVec2>().distance_squared(*at)
        };
        let squares = places.iter().map(square).sum();
        let angle = (term(1) - term(2)).angle_to(term(1) + term(2)).abs();
        solved.then_some(Self { angle, squares })
    }
}
