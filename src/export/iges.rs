//! IGES 5.3, entity 128: the rational B-spline surface, for programs that do not read STEP.

use std::io::Write;

use crate::error::Result;
use crate::nurbs::NurbsSurface;

/// Columns of the parameter section that hold data.
const DATA_COLUMNS: usize = 64;

/// Columns of the other sections that hold data.
const COLUMNS: usize = 72;

/// Writes a surface as an IGES file with one rational B-spline surface (entity 128). Coordinates
/// are written as millimetres, as in STEP.
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
    let global = wrap(&global(), COLUMNS);
    let parameters = wrap(&parameters(surface), DATA_COLUMNS);
    let count = parameters.len();
    // The directory entry: type, first parameter line, nothing special; then line count, form 0.
    let directory = [
        format!("{:8}{:8}{:8}{:8}{:8}{:8}{:8}{:8}{:>8}", 128, 1, 0, 0, 0, 0, 0, 0, "00000000"),
        format!("{:8}{:8}{:8}{count:8}{:8}{:8}{:8}{:8}{:8}", 128, 0, 0, 0, "", "", "", 0),
    ];
    section(out, 'S', &["neurbs".to_string()])?;
    section(out, 'G', &global)?;
    section(out, 'D', &directory)?;
    let pointed: Vec<String> = parameters.iter().map(|line| format!("{line:64} {:7}", 1)).collect();
    section(out, 'P', &pointed)?;
    let totals = format!("S{:7}G{:7}D{:7}P{count:7}", 1, global.len(), directory.len());
    section(out, 'T', &[totals])
}

fn section(out: &mut impl Write, letter: char, lines: &[String]) -> Result<()> {
    for (line, number) in lines.iter().zip(1..) {
        writeln!(out, "{line:72}{letter}{number:7}")?;
    }
    Ok(())
}

/// The global section: separators, names, number formats (32-bit integers, doubles of 15 digits up
/// to 10^308), scale 1, millimetres, and a resolution far below any model's.
fn global() -> Vec<String> {
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
        "2".into(),
        text("MM"),
        "1".into(),
        "0.01".into(),
        date(),
        "1.E-7".into(),
        "0.0".into(),
        String::new(),
        String::new(),
        "11".into(),
        "0".into(),
        date(),
    ];
    fields.into()
}

/// The parameters of entity 128, in the standard's order: u runs fastest over weights and points.
fn parameters(surface: &NurbsSurface) -> Vec<String> {
    let (rows, cols) = surface.shape();
    let (u, v) = (surface.knots_u(), surface.knots_v());
    let polynomial = usize::from(surface.weights().is_none());
    let integers = [128, rows - 1, cols - 1, u.degree(), v.degree(), 0, 0, polynomial, 0, 0];
    let by_columns = || (0..cols).flat_map(move |j| (0..rows).map(move |i| i * cols + j));
    let weights = by_columns().map(|i| surface.weights().map_or(1.0, |w| w[i]));
    let points = by_columns().flat_map(|i| surface.control_points()[i].to_array());
    let (domain_u, domain_v) = (u.domain(), v.domain());
    let reals = u.as_slice().iter().chain(v.as_slice()).copied();
    let reals = reals.chain(weights).chain(points);
    let reals = reals.chain([domain_u.0, domain_u.1, domain_v.0, domain_v.1]);
    integers.iter().map(ToString::to_string).chain(reals.map(real)).collect()
}

/// A real number of IGES: the shortest that is read back as the same bits; the exponent's letter D
/// asks for double precision.
fn real(value: f64) -> String {
    format!("{value:?}").replace('e', "D")
}

/// Joins fields to a record (commas between, a semicolon at the end) broken into lines; no field
/// is broken unless it is longer than a line.
fn wrap(fields: &[String], columns: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for (i, field) in fields.iter().enumerate() {
        let end = if i + 1 == fields.len() { ';' } else { ',' };
        let line = lines.last_mut().expect("there is a line from the beginning");
        if line.len() + field.len() < columns {
            line.push_str(field);
            line.push(end);
        } else {
            lines.push(format!("{field}{end}"));
        }
    }
    lines
}
