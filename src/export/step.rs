//! STEP (ISO 10303-21, application protocol 214): what every CAD program reads.

use std::fmt::Write as _;
use std::io::Write;

use glam::DVec3;

use crate::error::Result;
use crate::nurbs::{KnotVector, NurbsSurface};

/// Distance under which a reader may take two places for one, as a share of the largest coordinate.
/// Edges and surface are the same curves to the last bit, but readers evaluate both and compare:
/// far from the origin, rounding alone exceeds the usual absolute value.
const UNCERTAINTY: f64 = 1e-11;

/// The usual absolute uncertainty of CAD programs, in millimetres.
const LEAST_UNCERTAINTY: f64 = 1e-7;

/// Writes a surface as a STEP file: one advanced face in an open shell, bounded by the four
/// boundary curves of the net. Coordinates are written as millimetres, the unit that CAD programs
/// assume.
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
    let mut file = Entities::default();
    let face = face(&mut file, surface);
    let coordinates = surface.control_points().iter().map(|p| p.abs().max_element());
    let magnitude = coordinates.fold(0.0, f64::max);
    product(&mut file, &face, LEAST_UNCERTAINTY.max(UNCERTAINTY * magnitude));
    out.write_all(
        b"ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\n\
          FILE_NAME('','1970-01-01T00:00:00',(''),(''),'neurbs','neurbs','');\n\
          FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));\nENDSEC;\nDATA;\n",
    )?;
    out.write_all(file.text.as_bytes())?;
    out.write_all(b"ENDSEC;\nEND-ISO-10303-21;\n")?;
    Ok(())
}

/// The data section as it grows.
#[derive(Default)]
struct Entities {
    text: String,
    count: usize,
}

impl Entities {
    /// Appends an entity and returns the reference to it.
    fn add(&mut self, entity: &str) -> String {
        self.count += 1;
        writeln!(self.text, "#{}={entity};", self.count).expect("a string can always grow");
        format!("#{}", self.count)
    }

    fn point(&mut self, p: DVec3) -> String {
        self.add(&format!("CARTESIAN_POINT('',{})", list(p.to_array().map(real))))
    }

    fn points(&mut self, points: impl IntoIterator<Item = DVec3>) -> String {
        list(points.into_iter().map(|p| self.point(p)))
    }
}

/// A real number of STEP: the shortest that is read back as the same bits, always with a point.
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

/// Multiplicities and distinct values of the knots.
fn knots(knots: &KnotVector) -> (String, String) {
    let (values, times): (Vec<f64>, Vec<usize>) = knots.distinct().unzip();
    (list(times.iter().map(ToString::to_string)), list(values.into_iter().map(real)))
}

fn geometry(file: &mut Entities, surface: &NurbsSurface) -> String {
    let cols = surface.shape().1;
    let net = list(surface.control_points().chunks(cols).map(|row| file.points(row.to_vec())));
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

/// The boundary curve through these places of the net.
fn boundary(
    file: &mut Entities,
    surface: &NurbsSurface,
    places: impl Iterator<Item = usize> + Clone,
    along: &KnotVector,
) -> String {
    let points = file.points(places.clone().map(|i| surface.control_points()[i]));
    let (degree, (times, values)) = (along.degree(), knots(along));
    let form = format!("{degree},{points},.UNSPECIFIED.,.F.,.F.");
    let spans = format!("{times},{values},.UNSPECIFIED.");
    let Some(weights) = surface.weights() else {
        return file.add(&format!("B_SPLINE_CURVE_WITH_KNOTS('',{form},{spans})"));
    };
    let weights = list(places.map(|i| real(weights[i])));
    file.add(&format!(
        "(BOUNDED_CURVE() B_SPLINE_CURVE({form}) B_SPLINE_CURVE_WITH_KNOTS({spans}) CURVE() \
         GEOMETRIC_REPRESENTATION_ITEM() RATIONAL_B_SPLINE_CURVE({weights}) \
         REPRESENTATION_ITEM(''))"
    ))
}

/// The face, counter-clockwise about the normal: along u, along v, and back both ways.
fn face(file: &mut Entities, surface: &NurbsSurface) -> String {
    let geometry = geometry(file, surface);
    let (rows, cols) = surface.shape();
    let corners = [0, (rows - 1) * cols, rows * cols - 1, cols - 1].map(|i| {
        let point = file.point(surface.control_points()[i]);
        file.add(&format!("VERTEX_POINT('',{point})"))
    });
    let (u, v) = (surface.knots_u(), surface.knots_v());
    let row = |i: usize| i * cols..(i + 1) * cols;
    let column = |j: usize| (j..rows * cols).step_by(cols);
    let curves = [
        boundary(file, surface, column(0), u),
        boundary(file, surface, row(rows - 1), v),
        boundary(file, surface, column(cols - 1), u),
        boundary(file, surface, row(0), v),
    ];
    // Curves run with the parameters; the two last are walked backwards.
    let ends = [(0, 1, ".T."), (1, 2, ".T."), (3, 2, ".F."), (0, 3, ".F.")];
    let edges: Vec<String> = std::iter::zip(&curves, ends)
        .map(|(curve, (from, to, same))| {
            let (from, to) = (&corners[from], &corners[to]);
            let edge = file.add(&format!("EDGE_CURVE('',{from},{to},{curve},.T.)"));
            file.add(&format!("ORIENTED_EDGE('',*,*,{edge},{same})"))
        })
        .collect();
    let edge_loop = file.add(&format!("EDGE_LOOP('',{})", list(edges)));
    let bound = file.add(&format!("FACE_BOUND('',{edge_loop},.T.)"));
    file.add(&format!("ADVANCED_FACE('',({bound}),{geometry},.T.)"))
}

/// The product around the face: what AP214 wants to know beside the geometry.
fn product(file: &mut Entities, face: &str, uncertainty: f64) {
    let shell = file.add(&format!("OPEN_SHELL('',({face}))"));
    let model = file.add(&format!("SHELL_BASED_SURFACE_MODEL('',({shell}))"));
    let length = file.add("(LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.))");
    let angle = file.add("(NAMED_UNIT(*) PLANE_ANGLE_UNIT() SI_UNIT($,.RADIAN.))");
    let solid = file.add("(NAMED_UNIT(*) SI_UNIT($,.STERADIAN.) SOLID_ANGLE_UNIT())");
    let precision = file.add(&format!(
        "UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE({}),{length},\
         'distance_accuracy_value','')",
        real(uncertainty)
    ));
    let context = file.add(&format!(
        "(GEOMETRIC_REPRESENTATION_CONTEXT(3) \
         GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({precision})) \
         GLOBAL_UNIT_ASSIGNED_CONTEXT(({length},{angle},{solid})) REPRESENTATION_CONTEXT('',''))"
    ));
    let origin = file.point(DVec3::ZERO);
    let (z, x) = (file.add("DIRECTION('',(0.,0.,1.))"), file.add("DIRECTION('',(1.,0.,0.))"));
    let axes = file.add(&format!("AXIS2_PLACEMENT_3D('',{origin},{z},{x})"));
    let shape =
        file.add(&format!("MANIFOLD_SURFACE_SHAPE_REPRESENTATION('',({axes},{model}),{context})"));
    let application = file.add("APPLICATION_CONTEXT('automotive design')");
    file.add(&format!(
        "APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2000,\
         {application})"
    ));
    let mechanical = file.add(&format!("PRODUCT_CONTEXT('',{application},'mechanical')"));
    let product = file.add(&format!("PRODUCT('surface','surface','',({mechanical}))"));
    let formation = file.add(&format!("PRODUCT_DEFINITION_FORMATION('','',{product})"));
    let design =
        file.add(&format!("PRODUCT_DEFINITION_CONTEXT('part definition',{application},'design')"));
    let definition = file.add(&format!("PRODUCT_DEFINITION('design','',{formation},{design})"));
    let defined = file.add(&format!("PRODUCT_DEFINITION_SHAPE('','',{definition})"));
    file.add(&format!("SHAPE_DEFINITION_REPRESENTATION({defined},{shape})"));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reals_have_a_point_and_all_their_digits() {
        let cases = [(1.0, "1.0"), (-0.1, "-0.1"), (1e300, "1.E300"), (-2.5e-7, "-2.5E-7")];
        for (value, text) in cases {
            assert_eq!(real(value), text);
        }
        assert_eq!(real(5e-324), "5.E-324");
        assert_eq!(real(0.1 + 0.2), "0.30000000000000004");
    }

    #[test]
    fn every_reference_is_to_an_entity_before_it() {
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
