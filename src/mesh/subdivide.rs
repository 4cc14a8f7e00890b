//! How a block is divided into pieces.
//!
//! A piece that its triangles do not meet within the limits is halved, across the direction that
//! bends more; one of several patches, between patches.

#![expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]

use std::ops::Range;

use glam::{DVec2, DVec3, DVec4};
use pulp::{Simd, WithSimd};

use super::bernstein::{Bernstein, UNIT};
use super::certify::{self, Corner, Faces, Part};
use super::desk::Desk;
use super::located::Located;
use super::net::Net;
use super::options::Limits;
use super::outline::Zip;
use super::piece::{self, Block, Direction, PATCH, Piece};
use super::stitch::{Place, parameter};
use super::triangle::larger;
use crate::nurbs::{Bending, MAX_ORDER, NurbsSurface, PatchNets, halve, in_space};

/// What dividing needs to know.
#[derive(Debug)]
pub(super) struct Divider<'a> {
    pub surface: &'a NurbsSurface,
    pub nets: &'a PatchNets,
    pub bernstein: &'a Bernstein,
    pub limits: Limits,
}

/// Patches along a direction from which on a piece is looked at in four places there, not in three.
/// Most pieces of several patches are of two or three, and will be divided.
const MANY: u32 = 16;

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

    /// Halves a piece of several patches, at most so many times, as long as it is expected to be halved
    /// by [`Divider::divide`], and appends the parts.
    pub(super) fn spread(
        &self,
        block: Block,
        (piece, halvings): (Piece, u32),
        desk: &mut Desk,
        parts: &mut Vec<Piece>,
    ) {
        if halvings > 0 && !piece.is_single() {
            self.load(block, piece, desk);
            if let (Some(direction), _) = self.bent(&piece, &desk.points) {
                for half in piece.halves(direction) {
                    self.spread(block, (half, halvings - 1), desk, parts);
                }
                return;
            }
        }
        parts.push(piece);
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
        let tolerance = self.limits.tolerance;
        let net = &desk.nets[desk.nets.len() - (degrees.0 + 1) * (degrees.1 + 1)..];
        desk.points.clear();
        desk.points.extend(net.iter().map(|h| in_space(*h)));
        let (bent, bending) = self.bent(&piece, &desk.points);
        if bent.is_some() {
            return bent;
        }
        let ends = self.ends(&piece).map(|k| desk.points[k].truncate());
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
        let direction =
            self.unfit((block, piece), &piece.corners(), mesh, (distance, &desk.points));
        if direction.is_none() {
            desk.deviation = desk.deviation.max(distance);
            done.push(Piece { cut: cut.proven(distance / tolerance), ..piece });
        }
        direction
    }

    /// The direction to divide a piece in because it is expected to leave its triangles too far, so
    /// that it is not looked at closer, and how it bends.
    #[inline(always)]
    pub(super) fn bent(&self, piece: &Piece, points: &[DVec4]) -> (Option<Direction>, Bending) {
        let bending = if piece.is_single() {
            Bending::of(points, self.nets.degrees)
        } else {
            Bending::through(points, self.degrees(piece))
        };
        if piece.divisible() && bending.sag_of_square() > self.limits.tolerance {
            return (Some(self.steeper(piece, points)), bending);
        }
        (None, bending)
    }

    /// The direction to divide a piece in because its triangles, which are so far from the surface, do
    /// not meet the limits; `None` if they do, or it cannot be divided.
    #[inline(always)]
    pub(super) fn unfit(
        &self,
        (block, piece): (Block, Piece),
        places: &[Place],
        mesh: Faces<'_>,
        (distance, points): (f64, &[DVec4]),
    ) -> Option<Direction> {
        let direction = if distance <= self.limits.tolerance {
            self.beyond(block, places, mesh)
        } else {
            Some(self.steeper(&piece, points))
        };
        direction.filter(|_| piece.divisible())
    }

    /// The degrees of the net that a piece is loaded as. Of several patches, that has points of the
    /// surface in place of control points: at the ends and, evenly spaced, between.
    #[inline(always)]
    fn degrees(&self, piece: &Piece) -> (usize, usize) {
        if piece.is_single() {
            return self.nets.degrees;
        }
        let seen = |(from, to): (u32, u32)| if (to - from) / PATCH < MANY { 2 } else { 3 };
        (seen(piece.u), seen(piece.v))
    }

    /// Where the corners of the unit square stand in a net, counter-clockwise.
    #[inline(always)]
    pub(super) fn ends(&self, piece: &Piece) -> [usize; 4] {
        let (p, q) = self.degrees(piece);
        [0, p * (q + 1), (p + 1) * (q + 1) - 1, q]
    }

    /// The direction whose curves bend more, or, if neither does, are longer.
    #[inline(always)]
    pub(super) fn steeper(&self, piece: &Piece, points: &[DVec4]) -> Direction {
        let (p, q) = self.degrees(piece);
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

    /// A part of a piece, whose control points are appended to `points`, where nothing else is.
    pub(super) fn part<'a>(
        &self,
        block: Block,
        part: &piece::Part,
        points: &'a mut Vec<DVec4>,
    ) -> Part<'a> {
        let piece::Part { rows, cols, u, v, low, high } = part;
        let move_by = |range: &Range<usize>, by: usize| range.start + by..range.end + by;
        let (rows, cols) = (move_by(rows, block.rows.0), move_by(cols, block.cols.0));
        let (patches, degrees) = ((rows.len(), cols.len()), self.nets.degrees);
        self.nets.append(rows, cols, points);
        self.bernstein.rectangle(points, patches.1 * degrees.1 + 1, *u, *v);
        Part { low: *low, high: *high, net: Net { points, patches, degrees } }
    }

    /// Makes the net of a piece the only one on the desk.
    pub(super) fn load(&self, block: Block, piece: Piece, desk: &mut Desk) {
        desk.nets.clear();
        desk.points.clear();
        if piece.is_single() {
            for part in piece.parts() {
                self.part(block, &part, &mut desk.nets);
            }
            desk.points.extend(desk.nets.iter().map(|h| in_space(*h)));
            return;
        }
        let (p, q) = self.nets.degrees;
        let seen = self.degrees(&piece);
        let (Desk { points, places, columns, .. }, mut row) = (desk, Located::default());
        let (columns, mut across) = (&mut columns[..=seen.1], [0.0; MAX_ORDER]);
        for (j, (column, y)) in columns.iter_mut().zip(&mut across).enumerate() {
            let at = sample(piece.v, j, seen.1);
            column.find(at, block.cols.0, q);
            *y = share(at, piece.v);
        }
        places.clear();
        for i in 0..=seen.0 {
            let at = sample(piece.u, i, seen.0);
            row.find(at, block.rows.0, p);
            let x = share(at, piece.u);
            places.extend(across[..=seen.1].iter().map(|y| DVec2::new(x, *y)));
            let point = |column: &Located| self.nets.point(row.shares(), column.shares());
            points.extend(columns.iter().map(|column| in_space(point(column))));
        }
    }

    /// The homogeneous point at a place of a block.
    pub(super) fn point(&self, block: Block, (u, v): Place) -> DVec4 {
        let (p, q) = self.nets.degrees;
        let (row, col) = (Located::of(u, block.rows.0, p), Located::of(v, block.cols.0, q));
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

/// The k-th of n + 1 places in a range, which is that of a border of patches if it has several.
fn sample((from, to): (u32, u32), k: usize, n: usize) -> u32 {
    if k == n {
        return to;
    }
    let step = if to - from > PATCH { PATCH } else { 1 };
    let steps = ((to - from) / step) as usize * k / n;
    from + u32::try_from(steps).unwrap_or(0) * step
}

/// The share of a range that lies before x.
pub(super) fn share(x: u32, (from, to): (u32, u32)) -> f64 {
    f64::from(x - from) / f64::from(to - from)
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
    fn add(&mut self, points: &[DVec4], (start, stride): (usize, usize), degree: usize) {
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
