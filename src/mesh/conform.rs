//! How pieces come to fit their neighbours: corners on a piece's sides become corners of its
//! triangles, and a piece that these do not meet is divided, until nothing changes.

use super::adaptive::{Tessellation, too_many};
use super::desk::Desk;
use super::groups::{COLLECTED, FEW, in_groups};
use super::options::TessellateOptions;
use super::piece::Piece;
use super::review::{Divided, Room, Run};
use super::stitch::{Vertices, own_borders};
use crate::error::Result;
use crate::progress::Observer;

/// Jobs that a review worth sharing is done in at least, as long as they have enough pieces.
const RUNS: usize = 32;

/// Pieces that a thread reviews at a time at least.
const LEAST_AT_ONCE: usize = 4;

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
            let divided = self.review_all(&pending, observer)?;
            let blocks = divided.chunk_by(|a, b| a.block == b.block);
            let blocks: Vec<usize> = blocks.map(|divided| divided[0].block).collect();
            self.replace_all(&divided, observer)?;
            pending.fill(false);
            for index in blocks {
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

    /// Looks at the pieces of pending blocks; what has been divided, block by block.
    fn review_all(
        &mut self,
        pending: &[bool],
        observer: &mut dyn Observer,
    ) -> Result<Vec<Divided>> {
        let pending = || (0..pending.len()).filter(|&index| pending[index]);
        let count = pending().map(|index| self.pieces[index].len()).sum::<usize>();
        let at_once = if 2 * count > FEW { (count / RUNS).max(LEAST_AT_ONCE) } else { count };
        let split: Vec<usize> =
            pending().filter(|&index| self.pieces[index].len() > at_once).collect();
        let vertices = self.vertices_of(&split, observer)?;
        // Blocks change where they are: there is not room for a large mesh's pieces twice.
        let mut pieces = std::mem::take(&mut self.pieces);
        let (mut runs, mut left) = (vec![], pieces.iter_mut().enumerate());
        let mut vertices = split.iter().zip(&vertices).peekable();
        for block in pending() {
            let Some((_, pieces)) = left.find(|(index, _)| *index == block) else { continue };
            let vertices = vertices.next_if(|(index, _)| **index == block).map(|(_, found)| found);
            let run = |(k, pieces)| Run { block, first: k * at_once, pieces, vertices };
            runs.extend(pieces.chunks_mut(at_once).enumerate().map(run));
        }
        let review = |room: &mut Room, run: Run<'_>| {
            Desk::with(|desk: &mut Desk| self.review(desk, room, run))
        };
        let (mut all, mut deviation) = (vec![], self.deviation);
        let result = in_groups(runs, 2 * count, observer, review, |(divided, most)| {
            deviation = deviation.max(most);
            all.extend((!divided.is_empty()).then_some(divided));
            Ok(())
        });
        (self.pieces, self.deviation) = (pieces, deviation);
        result.map(|()| all)
    }

    /// The vertices of blocks that several threads look at.
    fn vertices_of(&self, blocks: &[usize], observer: &mut dyn Observer) -> Result<Vec<Vertices>> {
        let collect = |(): &mut (), index: usize| {
            let mut vertices = Vertices::default();
            vertices.collect(self.lattice.block(index), &self.pieces[index], self.sides(index));
            vertices
        };
        let mut all = Vec::with_capacity(blocks.len());
        let count = blocks.iter().map(|&index| self.pieces[index].len()).sum::<usize>();
        in_groups(blocks.iter().copied(), count / COLLECTED, observer, collect, |vertices| {
            all.push(vertices);
            Ok(())
        })?;
        Ok(all)
    }

    /// Puts the parts of divided pieces in their places.
    fn replace_all(&mut self, all: &[Divided], observer: &mut dyn Observer) -> Result<()> {
        let mut groups = all.chunk_by(|a, b| a.block == b.block).peekable();
        let blocks = self.pieces.iter_mut().enumerate();
        let blocks: Vec<(&[Divided], &mut Vec<Piece>)> = blocks
            .filter_map(|(index, pieces)| {
                Some((groups.next_if(|group| group[0].block == index)?, pieces))
            })
            .collect();
        let count = all.iter().map(Divided::parts).sum();
        let replace = |(): &mut (), (all, pieces): (&[Divided], _)| Divided::replace(all, pieces);
        in_groups(blocks, count, observer, replace, Ok)
    }
}
