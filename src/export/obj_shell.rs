//! Wavefront OBJ export of a surface as free-form geometry, without triangles.

use std::io::Write;

use crate::error::Result;
use crate::nurbs::NurbsSurface;

/// Numbers per line; a backslash continues a line.
const NUMBERS_PER_LINE: usize = 16;

/// Writes a surface as an OBJ file with one B-spline surface: control points (with weights if the
/// surface is rational), degrees, net and knots.
///
/// ```
/// use neurbs::{DVec3, export::write_obj_surface, nurbs::NurbsSurface};
/// let net = vec![DVec3::ZERO, DVec3::Y, DVec3::X, DVec3::ONE];
/// let mut file = Vec::new();
/// write_obj_surface(&NurbsSurface::clamped(net, (2, 2), 1)?, &mut file)?;
/// let records = "cstype bspline\ndeg 1 1\nsurf 0.0 1.0 0.0 1.0 1 3 2 4\n\
///                parm u 0.0 0.0 1.0 1.0\nparm v 0.0 0.0 1.0 1.0\nend\n";
/// assert!(String::from_utf8(file).unwrap().ends_with(records));
/// # Ok::<(), neurbs::Error>(())
/// ```
///
/// # Errors
///
/// [`crate::Error::Io`] if writing fails.
pub fn write_obj_surface(surface: &NurbsSurface, out: &mut impl Write) -> Result<()> {
    for (i, p) in surface.control_points().iter().enumerate() {
        write!(out, "v {:?} {:?} {:?}", p.x, p.y, p.z)?;
        match surface.weights() {
            Some(weights) => writeln!(out, " {:?}", weights[i])?,
            None => writeln!(out)?,
        }
    }
    let (u, v) = (surface.knots_u(), surface.knots_v());
    let (rows, cols) = surface.shape();
    let rational = if surface.weights().is_some() { "rat " } else { "" };
    writeln!(out, "cstype {rational}bspline")?;
    writeln!(out, "deg {} {}", u.degree(), v.degree())?;
    let ((u0, u1), (v0, v1)) = (u.domain(), v.domain());
    // Indices start at 1, and u runs fastest.
    let indices = (0..cols).flat_map(|j| (0..rows).map(move |i| i * cols + j + 1));
    record(out, &format!("surf {u0:?} {u1:?} {v0:?} {v1:?}"), indices)?;
    record(out, "parm u", u.as_slice())?;
    record(out, "parm v", v.as_slice())?;
    Ok(writeln!(out, "end")?)
}

/// Writes a statement followed by numbers, broken into lines.
fn record(
    out: &mut impl Write,
    statement: &str,
    numbers: impl IntoIterator<Item = impl std::fmt::Debug>,
) -> Result<()> {
    write!(out, "{statement}")?;
    for (i, number) in numbers.into_iter().enumerate() {
        if i > 0 && i % NUMBERS_PER_LINE == 0 {
            writeln!(out, " \\")?;
        }
        write!(out, " {number:?}")?;
    }
    Ok(writeln!(out)?)
}
