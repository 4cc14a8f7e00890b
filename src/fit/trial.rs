//! A surface on its way to points that shall all lie on it.

use glam::{DVec2, DVec3};

use super::band::Band;
use super::correct::Foot;
use super::joint::{Joint, STEPS};
use super::normal_equations::NormalEquations;
use crate::error::{Error, Result};
use crate::nurbs::NurbsSurface;

/// What is added to the diagonal at first, as a share of its mean; what is left of it after a step
/// that helps, and how many times as much it becomes after one that does not.
pub(super) const DAMPING: f64 = 1e-3;
const LESS: f64 = 0.2;
const MORE: f64 = 3.0;
const LEAST_DAMPING: f64 = 1e-16;

/// Share of a step at which its bend is measured, and how much longer than a step the bend may be.
const AHEAD: f64 = 0.1;
const MOST_BENT: f64 = 0.4;

/// A surface on its way to the points.
pub(super) struct Trial {
    pub(super) surface: NurbsSurface,
    /// The points' feet on it, or on what it goes on to.
    pub(super) feet: Vec<Foot>,
    /// Root of the mean square of the distances from them.
    pub(super) error: f64,
    pub(super) damping: f64,
    /// The equations of these feet, if a step with more damping is to come.
    pub(super) equations: Option<NormalEquations>,
}

impl Trial {
    pub(super) fn uv(&self) -> Vec<DVec2> {
        self.feet.iter().map(|foot| foot.uv).collect()
    }

    /// Makes a step, if it helps.
    pub(super) fn advance(&mut self, joint: &Joint) -> Result<()> {
        let equations = match self.equations.take() {
            Some(equations) => equations,
            None => joint.equations(&self.feet)?,
        };
        let mut matrix = equations.matrix.clone();
        matrix.add_ridge(self.damping);
        let next = if matrix.factor::<Error>(&mut || Ok(()))? {
            let change = matrix.solved_together(&equations.right);
            self.after(&self.bent(&matrix, change, joint)?, joint)?
        } else {
            None
        };
        // What is near enough may come a little farther away on the way to where it rests.
        if let Some(next) = next.filter(|next| next.error < self.error.max(joint.enough)) {
            *self = next;
        } else {
            self.damping *= MORE;
            self.equations = Some(equations);
        }
        Ok(())
    }

    /// A change of the control points that follows the bend of the way: by the second derivative of
    /// the distances along it.
    fn bent(&self, matrix: &Band, mut change: Vec<DVec3>, joint: &Joint) -> Result<Vec<DVec3>> {
        let ahead: Vec<DVec3> = change.iter().map(|change| AHEAD * *change).collect();
        let net = added(joint.space.unknown_points(&self.surface), &ahead);
        let uv = self.uv();
        let there = joint.feet(&joint.space.surface(&net)?, &uv, STEPS);
        let moved = joint.places(&ahead, &uv)?;
        let bend = |((here, there), moved): ((&Foot, &Foot), &DVec3)| {
            let distance = there.offset.dot(there.normal) * there.normal.dot(here.normal).signum();
            let straight = (here.offset - *moved).dot(here.normal);
            let bend = (distance - straight) / (AHEAD * AHEAD);
            Foot { offset: bend * here.normal, ..*here }
        };
        let bends: Vec<Foot> = self.feet.iter().zip(&there).zip(&moved).map(bend).collect();
        // Half the second derivative: what the square of the way leaves.
        let right = joint.samples(&bends, 1.0);
        let right = NormalEquations::of_distances(&joint.space, &right, &mut || Ok(()))?.right;
        let bend = matrix.solved_together(&right);
        let share = (MOST_BENT * length(&change) / length(&bend)).min(1.0);
        change.iter_mut().zip(&bend).for_each(|(change, bend)| *change += share * *bend);
        Ok(change)
    }

    /// After a change of the control points, and what follows from it for plain distances.
    fn after(&self, change: &[DVec3], joint: &Joint) -> Result<Option<Self>> {
        let net = added(joint.space.unknown_points(&self.surface), change);
        let feet = joint.feet(&joint.space.surface(&net)?, &self.uv(), STEPS);
        let Some(change) = joint.plain(&feet)? else { return Ok(None) };
        let surface = joint.space.surface(&added(net, &change))?;
        let uv: Vec<DVec2> = feet.iter().map(|foot| foot.uv).collect();
        let feet = joint.feet(&surface, &uv, STEPS);
        let damping = (LESS * self.damping).max(LEAST_DAMPING);
        Ok(Some(Self { error: joint.rms(&feet), surface, feet, damping, equations: None }))
    }
}

/// Root of the sum of squares.
fn length(change: &[DVec3]) -> f64 {
    change.iter().map(|change| change.length_squared()).sum::<f64>().sqrt()
}

fn added(mut net: Vec<DVec3>, change: &[DVec3]) -> Vec<DVec3> {
    net.iter_mut().zip(change).for_each(|(point, change)| *point += *change);
    net
}
