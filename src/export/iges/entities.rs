//! The directory and parameter sections of an IGES file: numbered entities.

use std::io::Write;
use std::sync::Arc;

use glam::DVec3;

use crate::error::Result;
use crate::nurbs::{NurbsCurve, NurbsSurface};

/// Columns with data in the parameter section.
const DATA_COLUMNS: usize = 64;

/// Columns with data in the other sections.
pub(super) const SECTION_COLUMNS: usize = 72;

/// Parameters of surfaces per line. A real has at most 24 characters, so two always fit. The number
/// of lines, which the directory entry needs, is thus known in advance.
const FIELDS_PER_LINE: usize = 2;

/// Number of integers at the start of the parameters of entity 128, including the entity number.
const INTEGER_FIELDS: usize = 10;

/// Status of an entity that stands alone.
pub(super) const INDEPENDENT: &str = "00000000";

/// Status of an entity that others refer to.
pub(super) const DEPENDENT: &str = "00010000";

/// Status of a curve in (u, v).
pub(super) const IN_PARAMETERS: &str = "00010500";

/// A property or the color of an entity, by its number.
#[derive(Clone, Copy, Default)]
pub(super) struct Attributes {
    pub name: Option<usize>,
    pub color: Option<usize>,
}

/// An entity: type and form, status, attributes and parameters.
struct Entity {
    kind: (usize, usize),
    status: &'static str,
    attributes: Attributes,
    parameters: Parameters,
}

enum Parameters {
    Fields(Vec<String>),
    /// Written in pieces, as nets may be large.
    Surface(Arc<NurbsSurface>),
}

impl Entity {
    /// The fields after the parameters: no associations, and the name's property.
    fn pointers(&self) -> Vec<String> {
        self.attributes.name.map_or(vec![], |name| integers(&[0, 1, name]))
    }

    /// The fields of a surface.
    fn surface_fields(&self, surface: &NurbsSurface) -> impl Iterator<Item = String> {
        surface_parameters(surface).chain(self.pointers())
    }

    /// The lines of the other entities.
    fn lines(&self, fields: &[String]) -> Vec<String> {
        let fields: Vec<String> = fields.iter().cloned().chain(self.pointers()).collect();
        wrap_lines(&fields, DATA_COLUMNS)
    }

    /// Number of lines in the parameter section.
    fn line_count(&self) -> usize {
        match &self.parameters {
            Parameters::Fields(fields) => self.lines(fields).len(),
            Parameters::Surface(surface) => {
                let knots = surface.knots_u().as_slice().len() + surface.knots_v().as_slice().len();
                let net = 4 * surface.control_points().len();
                let fields = INTEGER_FIELDS + knots + net + 4 + self.pointers().len();
                fields.div_ceil(FIELDS_PER_LINE)
            }
        }
    }
}

/// The entities of a file.
#[derive(Default)]
pub(super) struct Entities {
    all: Vec<Entity>,
}

impl Entities {
    fn push(&mut self, entity: Entity) -> usize {
        self.all.push(entity);
        // Each has two lines in the directory; its number is that of the first.
        2 * self.all.len() - 1
    }

    /// Adds an entity of a type and form, and returns its number.
    pub(super) fn add(
        &mut self,
        kind: (usize, usize),
        status: &'static str,
        attributes: Attributes,
        fields: Vec<String>,
    ) -> usize {
        let fields = integers(&[kind.0]).into_iter().chain(fields).collect();
        self.push(Entity { kind, status, attributes, parameters: Parameters::Fields(fields) })
    }

    /// Adds a surface (entity 128).
    pub(super) fn add_surface(
        &mut self,
        surface: Arc<NurbsSurface>,
        status: &'static str,
        attributes: Attributes,
    ) -> usize {
        let parameters = Parameters::Surface(surface);
        self.push(Entity { kind: (128, 0), status, attributes, parameters })
    }

    /// Adds a curve (entity 126), in space or in (u, v).
    pub(super) fn add_curve(&mut self, curve: &NurbsCurve, in_parameters: bool) -> usize {
        let (points, knots) = (curve.control_points(), curve.knots());
        let polynomial = usize::from(curve.weights().is_none());
        let [planar, closed] = [in_parameters, curve.closed()].map(usize::from);
        let mut fields =
            integers(&[points.len() - 1, knots.degree(), planar, closed, polynomial, 0]);
        let weights = (0..points.len()).map(|i| curve.weights().map_or(1.0, |w| w[i]));
        let (start, end) = knots.domain();
        let reals = knots.as_slice().iter().copied().chain(weights);
        let reals = reals.chain(points.iter().flat_map(DVec3::to_array));
        let normal = [0.0, 0.0, if in_parameters { 1.0 } else { 0.0 }];
        fields.extend(reals.chain([start, end]).chain(normal).map(real));
        let status = if in_parameters { IN_PARAMETERS } else { DEPENDENT };
        self.add((126, 0), status, Attributes::default(), fields)
    }

    /// Writes the directory and the parameter section; returns their numbers of lines.
    pub(super) fn write(&self, out: &mut impl Write) -> Result<(usize, usize)> {
        let counts: Vec<usize> = self.all.iter().map(Entity::line_count).collect();
        let mut first = 1;
        for (k, (entity, count)) in self.all.iter().zip(&counts).enumerate() {
            let ((kind, form), status) = (entity.kind, entity.status);
            // A color is a pointer, which is negative.
            let color = entity.attributes.color.map_or("0".into(), |color| format!("-{color}"));
            let lines = [
                format!("{kind:8}{first:8}{0:8}{0:8}{0:8}{0:8}{0:8}{0:8}{status:>8}", 0),
                format!(
                    "{kind:8}{:8}{color:>8}{count:8}{form:8}{:8}{:8}{:8}{:8}",
                    0, "", "", "", 0
                ),
            ];
            write_section(out, 'D', &lines, 2 * k + 1)?;
            first += count;
        }
        let mut number = 1;
        for (k, (entity, count)) in self.all.iter().zip(&counts).enumerate() {
            let directory = 2 * k + 1;
            match &entity.parameters {
                Parameters::Fields(fields) => {
                    for (line, number) in entity.lines(fields).iter().zip(number..) {
                        writeln!(out, "{line:DATA_COLUMNS$} {directory:7}P{number:7}")?;
                    }
                }
                Parameters::Surface(surface) => {
                    let mut fields = entity.surface_fields(surface);
                    for line in 1..=*count {
                        let end = if line == *count { ';' } else { ',' };
                        let pair: Vec<String> = fields.by_ref().take(FIELDS_PER_LINE).collect();
                        let text = format!("{}{end}", pair.join(","));
                        let number = number + line - 1;
                        writeln!(out, "{text:DATA_COLUMNS$} {directory:7}P{number:7}")?;
                    }
                }
            }
            number += count;
        }
        Ok((2 * self.all.len(), number - 1))
    }
}

/// Writes lines of a section, numbered from `first`.
pub(super) fn write_section(
    out: &mut impl Write,
    letter: char,
    lines: &[String],
    first: usize,
) -> Result<()> {
    for (line, number) in lines.iter().zip(first..) {
        writeln!(out, "{line:SECTION_COLUMNS$}{letter}{number:7}")?;
    }
    Ok(())
}

/// The parameters of entity 128 in the standard's order: over weights and points, u runs fastest.
fn surface_parameters(surface: &NurbsSurface) -> impl Iterator<Item = String> {
    let (rows, cols) = surface.shape();
    let (u, v) = (surface.knots_u(), surface.knots_v());
    let polynomial = usize::from(surface.weights().is_none());
    let first: [usize; INTEGER_FIELDS] =
        [128, rows - 1, cols - 1, u.degree(), v.degree(), 0, 0, polynomial, 0, 0];
    let by_columns = move || (0..cols).flat_map(move |j| (0..rows).map(move |i| i * cols + j));
    let weights = by_columns().map(|i| surface.weights().map_or(1.0, |w| w[i]));
    let points = by_columns().flat_map(|i| surface.control_points()[i].to_array());
    let (domain_u, domain_v) = (u.domain(), v.domain());
    let reals = u.as_slice().iter().chain(v.as_slice()).copied();
    let reals = reals.chain(weights).chain(points);
    let reals = reals.chain([domain_u.0, domain_u.1, domain_v.0, domain_v.1]);
    integers(&first).into_iter().chain(reals.map(real))
}

/// Formats integers.
pub(super) fn integers(values: &[usize]) -> Vec<String> {
    values.iter().map(ToString::to_string).collect()
}

/// Formats a real with the fewest digits that read back as the same bits. The exponent letter D
/// means double precision.
pub(super) fn real(value: f64) -> String {
    format!("{value:?}").replace('e', "D")
}

/// Formats a string. IGES has ASCII only: other characters become question marks.
pub(super) fn text(value: &str) -> String {
    let plain = |c: char| if (' '..='~').contains(&c) { c } else { '?' };
    format!("{}H{}", value.chars().count(), value.chars().map(plain).collect::<String>())
}

/// Joins fields and breaks lines between them. Only strings may be longer than a line.
pub(super) fn wrap_lines(fields: &[String], columns: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for (i, field) in fields.iter().enumerate() {
        let mut rest = format!("{field}{}", if i + 1 == fields.len() { ';' } else { ',' });
        let line = lines.last_mut().expect("there is a line from the beginning");
        if line.len() + rest.len() <= columns {
            line.push_str(&rest);
            continue;
        }
        if line.is_empty() {
            lines.pop();
        }
        while rest.len() > columns {
            let after = rest.split_off(columns);
            lines.push(std::mem::replace(&mut rest, after));
        }
        lines.push(rest);
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_break_between_fields_and_inside_long_strings() {
        let fields = ["12".to_string(), "3.5".into(), text("a much longer name"), "7".into()];
        let lines = wrap_lines(&fields, 8);
        assert_eq!(lines, ["12,3.5,", "18Ha muc", "h longer", " name,7;"]);
        assert_eq!(text("Öl"), "2H?l");
    }
}
