//! Wavefront OBJ export of meshes, as text with all digits.

use std::io::Write;

use crate::error::Result;
use crate::mesh::MeshView;

/// Writes a mesh as a Wavefront OBJ file: vertices, parameters as texture coordinates, normals,
/// triangles.
///
/// ```
/// use neurbs::{DVec3, export::write_obj, mesh::UniformGrid, nurbs::NurbsSurface};
/// # use neurbs::progress::Silent;
/// let net = vec![DVec3::ZERO, DVec3::Y, DVec3::X, DVec3::ONE];
/// let surface = NurbsSurface::clamped(net, (2, 2), 1)?;
/// let mesh = UniformGrid::new(2, 2)?.tessellate(&surface, &mut Silent)?;
/// let mut file = Vec::new();
/// write_obj(mesh.view(), &mut file)?;
/// assert!(String::from_utf8(file).unwrap().ends_with("f 1/1/1 4/4/4 2/2/2\n"));
/// # Ok::<(), neurbs::Error>(())
/// ```
///
/// # Errors
///
/// [`crate::Error::Io`] if writing fails.
pub fn write_obj(mesh: MeshView<'_>, out: &mut impl Write) -> Result<()> {
    for p in mesh.vertices {
        writeln!(out, "v {:?} {:?} {:?}", p.x, p.y, p.z)?;
    }
    for at in mesh.uv {
        writeln!(out, "vt {:?} {:?}", at.x, at.y)?;
    }
    for n in mesh.normals {
        writeln!(out, "vn {:?} {:?} {:?}", n.x, n.y, n.z)?;
    }
    for triangle in mesh.triangles {
        let [a, b, c] = triangle.map(|i| u64::from(i) + 1);
        writeln!(out, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}")?;
    }
    Ok(())
}
