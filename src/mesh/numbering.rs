//! The numbers of vertices and triangles.
//!
//! First come the corners of blocks, then their borders, then what is inside. So every block can
//! tell the numbers of all its vertices without the others, and neighbours tell the same ones.

use glam::DVec2;

use super::adaptive::Tessellation;
use super::piece::Piece;
use super::stitch::{Vertices, parameter};

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
    pub(super) fn number(&mut self, split: bool) {
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
        for index in 0..self.lattice.blocks() {
            let (inside, faces) = self.count(index);
            vertices.push(vertices[index] + inside);
            triangles.push(triangles[index] + faces);
        }
        (self.numbers.vertices, self.numbers.triangles) = (vertices, triangles);
    }

    /// The inner vertices and the triangles of a block.
    fn count(&self, index: usize) -> (usize, usize) {
        let triangles = self.pieces[index].iter().map(|piece| piece.cut.corners() - 2);
        let (triangles, sides) = (triangles.sum::<usize>(), self.sides(index).map(<[u32]>::len));
        let border = 4 + sides.iter().sum::<usize>();
        // A triangulated disc has two triangles for each inner vertex and one for each vertex of
        // its border, but for two.
        let inside = (triangles + 2 - border) / 2;
        // Triangles of which two corners are the same pole are left out: one at each edge there.
        let (i, j) = self.lattice.at(index);
        let lattice = &self.lattice;
        let poles = [
            lattice.is_pole_u(i),
            lattice.is_pole_u(i + 1),
            lattice.is_pole_v(j),
            lattice.is_pole_v(j + 1),
        ];
        let collapsed = poles.iter().zip(sides).filter(|(pole, _)| **pole).map(|(_, n)| n + 1);
        (inside, triangles - collapsed.sum::<usize>())
    }

    /// The numbers of a block's vertices, in order of their places.
    pub(super) fn names(
        &self,
        vertices: &Vertices,
        index: usize,
        mut inner: u32,
        names: &mut Vec<u32>,
    ) {
        let (_, cols) = self.lattice.shape();
        let (i, j) = self.lattice.at(index);
        let whole = Piece::of(self.lattice.block(index));
        let numbers = &self.numbers;
        let sides = self.sides(index);
        let border = |(first, pole): (u32, bool), places: &[u32], place: u32| {
            if pole { first } else { first + number_of(places.partition_point(|&at| at < place)) }
        };
        names.clear();
        names.extend(vertices.places().map(|(u, v)| {
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
