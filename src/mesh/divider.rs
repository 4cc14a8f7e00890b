//! How a block is divided into pieces.
//!
//! A piece that its triangles do not meet within the limits is halved, across the direction that
//! bends more; one of several patches, between patches.

#![expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]

use std::cell::RefCell;
use std::ops::Range;

use glam::{DVec2, DVec3, DVec4};
use pulp::{Arch, Simd, WithSimd};

use super::bernstein::{Bernstein, UNIT, polynomials};
use super::certify::{self, Corner, Face, Faces, Part, Workspace};
use super::chord::Chord;
use super::net::Net;
use super::options::Limits;
use super::outline::{Bending, MOST_CORNERS, Zip};
use super::piece::{self, Block, Direction, PATCH, Piece};
use super::stitch::{Place, parameter};
use super::triangle::larger;
use crate::nurbs::{NurbsSurface, PatchNets, Row, halve};

/// Share of the tolerance from which on a proof leaves so little that new vertices hardly ever keep
/// within it.
const GROWS: f64 = 0.75;

/// What dividing needs to know.
#[derive(Debug)]
pub(super) struct Divider<'a> {
    pub surface: &'a NurbsSurface,
    pub nets: &'a PatchNets,
    pub bernstein: &'a Bernstein,
    pub limits: Limits,
}

/// Memory that dividing needs.
#[derive(Debug, Default)]
pub(super) struct Desk {
    /// The vector instructions that may be used.
    arch: Arch,
    /// The pieces whose nets are on the desk.
    pieces: Vec<Piece>,
    /// Nets, one behind the other: those of the pieces around the one being looked at.
    nets: Vec<DVec4>,
    /// The control points of the last net in space.
    points: Vec<DVec3>,
    /// Where its columns lie.
    columns: Vec<Located>,
    part: Vec<DVec4>,
    corners: Vec<Corner>,
    faces: Vec<Face>,
    work: Workspace,
    /// The largest certified distance of a finished piece.
    deviation: f64,
}

thread_local! {
    /// Each thread keeps its desk: small meshes would spend much of their time on asking for memory.
    static DESK: RefCell<Desk> = RefCell::default();
}

impl Desk {
    /// What `work`, which must not ask for it again, does at the desk of this thread, and the largest
    /// distance that it has certified.
    pub(super) fn with<T>(work: impl FnOnce(&mut Self) -> T) -> (T, f64) {
        DESK.with_borrow_mut(|desk| {
            desk.deviation = 0.0;
            (work(desk), desk.deviation)
        })
    }
}

impl Divider<'_> {
    /// Divides a piece of a block until each part meets the limits with two triangles, and appends
    /// the parts.
    pub(super) fn divide(
        &self,
        block: Block,
        piece: Piece,
        desk: &mut Desk,
        done: &mut Vec<Piece>,
    ) {
        if piece.is_single() {
            self.load(block, piece, desk);
            desk.arch.dispatch(DivideNet { divider: self, block, piece, desk, done });
            return;
        }
        let mut merged = piece;
        match self.check(block, &mut merged, &piece.corners(), desk) {
            None => done.push(merged),
            Some(direction) => self.redivide(block, (piece, direction), desk, done),
        }
    }

    /// As [`Divider::divide`], for a piece whose net is the only one on the desk; takes it away.
    #[inline(always)]
    fn divide_net<S: Simd>(
        &self,
        simd: S,
        (block, piece): (Block, Piece),
        desk: &mut Desk,
        done: &mut Vec<Piece>,
    ) {
        let (p, q) = (self.bernstein.p, self.bernstein.q);
        let size = (p + 1) * (q + 1);
        desk.pieces.clear();
        desk.pieces.push(piece);
        while let Some(piece) = desk.pieces.pop() {
            let start = desk.nets.len() - size;
            let Some(direction) = self.unmet(simd, (block, piece), desk, done) else {
                desk.nets.truncate(start);
                continue;
            };
            let [first, second] = piece.halves(direction);
            // The second half's net takes this one's place, the first half's goes on top.
            desk.pieces.extend([second, first]);
            desk.nets.extend_from_within(start..);
            let (below, above) = desk.nets.split_at_mut(start + size);
            let below = &mut below[start..];
            match direction {
                Direction::U => halve(above, below, p, q + 1, 0..=q),
                Direction::V => halve(above, below, q, 1, (0..=p).map(|row| row * (q + 1))),
            }
        }
    }

    /// Looks at a piece whose net is the last on the desk: the direction to divide it in, or, if it
    /// need not be, appends it.
    #[inline(always)]
    fn unmet<S: Simd>(
        &self,
        simd: S,
        (block, piece): (Block, Piece),
        desk: &mut Desk,
        done: &mut Vec<Piece>,
    ) -> Option<Direction> {
        let degrees = self.nets.degrees;
        let (tolerance, divisible) = (self.limits.tolerance, piece.divisible());
        let net = &desk.nets[desk.nets.len() - (degrees.0 + 1) * (degrees.1 + 1)..];
        desk.points.clear();
        desk.points.extend(net.iter().map(|h| h.project()));
        let bending = Bending::of(&desk.points, degrees);
        // What is expected to leave its triangles too far is not looked at closer.
        if divisible && bending.sag_of_square() > tolerance {
            return Some(self.steeper(&desk.points));
        }
        let ends = self.ends().map(|k| desk.points[k]);
        let corners = [0, 1, 2, 3].map(|k| Corner { at: UNIT[k], point: ends[k] });
        let cut = Zip::best(&corners, [0, 1, 2, 3], bending, tolerance);
        desk.faces.clear();
        cut.faces([0, 1, 2, 3], &mut desk.faces);
        let mesh = (&corners[..], &desk.faces[..]);
        let work = &mut desk.work;
        let distance = if work.begin(mesh) {
            let whole = Part::whole(Net::single(net, degrees));
            work.certify(self.bernstein, whole, mesh, tolerance).with_simd(simd)
        } else {
            certify::ball(Net::single(net, degrees), mesh)
        };
        let direction = if distance <= tolerance {
            self.beyond(block, &piece.corners(), mesh)
        } else {
            Some(self.steeper(&desk.points))
        };
        let direction = direction.filter(|_| divisible);
        if direction.is_none() {
            desk.deviation = desk.deviation.max(distance);
            done.push(Piece { cut: cut.proven(distance / tolerance), ..piece });
        }
        direction
    }

    /// Where the corners of the unit square stand in a net, counter-clockwise.
    #[inline(always)]
    fn ends(&self) -> [usize; 4] {
        let (p, q) = (self.bernstein.p, self.bernstein.q);
        [0, p * (q + 1), (p + 1) * (q + 1) - 1, q]
    }

    /// The direction whose curves bend more, or, if neither does, are longer.
    #[inline(always)]
    fn steeper(&self, points: &[DVec3]) -> Direction {
        let (p, q) = (self.bernstein.p, self.bernstein.q);
        let (mut u, mut v) = (Line::default(), Line::default());
        for j in 0..=q {
            u.add(points, (j, q + 1), p);
        }
        for i in 0..=p {
            v.add(points, (i * (q + 1), 1), q);
        }
        let bent = u.sag.max(v.sag) > (self.limits.tolerance / 4.0).powi(2);
        if if bent { u.sag >= v.sag } else { u.length >= v.length } {
            Direction::U
        } else {
            Direction::V
        }
    }

    /// The direction to divide a piece in because its triangles do not meet the limits of edges,
    /// angles and sides.
    fn beyond(
        &self,
        block: Block,
        places: &[Place],
        (corners, faces): Faces<'_>,
    ) -> Option<Direction> {
        if self.limits.only_distance() {
            return None;
        }
        let Limits { cosine, edge, aspect, .. } = self.limits;
        let [a, b, c, d] = UNIT.map(|at| corners.iter().position(|corner| corner.at == at));
        let (a, b, c, d) = (a?, b?, c?, d?);
        let length = |i: usize, j: usize| corners[i].point.distance(corners[j].point);
        let (along_u, along_v) = (length(a, b) + length(d, c), length(a, d) + length(b, c));
        let longer = if along_u >= along_v { Direction::U } else { Direction::V };
        let edges = || faces.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
        if edge.is_some_and(|most| edges().any(|(i, j)| length(i, j) > most)) {
            return Some(longer);
        }
        let (short, long) = (along_u.min(along_v), along_u.max(along_v));
        if aspect.is_some_and(|most| short > 0.0 && long > most * short) {
            return Some(longer);
        }
        let least = cosine?;
        let normal = |&(u, v): &Place| {
            let u = parameter(&self.nets.u, block.rows.0, u);
            self.surface.normal(u, parameter(&self.nets.v, block.cols.0, v))
        };
        let normals: Vec<DVec3> = places.iter().map(normal).collect();
        let turn = |i: usize, j: usize| normals[i].dot(normals[j]);
        let turned = edges().any(|(i, j)| turn(i, j) < least && length(i, j) > 0.0);
        let in_u = turn(a, b) + turn(d, c) <= turn(a, d) + turn(b, c);
        turned.then_some(if in_u { Direction::U } else { Direction::V })
    }

    /// Cuts a piece with all the vertices on its outline into triangles. The direction to divide it
    /// in because they do not meet the limits, or because they are too many; `None` if they do.
    pub(super) fn check(
        &self,
        block: Block,
        piece: &mut Piece,
        outline: &[Place],
        desk: &mut Desk,
    ) -> Option<Direction> {
        if outline.len() > MOST_CORNERS {
            self.load(block, *piece, desk);
            return Some(self.steeper(&desk.points));
        }
        let ends = piece.ends(outline.iter().copied());
        let share = piece.cut.share().filter(|share| outline.len() > 4 && *share < GROWS);
        let share = share.filter(|_| self.limits.only_distance());
        if let Some(share) = share {
            self.place((block, *piece), outline, false, desk);
            if self.grow(piece, ends, share, desk) {
                return None;
            }
        }
        self.load(block, *piece, desk);
        let tolerance = self.limits.tolerance;
        let bending = Bending::of(&desk.points, self.nets.degrees);
        // What is expected to leave its triangles too far is not looked at closer.
        if piece.divisible() && bending.sag_of_square() > tolerance {
            return Some(self.steeper(&desk.points));
        }
        if share.is_none() {
            self.place((block, *piece), outline, true, desk);
        }
        let Desk { arch, nets, points, part, corners, faces, work, deviation, .. } = desk;
        let single = piece.is_single();
        let cut = Zip::best(corners, ends, bending, tolerance);
        faces.clear();
        cut.faces(ends, faces);
        let mesh = (&corners[..], &faces[..]);
        let distance = if !single {
            self.distance_of_patches(block, (*piece, points), mesh, (*arch, part, work))
        } else if work.begin(mesh) {
            let whole = Part::whole(Net::single(nets, self.nets.degrees));
            arch.dispatch(work.certify(self.bernstein, whole, mesh, tolerance))
        } else {
            certify::ball(Net::single(nets, self.nets.degrees), mesh)
        };
        let direction = if distance <= tolerance {
            self.beyond(block, outline, mesh)
        } else {
            Some(self.steeper(points))
        };
        let direction = direction.filter(|_| piece.divisible());
        if direction.is_none() {
            piece.cut = cut.proven(distance / tolerance);
            *deviation = deviation.max(distance);
        }
        direction
    }

    /// Puts the corners of an outline on the desk; those of the piece are known if it is loaded.
    fn place(
        &self,
        (block, piece): (Block, Piece),
        outline: &[Place],
        loaded: bool,
        desk: &mut Desk,
    ) {
        desk.corners.clear();
        for &(u, v) in outline {
            let at = DVec2::new(share(u, piece.u), share(v, piece.v));
            let end = UNIT.iter().position(|corner| *corner == at).filter(|_| loaded);
            let point = match end {
                Some(end) => desk.points[self.ends()[end]],
                None => self.point(block, (u, v)).project(),
            };
            desk.corners.push(Corner { at, point });
        }
    }

    /// Whether the triangles that a piece was proven with hold with new vertices on its sides: then it
    /// is cut into triangles with them.
    ///
    /// Triangles that keep the edge between the two come from them by moving the new vertices off
    /// their sides. No point moves further than these do, so neither does the distance from the
    /// surface grow by more.
    fn grow(
        &self,
        piece: &mut Piece,
        ends: [usize; 4],
        share: f64,
        Desk { corners, faces, work, deviation, .. }: &mut Desk,
    ) -> bool {
        let tolerance = self.limits.tolerance;
        let mut moved = 0.0;
        for (k, &start) in ends.iter().enumerate() {
            let (end, last) = match ends.get(k + 1) {
                Some(&end) => (end, end),
                None => (0, corners.len()),
            };
            let side = Chord::new(corners[start].point, corners[end].point);
            for corner in &corners[start + 1..last] {
                moved = larger(moved, side.squared(corner.point));
            }
        }
        let distance = share * tolerance + moved.sqrt();
        if distance > tolerance {
            return false;
        }
        let cut = piece.cut.grown(corners, ends);
        faces.clear();
        cut.faces(ends, faces);
        let sheet = work.begin((&corners[..], &faces[..]));
        if sheet {
            piece.cut = cut;
            *deviation = deviation.max(distance);
        }
        sheet
    }

    /// The certified distance of a piece of several patches, on which these points lie, or anything
    /// above the tolerance.
    fn distance_of_patches(
        &self,
        block: Block,
        (piece, points): (Piece, &[DVec3]),
        mesh: Faces<'_>,
        (arch, net, work): (Arch, &mut Vec<DVec4>, &mut Workspace),
    ) -> f64 {
        let limit = self.limits.tolerance;
        if !work.begin(mesh) || work.misses(points, mesh, limit) {
            return f64::INFINITY;
        }
        let mut most = 0.0;
        for of_piece in piece.parts() {
            net.clear();
            let part = self.part(block, &of_piece, net);
            most = arch.dispatch(work.certify(self.bernstein, part, mesh, limit));
            if most > limit {
                break;
            }
        }
        most
    }

    /// A part of a piece, whose control points are appended to `points`, where nothing else is.
    fn part<'a>(&self, block: Block, part: &piece::Part, points: &'a mut Vec<DVec4>) -> Part<'a> {
        let piece::Part { rows, cols, u, v, low, high } = part;
        let move_by = |range: &Range<usize>, by: usize| range.start + by..range.end + by;
        let (rows, cols) = (move_by(rows, block.rows.0), move_by(cols, block.cols.0));
        let (patches, degrees) = ((rows.len(), cols.len()), self.nets.degrees);
        self.nets.append(rows, cols, points);
        self.bernstein.rectangle(points, patches.1 * degrees.1 + 1, *u, *v);
        Part { low: *low, high: *high, net: Net { points, patches, degrees } }
    }

    /// Makes the net of a piece the only one on the desk; of several patches only points, between
    /// which it bends about as the piece does.
    fn load(&self, block: Block, piece: Piece, desk: &mut Desk) {
        desk.nets.clear();
        desk.points.clear();
        if piece.is_single() {
            for part in piece.parts() {
                self.part(block, &part, &mut desk.nets);
            }
            desk.points.extend(desk.nets.iter().map(|h| h.project()));
            return;
        }
        let (p, q) = self.nets.degrees;
        let place = |(from, to): (u32, u32), k: usize, n: usize| {
            if k == n {
                return to;
            }
            let step = if to - from > PATCH { PATCH } else { 1 };
            let steps = ((to - from) / step) as usize * k / n;
            from + u32::try_from(steps).unwrap_or(0) * step
        };
        desk.columns.clear();
        desk.columns.extend((0..=q).map(|j| located(place(piece.v, j, q), block.cols.0, q)));
        for i in 0..=p {
            let row = located(place(piece.u, i, p), block.rows.0, p);
            for col in &desk.columns {
                let h = self.nets.point(row.shares(), col.shares());
                desk.points.push(h.w.recip() * h.truncate());
            }
        }
    }

    /// The homogeneous point at a place of a block.
    fn point(&self, block: Block, (u, v): Place) -> DVec4 {
        let (p, q) = self.nets.degrees;
        let (row, col) = (located(u, block.rows.0, p), located(v, block.cols.0, q));
        self.nets.point(row.shares(), col.shares())
    }

    /// Divides a piece that has become unfit in this direction first.
    pub(super) fn redivide(
        &self,
        block: Block,
        (piece, direction): (Piece, Direction),
        desk: &mut Desk,
        done: &mut Vec<Piece>,
    ) {
        for half in piece.halves(direction) {
            self.divide(block, half, desk, done);
        }
    }
}

/// [`Divider::divide_net`] in registers of any width.
struct DivideNet<'a> {
    divider: &'a Divider<'a>,
    block: Block,
    piece: Piece,
    desk: &'a mut Desk,
    done: &'a mut Vec<Piece>,
}

impl WithSimd for DivideNet<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { divider, block, piece, desk, done } = self;
        divider.divide_net(simd, (block, piece), desk, done);
    }
}

/// Where a place of a block lies along one direction of the nets.
#[derive(Debug)]
enum Located {
    /// Between patches: at this control point.
    Between(usize),
    /// Inside a patch: its first control point, and how much of each.
    Inside(usize, Row, usize),
}

impl Located {
    /// The first control point, and how much of each from there on.
    fn shares(&self) -> (usize, &[f64]) {
        match self {
            Self::Between(at) => (*at, &[1.0]),
            Self::Inside(start, row, order) => (*start, &row[..*order]),
        }
    }
}

/// Where a place of a block lies that begins with this row or column of patches.
fn located(place: u32, first: usize, degree: usize) -> Located {
    let (patch, rest) = (first + (place / PATCH) as usize, place % PATCH);
    if rest == 0 {
        return Located::Between(patch * degree);
    }
    let row = polynomials(degree, f64::from(rest) / f64::from(PATCH));
    Located::Inside(patch * degree, row, degree + 1)
}

/// The share of a range that lies before x.
fn share(x: u32, (from, to): (u32, u32)) -> f64 {
    f64::from(x - from) / f64::from(to - from)
}

/// Squares of the largest length of some curves' chords, and of the largest distance of their
/// control points from these.
#[derive(Default)]
struct Line {
    length: f64,
    sag: f64,
}

impl Line {
    /// Takes a curve into account whose control points follow one another by `stride`.
    #[inline(always)]
    fn add(&mut self, points: &[DVec3], (start, stride): (usize, usize), degree: usize) {
        let a = points[start];
        let chord = points[start + degree * stride] - a;
        let length = chord.length_squared();
        let along = chord / length.sqrt().max(f64::MIN_POSITIVE);
        self.length = self.length.max(length);
        for k in 1..degree {
            let away = points[start + k * stride] - a;
            self.sag = larger(self.sag, (away - away.dot(along) * along).length_squared());
        }
    }
}
