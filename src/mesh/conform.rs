//! How pieces come to fit their neighbours: corners on a piece's sides become corners of its
//! triangles, and a piece that these do not meet is divided, until nothing changes.

use super::adaptive::{Tessellation, too_many};
use super::desk::Desk;
use super::groups::in_groups;
use super::options::TessellateOptions;
use super::piece::Piece;
use super::stitch::{Place, Vertices, own_borders};
use crate::error::Result;
use crate::progress::Observer;

/// Memory of a thread.
#[derive(Default)]
struct Room {
    vertices: Vertices,
    /// Numbers of vertices around a piece.
    outline: Vec<usize>,
    places: Vec<Place>,
}

impl Tessellation<'_> {
    /// Divides pieces until their triangles hold with all vertices that stand on their sides.
    pub(super) fn conform(
        &mut self,
        options: &TessellateOptions,
        observer: &mut dyn Observer,
    ) -> Result<()> {
        let mut pending = vec![true; self.lattice.blocks()];
        (0..pending.len()).for_each(|index| self.touch(index, &mut pending));
        while pending.contains(&true) {
            // Blocks change where they are: there is not room for a large mesh's pieces twice.
            let mut pieces = std::mem::take(&mut self.pieces);
            let blocks = pieces.iter_mut().enumerate().filter(|&(index, _)| pending[index]);
            let blocks: Vec<(usize, &mut Vec<Piece>)> = blocks.collect();
            let (mut divided, mut deviation) = (vec![], self.deviation);
            let count = blocks.iter().map(|(_, pieces)| pieces.len()).sum();
            let review = |room: &mut Room, (index, pieces): (usize, &mut Vec<Piece>)| {
                let review = |desk: &mut Desk| self.review(desk, room, index, pieces);
                let (changed, deviation) = Desk::with(review);
                (index, changed, deviation)
            };
            in_groups(blocks, count, observer, review, |(index, changed, most)| {
                divided.extend(changed.then_some(index));
                deviation = deviation.max(most);
                Ok(())
            })?;
            (self.pieces, self.deviation) = (pieces, deviation);
            pending.fill(false);
            for index in divided {
                pending[index] = true;
                self.touch(index, &mut pending);
            }
            let count = self.pieces.iter().map(Vec::len).sum::<usize>();
            if 2 * count > options.max_triangles {
                return Err(too_many(options, &self.limits, 2.0 * count as f64));
            }
        }
        Ok(())
    }

    /// Puts a block's vertices on its borders; the blocks beside new ones are pending.
    fn touch(&mut self, index: usize, pending: &mut [bool]) {
        let sides = own_borders(self.lattice.block(index), &self.pieces[index]);
        for (side, places) in self.borders.around(index).into_iter().zip(sides) {
            if self.borders.add(side, &places) {
                self.lattice.beside(side).into_iter().for_each(|other| pending[other] = true);
            }
        }
    }

    /// Looks at the pieces of a block that have got vertices on their sides; whether one was
    /// divided.
    fn review(
        &self,
        desk: &mut Desk,
        Room { vertices, outline, places }: &mut Room,
        index: usize,
        pieces: &mut Vec<Piece>,
    ) -> bool {
        let (block, divider) = (self.lattice.block(index), self.divider());
        vertices.collect(block, pieces, self.sides(index));
        let mut divided: Option<Vec<Piece>> = None;
        for k in 0..pieces.len() {
            let piece = &mut pieces[k];
            outline.clear();
            vertices.outline(piece, outline);
            let grown = outline.len() > piece.cut.corners();
            let unfit = if grown {
                places.clear();
                places.extend(outline.iter().map(|&rank| vertices.place(rank)));
                divider.check(block, piece, places, desk)
            } else {
                None
            };
            match (unfit, &mut divided) {
                (Some(direction), _) => {
                    let piece = *piece;
                    let new = divided.get_or_insert_with(|| pieces[..k].to_vec());
                    divider.redivide(block, (piece, direction), desk, new);
                }
                (None, Some(new)) => new.push(*piece),
                (None, None) => {}
            }
        }
        let Some(mut new) = divided else { return false };
        new.shrink_to_fit();
        *pieces = new;
        true
    }
}
