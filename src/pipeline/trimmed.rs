//! The faces of a surface that end where the points end, and what the report says of them.

use std::sync::Arc;

use glam::{DAffine3, DVec2, DVec3};

use super::options::Trimming;
use super::report::TrimReport;
use super::settings::TrimmedSettings;
use crate::brep::{Face, Shell};
use crate::diagnostic::Diagnostic;
use crate::error::{Error, Result};
use crate::nurbs::NurbsSurface;
use crate::progress::{Observer, Silent};
use crate::trim::{Trim, TrimOptions, trim};

const SETTINGS: TrimmedSettings = TrimmedSettings::STANDARD;

/// A surface with its faces.
#[derive(Clone, Debug)]
pub struct Trimmed {
    /// The faces.
    pub shell: Shell,
    /// Their figures; `None` if no trimming was asked for.
    pub report: Option<TrimReport>,
    /// Why the surface is whole, or what is doubtful.
    pub diagnostics: Vec<Diagnostic>,
}

impl Trimmed {
    /// Trims a surface where the points with these parameters end. If that fails, the surface stays
    /// whole, with a diagnostic.
    ///
    /// Distances between points count in coordinates divided by `axis_scale`, as in the fit.
    ///
    /// # Errors
    ///
    /// If the observer interrupts, or the area of the surface cannot be measured.
    pub fn of(
        surface: &NurbsSurface,
        axis_scale: DVec3,
        uv: &[DVec2],
        trimming: Trimming,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let surface = Arc::new(surface.clone());
        let shell = Shell::whole(Arc::clone(&surface))?;
        if trimming == Trimming::No {
            return Ok(Self { shell, report: None, diagnostics: vec![] });
        }
        let surface_area = shell.area(SETTINGS.accuracy, observer)?;
        let whole = |beyond: Option<f64>, diagnostics: Vec<Diagnostic>| {
            let report = Some(TrimReport::whole(surface_area, beyond));
            Ok(Self { shell, report, diagnostics })
        };
        let options = TrimOptions { holes: trimming != Trimming::Outer, border: None };
        let scale = power_of_two(axis_scale);
        let scaled = match scale {
            DVec3::ONE => Arc::clone(&surface),
            _ => Arc::new(surface.map_control_points(|point| point / scale)?),
        };
        let found = match trim(&scaled, uv, &options, observer) {
            Err(error) => return whole(None, untrimmed(error)?),
            Ok(found) => found,
        };
        let auto = trimming == Trimming::Auto;
        if found.loops.is_empty() {
            return whole(found.beyond_untrimmed, found.diagnostic().into_iter().collect());
        }
        if let Some(doubt) = found.doubt.filter(|_| auto) {
            let reason = format!("{doubt}. Use `trim=True` to trim it all the same");
            return whole(found.beyond_untrimmed, vec![Diagnostic::Untrimmed { reason }]);
        }
        if auto && found.pointless {
            return whole(found.beyond_untrimmed, vec![]);
        }
        let mut diagnostics: Vec<Diagnostic> = found.diagnostic().into_iter().collect();
        if found.regions > 1 {
            diagnostics.push(Diagnostic::Regions { count: found.regions });
        }
        let (trimmed, area, holes) = match measured(&found, scale, observer) {
            Err(error) => return whole(None, untrimmed(error)?),
            Ok(made) => made,
        };
        let report = Some(TrimReport::of(&found, (area, surface_area), holes));
        Ok(Self { shell: trimmed, report, diagnostics })
    }
}

/// The finding that an error of trimming leaves; an interruption stays an error.
fn untrimmed(error: Error) -> Result<Vec<Diagnostic>> {
    match error {
        Error::Interrupted => Err(error),
        error => Ok(vec![Diagnostic::Untrimmed { reason: error.to_string() }]),
    }
}

/// The powers of two nearest to these divisors: dividing by them and multiplying again does not
/// round, so faces have the control points of the surface.
fn power_of_two(axis_scale: DVec3) -> DVec3 {
    axis_scale.map(|divisor| divisor.log2().round().exp2())
}

/// The shell of trimmed faces in given coordinates, its area, and the areas of its holes.
fn measured(
    found: &Trim,
    scale: DVec3,
    observer: &mut dyn Observer,
) -> Result<(Shell, f64, Vec<f64>)> {
    let mut shell = Shell::new(found.faces.clone(), None)?;
    if scale != DVec3::ONE {
        shell = shell.transformed(&DAffine3::from_scale(scale))?;
    }
    let area = shell.area(SETTINGS.accuracy, observer)?;
    let holes = hole_areas(&shell, observer)?;
    Ok((shell, area, holes))
}

/// The areas of all holes, the largest first.
fn hole_areas(shell: &Shell, observer: &mut dyn Observer) -> Result<Vec<f64>> {
    let mut areas = vec![];
    for face in shell.faces() {
        for hole in face.inner() {
            let curves = hole.curves().iter().rev();
            let around = curves.map(|curve| curve.reversed(&mut Silent)).collect::<Result<_>>()?;
            let covered = Face::trimmed(Arc::clone(face.surface()), vec![around])?;
            areas.push(covered.area(SETTINGS.accuracy, observer)?);
        }
    }
    areas.sort_unstable_by(|a, b| b.total_cmp(a));
    Ok(areas)
}
