//! The normal equations of a fit, as sums over points and spans.
//!
//! A point touches (degree + 1)² control points and adds a block of products of its basis
//! functions. Points are sorted by the cells of the knots; each cell's block is one sum, made by
//! one owner in one order, and the blocks are added to the matrix in the order of the cells: any
//! number of threads gives the same bits.

use glam::{DVec2, DVec3};
use pulp::Arch;
use rayon::prelude::*;

use super::POINTS_PER_LOOK;
use super::band::Band;
use super::space::SplineSpace;
use crate::error::Result;
use crate::nurbs::{Basis, MAX_ORDER, padded};
use crate::progress::Listen;

/// Points to a task: enough to be worth its block, few enough that a crowded cell is shared.
const POINTS_PER_TASK: usize = 2048;

/// Numbers in the blocks that are held at a time, 32 MB.
const BLOCK_NUMBERS: usize = 1 << 22;

/// Products that are added up between two looks at the observer: tens of milliseconds.
const PRODUCTS: usize = 1 << 27;

/// A point and how its distance from the surface counts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub(super) point: DVec3,
    pub(super) uv: DVec2,
    pub(super) weight: f64,
    /// The unit normal along which distances count in full.
    pub(super) normal: DVec3,
    /// The share with which they count across it.
    pub(super) tangential: f64,
}

/// Matrix and right-hand side of a fit of control points to samples.
pub(super) struct NormalEquations {
    pub(super) matrix: Band,
    pub(super) right: Vec<[f64; 3]>,
}

/// Pairs of coordinates in the order in which a block holds them.
const PAIRS: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];

impl NormalEquations {
    /// Of distances that count alike in all directions: one matrix serves x, y and z.
    pub(super) fn of_distances(
        space: &SplineSpace,
        samples: &[Sample],
        listen: &mut Listen<'_>,
    ) -> Result<Self> {
        let coefficients = |sample: &Sample| ([sample.weight], sample.weight * sample.point);
        let mut equations = Self::empty(space, 1);
        equations.add(space, samples, coefficients, listen, |matrix, [a, b], block, _, at| {
            matrix.add(a, b, block[at]);
        })?;
        Ok(equations)
    }

    /// Of distances that count in full along normals alone: x, y and z are coupled.
    pub(super) fn of_tangent_distances(
        space: &SplineSpace,
        samples: &[Sample],
        listen: &mut Listen<'_>,
    ) -> Result<Self> {
        let coefficients = |sample: &Sample| {
            let (normal, rest) = (sample.normal.to_array(), sample.tangential);
            let metric = PAIRS.map(|(a, b)| {
                let along = (1.0 - rest) * normal[a] * normal[b];
                sample.weight * if a == b { along + rest } else { along }
            });
            let along = (1.0 - rest) * sample.normal.dot(sample.point) * sample.normal;
            (metric, sample.weight * (along + rest * sample.point))
        };
        let mut equations = Self::empty(space, 3);
        equations.add(
            space,
            samples,
            coefficients,
            listen,
            |matrix, [a, b], block, size, at| {
                for (pair, &(r, s)) in PAIRS.iter().enumerate() {
                    let value = block[pair * size + at];
                    matrix.add(3 * a + r, 3 * b + s, value);
                    if a != b && r != s {
                        matrix.add(3 * a + s, 3 * b + r, value);
                    }
                }
            },
        )?;
        Ok(equations)
    }

    fn empty(space: &SplineSpace, components: usize) -> Self {
        let right = vec![[0.0; 3]; space.unknowns()];
        Self { matrix: space.matrix(components), right }
    }

    /// Adds the samples' blocks of `C` numbers for each pair of basis functions.
    fn add<const C: usize>(
        &mut self,
        space: &SplineSpace,
        samples: &[Sample],
        coefficients: impl Fn(&Sample) -> ([f64; C], DVec3) + Sync,
        listen: &mut Listen<'_>,
        scatter: impl Fn(&mut Band, [usize; 2], &[f64], usize, usize),
    ) -> Result<()> {
        let [p, q] = [0, 1].map(|d| space.knots[d].degree());
        let functions = (p + 1) * (q + 1);
        let size = functions * functions;
        let length = C * size + 3 * functions;
        let cells = Cells::of(space, samples, listen)?;
        let tasks = cells.tasks();
        let arch = Arch::new();
        let at_once = (PRODUCTS / (POINTS_PER_TASK * C * size)).max(rayon::current_num_threads());
        let held = (BLOCK_NUMBERS / length).clamp(1, at_once);
        let mut blocks = vec![0.0; held.min(tasks.len()) * length];
        for tasks in tasks.chunks(held) {
            listen()?;
            let blocks = &mut blocks[..tasks.len() * length];
            blocks.par_chunks_mut(length).zip(tasks).for_each(|(block, task)| {
                block.fill(0.0);
                let members = cells.order[task.points.clone()].iter();
                let members = members.map(|&index| &samples[index as usize]);
                arch.dispatch(
                    #[inline(always)]
                    || accumulate(space, members, functions, &coefficients, block),
                );
            });
            for (block, task) in blocks.chunks(length).zip(tasks) {
                let corner = cells.corner(task.cell);
                let place =
                    |k: usize| space.place(corner[0] + k / (q + 1), corner[1] + k % (q + 1));
                let places: Vec<usize> = (0..functions).map(place).collect();
                for i in 0..functions {
                    for j in i..functions {
                        let at = i * functions + j;
                        scatter(&mut self.matrix, [places[i], places[j]], block, size, at);
                    }
                    let right = &block[C * size + 3 * i..][..3];
                    self.right[places[i]].iter_mut().zip(right).for_each(|(sum, v)| *sum += v);
                }
            }
        }
        Ok(())
    }
}

/// The blocks of some samples of one cell, summed: for each coefficient the products of functions,
/// then the right-hand sides.
#[expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]
#[inline(always)]
fn accumulate<'a, const C: usize>(
    space: &SplineSpace,
    samples: impl Iterator<Item = &'a Sample>,
    functions: usize,
    coefficients: &impl Fn(&Sample) -> ([f64; C], DVec3),
    block: &mut [f64],
) {
    let [p, q] = [0, 1].map(|d| space.knots[d].degree());
    let (products, right) = block.split_at_mut(C * functions * functions);
    let mut values = [0.0; MAX_ORDER * MAX_ORDER];
    let values = &mut values[..functions];
    for sample in samples {
        if (p, q) == (3, 3) {
            let rows = Basis::<4>::at(&space.knots[0], sample.uv.x);
            let cols = Basis::<4>::at(&space.knots[1], sample.uv.y);
            outer(&rows.values, &cols.values, values);
        } else {
            let rows = padded(&space.knots[0], sample.uv.x);
            let cols = padded(&space.knots[1], sample.uv.y);
            outer(&rows.values[..=p], &cols.values[..=q], values);
        }
        let (factors, target) = coefficients(sample);
        for (products, factor) in products.chunks_exact_mut(functions * functions).zip(factors) {
            match <&[f64; BICUBIC]>::try_from(&*values) {
                Ok(values) => add_products(products, factor, values),
                Err(_) => add_any_products(products, factor, values),
            }
        }
        for (right, value) in right.chunks_exact_mut(3).zip(&*values) {
            right[0] += value * target.x;
            right[1] += value * target.y;
            right[2] += value * target.z;
        }
    }
}

/// Writes the product of each row's and each column's value.
#[expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]
#[inline(always)]
fn outer(rows: &[f64], cols: &[f64], products: &mut [f64]) {
    for (line, row) in products.chunks_exact_mut(cols.len()).zip(rows) {
        line.iter_mut().zip(cols).for_each(|(product, col)| *product = row * col);
    }
}

/// Basis functions of a bicubic patch, the case that is worth a loop of fixed length.
const BICUBIC: usize = 16;

/// Adds the products of all pairs of values, times a factor.
#[expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]
#[inline(always)]
fn add_products(products: &mut [f64], factor: f64, values: &[f64; BICUBIC]) {
    for (line, value) in products.as_chunks_mut::<BICUBIC>().0.iter_mut().zip(values) {
        let scaled = factor * value;
        for (sum, value) in line.iter_mut().zip(values) {
            *sum += scaled * value;
        }
    }
}

/// The same for any number of values.
fn add_any_products(products: &mut [f64], factor: f64, values: &[f64]) {
    for (line, value) in products.chunks_exact_mut(values.len()).zip(values) {
        let scaled = factor * value;
        for (sum, value) in line.iter_mut().zip(values) {
            *sum += scaled * value;
        }
    }
}

/// Samples by the cell between knots in which they lie, in their own order.
pub(super) struct Cells {
    pub(super) order: Vec<u32>,
    /// Where each cell's samples begin in `order`.
    pub(super) starts: Vec<usize>,
    cols: usize,
}

/// Some samples of a cell.
struct Task {
    cell: usize,
    points: std::ops::Range<usize>,
}

impl Cells {
    pub(super) fn of(
        space: &SplineSpace,
        samples: &[Sample],
        listen: &mut Listen<'_>,
    ) -> Result<Self> {
        listen()?;
        let [u, v] = &space.knots;
        let counts = [u, v].map(|knots| knots.control_points() - knots.degree());
        let cell = |sample: &Sample| {
            let (row, col) = (u.span(sample.uv.x) - u.degree(), v.span(sample.uv.y) - v.degree());
            u32::try_from(row * counts[1] + col).unwrap_or(u32::MAX)
        };
        let cells: Vec<u32> = samples.par_iter().with_min_len(POINTS_PER_TASK).map(cell).collect();
        listen()?;
        let mut starts = vec![0; counts[0] * counts[1] + 1];
        for &cell in &cells {
            starts[cell as usize + 1] += 1;
        }
        (1..starts.len()).for_each(|i| starts[i] += starts[i - 1]);
        let mut next = starts.clone();
        let mut order = vec![0; samples.len()];
        for (index, &cell) in (0_u32..).zip(&cells) {
            if (index as usize).is_multiple_of(POINTS_PER_LOOK) {
                listen()?;
            }
            order[next[cell as usize]] = index;
            next[cell as usize] += 1;
        }
        Ok(Self { order, starts, cols: counts[1] })
    }

    /// The first control point that a cell touches.
    fn corner(&self, cell: usize) -> [usize; 2] {
        [cell / self.cols, cell % self.cols]
    }

    fn tasks(&self) -> Vec<Task> {
        let tasks = self.starts.windows(2).enumerate().flat_map(|(cell, range)| {
            let (from, to) = (range[0], range[1]);
            (from..to)
                .step_by(POINTS_PER_TASK)
                .map(move |from| Task { cell, points: from..(from + POINTS_PER_TASK).min(to) })
        });
        tasks.collect()
    }
}
