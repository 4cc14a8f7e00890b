//! Levenberg-Marquardt steps for a net, with second-order correction (M. Transtrum, J. Sethna,
//! *Improvements to the Levenberg-Marquardt algorithm for nonlinear least-squares minimization*,
//! 2012).

use glam::{DVec2, DVec3};

use super::super::band_matrix::BandMatrix;
use super::super::normal_equations::NormalEquations;
use super::super::projection::Projection;
use super::super::settings::ProjectionSettings;
use super::settings::RecoverySettings;
use super::varpro::Problem;
use crate::error::{Error, Result};
use crate::nurbs::NurbsSurface;

const SETTINGS: RecoverySettings = RecoverySettings::STANDARD;
const PROJECTION: ProjectionSettings = ProjectionSettings::STANDARD;

/// A surface that approaches the points, from one start.
pub(super) struct Trial {
    pub(super) surface: NurbsSurface,
    /// The points' projections onto it, or onto its extension.
    pub(super) projections: Vec<Projection>,
    /// Rms distance of the points.
    pub(super) error: f64,
    damping: f64,
    /// The equations of these projections, if the next step only needs more damping.
    equations: Option<NormalEquations>,
}

impl Trial {
    /// A surface, with projections from these parameters.
    pub(super) fn from_surface(problem: &Problem<'_>, surface: NurbsSurface, uv: &[DVec2]) -> Self {
        let projections = problem.projections(&surface, uv, 2 * PROJECTION.first_steps);
        Self {
            error: rms(&projections),
            surface,
            projections,
            damping: SETTINGS.damping,
            equations: None,
        }
    }

    /// The surface with the least plain distances at these parameters. `None` if the points do not
    /// determine it.
    pub(super) fn from_parameters(problem: &Problem<'_>, uv: &[DVec2]) -> Result<Option<Self>> {
        let place =
            |(&uv, &offset): (&DVec2, &DVec3)| Projection { uv, offset, ..Projection::default() };
        let places: Vec<Projection> = uv.iter().zip(problem.points).map(place).collect();
        let Some(net) = problem.plain(&places)? else { return Ok(None) };
        Ok(Some(Self::from_surface(problem, problem.space.surface(&net)?, uv)))
    }

    fn uv(&self) -> Vec<DVec2> {
        self.projections.iter().map(|projection| projection.uv).collect()
    }

    /// Makes a step if it decreases the error, else raises the damping.
    pub(super) fn advance(&mut self, problem: &Problem<'_>) -> Result<()> {
        let equations = match self.equations.take() {
            Some(equations) => equations,
            None => problem.equations(&self.projections)?,
        };
        let mut matrix = equations.matrix.clone();
        matrix.add_ridge(self.damping);
        let next = if matrix.factor::<Error>(&mut || Ok(()))? {
            let change = matrix.solved_together(&equations.right);
            self.stepped(&self.second_order_step(&matrix, change, problem)?, problem)?
        } else {
            None
        };
        // Steps are also accepted once the surface passes through all points, so that the net
        // converges.
        let helps = |next: &Self| next.error < self.error || problem.is_converged(next.error);
        if let Some(next) = next.filter(helps) {
            *self = next;
        } else {
            self.damping *= SETTINGS.damping_factor;
            self.equations = Some(equations);
        }
        Ok(())
    }

    /// The change of the control points plus its second-order correction, from the second
    /// derivative of the distances along it.
    fn second_order_step(
        &self,
        matrix: &BandMatrix,
        mut change: Vec<DVec3>,
        problem: &Problem<'_>,
    ) -> Result<Vec<DVec3>> {
        let ahead: Vec<DVec3> = change.iter().map(|change| SETTINGS.probe * *change).collect();
        let net = added(problem.space.unknown_points(&self.surface), &ahead);
        let uv = self.uv();
        let there = problem.projections(&problem.space.surface(&net)?, &uv, PROJECTION.steps);
        let moved = problem.at(&ahead, &uv)?;
        let bend = |((here, there), moved): ((&Projection, &Projection), &DVec3)| {
            let distance = there.offset.dot(there.normal) * there.normal.dot(here.normal).signum();
            let straight = (here.offset - *moved).dot(here.normal);
            let bend = (distance - straight) / (SETTINGS.probe * SETTINGS.probe);
            Projection { offset: bend * here.normal, ..*here }
        };
        let bends: Vec<Projection> =
            self.projections.iter().zip(&there).zip(&moved).map(bend).collect();
        let right = problem.samples(&bends, 1.0);
        let right = NormalEquations::of_distances(problem.space, &right, &mut || Ok(()))?.right;
        let bend = matrix.solved_together(&right);
        // The correction has a limited length.
        let share = (SETTINGS.max_correction * length(&change) / length(&bend)).min(1.0);
        change.iter_mut().zip(&bend).for_each(|(change, bend)| *change += share * *bend);
        Ok(change)
    }

    /// The surface after a change of the control points, with projected parameters and one plain
    /// solution.
    fn stepped(&self, change: &[DVec3], problem: &Problem<'_>) -> Result<Option<Self>> {
        let net = added(problem.space.unknown_points(&self.surface), change);
        let projections =
            problem.projections(&problem.space.surface(&net)?, &self.uv(), PROJECTION.steps);
        let Some(change) = problem.plain(&projections)? else { return Ok(None) };
        let surface = problem.space.surface(&added(net, &change))?;
        let uv: Vec<DVec2> = projections.iter().map(|projection| projection.uv).collect();
        let projections = problem.projections(&surface, &uv, PROJECTION.steps);
        let damping = (self.damping / SETTINGS.damping_factor).max(SETTINGS.min_damping);
        Ok(Some(Self { error: rms(&projections), surface, projections, damping, equations: None }))
    }
}

fn rms(projections: &[Projection]) -> f64 {
    let squares: f64 =
        projections.iter().map(|projection| projection.offset.length_squared()).sum();
    (squares / projections.len() as f64).sqrt()
}

/// Root of the sum of squares.
fn length(change: &[DVec3]) -> f64 {
    change.iter().map(|change| change.length_squared()).sum::<f64>().sqrt()
}

fn added(mut net: Vec<DVec3>, change: &[DVec3]) -> Vec<DVec3> {
    net.iter_mut().zip(change).for_each(|(point, change)| *point += *change);
    net
}
