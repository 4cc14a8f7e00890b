//! Which corners hold: two smooth arcs explain the border better than one.

use std::collections::HashMap;

use super::arc::core;
use super::border::Border;
use super::corners::Candidates;
use super::settings::{CornerCheckSettings, SplineSettings};
use super::spline_fit::Form;
use super::stretch::Stretch;
use crate::error::Result;

const SETTINGS: CornerCheckSettings = CornerCheckSettings::STANDARD;

/// The corners that remain after those that explain least were taken away, one by one.
///
/// The cost of an arc is the sum of its places' squared distances over the variance, plus a cost
/// per control point; it is least over their number. A corner goes if one arc is cheaper than two
/// and `cost` times the cost of a corner.
pub(super) fn checked(
    border: &Border,
    Candidates { mut corners, variance }: Candidates,
    cost: f64,
) -> Result<Vec<usize>> {
    let corner = cost * SETTINGS.corner_cost;
    let mut costs = Costs { border, variance, corner, known: HashMap::new() };
    while !corners.is_empty() {
        let mut worst = (f64::NEG_INFINITY, 0);
        for k in 0..corners.len() {
            let gain = costs.gain(&corners, k)?;
            if gain > worst.0 {
                worst = (gain, k);
            }
        }
        if worst.0 < 0.0 {
            break;
        }
        corners.remove(worst.1);
    }
    Ok(corners)
}

/// Costs of arcs between places of a border.
struct Costs<'a> {
    border: &'a Border,
    variance: f64,
    corner: f64,
    known: HashMap<(usize, usize), f64>,
}

impl Costs<'_> {
    /// What taking a corner away saves.
    fn gain(&mut self, corners: &[usize], k: usize) -> Result<f64> {
        let count = self.border.len();
        let (before, corner) = (corners[(k + corners.len() - 1) % corners.len()], corners[k]);
        let behind = corners[(k + 1) % corners.len()];
        let after = |from: usize, to: usize| if to > from { to } else { to + count };
        let one = if corners.len() == 1 {
            self.smooth()?
        } else {
            // Two arcs around a loop become one around all of it.
            let middle = after(before, corner);
            let end = after(middle % count, behind) + middle / count * count;
            self.cost(before, end)?
        };
        let two = if corners.len() == 1 {
            self.cost(corner, corner + count)?
        } else {
            self.cost(before, after(before, corner))? + self.cost(corner, after(corner, behind))?
        };
        Ok(two + self.corner - one)
    }

    /// The cost of an arc from one place to another, whose index may be a turn ahead.
    fn cost(&mut self, from: usize, to: usize) -> Result<f64> {
        if let Some(known) = self.known.get(&(from, to)) {
            return Ok(*known);
        }
        let stretch = Stretch::of(self.border, &[core(self.border, (from, to))]);
        let cost = self.least(&stretch, Form::Open([None; 2]))?;
        // Places that are left out cost what places do.
        let cost = cost + (to - from - stretch.uv.len().min(to - from)) as f64;
        self.known.insert((from, to), cost);
        Ok(cost)
    }

    /// The cost of a smooth loop.
    fn smooth(&self) -> Result<f64> {
        let stretch = Stretch::of(self.border, &[0..=self.border.len()]);
        self.least(&stretch, Form::Periodic(self.border.shift))
    }

    /// The least cost over numbers of control points.
    fn least(&self, stretch: &Stretch, form: Form) -> Result<f64> {
        let most = stretch.uv.len() / 2;
        let mut least = f64::INFINITY;
        for count in form.sizes().iter().copied().take_while(|count| *count <= most.max(2)) {
            let own = SETTINGS.point_cost * count as f64;
            if own > least {
                break;
            }
            if let Some(fit) =
                stretch.targets().fit(form, count, SplineSettings::STANDARD.fairness)?
            {
                least = least.min(own + fit.squares / self.variance);
            }
        }
        Ok(least)
    }
}
