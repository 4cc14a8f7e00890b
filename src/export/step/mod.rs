//! STEP export (ISO 10303-21, application protocol 214).

use std::borrow::Cow;
use std::io::Write;

use glam::DVec3;

use crate::brep::LengthUnit;
use crate::error::Result;
use crate::nurbs::{KnotVector, NurbsSurface};
use crate::progress::Silent;

/// Distance below which a reader may identify two points, as a fraction of the surface's size.
/// Edges and surface are exactly the same curves, but readers compare them at sampled points.
const UNCERTAINTY: f64 = 1e-6;

/// The same distance as a fraction of the largest coordinate. Far from the origin, rounding is
/// larger.
const ROUNDING: f64 = 1e-11;

/// The smallest uncertainty that CAD programs accept, in millimeters.
const MIN_UNCERTAINTY: f64 = 1e-7;

/// Writes a surface as a STEP file: one advanced face in an open shell.
///
/// The face is bounded by the four boundary curves of the surface, also where they meet at a seam
/// or collapse at a pole.
///
/// Coordinates are in millimeters. Unclamped knots are clamped first.
///
/// ```
/// use neurbs::{DVec3, export::write_step, nurbs::NurbsSurface};
/// let net = vec![DVec3::ZERO, DVec3::Y, DVec3::X, DVec3::ONE];
/// let mut file = Vec::new();
/// write_step(&NurbsSurface::clamped(net, (2, 2), 1)?, &mut file)?;
/// assert!(file.starts_with(b"ISO-10303-21;"));
/// # Ok::<(), neurbs::Error>(())
/// ```
///
/// # Errors
///
/// [`crate::Error::Io`] if writing fails.
pub fn write_step(surface: &NurbsSurface, out: &mut impl Write) -> Result<()> {
    write_step_in(surface, LengthUnit::default(), out)
}

/// Writes the coordinates in another unit; see [`write_step`].
///
/// # Errors
///
/// [`crate::Error::Io`] if writing fails.
pub fn write_step_in(surface: &NurbsSurface, unit: LengthUnit, out: &mut impl Write) -> Result<()> {
    // Only with clamped knots are the outermost control points the boundary of the face.
    let clamped = surface.knots_u().is_clamped() && surface.knots_v().is_clamped();
    let surface =
        &if clamped { Cow::Borrowed(surface) } else { Cow::Owned(surface.clamp(&mut Silent)?) };
    out.write_all(
        b"ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\n\
          FILE_NAME('','1970-01-01T00:00:00',(''),(''),'neurbs','neurbs','');\n\
          FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));\nENDSEC;\nDATA;\n",
    )?;
    let mut file = Entities { out: &mut *out, count: 0 };
    let face = face(&mut file, surface)?;
    product(&mut file, &face, unit, uncertainty(surface, unit))?;
    out.write_all(b"ENDSEC;\nEND-ISO-10303-21;\n")?;
    Ok(())
}

/// Returns the declared uncertainty, in the unit of the file.
fn uncertainty(surface: &NurbsSurface, unit: LengthUnit) -> f64 {
    let net = surface.control_points().iter();
    let (min, max) =
        net.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), &p| (min.min(p), max.max(p)));
    let magnitude = min.abs().max(max.abs()).max_element();
    let min_uncertainty = MIN_UNCERTAINTY / unit.in_millimeters();
    min_uncertainty.max(UNCERTAINTY * (max - min).length()).max(ROUNDING * magnitude)
}

/// The data section, which numbers its entities.
struct Entities<'a, W: Write> {
    out: &'a mut W,
    count: usize,
}

impl<W: Write> Entities<'_, W> {
    /// Writes an entity and returns the reference to it.
    fn add(&mut self, entity: &str) -> Result<String> {
        self.count += 1;
        writeln!(self.out, "#{}={entity};", self.count)?;
        Ok(format!("#{}", self.count))
    }

    fn point(&mut self, p: DVec3) -> Result<String> {
        self.add(&format!("CARTESIAN_POINT('',{})", list(p.to_array().map(real))))
    }

    fn points(&mut self, points: impl IntoIterator<Item = DVec3>) -> Result<String> {
        let references: Vec<String> =
            points.into_iter().map(|p| self.point(p)).collect::<Result<_>>()?;
        Ok(list(references))
    }
}

/// Formats a real with the fewest digits that read back as the same bits, always with a decimal
/// point.
fn real(value: f64) -> String {
    let text = format!("{value:?}");
    match text.split_once('e') {
        Some((digits, exponent)) if digits.contains('.') => format!("{digits}E{exponent}"),
        Some((digits, exponent)) => format!("{digits}.E{exponent}"),
        None => text,
    }
}

fn list(items: impl IntoIterator<Item = String>) -> String {
    let items: Vec<String> = items.into_iter().collect();
    format!("({})", items.join(","))
}

/// The multiplicities and the distinct values of the knots.
fn knots(knots: &KnotVector) -> (String, String) {
    let (values, times): (Vec<f64>, Vec<usize>) = knots.distinct().unzip();
    (list(times.iter().map(ToString::to_string)), list(values.into_iter().map(real)))
}

fn geometry<W: Write>(file: &mut Entities<'_, W>, surface: &NurbsSurface) -> Result<String> {
    let cols = surface.shape().1;
    let rows = surface.control_points().chunks(cols).map(|row| file.points(row.iter().copied()));
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

/// Writes the boundary curve through the control points with these indices.
fn boundary<W: Write>(
    file: &mut Entities<'_, W>,
    surface: &NurbsSurface,
    indices: impl Iterator<Item = usize> + Clone,
    along: &KnotVector,
) -> Result<String> {
    let points = file.points(indices.clone().map(|i| surface.control_points()[i]))?;
    let (degree, (times, values)) = (along.degree(), knots(along));
    let form = format!("{degree},{points},.UNSPECIFIED.,.F.,.F.");
    let spans = format!("{times},{values},.UNSPECIFIED.");
    let Some(weights) = surface.weights() else {
        return file.add(&format!("B_SPLINE_CURVE_WITH_KNOTS('',{form},{spans})"));
    };
    let weights = list(indices.map(|i| real(weights[i])));
    file.add(&format!(
        "(BOUNDED_CURVE() B_SPLINE_CURVE({form}) B_SPLINE_CURVE_WITH_KNOTS({spans}) CURVE() \
         GEOMETRIC_REPRESENTATION_ITEM() RATIONAL_B_SPLINE_CURVE({weights}) \
         REPRESENTATION_ITEM(''))"
    ))
}

/// Writes the face. Its boundary is counterclockwise around the normal: along u, along v, and back
/// in both.
fn face<W: Write>(file: &mut Entities<'_, W>, surface: &NurbsSurface) -> Result<String> {
    let geometry = geometry(file, surface)?;
    let (rows, cols) = surface.shape();
    let corners = [0, (rows - 1) * cols, rows * cols - 1, cols - 1].map(|i| {
        let point = file.point(surface.control_points()[i])?;
        file.add(&format!("VERTEX_POINT('',{point})"))
    });
    let corners = corners.into_iter().collect::<Result<Vec<String>>>()?;
    let (u, v) = (surface.knots_u(), surface.knots_v());
    let row = |i: usize| i * cols..(i + 1) * cols;
    let column = |j: usize| (j..rows * cols).step_by(cols);
    let curves = [
        boundary(file, surface, column(0), u)?,
        boundary(file, surface, row(rows - 1), v)?,
        boundary(file, surface, column(cols - 1), u)?,
        boundary(file, surface, row(0), v)?,
    ];
    // The curves follow increasing parameters, so the last two are traversed backwards.
    let ends = [(0, 1, ".T."), (1, 2, ".T."), (3, 2, ".F."), (0, 3, ".F.")];
    let edges = std::iter::zip(&curves, ends)
        .map(|(curve, (from, to, same))| {
            let (from, to) = (&corners[from], &corners[to]);
            let edge = file.add(&format!("EDGE_CURVE('',{from},{to},{curve},.T.)"))?;
            file.add(&format!("ORIENTED_EDGE('',*,*,{edge},{same})"))
        })
        .collect::<Result<Vec<String>>>()?;
    let edge_loop = file.add(&format!("EDGE_LOOP('',{})", list(edges)))?;
    let bound = file.add(&format!("FACE_BOUND('',{edge_loop},.T.)"))?;
    file.add(&format!("ADVANCED_FACE('',({bound}),{geometry},.T.)"))
}

/// Writes the unit of length. Inches and feet are defined by millimeters.
fn length_unit<W: Write>(file: &mut Entities<'_, W>, unit: LengthUnit) -> Result<String> {
    let (prefix, name) = match unit {
        LengthUnit::Millimeter => (".MILLI.", None),
        LengthUnit::Centimeter => (".CENTI.", None),
        LengthUnit::Meter => ("$", None),
        LengthUnit::Inch => (".MILLI.", Some("INCH")),
        LengthUnit::Foot => (".MILLI.", Some("FOOT")),
    };
    let metric = file.add(&format!("(LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT({prefix},.METRE.))"))?;
    let Some(name) = name else {
        return Ok(metric);
    };
    let millimeters = real(unit.in_millimeters());
    let factor =
        file.add(&format!("LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE({millimeters}),{metric})"))?;
    let dimension = file.add("DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.)")?;
    file.add(&format!(
        "(CONVERSION_BASED_UNIT('{name}',{factor}) LENGTH_UNIT() NAMED_UNIT({dimension}))"
    ))
}

/// Writes the product, units and context that AP214 requires in addition to the face.
fn product<W: Write>(
    file: &mut Entities<'_, W>,
    face: &str,
    unit: LengthUnit,
    uncertainty: f64,
) -> Result<()> {
    let shell = file.add(&format!("OPEN_SHELL('',({face}))"))?;
    let model = file.add(&format!("SHELL_BASED_SURFACE_MODEL('',({shell}))"))?;
    let length = length_unit(file, unit)?;
    let angle = file.add("(NAMED_UNIT(*) PLANE_ANGLE_UNIT() SI_UNIT($,.RADIAN.))")?;
    let solid = file.add("(NAMED_UNIT(*) SI_UNIT($,.STERADIAN.) SOLID_ANGLE_UNIT())")?;
    let precision = file.add(&format!(
        "UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE({}),{length},\
         'distance_accuracy_value','')",
        real(uncertainty)
    ))?;
    let context = file.add(&format!(
        "(GEOMETRIC_REPRESENTATION_CONTEXT(3) \
         GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({precision})) \
         GLOBAL_UNIT_ASSIGNED_CONTEXT(({length},{angle},{solid})) REPRESENTATION_CONTEXT('',''))"
    ))?;
    let origin = file.point(DVec3::ZERO)?;
    let (z, x) = (file.add("DIRECTION('',(0.,0.,1.))")?, file.add("DIRECTION('',(1.,0.,0.))")?);
    let axes = file.add(&format!("AXIS2_PLACEMENT_3D('',{origin},{z},{x})"))?;
    let shape =
        file.add(&format!("MANIFOLD_SURFACE_SHAPE_REPRESENTATION('',({axes},{model}),{context})"))?;
    let application = file.add("APPLICATION_CONTEXT('automotive design')")?;
    file.add(&format!(
        "APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2000,\
         {application})"
    ))?;
    let mechanical = file.add(&format!("PRODUCT_CONTEXT('',{application},'mechanical')"))?;
    let product = file.add(&format!("PRODUCT('surface','surface','',({mechanical}))"))?;
    let formation = file.add(&format!("PRODUCT_DEFINITION_FORMATION('','',{product})"))?;
    let design =
        file.add(&format!("PRODUCT_DEFINITION_CONTEXT('part definition',{application},'design')"))?;
    let definition = file.add(&format!("PRODUCT_DEFINITION('design','',{formation},{design})"))?;
    let defined = file.add(&format!("PRODUCT_DEFINITION_SHAPE('','',{definition})"))?;
    file.add(&format!("SHAPE_DEFINITION_REPRESENTATION({defined},{shape})"))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reals_have_a_decimal_point_and_all_digits() {
        let cases = [(1.0, "1.0"), (-0.1, "-0.1"), (1e300, "1.E300"), (-2.5e-7, "-2.5E-7")];
        for (value, text) in cases {
            assert_eq!(real(value), text);
        }
        assert_eq!(real(5e-324), "5.E-324");
        assert_eq!(real(0.1 + 0.2), "0.30000000000000004");
    }

    #[test]
    fn references_point_to_earlier_entities() {
        let net = (0..6).map(|i| DVec3::splat(f64::from(i))).collect();
        let u = KnotVector::clamped_uniform(1, 2).unwrap();
        let v = KnotVector::clamped_uniform(2, 3).unwrap();
        for weights in [None, Some(vec![1.0, 0.5, 2.0, 1.0, 1.0, 3.0])] {
            let surface = NurbsSurface::new(Clone::clone(&net), weights, u.clone(), v.clone());
            let mut file = Vec::new();
            write_step(&surface.unwrap(), &mut file).unwrap();
            let text = String::from_utf8(file).unwrap();
            let entities = text.lines().filter_map(|line| line.strip_prefix('#'));
            for (before, entity) in entities.enumerate() {
                let (number, body) = entity.split_once('=').unwrap();
                assert_eq!(number.parse(), Ok(before + 1));
                for reference in body.split('#').skip(1) {
                    let end = reference.find(|c: char| !c.is_ascii_digit()).unwrap();
                    assert!(reference[..end].parse::<usize>().unwrap() <= before);
                }
            }
        }
    }
}
