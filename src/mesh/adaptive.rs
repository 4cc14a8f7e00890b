//! Adaptive tessellation: as few triangles as a certified tolerance allows.
//!
//! The surface is cut into blocks of Bézier patches, and each block into pieces (rectangles of the
//! parameters), until two triangles meet every piece within the tolerance. Then the corners that
//! neighbours have put on a piece's sides become corners of its triangles as well, so that no
//! vertex lies on an edge; a piece that these triangles do not meet is divided again, until nothing
//! changes. Blocks are independent in between, so the result does not depend on the threads.

use std::time::{Duration, Instant};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::bernstein::Bernstein;
use super::certify::Face;
use super::estimate::Estimate;
use super::lattice::Lattice;
use super::numbering::{Numbers, number_of};
use super::options::{Limits, TessellateOptions, diagonal};
use super::piece::{Desk, Divider, Piece};
use super::stitch::{Borders, Place, Vertices, own_borders, parameter};
use super::uniform::check_length;
use super::{MeshSlices, TriangleMesh};
use crate::error::{Error, Result};
use crate::nurbs::NurbsSurface;
use crate::progress::{self, Observer, Progress, Stage};

/// Time between two calls of the observer that is aimed at.
const REPORT: Duration = Duration::from_millis(20);

/// Share by which an estimate must pass the limit on triangles before the work is refused.
const SURELY: f64 = 2.0;

/// Blocks (or parts of borders) that are worked on before the first report.
const FIRST_GROUP: usize = 16;

/// Vertices on borders that a thread evaluates at a time.
const VERTICES_PER_TASK: usize = 1 << 10;

/// A finished division of a surface, ready to be written into memory of whatever origin.
#[derive(Debug)]
pub struct Tessellation<'a> {
    surface: &'a NurbsSurface,
    limits: Limits,
    pub(super) lattice: Lattice,
    bernstein: Bernstein,
    /// The pieces of each block.
    pub(super) pieces: Vec<Vec<Piece>>,
    pub(super) borders: Borders,
    pub(super) numbers: Numbers,
    deviation: f64,
}

/// What looking at a block has found.
#[derive(Default)]
struct Review {
    /// The pieces, if any of them has changed.
    pieces: Option<Vec<Piece>>,
    /// Whether one was divided.
    divided: bool,
    /// The largest distance of those that were looked at.
    deviation: f64,
}

/// Memory of a thread.
#[derive(Default)]
pub(super) struct Local {
    desk: Desk,
    pub(super) vertices: Vertices,
    pub(super) outline: Vec<(u32, Place)>,
    places: Vec<Place>,
    faces: Vec<Face>,
    /// The numbers of the vertices, in their order.
    pub(super) numbers: Vec<u32>,
}

impl NurbsSurface {
    /// The surface as triangles that lie within a certified tolerance of it everywhere.
    ///
    /// No vertex lies on an edge, every inner edge belongs to two triangles, closed directions are
    /// welded (unless split on request), poles are one vertex, and creases (knots repeated as often
    /// as the degree) lie on edges. The same bits for any number of threads; O(triangles).
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a limit is out of its range, or so small that the mesh would have
    /// more than `options.max_triangles`; [`Error::Interrupted`] if the observer stops it.
    pub fn tessellate(
        &self,
        options: &TessellateOptions,
        observer: &mut dyn Observer,
    ) -> Result<TriangleMesh> {
        Tessellation::new(self, options, observer)?.mesh(observer)
    }
}

impl<'a> Tessellation<'a> {
    /// Divides a surface.
    ///
    /// # Errors
    ///
    /// Those of [`NurbsSurface::tessellate`].
    pub fn new(
        surface: &'a NurbsSurface,
        options: &TessellateOptions,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let limits = options.limits(diagonal(&[surface]))?;
        let estimate = Estimate::of(surface, &limits);
        if estimate.triangles > SURELY * options.max_triangles as f64 {
            return Err(too_many(options, &limits, estimate.triangles));
        }
        let lattice = Lattice::new(surface, estimate)?;
        let bernstein = Bernstein::new(lattice.nets.degrees);
        let borders = Borders::new(&lattice);
        let mut this = Self {
            surface,
            limits,
            lattice,
            bernstein,
            pieces: vec![],
            borders,
            numbers: Numbers::default(),
            deviation: 0.0,
        };
        this.divide(options, observer)?;
        this.conform(options, observer)?;
        this.number(options.split_seams, observer)?;
        if this.triangles() > options.max_triangles {
            return Err(too_many(options, &limits, this.triangles() as f64));
        }
        Ok(this)
    }

    /// Number of vertices.
    #[must_use]
    pub fn vertices(&self) -> usize {
        self.numbers.vertices[self.lattice.blocks()]
    }

    /// Number of triangles.
    #[must_use]
    pub fn triangles(&self) -> usize {
        self.numbers.triangles[self.lattice.blocks()]
    }

    /// See [`TriangleMesh::max_deviation`].
    #[must_use]
    pub fn max_deviation(&self) -> f64 {
        self.deviation
    }

    /// The mesh.
    ///
    /// # Errors
    ///
    /// [`Error::Interrupted`] if the observer stops it.
    pub fn mesh(&self, observer: &mut dyn Observer) -> Result<TriangleMesh> {
        let mut mesh = TriangleMesh {
            vertices: vec![DVec3::ZERO; self.vertices()],
            triangles: vec![[0; 3]; self.triangles()],
            normals: vec![DVec3::ZERO; self.vertices()],
            uv: vec![DVec2::ZERO; self.vertices()],
            max_deviation: Some(self.deviation),
        };
        let TriangleMesh { vertices, triangles, normals, uv, .. } = &mut mesh;
        self.write(MeshSlices { vertices, triangles, normals, uv }, observer)?;
        Ok(mesh)
    }

    fn divider(&self) -> Divider<'_> {
        let (surface, nets, bernstein) = (self.surface, &self.lattice.nets, &self.bernstein);
        Divider { surface, nets, bernstein, limits: self.limits }
    }

    fn divide(&mut self, options: &TessellateOptions, observer: &mut dyn Observer) -> Result<()> {
        let (divider, lattice) = (self.divider(), &self.lattice);
        let mut count = 0;
        let job = |local: &mut Local, index: usize| {
            let (block, mut done) = (lattice.block(index), vec![]);
            local.desk.deviation = 0.0;
            divider.divide(block, Piece::of(block), &mut local.desk, &mut done);
            done.shrink_to_fit();
            (done, local.desk.deviation)
        };
        let mut pieces = Vec::with_capacity(lattice.blocks());
        let mut deviation = 0.0_f64;
        in_groups(0..lattice.blocks(), observer, job, |(done, most)| {
            count += done.len();
            deviation = deviation.max(most);
            pieces.push(done);
            if 2 * count > options.max_triangles {
                let share = lattice.blocks() as f64 / pieces.len() as f64;
                return Err(too_many(options, &self.limits, 2.0 * count as f64 * share));
            }
            Ok(())
        })?;
        (self.pieces, self.deviation) = (pieces, deviation);
        Ok(())
    }

    /// Divides pieces until their triangles hold with all vertices that stand on their sides.
    fn conform(&mut self, options: &TessellateOptions, observer: &mut dyn Observer) -> Result<()> {
        let blocks = self.lattice.blocks();
        let mut pending = vec![true; blocks];
        let touch = |borders: &mut Borders,
                     pieces: &[Vec<Piece>],
                     lattice: &Lattice,
                     index: usize,
                     pending: &mut [bool]| {
            let sides = own_borders(lattice.block(index), &pieces[index]);
            for (side, places) in borders.around(index).into_iter().zip(sides) {
                if borders.add(side, &places) {
                    for other in lattice.beside(side) {
                        pending[other] = true;
                    }
                }
            }
        };
        for index in 0..blocks {
            touch(&mut self.borders, &self.pieces, &self.lattice, index, &mut pending);
        }
        while pending.contains(&true) {
            let todo: Vec<usize> = (0..blocks).filter(|&index| pending[index]).collect();
            let mut changed: Vec<(usize, Vec<Piece>, bool)> = vec![];
            let mut deviation = self.deviation;
            let review = |local: &mut Local, index| (index, self.review(local, index));
            in_groups(todo, observer, review, |(index, found)| {
                deviation = deviation.max(found.deviation);
                changed.extend(found.pieces.map(|pieces| (index, pieces, found.divided)));
                Ok(())
            })?;
            self.deviation = deviation;
            pending.fill(false);
            for (index, pieces, divided) in changed {
                self.pieces[index] = pieces;
                if divided {
                    pending[index] = true;
                    touch(&mut self.borders, &self.pieces, &self.lattice, index, &mut pending);
                }
            }
            let count = self.pieces.iter().map(Vec::len).sum::<usize>();
            if 2 * count > options.max_triangles {
                return Err(too_many(options, &self.limits, 2.0 * count as f64));
            }
        }
        Ok(())
    }

    /// Looks at the pieces of a block that have got vertices on their sides.
    fn review(&self, local: &mut Local, index: usize) -> Review {
        let (block, pieces) = (self.lattice.block(index), &self.pieces[index]);
        let divider = self.divider();
        local.desk.deviation = 0.0;
        local.vertices.collect(block, pieces, self.sides(index));
        let mut review = Review::default();
        for (k, &before) in pieces.iter().enumerate() {
            let mut piece = before;
            local.outline.clear();
            local.vertices.outline(&piece, &mut local.outline);
            let mut unfit = None;
            if local.outline.len() > piece.cut.corners as usize {
                local.places.clear();
                local.places.extend(local.outline.iter().map(|&(_, place)| place));
                unfit = divider.check(block, &mut piece, &local.places, &mut local.desk);
            }
            if unfit.is_some() || piece != before {
                review.pieces.get_or_insert_with(|| pieces[..k].to_vec());
            }
            let Some(new) = &mut review.pieces else { continue };
            match unfit {
                Some(direction) => {
                    divider.redivide(block, (piece, direction), &mut local.desk, new);
                    review.divided = true;
                }
                None => new.push(piece),
            }
        }
        review.deviation = local.desk.deviation;
        review
    }

    pub(super) fn sides(&self, index: usize) -> [&[u32]; 4] {
        self.borders.around(index).map(|side| self.borders.at(side))
    }

    /// Writes the mesh into memory of the caller.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a slice has not the right length; [`Error::Interrupted`] if the
    /// observer stops it.
    pub fn write(&self, out: MeshSlices<'_>, observer: &mut dyn Observer) -> Result<()> {
        let MeshSlices { vertices, triangles, normals, uv } = out;
        check_length("uv", uv.len(), self.vertices())?;
        check_length("triangles", triangles.len(), self.triangles())?;
        check_length("vertices", vertices.len(), self.vertices())?;
        check_length("normals", normals.len(), self.vertices())?;
        let (numbers, borders) = (&self.numbers, self.numbers.on_borders.len());
        let (border_points, vertices) = vertices.split_at_mut(borders);
        let (border_normals, normals) = normals.split_at_mut(borders);
        let (border_uv, uv) = uv.split_at_mut(borders);
        border_uv.copy_from_slice(&numbers.on_borders);
        let on_borders = border_uv.chunks(VERTICES_PER_TASK);
        let on_borders = on_borders.zip(border_points.chunks_mut(VERTICES_PER_TASK));
        let on_borders = on_borders.zip(border_normals.chunks_mut(VERTICES_PER_TASK));
        let evaluate = |_: &mut Local, ((uv, points), normals): ((&[DVec2], _), _)| {
            self.evaluate(uv, points, normals);
        };
        in_groups(on_borders, observer, evaluate, Ok)?;
        let (points, normals) =
            (parts(vertices, &numbers.vertices), parts(normals, &numbers.vertices));
        let inside = points.into_iter().zip(normals).zip(parts(uv, &numbers.vertices));
        let blocks = inside.zip(parts(triangles, &numbers.triangles)).enumerate();
        let write = |local: &mut Local, (index, (((points, normals), uv), faces)): (usize, ((_, &mut [DVec2]), _))| {
            self.write_block(local, index, uv, faces);
            self.evaluate(uv, points, normals);
        };
        in_groups(blocks, observer, write, Ok)
    }

    fn evaluate(&self, uv: &[DVec2], points: &mut [DVec3], normals: &mut [DVec3]) {
        for ((at, point), normal) in uv.iter().zip(points).zip(normals) {
            (*point, *normal) = self.surface.point_and_normal(at.x, at.y);
        }
    }

    /// Writes the parameters of a block's inner vertices, and its triangles.
    fn write_block(
        &self,
        local: &mut Local,
        index: usize,
        uv: &mut [DVec2],
        faces: &mut [[u32; 3]],
    ) {
        let (block, pieces) = (self.lattice.block(index), &self.pieces[index]);
        local.vertices.collect(block, pieces, self.sides(index));
        let first = number_of(self.numbers.vertices[index]);
        self.names(local, index, first);
        let (cuts_u, cuts_v) = (&self.lattice.nets.u, &self.lattice.nets.v);
        for (&(u, v), &number) in local.vertices.places().iter().zip(&local.numbers) {
            if number >= first {
                let u = parameter(cuts_u, block.rows.0, u);
                uv[(number - first) as usize] = DVec2::new(u, parameter(cuts_v, block.cols.0, v));
            }
        }
        let mut next = faces.iter_mut();
        for piece in pieces {
            local.outline.clear();
            local.vertices.outline(piece, &mut local.outline);
            local.faces.clear();
            let outline = local.outline.iter().map(|&(_, place)| place);
            piece.cut.faces(piece.ends(&outline), &mut local.faces);
            let named = local
                .faces
                .iter()
                .map(|face| face.map(|k| local.numbers[local.outline[k].0 as usize]));
            let whole = named.filter(|[a, b, c]| a != b && b != c && c != a);
            whole.zip(&mut next).for_each(|(face, out)| *out = face);
        }
    }
}

/// Slices of a whole between these bounds.
fn parts<'a, T>(mut whole: &'a mut [T], bounds: &[usize]) -> Vec<&'a mut [T]> {
    let mut parts = Vec::with_capacity(bounds.len() - 1);
    for pair in bounds.windows(2) {
        let (part, rest) = whole.split_at_mut(pair[1] - pair[0]);
        parts.push(part);
        whole = rest;
    }
    parts
}

/// Does a job for each item, in parallel, and takes the results in order; reports in between.
pub(super) fn in_groups<I: Send, T: Send>(
    items: impl IntoIterator<Item = I, IntoIter: ExactSizeIterator>,
    observer: &mut dyn Observer,
    job: impl Fn(&mut Local, I) -> T + Sync,
    mut take: impl FnMut(T) -> Result<()>,
) -> Result<()> {
    let mut items = items.into_iter();
    let (mut done, mut size, total) = (0, FIRST_GROUP, items.len() as u64);
    loop {
        let at = Progress::of_stage(Stage::Tessellation, done, total, 0);
        progress::report(observer, &at)?;
        let group: Vec<I> = items.by_ref().take(size).collect();
        if group.is_empty() {
            return Ok(());
        }
        done += group.len() as u64;
        let started = Instant::now();
        let results = group.into_par_iter().map_init(Local::default, &job);
        results.collect::<Vec<T>>().into_iter().try_for_each(&mut take)?;
        size = if started.elapsed() < REPORT { 2 * size } else { (size / 2).max(1) };
    }
}

fn too_many(options: &TessellateOptions, limits: &Limits, triangles: f64) -> Error {
    let must = format!("large enough for at most {} triangles", options.max_triangles);
    let got = format!("{:e}, which would take about {triangles:.1e}", limits.tolerance);
    Error::parameter("tolerance", must, got)
}
