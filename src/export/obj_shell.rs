//! Wavefront OBJ export of shells as free-form geometry, without triangles.
//!
//! Each face is a surface:
//!
//! ```text
//! # 1 surfaces                         the number of surfaces in the file
//! o shell_1                            only if there are several shells
//! g name                               the face's name, if it has one; "default" after others
//! v x y z [weight]                     control points in space
//! vp u v [weight]                      control points of the loops of a trimmed face
//! cstype [rat] bspline
//! deg 2
//! curv2 1 2 3 ...                      each curve of each loop: indices of vp
//! parm u 0.0 0.0 0.0 1.0 1.0 1.0       knots
//! end
//! cstype [rat] bspline
//! deg 3 3
//! surf 0.0 1.0 0.0 1.0 1 5 9 2 ...     domain; indices of v, u fastest
//! parm u 0.0 ...
//! parm v 0.0 ...
//! trim 0.0 1.0 1 0.0 1.0 2 ...         outer loop: domain and index of each curv2
//! hole 0.0 1.0 3                       one for each inner loop
//! end
//! ```
//!
//! Indices start at 1 and count through the file. A curve in (u, v) ends where the next one of its
//! loop begins; outer loops run counter-clockwise, inner ones clockwise. The format has no reversed
//! faces: u and v of reversed ones are exchanged. In names, white space becomes `_`. Colors and
//! units are not written.

use std::io::Write;

use super::boundary::{oriented_loops, oriented_surface};
use super::common::check_shells;
use crate::brep::{Face, Shell};
use crate::error::Result;
use crate::nurbs::{NurbsCurve, NurbsSurface};

/// Numbers per line; a backslash continues a line.
const NUMBERS_PER_LINE: usize = 16;

/// Writes shells as an OBJ file with one B-spline surface per face: control points (with weights if
/// the surface is rational), degrees, net, knots and, if it is trimmed, loops.
///
/// ```
/// use neurbs::{DVec3, Face, NurbsSurface, Shell, export::write_obj_shells};
/// let plane = Face::whole(NurbsSurface::plane(DVec3::ZERO, DVec3::X, DVec3::Y)?)?;
/// let mut file = Vec::new();
/// write_obj_shells(&[Shell::new(vec![plane], None)?], &mut file)?;
/// let records = "cstype bspline\ndeg 1 1\nsurf 0.0 1.0 0.0 1.0 1 3 2 4\n\
///                parm u 0.0 0.0 1.0 1.0\nparm v 0.0 0.0 1.0 1.0\nend\n";
/// assert!(String::from_utf8(file).unwrap().ends_with(records));
/// # Ok::<(), neurbs::Error>(())
/// ```
///
/// # Errors
///
/// [`crate::Error::Io`] if writing fails, [`crate::Error::Parameter`] if there are no shells.
pub fn write_obj_shells(shells: &[Shell], out: &mut impl Write) -> Result<()> {
    check_shells(shells)?;
    // The format has no end mark: readers count the surfaces.
    let surfaces = shells.iter().map(|shell| shell.faces().len()).sum::<usize>();
    writeln!(out, "# {surfaces} surfaces")?;
    let mut file = Writer { out, vertices: 0, places: 0, curves: 0, grouped: false };
    for (shell, number) in shells.iter().zip(1..) {
        if shells.len() > 1 {
            writeln!(file.out, "o shell_{number}")?;
        }
        for face in shell.faces() {
            file.face(face)?;
        }
    }
    Ok(())
}

/// The file, with the numbers of elements so far.
struct Writer<'a, W: Write> {
    out: &'a mut W,
    vertices: usize,
    /// Places in (u, v).
    places: usize,
    curves: usize,
    /// Whether the last face has a name.
    grouped: bool,
}

impl<W: Write> Writer<'_, W> {
    fn face(&mut self, face: &Face) -> Result<()> {
        if face.name().is_some() || self.grouped {
            writeln!(self.out, "g {}", group(face.name().unwrap_or("default")))?;
        }
        self.grouped = face.name().is_some();
        let surface = oriented_surface(face)?;
        let first = self.vertices + 1;
        for (i, p) in surface.control_points().iter().enumerate() {
            write!(self.out, "v {:?} {:?} {:?}", p.x, p.y, p.z)?;
            self.weight(surface.weights(), i)?;
        }
        self.vertices += surface.control_points().len();
        let mut trims = vec![];
        if face.is_trimmed() {
            for of_loop in oriented_loops(face)? {
                let curves = of_loop.iter().map(|curve| self.curve(curve));
                trims.push(curves.collect::<Result<Vec<String>>>()?);
            }
        }
        self.surface(&surface, first)?;
        for (l, trim) in trims.into_iter().enumerate() {
            let statement = if l == 0 { "trim" } else { "hole" };
            record(self.out, statement, trim)?;
        }
        Ok(writeln!(self.out, "end")?)
    }

    /// Ends the line of a control point.
    fn weight(&mut self, weights: Option<&[f64]>, index: usize) -> Result<()> {
        match weights {
            Some(weights) => Ok(writeln!(self.out, " {:?}", weights[index])?),
            None => Ok(writeln!(self.out)?),
        }
    }

    /// Writes a curve in (u, v); returns its domain and index.
    fn curve(&mut self, curve: &NurbsCurve) -> Result<String> {
        let (points, knots) = (curve.control_points(), curve.knots());
        for (i, p) in points.iter().enumerate() {
            write!(self.out, "vp {:?} {:?}", p.x, p.y)?;
            self.weight(curve.weights(), i)?;
        }
        self.curve_type(curve.weights().is_some())?;
        writeln!(self.out, "deg {}", knots.degree())?;
        record(self.out, "curv2", (self.places + 1..).take(points.len()).map(|i| i.to_string()))?;
        record(self.out, "parm u", reals(knots.as_slice()))?;
        writeln!(self.out, "end")?;
        self.places += points.len();
        self.curves += 1;
        let (start, end) = knots.domain();
        Ok(format!("{start:?} {end:?} {}", self.curves))
    }

    /// Writes a surface without its end; `first` is the index of its first control point.
    fn surface(&mut self, surface: &NurbsSurface, first: usize) -> Result<()> {
        let (u, v) = (surface.knots_u(), surface.knots_v());
        let (rows, cols) = surface.shape();
        self.curve_type(surface.weights().is_some())?;
        writeln!(self.out, "deg {} {}", u.degree(), v.degree())?;
        let ((u0, u1), (v0, v1)) = (u.domain(), v.domain());
        // u runs fastest.
        let indices = (0..cols).flat_map(|j| (0..rows).map(move |i| i * cols + j + first));
        let statement = format!("surf {u0:?} {u1:?} {v0:?} {v1:?}");
        record(self.out, &statement, indices.map(|i| i.to_string()))?;
        record(self.out, "parm u", reals(u.as_slice()))?;
        record(self.out, "parm v", reals(v.as_slice()))
    }

    fn curve_type(&mut self, rational: bool) -> Result<()> {
        Ok(writeln!(self.out, "cstype {}bspline", if rational { "rat " } else { "" })?)
    }
}

/// The name of a group: names end at white space.
fn group(name: &str) -> String {
    let visible = |c: char| if c.is_whitespace() || c.is_control() { '_' } else { c };
    name.chars().map(visible).collect()
}

fn reals(values: &[f64]) -> impl Iterator<Item = String> {
    values.iter().map(|value| format!("{value:?}"))
}

/// Writes a statement followed by numbers, broken into lines.
fn record(
    out: &mut impl Write,
    statement: &str,
    numbers: impl IntoIterator<Item = String>,
) -> Result<()> {
    write!(out, "{statement}")?;
    for (i, number) in numbers.into_iter().enumerate() {
        if i > 0 && i % NUMBERS_PER_LINE == 0 {
            writeln!(out, " \\")?;
        }
        write!(out, " {number}")?;
    }
    Ok(writeln!(out)?)
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;

    fn text(shells: &[Shell]) -> String {
        let mut file = Vec::new();
        write_obj_shells(shells, &mut file).unwrap();
        String::from_utf8(file).unwrap()
    }

    fn circle(radius: f64) -> Vec<NurbsCurve> {
        let center = DVec3::new(0.5, 0.5, 0.0);
        let (x, y) = (radius * DVec3::X, radius * DVec3::Y);
        vec![NurbsCurve::arc(center, x, y, std::f64::consts::TAU).unwrap()]
    }

    #[test]
    fn loops_are_curves_numbered_through_the_file() {
        let plane = || NurbsSurface::plane(DVec3::ZERO, DVec3::X, 2.0 * DVec3::Y).unwrap();
        let ring = Face::trimmed(plane(), vec![circle(0.4), circle(0.2)]).unwrap();
        let named = ring.clone().with_name(Some("a ring".into()));
        let both = [named, ring.reversed()].map(|face| Shell::new(vec![face], None).unwrap());
        let text = text(&both);
        let statements = |word: &str| -> Vec<String> {
            let lines = text.lines().filter(|line| line.split(' ').next() == Some(word));
            lines.map(str::to_string).collect()
        };
        assert_eq!(statements("o"), ["o shell_1", "o shell_2"]);
        assert_eq!(statements("g"), ["g a_ring", "g default"]);
        assert_eq!(statements("trim"), ["trim 0.0 1.0 1", "trim 0.0 1.0 3"]);
        assert_eq!(statements("hole"), ["hole 0.0 1.0 2", "hole 0.0 1.0 4"]);
        // A circle has nine control points.
        assert_eq!(statements("curv2")[3], "curv2 28 29 30 31 32 33 34 35 36");
        // The second surface has u and v exchanged.
        assert_eq!(statements("surf")[0], "surf 0.0 1.0 0.0 1.0 1 3 2 4");
        assert_eq!(statements("v")[5], "v 1.0 0.0 0.0");
        assert_eq!(statements("surf")[1], "surf 0.0 1.0 0.0 1.0 5 7 6 8");
        // Both outer loops turn counter-clockwise around the middle, the inner ones clockwise.
        let points = statements("vp");
        let away = |k: usize| {
            let numbers: Vec<f64> =
                points[k].split(' ').skip(1).map(|number| number.parse().unwrap()).collect();
            DVec2::new(numbers[0] - 0.5, numbers[1] - 0.5)
        };
        let turns = [0, 9, 18, 27].map(|k| away(k).perp_dot(away(k + 1)) > 0.0);
        assert_eq!(turns, [true, false, true, false]);
    }
}
