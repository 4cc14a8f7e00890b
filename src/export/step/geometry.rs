//! Points, B-spline curves and B-spline surfaces as entities.

use std::io::Write;

use glam::DVec3;

use super::entities::{Entities, list, real};
use crate::error::Result;
use crate::nurbs::{KnotVector, NurbsCurve, NurbsSurface};

/// Number of coordinates in space.
const IN_SPACE: usize = 3;

/// Number of coordinates in (u, v).
const IN_PLANE: usize = 2;

/// Writes a point.
pub(super) fn point<W: Write>(file: &mut Entities<'_, W>, point: DVec3) -> Result<String> {
    cartesian_point(file, point, IN_SPACE)
}

fn cartesian_point<W: Write>(
    file: &mut Entities<'_, W>,
    point: DVec3,
    dimension: usize,
) -> Result<String> {
    let coordinates = point.to_array().into_iter().take(dimension).map(real);
    file.add(&format!("CARTESIAN_POINT('',{})", list(coordinates)))
}

fn points<W: Write>(
    file: &mut Entities<'_, W>,
    points: &[DVec3],
    dimension: usize,
) -> Result<String> {
    let references = points.iter().map(|&p| cartesian_point(file, p, dimension));
    Ok(list(references.collect::<Result<Vec<String>>>()?))
}

/// The multiplicities and the distinct values of the knots.
fn knots(knots: &KnotVector) -> (String, String) {
    let (values, times): (Vec<f64>, Vec<usize>) = knots.distinct().unzip();
    (list(times.iter().map(ToString::to_string)), list(values.into_iter().map(real)))
}

/// Writes a surface.
pub(super) fn surface<W: Write>(
    file: &mut Entities<'_, W>,
    surface: &NurbsSurface,
) -> Result<String> {
    let cols = surface.shape().1;
    let rows = surface.control_points().chunks(cols).map(|row| points(file, row, IN_SPACE));
    let net = list(rows.collect::<Result<Vec<String>>>()?);
    let (u, v) = (surface.knots_u(), surface.knots_v());
    let (p, q, (times_u, values_u), (times_v, values_v)) =
        (u.degree(), v.degree(), knots(u), knots(v));
    let form = format!("{p},{q},{net},.UNSPECIFIED.,.F.,.F.,.F.");
    let spans = format!("{times_u},{times_v},{values_u},{values_v},.UNSPECIFIED.");
    let Some(weights) = surface.weights() else {
        return file.add(&format!("B_SPLINE_SURFACE_WITH_KNOTS('',{form},{spans})"));
    };
    let weights = list(weights.chunks(cols).map(|row| list(row.iter().map(|&w| real(w)))));
    file.add(&format!(
        "(BOUNDED_SURFACE() B_SPLINE_SURFACE({form}) B_SPLINE_SURFACE_WITH_KNOTS({spans}) \
         GEOMETRIC_REPRESENTATION_ITEM() RATIONAL_B_SPLINE_SURFACE({weights}) \
         REPRESENTATION_ITEM('') SURFACE())"
    ))
}

/// Writes a curve in space.
pub(super) fn curve<W: Write>(file: &mut Entities<'_, W>, curve: &NurbsCurve) -> Result<String> {
    b_spline_curve(file, curve, IN_SPACE)
}

/// Writes a curve in (u, v) of a surface; `context` is a parametric context.
pub(super) fn pcurve<W: Write>(
    file: &mut Entities<'_, W>,
    curve: &NurbsCurve,
    surface: &str,
    context: &str,
) -> Result<String> {
    let curve = b_spline_curve(file, curve, IN_PLANE)?;
    let definition = file.add(&format!("DEFINITIONAL_REPRESENTATION('',({curve}),{context})"))?;
    file.add(&format!("PCURVE('',{surface},{definition})"))
}

fn b_spline_curve<W: Write>(
    file: &mut Entities<'_, W>,
    curve: &NurbsCurve,
    dimension: usize,
) -> Result<String> {
    let points = points(file, curve.control_points(), dimension)?;
    let (degree, (times, values)) = (curve.knots().degree(), knots(curve.knots()));
    let form = format!("{degree},{points},.UNSPECIFIED.,.F.,.F.");
    let spans = format!("{times},{values},.UNSPECIFIED.");
    let Some(weights) = curve.weights() else {
        return file.add(&format!("B_SPLINE_CURVE_WITH_KNOTS('',{form},{spans})"));
    };
    let weights = list(weights.iter().map(|&w| real(w)));
    file.add(&format!(
        "(BOUNDED_CURVE() B_SPLINE_CURVE({form}) B_SPLINE_CURVE_WITH_KNOTS({spans}) CURVE() \
         GEOMETRIC_REPRESENTATION_ITEM() RATIONAL_B_SPLINE_CURVE({weights}) \
         REPRESENTATION_ITEM(''))"
    ))
}
