//! IGES 5.3 export: a rational B-spline surface (entity 128), for programs that do not read STEP.

use std::io::Write;

use crate::brep::LengthUnit;
use crate::error::Result;
use crate::nurbs::NurbsSurface;

/// Columns with data in the parameter section.
const DATA_COLUMNS: usize = 64;

/// Parameters per line. A real has at most 24 characters, so two always fit. The number of lines,
/// which the directory entry needs, is thus known in advance.
const FIELDS_PER_LINE: usize = 2;

/// Number of integers at the start of the parameters of entity 128, including the entity number.
const INTEGER_FIELDS: usize = 10;

/// Columns with data in the other sections.
const SECTION_COLUMNS: usize = 72;

/// The declared resolution, in millimeters: far below the detail of any model.
const RESOLUTION: f64 = 1e-7;

/// Writes a surface as an IGES file with one rational B-spline surface (entity 128), in
/// millimeters.
///
/// ```
/// use neurbs::{DVec3, export::write_iges, nurbs::NurbsSurface};
/// let net = vec![DVec3::ZERO, DVec3::Y, DVec3::X, DVec3::ONE];
/// let mut file = Vec::new();
/// write_iges(&NurbsSurface::clamped(net, (2, 2), 1)?, &mut file)?;
/// assert!(file.split(|&b| b == b'\n').all(|line| line.is_empty() || line.len() == 80));
/// # Ok::<(), neurbs::Error>(())
/// ```
///
/// # Errors
///
/// [`crate::Error::Io`] if writing fails.
pub fn write_iges(surface: &NurbsSurface, out: &mut impl Write) -> Result<()> {
    write_iges_in(surface, LengthUnit::default(), out)
}

/// Writes the coordinates in another unit; see [`write_iges`].
///
/// # Errors
///
/// [`crate::Error::Io`] if writing fails.
pub fn write_iges_in(surface: &NurbsSurface, unit: LengthUnit, out: &mut impl Write) -> Result<()> {
    let global = wrap_lines(&global(unit));
    let fields = parameters(surface);
    let count = field_count(surface).div_ceil(FIELDS_PER_LINE);
    // The directory entry: type, first parameter line, default attributes; then line count, form 0.
    let directory = [
        format!("{:8}{:8}{:8}{:8}{:8}{:8}{:8}{:8}{:>8}", 128, 1, 0, 0, 0, 0, 0, 0, "00000000"),
        format!("{:8}{:8}{:8}{count:8}{:8}{:8}{:8}{:8}{:8}", 128, 0, 0, 0, "", "", "", 0),
    ];
    section(out, 'S', &["neurbs".to_string()])?;
    section(out, 'G', &global)?;
    section(out, 'D', &directory)?;
    write_record(out, fields, count)?;
    section(out, 'T', &[format!("S{:7}G{:7}D{:7}P{count:7}", 1, global.len(), directory.len())])
}

fn section(out: &mut impl Write, letter: char, lines: &[String]) -> Result<()> {
    for (line, number) in lines.iter().zip(1..) {
        writeln!(out, "{line:SECTION_COLUMNS$}{letter}{number:7}")?;
    }
    Ok(())
}

/// Writes the parameter section: `count` lines of fields, with a semicolon after the last.
fn write_record(
    out: &mut impl Write,
    mut fields: impl Iterator<Item = String>,
    count: usize,
) -> Result<()> {
    for number in 1..=count {
        let end = if number == count { ';' } else { ',' };
        let line: Vec<String> = fields.by_ref().take(FIELDS_PER_LINE).collect();
        let line = format!("{}{end}", line.join(","));
        writeln!(out, "{line:DATA_COLUMNS$} {:7}P{number:7}", 1)?;
    }
    Ok(())
}

/// Returns the fields of the global section: separators, names, number formats (32-bit integers,
/// doubles of 15 digits up to 10^308), scale 1, unit and resolution.
fn global(unit: LengthUnit) -> Vec<String> {
    let (flag, unit_name) = match unit {
        LengthUnit::Inch => ("1", "IN"),
        LengthUnit::Millimeter => ("2", "MM"),
        LengthUnit::Foot => ("4", "FT"),
        LengthUnit::Meter => ("6", "M"),
        LengthUnit::Centimeter => ("10", "CM"),
    };
    let text = |value: &str| format!("{}H{value}", value.len());
    let name = || text("surface");
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
        real(RESOLUTION / unit.in_millimeters()),
        "0.0".into(),
        String::new(),
        String::new(),
        "11".into(),
        "0".into(),
        date(),
    ];
    fields.into()
}

/// Number of parameters of entity 128 for this surface.
fn field_count(surface: &NurbsSurface) -> usize {
    let knots = surface.knots_u().as_slice().len() + surface.knots_v().as_slice().len();
    INTEGER_FIELDS + knots + 4 * surface.control_points().len() + 4
}

/// The parameters of entity 128 in the standard's order: over weights and points, u runs fastest.
fn parameters(surface: &NurbsSurface) -> impl Iterator<Item = String> {
    let (rows, cols) = surface.shape();
    let (u, v) = (surface.knots_u(), surface.knots_v());
    let polynomial = usize::from(surface.weights().is_none());
    let integers: [usize; INTEGER_FIELDS] =
        [128, rows - 1, cols - 1, u.degree(), v.degree(), 0, 0, polynomial, 0, 0];
    let by_columns = move || (0..cols).flat_map(move |j| (0..rows).map(move |i| i * cols + j));
    let weights = by_columns().map(|i| surface.weights().map_or(1.0, |w| w[i]));
    let points = by_columns().flat_map(|i| surface.control_points()[i].to_array());
    let (domain_u, domain_v) = (u.domain(), v.domain());
    let reals = u.as_slice().iter().chain(v.as_slice()).copied();
    let reals = reals.chain(weights).chain(points);
    let reals = reals.chain([domain_u.0, domain_u.1, domain_v.0, domain_v.1]);
    integers.into_iter().map(|integer| integer.to_string()).chain(reals.map(real))
}

/// Formats a real with the fewest digits that read back as the same bits. The exponent letter D
/// means double precision.
fn real(value: f64) -> String {
    format!("{value:?}").replace('e', "D")
}

/// Joins the fields of the global section and breaks lines between fields.
fn wrap_lines(fields: &[String]) -> Vec<String> {
    let mut lines = vec![String::new()];
    for (i, field) in fields.iter().enumerate() {
        let end = if i + 1 == fields.len() { ';' } else { ',' };
        let line = lines.last_mut().expect("there is a line from the beginning");
        if line.len() + field.len() < SECTION_COLUMNS {
            line.push_str(field);
            line.push(end);
        } else {
            lines.push(format!("{field}{end}"));
        }
    }
    lines
}
