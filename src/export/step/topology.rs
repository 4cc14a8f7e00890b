//! Vertices, edges, loops and faces as entities.

use std::io::Write;

use super::entities::{Entities, list, string};
use super::geometry;
use crate::brep::{Coedge, Edge, Face, Shell};
use crate::error::Result;

/// Writes the faces of a shell and returns the references to them.
///
/// `turned` is, for each face, whether its normals turn to the other side. `pcurves` adds the curves in (u, v) of trimmed
/// faces to their edges.
pub(super) fn faces<W: Write>(
    file: &mut Entities<'_, W>,
    shell: &Shell,
    turned: &[bool],
    pcurves: bool,
) -> Result<Vec<String>> {
    let surfaces = shell.faces().iter().map(|face| geometry::surface(file, face.surface()));
    let surfaces = surfaces.collect::<Result<Vec<String>>>()?;
    let vertices = shell.vertices().iter().map(|&place| {
        let point = geometry::point(file, place)?;
        file.add(&format!("VERTEX_POINT('',{point})"))
    });
    let vertices = vertices.collect::<Result<Vec<String>>>()?;
    let mut writer = Topology { file, shell, surfaces, vertices, edges: vec![] };
    writer.write_edges(pcurves)?;
    let faces = shell.faces().iter().zip(turned).enumerate();
    faces.map(|(index, (face, turned))| writer.face(index, face, *turned)).collect()
}

/// The entities of a shell so far.
struct Topology<'a, 'b, W: Write> {
    file: &'a mut Entities<'b, W>,
    shell: &'a Shell,
    surfaces: Vec<String>,
    vertices: Vec<String>,
    edges: Vec<String>,
}

impl<W: Write> Topology<'_, '_, W> {
    fn write_edges(&mut self, pcurves: bool) -> Result<()> {
        let trimmed = self.shell.faces().iter().any(Face::is_trimmed);
        let context = if pcurves && trimmed {
            Some(self.file.add(
                "(GEOMETRIC_REPRESENTATION_CONTEXT(2) PARAMETRIC_REPRESENTATION_CONTEXT() \
                 REPRESENTATION_CONTEXT('',''))",
            )?)
        } else {
            None
        };
        for edge in self.shell.edges() {
            let mut curve = geometry::curve(self.file, &edge.curve)?;
            if let Some(context) = &context {
                curve = self.on_surfaces(edge, curve, context)?;
            }
            let [start, end] = edge.vertices.map(|vertex| &self.vertices[vertex]);
            let written = self.file.add(&format!("EDGE_CURVE('',{start},{end},{curve},.T.)"))?;
            self.edges.push(written);
        }
        Ok(())
    }

    /// Adds to the curve of an edge its curves in (u, v) of trimmed faces.
    fn on_surfaces(&mut self, edge: &Edge, curve: String, context: &str) -> Result<String> {
        let mut written = vec![];
        let trimmed = |face: usize| self.shell.faces()[face].is_trimmed();
        for at in edge.uses.iter().filter(|at| trimmed(at.face)) {
            let pcurve = self.shell.pcurve(*at)?;
            let surface = &self.surfaces[at.face];
            written.push(geometry::pcurve(self.file, &pcurve, surface, context)?);
        }
        if written.is_empty() {
            return Ok(curve);
        }
        let is_seam = edge.uses.len() == 2 && edge.uses[0].face == edge.uses[1].face;
        let kind = if is_seam { "SEAM_CURVE" } else { "SURFACE_CURVE" };
        self.file.add(&format!("{kind}('',{curve},{},.PCURVE_S1.)", list(written)))
    }

    fn face(&mut self, index: usize, face: &Face, turned: bool) -> Result<String> {
        let agrees = face.is_reversed() == turned;
        let mut bounds = vec![];
        for (l, coedges) in self.shell.coedges(index).iter().enumerate() {
            let written = self.closed_loop(coedges, agrees)?;
            let kind = if l == 0 { "FACE_OUTER_BOUND" } else { "FACE_BOUND" };
            bounds.push(self.file.add(&format!("{kind}('',{written},.T.)"))?);
        }
        let (name, bounds) = (string(face.name().unwrap_or_default()), list(bounds));
        let (surface, sense) = (&self.surfaces[index], logical(agrees));
        self.file.add(&format!("ADVANCED_FACE({name},{bounds},{surface},{sense})"))
    }

    /// Writes a loop, counter-clockwise around the face's normal, without poles.
    fn closed_loop(&mut self, coedges: &[Coedge], agrees: bool) -> Result<String> {
        let mut oriented = vec![];
        for coedge in coedges {
            let Some(edge) = coedge.edge else { continue };
            let (edge, forward) = (&self.edges[edge], logical(coedge.forward == agrees));
            oriented.push(self.file.add(&format!("ORIENTED_EDGE('',*,*,{edge},{forward})"))?);
        }
        if oriented.is_empty() {
            let vertex = &self.vertices[coedges[0].vertex];
            return self.file.add(&format!("VERTEX_LOOP('',{vertex})"));
        }
        if !agrees {
            oriented.reverse();
        }
        self.file.add(&format!("EDGE_LOOP('',{})", list(oriented)))
    }
}

fn logical(value: bool) -> &'static str {
    if value { ".T." } else { ".F." }
}
