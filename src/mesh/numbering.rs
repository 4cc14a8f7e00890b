//! The numbers of vertices and triangles.
//!
//! First come the corners of blocks, then their borders, then what is inside. So every block can
//! tell the numbers of all its vertices without the others, and neighbours tell the same ones.

use glam::DVec2;

use super::adaptive::{Local, Tessellation, in_groups};
use super::piece::Piece;
use super::stitch::parameter;
use crate::error::Result;
use crate::progress::Observer;

/// The numbers of vertices and triangles.
#[derive(Debug, Default)]
pub(super) struct Numbers {
    /// Of the corners of blocks, row by row.
    pub corners: Vec<u32>,
    /// Of the first vertex of each border, and whether they all are that one (a pole).
    pub across_u: Vec<(u32, bool)>,
    pub across_v: Vec<(u32, bool)>,
    /// Where the vertices of borders are in the parameters, in order.
    pub on_borders: Vec<DVec2>,
    /// The first inner vertex of each block, and the end.
    pub vertices: Vec<usize>,
    /// The first triangle of each block, and the end.
    pub triangles: Vec<usize>,
}

impl Tessellation<'_> {
    /// Gives numbers to vertices and triangles: first to the corners of blocks, then to their
    /// borders, then to what is inside.
    pub(super) fn number(&mut self, split: bool, observer: &mut dyn Observer) -> Result<()> {
        let lattice = &self.lattice;
        let (rows, cols) = lattice.shape();
        let closed = if split { (false, false) } else { lattice.closed };
        let mut numbers = Numbers::default();
        let next = |numbers: &Numbers| number_of(numbers.on_borders.len());
        let (u, v) = (
            |line: usize| lattice.nets.u[lattice.u[line]],
            |line: usize| lattice.nets.v[lattice.v[line]],
        );
        for (i, j) in (0..=rows).flat_map(|i| (0..=cols).map(move |j| (i, j))) {
            let owner = lattice.owner((i, j), closed);
            let number = if owner == (i, j) {
                numbers.on_borders.push(DVec2::new(u(i), v(j)));
                next(&numbers) - 1
            } else {
                numbers.corners[owner.0 * (cols + 1) + owner.1]
            };
            numbers.corners.push(number);
        }
        for (i, j) in (0..=rows).flat_map(|i| (0..cols).map(move |j| (i, j))) {
            let entry = if lattice.is_pole_u(i) {
                (numbers.corners[i * (cols + 1) + j], true)
            } else if i == rows && closed.0 {
                numbers.across_u[j]
            } else {
                let first = next(&numbers);
                let border = self.borders.at(self.borders.line_u(i, j));
                let at = |&place: &u32| parameter(&lattice.nets.v, lattice.v[j], place);
                numbers.on_borders.extend(border.iter().map(|place| DVec2::new(u(i), at(place))));
                (first, false)
            };
            numbers.across_u.push(entry);
        }
        for (i, j) in (0..rows).flat_map(|i| (0..=cols).map(move |j| (i, j))) {
            let entry = if lattice.is_pole_v(j) {
                (numbers.corners[i * (cols + 1) + j], true)
            } else if j == cols && closed.1 {
                numbers.across_v[i * (cols + 1)]
            } else {
                let first = next(&numbers);
                let border = self.borders.at(self.borders.line_v(i, j));
                let at = |&place: &u32| parameter(&lattice.nets.u, lattice.u[i], place);
                numbers.on_borders.extend(border.iter().map(|place| DVec2::new(at(place), v(j))));
                (first, false)
            };
            numbers.across_v.push(entry);
        }
        self.numbers = numbers;
        let (mut vertices, mut triangles) = (vec![self.numbers.on_borders.len()], vec![0]);
        let count = |local: &mut Local, index: usize| self.count(local, index);
        in_groups(0..lattice.blocks(), observer, count, |(inside, faces)| {
            vertices.push(vertices[vertices.len() - 1] + inside);
            triangles.push(triangles[triangles.len() - 1] + faces);
            Ok(())
        })?;
        (self.numbers.vertices, self.numbers.triangles) = (vertices, triangles);
        Ok(())
    }

    /// The inner vertices and the triangles of a block.
    fn count(&self, local: &mut Local, index: usize) -> (usize, usize) {
        let pieces = &self.pieces[index];
        local.vertices.collect(self.lattice.block(index), pieces, self.sides(index));
        let on_borders = 4 + self.sides(index).iter().map(|side| side.len()).sum::<usize>();
        self.names(local, index, number_of(self.numbers.on_borders.len()));
        let mut triangles = 0;
        for piece in pieces {
            local.outline.clear();
            local.vertices.outline(piece, &mut local.outline);
            let name = |k: usize| local.numbers[local.outline[k % local.outline.len()].0 as usize];
            let n = local.outline.len();
            // At a pole, triangles of which two corners are the pole are left out.
            let collapsed = if self.lattice.has_poles() {
                (0..n).filter(|&k| name(k) == name(k + 1)).count()
            } else {
                0
            };
            triangles += n - 2 - collapsed;
        }
        (local.vertices.places().len() - on_borders, triangles)
    }

    /// Puts the numbers of a block's vertices on the desk, in order of their places.
    pub(super) fn names(&self, local: &mut Local, index: usize, mut inner: u32) {
        let (_, cols) = self.lattice.shape();
        let (i, j) = (index / cols, index % cols);
        let whole = Piece::of(self.lattice.block(index));
        let numbers = &self.numbers;
        let sides = self.sides(index);
        let border = |(first, pole): (u32, bool), places: &[u32], place: u32| {
            if pole { first } else { first + number_of(places.partition_point(|&at| at < place)) }
        };
        local.numbers.clear();
        local.numbers.extend(local.vertices.places().iter().map(|&(u, v)| {
            let (last_u, last_v) = (u == whole.u.1, v == whole.v.1);
            let (on_u, on_v) = (u == 0 || last_u, v == 0 || last_v);
            let (line_u, line_v) = (i + usize::from(last_u), j + usize::from(last_v));
            match (on_u, on_v) {
                (true, true) => numbers.corners[line_u * (cols + 1) + line_v],
                (true, false) => {
                    border(numbers.across_u[line_u * cols + j], sides[usize::from(last_u)], v)
                }
                (false, true) => {
                    let side = sides[2 + usize::from(last_v)];
                    border(numbers.across_v[i * (cols + 1) + line_v], side, u)
                }
                (false, false) => {
                    inner += 1;
                    inner - 1
                }
            }
        }));
    }
}

/// A vertex number; the limit on triangles keeps them below 2^32.
pub(super) fn number_of(index: usize) -> u32 {
    u32::try_from(index).unwrap_or(u32::MAX)
}
