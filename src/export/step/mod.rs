//! STEP export of shells (ISO 10303-21, application protocol 214).
//!
//! Each shell is a product. Its closed parts are solids, `MANIFOLD_SOLID_BREP` of a `CLOSED_SHELL`
//! or, with cavities, `BREP_WITH_VOIDS`. The others are a `SHELL_BASED_SURFACE_MODEL` of an
//! `OPEN_SHELL` each.
//!
//! - A face is an `ADVANCED_FACE` of a B-spline surface with clamped knots, with its name. The
//!   outer loop is the `FACE_OUTER_BOUND`; each hole is a `FACE_BOUND`.
//! - An edge is one `EDGE_CURVE`, which its loops use forward and backward. The two sides of a seam
//!   are one edge. A pole is the vertex where the seam ends, without an edge; a loop of nothing but
//!   a pole is a `VERTEX_LOOP`.
//! - The edges of trimmed faces have a curve in (u, v) for each use (`SURFACE_CURVE`, `SEAM_CURVE`
//!   for the two sides of a seam), with the parameter of the curve in space.
//! - A color is a `STYLED_ITEM` of its face.

mod colors;
mod entities;
mod geometry;
mod product;
mod topology;

use std::io::Write;

use self::entities::{Entities, list};
use self::product::Common;
use super::bodies::Bodies;
use super::common::{check_shells, product_name};
use crate::brep::{LengthUnit, Shell};
use crate::error::Result;

/// Options of [`write_step`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepOptions {
    /// The unit of the coordinates, which are not converted. Default: millimeter.
    pub unit: LengthUnit,
    /// Whether the edges of trimmed faces have curves in (u, v), too. Readers that do not know
    /// them compute them. Default: true.
    pub pcurves: bool,
}

impl Default for StepOptions {
    fn default() -> Self {
        Self { unit: LengthUnit::default(), pcurves: true }
    }
}

/// Writes shells as a STEP file: solids where they are closed, with outward normals, else surfaces.
///
/// The declared uncertainty is the shell's tolerance, but at least 1e-6 of its size and 1e-7 mm.
///
/// ```
/// use neurbs::export::{StepOptions, write_step};
/// use neurbs::{DVec3, Face, NurbsSurface, Shell};
/// let sphere = Face::whole(NurbsSurface::sphere(DVec3::ZERO, 1.0)?)?;
/// let mut file = Vec::new();
/// write_step(&[Shell::new(vec![sphere], None)?], &StepOptions::default(), &mut file)?;
/// let text = String::from_utf8(file).unwrap();
/// assert!(text.contains("MANIFOLD_SOLID_BREP") && text.matches("EDGE_CURVE").count() == 1);
/// # Ok::<(), neurbs::Error>(())
/// ```
///
/// # Errors
///
/// [`crate::Error::Io`] if writing fails, [`crate::Error::Parameter`] if there are no shells.
pub fn write_step(shells: &[Shell], options: &StepOptions, out: &mut impl Write) -> Result<()> {
    check_shells(shells)?;
    out.write_all(
        b"ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\n\
          FILE_NAME('','1970-01-01T00:00:00',(''),(''),'neurbs','neurbs','');\n\
          FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));\nENDSEC;\nDATA;\n",
    )?;
    let mut file = Entities::new(&mut *out);
    let common = Common::write(&mut file, options.unit)?;
    for shell in shells {
        write_shell(&mut file, shell, options.pcurves, &common)?;
    }
    out.write_all(b"ENDSEC;\nEND-ISO-10303-21;\n")?;
    Ok(())
}

/// Writes a shell as a product.
fn write_shell<W: Write>(
    file: &mut Entities<'_, W>,
    shell: &Shell,
    pcurves: bool,
    common: &Common,
) -> Result<()> {
    let context = common.context(file, shell)?;
    let bodies = Bodies::of(shell);
    let faces = topology::faces(file, shell, &bodies.turned, pcurves)?;
    let of = |part: &[usize]| list(part.iter().map(|&face| faces[face].clone()));
    let mut items = vec![];
    for solid in &bodies.solids {
        let outer = file.add(&format!("CLOSED_SHELL('',{})", of(&solid.outer)))?;
        let mut voids = vec![];
        for part in &solid.voids {
            let void = file.add(&format!("CLOSED_SHELL('',{})", of(part)))?;
            voids.push(file.add(&format!("ORIENTED_CLOSED_SHELL('',*,{void},.T.)"))?);
        }
        items.push(if voids.is_empty() {
            file.add(&format!("MANIFOLD_SOLID_BREP('',{outer})"))?
        } else {
            file.add(&format!("BREP_WITH_VOIDS('',{outer},{})", list(voids)))?
        });
    }
    if !bodies.surfaces.is_empty() {
        let open = bodies.surfaces.iter();
        let open = open.map(|part| file.add(&format!("OPEN_SHELL('',{})", of(part))));
        let open = list(open.collect::<Result<Vec<String>>>()?);
        items.push(file.add(&format!("SHELL_BASED_SURFACE_MODEL('',{open})"))?);
    }
    let kind = match (bodies.solids.is_empty(), bodies.surfaces.is_empty()) {
        (false, true) => "ADVANCED_BREP_SHAPE_REPRESENTATION",
        (true, false) => "MANIFOLD_SURFACE_SHAPE_REPRESENTATION",
        _ => "SHAPE_REPRESENTATION",
    };
    common.product(file, product_name(shell), (kind, items), &context)?;
    colors::colors(file, shell.faces(), &faces, &context)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::brep::Face;
    use crate::nurbs::{KnotVector, NurbsCurve, NurbsSurface};

    /// Checks that references point to earlier entities; returns the text.
    fn checked(shells: &[Shell], pcurves: bool) -> String {
        let options = StepOptions { pcurves, ..StepOptions::default() };
        let mut file = Vec::new();
        write_step(shells, &options, &mut file).unwrap();
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
        text
    }

    fn shell(surface: NurbsSurface) -> Shell {
        Shell::new(vec![Face::whole(surface).unwrap()], None).unwrap()
    }

    #[test]
    fn references_point_to_earlier_entities() {
        let net = (0..6).map(|i| DVec3::splat(f64::from(i))).collect();
        let u = KnotVector::clamped_uniform(1, 2).unwrap();
        let v = KnotVector::clamped_uniform(2, 3).unwrap();
        for weights in [None, Some(vec![1.0, 0.5, 2.0, 1.0, 1.0, 3.0])] {
            let surface = NurbsSurface::new(Clone::clone(&net), weights, u.clone(), v.clone());
            checked(&[shell(surface.unwrap())], true);
        }
        assert!(write_step(&[], &StepOptions::default(), &mut Vec::new()).is_err());
    }

    #[test]
    fn shells_are_products_with_names_and_colors() {
        let plane = || NurbsSurface::plane(DVec3::ZERO, DVec3::X, DVec3::Y).unwrap();
        let circle = |radius: f64| {
            let center = DVec3::new(0.5, 0.5, 0.0);
            let (x, y) = (radius * DVec3::X, radius * DVec3::Y);
            vec![NurbsCurve::arc(center, x, y, std::f64::consts::TAU).unwrap()]
        };
        let ring = Face::trimmed(plane(), vec![circle(0.4), circle(0.2)]).unwrap();
        let ring = ring.with_name(Some("a ring".into())).with_color(Some([1.0, 0.5, 0.0])).unwrap();
        let ring = Shell::new(vec![ring], None).unwrap();
        let text = checked(&[ring.clone(), shell(plane())], true);
        let count = |text: &str, word: &str| text.matches(word).count();
        assert_eq!((count(&text, "PRODUCT("), count(&text, "=FACE_BOUND(")), (2, 1));
        assert_eq!((count(&text, "ADVANCED_FACE('a ring'"), count(&text, "=PCURVE(")), (1, 2));
        assert!(text.contains("COLOUR_RGB('',1.0,0.5,0.0)"));
        assert_eq!(count(&checked(&[ring], false), "PCURVE"), 0);
    }
}
