//! The solids and open surfaces that a shell consists of.

use glam::DVec3;

use super::orientation::signed_volume;
use crate::brep::{Edge, Shell};
use crate::disjoint_sets::DisjointSets;
use crate::numeric::index;

/// The bodies of a shell, as indices of its faces.
pub(super) struct Bodies {
    pub solids: Vec<Solid>,
    /// Connected faces with a border.
    pub surfaces: Vec<Vec<usize>>,
    /// For each face, whether its normals must turn to point out of its solid.
    pub turned: Vec<bool>,
}

/// A solid: connected faces without a border.
pub(super) struct Solid {
    pub outer: Vec<usize>,
    /// The faces around each cavity.
    pub voids: Vec<Vec<usize>>,
}

impl Bodies {
    /// Divides a shell. Closed parts whose normals point inward are the cavities of the only other
    /// one if they lie in its box; else they are solids that are inside out.
    pub(super) fn of(shell: &Shell) -> Self {
        let (closed, surfaces) = connected(shell).into_iter().partition(|part| part.is_closed);
        let faces = |parts: Vec<Part>| parts.into_iter().map(|part| part.faces).collect();
        let signed = |part: Part| (signed_volume(shell, &part.faces), part.faces);
        let closed: Vec<(f64, Vec<usize>)> = Vec::into_iter(closed).map(signed).collect();
        let (inward, outward): (Vec<_>, Vec<_>) =
            closed.iter().cloned().partition(|(volume, _)| *volume < 0.0);
        let mut turned = vec![false; shell.faces().len()];
        if let [(_, outer)] = &outward[..] {
            let ((low, high), all) = (net_box(shell, outer), inward.iter());
            let inside = |part: &[usize]| {
                let (a, b) = net_box(shell, part);
                low.cmple(a).all() && b.cmple(high).all()
            };
            if all.clone().all(|(_, part)| inside(part)) {
                let voids = all.map(|(_, part)| part.clone()).collect();
                let solids = vec![Solid { outer: outer.clone(), voids }];
                return Self { solids, surfaces: faces(surfaces), turned };
            }
        }
        for &face in inward.iter().flat_map(|(_, part)| part) {
            turned[face] = true;
        }
        let solids = closed.into_iter().map(|(_, outer)| Solid { outer, voids: vec![] }).collect();
        Self { solids, surfaces: faces(surfaces), turned }
    }
}

/// Faces that edges connect.
struct Part {
    faces: Vec<usize>,
    is_closed: bool,
}

/// The connected parts of a shell, in the order of their first faces.
fn connected(shell: &Shell) -> Vec<Part> {
    let count = shell.faces().len();
    let mut sets = DisjointSets::new(count);
    for edge in shell.edges() {
        for at in &edge.uses {
            sets.unite(index(edge.uses[0].face), index(at.face));
        }
    }
    let mut parts: Vec<Part> = vec![];
    let mut part_of = vec![0; count];
    for (face, first) in sets.roots().into_iter().enumerate() {
        let first = first as usize;
        if first == face {
            part_of[face] = parts.len();
            parts.push(Part { faces: vec![], is_closed: true });
        }
        part_of[face] = part_of[first];
        parts[part_of[face]].faces.push(face);
    }
    for edge in shell.edges().iter().filter(|edge| Edge::is_border(edge)) {
        parts[part_of[edge.uses[0].face]].is_closed = false;
    }
    parts
}

/// The box around the control points of faces.
fn net_box(shell: &Shell, faces: &[usize]) -> (DVec3, DVec3) {
    let boxes = faces.iter().map(|&face| shell.faces()[face].surface().net_box());
    boxes.reduce(|(a, b), (c, d)| (a.min(c), b.max(d))).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brep::Face;
    use crate::nurbs::NurbsSurface;

    fn sphere(x: f64, radius: f64) -> Face {
        Face::whole(NurbsSurface::sphere(x * DVec3::X, radius).unwrap()).unwrap()
    }

    fn bodies(faces: Vec<Face>) -> (usize, usize, usize, Vec<bool>) {
        let bodies = Bodies::of(&Shell::new(faces, None).unwrap());
        let voids = bodies.solids.iter().map(|solid| solid.voids.len()).sum();
        (bodies.solids.len(), voids, bodies.surfaces.len(), bodies.turned)
    }

    #[test]
    fn closed_parts_are_solids_or_cavities() {
        let plane = Face::whole(NurbsSurface::plane(DVec3::ZERO, DVec3::X, DVec3::Y).unwrap());
        let (ball, other) = (sphere(0.0, 2.0), sphere(9.0, 2.0));
        let apart = bodies(vec![ball.clone(), plane.unwrap(), other.reversed()]);
        assert_eq!(apart, (2, 0, 1, vec![false, false, true]));
        let hollow = bodies(vec![sphere(0.5, 1.0).reversed(), ball]);
        assert_eq!(hollow, (1, 1, 0, vec![false, false]));
    }
}
