//! The triangles of one face, from the points of its edges.

use std::collections::BTreeSet;

use glam::{DVec2, DVec3};

use super::TessellateOptions;
use super::adaptive::Tessellation;
use super::edge_points::EdgePoints;
use super::kept_cells::{INNER, keep};
use super::options::Limits;
use super::outline::{Node, Origin, Outline};
use super::strip::Strip;
use super::strip_triangulation::StripTriangulation;
use crate::brep::{Face, Shell};
use crate::error::Result;
use crate::nurbs::NurbsSurface;
use crate::progress::Observer;

/// The tolerance of the kept cells, as shares to try in turn. Sides of cells that deviate as much as
/// the tolerance may leave too little to the triangles beside them.
const CELL_SHARES: [f64; 3] = [1.0, 0.9, 0.7];

/// Samples of the tangents along each direction.
const SAMPLES: u32 = 4;

/// The triangles of a face.
#[derive(Debug)]
pub(super) struct FaceMesh {
    /// The corners of triangles.
    pub nodes: Vec<Node>,
    /// The surface's normals at the nodes.
    pub normals: Vec<DVec3>,
    /// The triangles, by nodes; counter-clockwise in (u, v).
    pub triangles: Vec<[usize; 3]>,
    pub deviation: f64,
    /// Whether all triangles are certified within the tolerance.
    pub is_proven: bool,
}

impl FaceMesh {
    /// Leaves out the nodes that are in no triangle.
    fn new(
        surface: &NurbsSurface,
        all: &[Node],
        mut triangles: Vec<[usize; 3]>,
        (deviation, is_proven): (f64, bool),
    ) -> Self {
        let (mut numbers, mut nodes) = (vec![usize::MAX; all.len()], vec![]);
        for corner in triangles.iter_mut().flatten() {
            if numbers[*corner] == usize::MAX {
                numbers[*corner] = nodes.len();
                nodes.push(all[*corner]);
            }
            *corner = numbers[*corner];
        }
        let uv: Vec<DVec2> = nodes.iter().map(|node| node.uv).collect();
        let (mut points, mut normals) = (vec![DVec3::ZERO; uv.len()], vec![DVec3::ZERO; uv.len()]);
        surface.points_and_normals(&uv, &mut points, &mut normals);
        Self { nodes, normals, triangles, deviation, is_proven }
    }

    /// Whether a triangle has two corners at the same vertex or point of an edge.
    pub(super) fn has_collapsed(&self) -> bool {
        self.triangles.iter().any(|triangle| {
            let [a, b, c] = triangle.map(|k| self.nodes[k].origin);
            let same = |a: Origin, b: Origin| a == b && a != Origin::Inside;
            same(a, b) || same(b, c) || same(c, a)
        })
    }
}

/// The triangles of a face, or the chords of its edges that must be divided before.
#[derive(Debug)]
pub(super) enum Attempt {
    Done(FaceMesh),
    /// Edges and indices of chords.
    Crossing(BTreeSet<(usize, usize)>),
}

/// Lengths in space per unit of u and v, on average.
pub(super) fn scale(face: &Face) -> DVec2 {
    let (u, v) = (face.surface().knots_u().domain(), face.surface().knots_v().domain());
    let mut sum = DVec2::ZERO;
    let inside = |(from, to): (f64, f64), k: u32| {
        from + (f64::from(k) + 0.5) / f64::from(SAMPLES) * (to - from)
    };
    for (i, j) in (0..SAMPLES).flat_map(|i| (0..SAMPLES).map(move |j| (i, j))) {
        let [_, by_u, by_v] = face.surface().tangents(inside(u, i), inside(v, j));
        sum += DVec2::new(by_u.length(), by_v.length());
    }
    let unit = DVec2::new(u.1 - u.0, v.1 - v.0).recip();
    let least = f64::EPSILON * (sum / unit).max_element();
    sum.max(unit * least).max(DVec2::splat(f64::MIN_POSITIVE)) / f64::from(SAMPLES * SAMPLES)
}

/// What the faces of a shell are triangulated with.
#[derive(Clone, Copy)]
pub(super) struct FaceMesher<'a> {
    pub shell: &'a Shell,
    pub edges: &'a [EdgePoints],
    /// See [`scale`]; one for each face.
    pub scales: &'a [DVec2],
    pub options: &'a TessellateOptions,
    pub limits: &'a Limits,
}

impl FaceMesher<'_> {
    /// Triangulates a face.
    ///
    /// Inner sides between two of the `forbidden` pairs of origins are halved.
    pub(super) fn mesh(
        &self,
        face: usize,
        forbidden: &BTreeSet<[Origin; 2]>,
        observer: &mut dyn Observer,
    ) -> Result<Attempt> {
        let mut found = self.attempt((face, CELL_SHARES[0]), forbidden, observer)?;
        for share in &CELL_SHARES[1..] {
            let Attempt::Done(mesh) = &found else { break };
            if mesh.is_proven {
                break;
            }
            found = self.attempt((face, *share), forbidden, observer)?;
        }
        Ok(found)
    }

    /// Triangulates a face with kept cells within a share of the tolerance.
    fn attempt(
        &self,
        (face, share): (usize, f64),
        forbidden: &BTreeSet<[Origin; 2]>,
        observer: &mut dyn Observer,
    ) -> Result<Attempt> {
        let (surface, scale) = (self.shell.faces()[face].surface(), self.scales[face]);
        let tolerance = Some(share * self.limits.tolerance);
        let options =
            TessellateOptions { tolerance, relative: false, split_seams: true, ..*self.options };
        let cells = Tessellation::new(surface, &options, observer)?;
        let mesh = cells.mesh(observer)?;
        let mut outline = Outline::new(self.shell, face, self.edges, &cells.at_poles());
        let kept = keep(&mut outline, &mesh, &cells.cells(), scale);
        let loops = outline.sides.iter().map(|side| side.nodes);
        let fixed: Vec<[usize; 2]> = loops.chain(kept.border.iter().copied()).collect();
        let places = outline.nodes.iter().map(|node| node.uv);
        let mut triangulation = match StripTriangulation::new(places, fixed, scale) {
            Ok(triangulation) => triangulation,
            Err(conflicts) => return Ok(Attempt::Crossing(outline.crossing(&conflicts))),
        };
        let mut strip = Strip::new(surface, self.limits, outline.nodes);
        let mut triangles = strip.refine(&mut triangulation, forbidden);
        let first = strip.nodes.len();
        let of = |k: usize| if k >= INNER { k - INNER + first } else { k };
        triangles.extend(kept.triangles.iter().map(|triangle| triangle.map(of)));
        let mut deviation = strip.deviation;
        if !kept.triangles.is_empty() {
            deviation = deviation.max(cells.max_deviation());
        }
        let mut nodes = strip.nodes;
        nodes.extend(kept.inner);
        let proven = (deviation, strip.is_proven);
        Ok(Attempt::Done(FaceMesh::new(surface, &nodes, triangles, proven)))
    }
}
