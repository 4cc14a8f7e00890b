//! IGES 5.3 export of shells, for programs that do not read STEP.
//!
//! - A closed part of a shell is a solid (entity 186) of faces with loops of shared edges (514, 510, 508,
//!   504, 502). A pole is a vertex in its loop.
//! - The faces of an open part stand alone: a surface (128), or a trimmed surface (144) with curves
//!   (142; 102 where several; 126) in (u, v) and, with the same parameter, in space. IGES has no
//!   reversed surfaces: u and v of reversed faces are exchanged.
//! - Names are properties (406, form 15); colors are entities 314.

mod entities;
mod shells;

use std::io::Write;

use self::entities::{Entities, SECTION_COLUMNS, real, text, wrap_lines, write_section};
use super::bodies::Bodies;
use super::common::{check_shells, min_uncertainty, product_name, uncertainty};
use crate::brep::{Face, LengthUnit, Shell};
use crate::error::Result;

/// Writes shells as an IGES file: solids where they are closed, else surfaces.
///
/// `unit` is the unit of the coordinates, which are not converted. The declared resolution is that
/// of [`write_step`](super::write_step); 1e-7 mm where the file has no edges.
///
/// ```
/// use neurbs::{DVec3, Face, LengthUnit, NurbsSurface, Shell, export::write_iges};
/// let plane = Face::whole(NurbsSurface::plane(DVec3::ZERO, DVec3::X, DVec3::Y)?)?;
/// let mut file = Vec::new();
/// write_iges(&[Shell::new(vec![plane], None)?], LengthUnit::Millimeter, &mut file)?;
/// assert!(file.split(|&b| b == b'\n').all(|line| line.is_empty() || line.len() == 80));
/// # Ok::<(), neurbs::Error>(())
/// ```
///
/// # Errors
///
/// [`crate::Error::Io`] if writing fails, [`crate::Error::Parameter`] if there are no shells.
pub fn write_iges(shells: &[Shell], unit: LengthUnit, out: &mut impl Write) -> Result<()> {
    check_shells(shells)?;
    let mut file = Entities::default();
    let mut resolution = min_uncertainty(unit);
    for shell in shells {
        let bodies = Bodies::of(shell);
        shells::add_solids(&mut file, shell, &bodies)?;
        for part in &bodies.surfaces {
            shells::add_faces(&mut file, shell, part)?;
        }
        if !bodies.solids.is_empty() || shell.faces().iter().any(Face::is_trimmed) {
            resolution = resolution.max(uncertainty(shell, unit));
        }
    }
    let name = if shells.len() == 1 { product_name(&shells[0]) } else { "shells" };
    let global = wrap_lines(&global(name, unit, resolution), SECTION_COLUMNS);
    write_section(out, 'S', &["neurbs".to_string()], 1)?;
    write_section(out, 'G', &global, 1)?;
    let (directory, parameters) = file.write(out)?;
    let end = format!("S{:7}G{:7}D{directory:7}P{parameters:7}", 1, global.len());
    write_section(out, 'T', &[end], 1)
}

/// Returns the fields of the global section: separators, names, number formats (32-bit integers,
/// doubles of 15 digits up to 10^308), scale 1, unit and resolution.
fn global(name: &str, unit: LengthUnit, resolution: f64) -> Vec<String> {
    let (flag, unit_name) = match unit {
        LengthUnit::Inch => ("1", "IN"),
        LengthUnit::Millimeter => ("2", "MM"),
        LengthUnit::Foot => ("4", "FT"),
        LengthUnit::Meter => ("6", "M"),
        LengthUnit::Centimeter => ("10", "CM"),
    };
    let name = || text(name);
    let date = || text("19700101.000000");
    let fields = [
        text(","),
        text(";"),
        name(),
        text("surface.igs"),
        text("neurbs"),
        text("neurbs"),
        "32".into(),
        "38".into(),
        "6".into(),
        "308".into(),
        "15".into(),
        name(),
        "1.0".into(),
        flag.into(),
        text(unit_name),
        "1".into(),
        "0.01".into(),
        date(),
        real(resolution),
        "0.0".into(),
        String::new(),
        String::new(),
        "11".into(),
        "0".into(),
        date(),
    ];
    fields.into()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::nurbs::{NurbsCurve, NurbsSurface};

    /// The types of the entities in a file, whose sections are checked.
    fn entities(shells: &[Shell]) -> Vec<usize> {
        let mut file = Vec::new();
        write_iges(shells, LengthUnit::Inch, &mut file).unwrap();
        let text = String::from_utf8(file).unwrap();
        let lines = |letter: char| text.lines().filter(move |line| line[72..].starts_with(letter));
        assert!(text.lines().all(|line| line.len() == 80));
        for letter in ['S', 'G', 'D', 'P', 'T'] {
            for (line, number) in lines(letter).zip(1..) {
                assert_eq!(line[73..].trim().parse(), Ok(number));
            }
        }
        let directory: Vec<&str> = lines('D').collect();
        let parameters: Vec<&str> = lines('P').collect();
        let integer = |text: &str| text.trim().parse::<usize>().unwrap();
        let types = directory.chunks(2).enumerate().map(|(k, entry)| {
            let (kind, first) = (integer(&entry[0][..8]), integer(&entry[0][8..16]));
            let count = integer(&entry[1][24..32]);
            let own = &parameters[first - 1..first - 1 + count];
            assert!(own.iter().all(|line| integer(&line[64..72]) == 2 * k + 1));
            assert!(own[0].starts_with(&format!("{kind},")));
            let ends = own.iter().map(|line| line[..64].trim_end().ends_with(';'));
            assert_eq!(ends.filter(|&end| end).count(), 1);
            kind
        });
        types.collect()
    }

    fn count(types: &[usize], kind: usize) -> usize {
        types.iter().filter(|&&k| k == kind).count()
    }

    #[test]
    fn closed_parts_are_solids_and_others_faces() {
        let plane = || NurbsSurface::plane(DVec3::ZERO, DVec3::X, DVec3::Y).unwrap();
        let plain = Shell::whole(plane()).unwrap();
        assert_eq!(entities(std::slice::from_ref(&plain)), [128]);
        let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0).unwrap();
        let types = entities(&[Shell::whole(sphere).unwrap(), plain]);
        for kind in [126, 502, 504, 508, 510, 514, 186] {
            assert_eq!(count(&types, kind), 1, "{kind}");
        }
        assert_eq!(count(&types, 128), 2);
        let circle = |radius: f64| {
            let center = DVec3::new(0.5, 0.5, 0.0);
            let (x, y) = (radius * DVec3::X, radius * DVec3::Y);
            vec![NurbsCurve::arc(center, x, y, std::f64::consts::TAU).unwrap()]
        };
        let ring = Face::trimmed(plane(), vec![circle(0.4), circle(0.2)]).unwrap();
        let ring = ring.with_name(Some("ring ".repeat(30))).with_color(Some([1.0, 0.5, 0.0]));
        let types = entities(&[Shell::new(vec![ring.unwrap()], None).unwrap()]);
        let numbers = [144, 142, 102, 126, 406, 314].map(|kind| count(&types, kind));
        // Quarters of circles, in (u, v) and in space.
        assert_eq!(numbers, [1, 2, 4, 16, 1, 1]);
        assert!(write_iges(&[], LengthUnit::Inch, &mut Vec::new()).is_err());
    }
}
