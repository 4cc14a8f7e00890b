//! Faces and shells as IGES entities.

use std::sync::Arc;

use glam::DVec3;

use super::super::bodies::Bodies;
use super::super::boundary::{Bound, bounds, oriented_bounds, oriented_surface};
use super::entities::{
    Attributes, DEPENDENT, Entities, IN_PARAMETERS, INDEPENDENT, integers, real, text,
};
use crate::brep::{Coedge, Face, Shell};
use crate::error::Result;
use crate::nurbs::NurbsCurve;

/// Per cent of a color's component of 1.
const PER_CENT: f64 = 100.0;

/// Adds some faces of a shell: surfaces (entity 128), trimmed ones (144) where they have loops.
pub(super) fn add_faces(file: &mut Entities, shell: &Shell, faces: &[usize]) -> Result<()> {
    for &index in faces {
        let face = &shell.faces()[index];
        let attributes = add_attributes(file, face);
        let surface = oriented_surface(face)?;
        if !face.is_trimmed() {
            file.add_surface(surface, INDEPENDENT, attributes);
            continue;
        }
        let surface = file.add_surface(surface, DEPENDENT, Attributes::default());
        let mut on_surface = vec![];
        for of_loop in oriented_bounds(shell, index)? {
            // OpenCASCADE approximates curves that may have kinks, to 1e-5 in any unit.
            let parts = of_loop.into_iter().map(Bound::smooth_parts).collect::<Result<Vec<_>>>()?;
            let parts = || parts.iter().flatten();
            let in_parameters = add_chain(file, parts().map(|part| &part.in_parameters), true);
            let in_space =
                add_chain(file, parts().filter_map(|part| part.in_space.as_ref()), false);
            // On the surface, curves are given in (u, v) first.
            let fields = integers(&[0, surface, in_parameters, in_space, 1]);
            on_surface.push(file.add((142, 0), DEPENDENT, Attributes::default(), fields));
        }
        // 1: the outer loop is not the surface's own boundary.
        let mut fields = integers(&[surface, 1, on_surface.len() - 1]);
        fields.extend(integers(&on_surface));
        file.add((144, 0), INDEPENDENT, attributes, fields);
    }
    Ok(())
}

/// Adds a chain of curves (entity 126), composite (102) if there are several; 0 if there are none.
fn add_chain<'c>(
    file: &mut Entities,
    curves: impl Iterator<Item = &'c NurbsCurve>,
    in_parameters: bool,
) -> usize {
    let curves: Vec<usize> = curves.map(|curve| file.add_curve(curve, in_parameters)).collect();
    match curves[..] {
        [] => 0,
        [only] => only,
        _ => {
            let mut fields = integers(&[curves.len()]);
            fields.extend(integers(&curves));
            let status = if in_parameters { IN_PARAMETERS } else { DEPENDENT };
            file.add((102, 0), status, Attributes::default(), fields)
        }
    }
}

/// Adds the solids of a shell (entity 186), with common lists of vertices (502) and edges (504).
pub(super) fn add_solids(file: &mut Entities, shell: &Shell, bodies: &Bodies) -> Result<()> {
    if bodies.solids.is_empty() {
        return Ok(());
    }
    let none = Attributes::default();
    let vertices = shell.vertices();
    let mut fields = integers(&[vertices.len()]);
    fields.extend(vertices.iter().flat_map(DVec3::to_array).map(real));
    let vertices = file.add((502, 1), DEPENDENT, none, fields);
    let mut fields = integers(&[shell.edges().len()]);
    for edge in shell.edges() {
        let curve = file.add_curve(&edge.curve, false);
        let [start, end] = edge.vertices.map(|vertex| vertex + 1);
        fields.extend(integers(&[curve, vertices, start, vertices, end]));
    }
    let edges = file.add((504, 1), DEPENDENT, none, fields);
    let lists = [vertices, edges];
    for solid in &bodies.solids {
        let outer = add_closed(file, shell, (&solid.outer, &bodies.turned), lists)?;
        // 1: the shell's normals are used as they are.
        let mut fields = integers(&[outer, 1, solid.voids.len()]);
        for part in &solid.voids {
            let void = add_closed(file, shell, (part, &bodies.turned), lists)?;
            fields.extend(integers(&[void, 1]));
        }
        file.add((186, 0), INDEPENDENT, none, fields);
    }
    Ok(())
}

/// Adds closed faces of a shell (entity 514).
fn add_closed(
    file: &mut Entities,
    shell: &Shell,
    (part, turned): (&[usize], &[bool]),
    lists: [usize; 2],
) -> Result<usize> {
    let none = Attributes::default();
    let mut faces = integers(&[part.len()]);
    for &index in part {
        let face = &shell.faces()[index];
        let attributes = add_attributes(file, face);
        let surface = file.add_surface(Arc::clone(face.surface()), DEPENDENT, none);
        let mut loops = vec![];
        for (coedges, of_loop) in shell.coedges(index).iter().zip(bounds(shell, index)?) {
            let mut fields = integers(&[coedges.len()]);
            for (coedge, bound) in coedges.iter().zip(&of_loop) {
                fields.extend(integers(&loop_part(file, face, coedge, bound, lists)));
            }
            loops.push(file.add((508, 1), DEPENDENT, none, fields));
        }
        // 1: the first loop is the outer one.
        let mut fields = integers(&[surface, loops.len(), 1]);
        fields.extend(integers(&loops));
        let face_entity = file.add((510, 1), DEPENDENT, attributes, fields);
        let agrees = face.is_reversed() == turned[index];
        faces.extend(integers(&[face_entity, usize::from(agrees)]));
    }
    Ok(file.add((514, 1), DEPENDENT, none, faces))
}

/// The fields of a part of a loop: an edge or a pole, with its curve in (u, v) if the face is
/// trimmed.
fn loop_part(
    file: &mut Entities,
    face: &Face,
    coedge: &Coedge,
    bound: &Bound,
    [vertices, edges]: [usize; 2],
) -> Vec<usize> {
    let mut part = match coedge.edge {
        Some(edge) => vec![0, edges, edge + 1, usize::from(coedge.forward)],
        None => vec![1, vertices, coedge.vertex + 1, 1],
    };
    if face.is_trimmed() {
        // One curve, which need not have constant u or v.
        part.extend([1, 0, file.add_curve(&bound.in_parameters, true)]);
    } else {
        part.push(0);
    }
    part
}

/// Adds the name (entity 406, form 15) and the color (314) of a face.
fn add_attributes(file: &mut Entities, face: &Face) -> Attributes {
    let name = face.name().map(|name| {
        let fields = vec!["1".into(), text(name)];
        file.add((406, 15), DEPENDENT, Attributes::default(), fields)
    });
    let color = face.color().map(|color| {
        let fields = color.map(|component| real(PER_CENT * component)).to_vec();
        file.add((314, 0), "00000200", Attributes::default(), fields)
    });
    Attributes { name, color }
}
