//! Normal equations of a fit, as sums over samples and cells of the knots.
//!
//! A sample touches (degree + 1)² control points and adds a block of products of their basis
//! functions. Samples are sorted by cells. One task computes the block of a cell in a fixed order,
//! and blocks are added to the matrix in the order of the cells. So any number of threads gives the
//! same bits.

use glam::{DVec2, DVec3};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::band_matrix::BandMatrix;
use super::sizes::{BATCH, CUBIC_ORDER, POINTS_PER_CALL, POINTS_PER_TASK};
use super::spline_space::SplineSpace;
use crate::error::Result;
use crate::nurbs::{MAX_ORDER, values_at, window};
use crate::progress::InterruptCheck;
use crate::worker_pool;

/// Numbers in the blocks that are summed up at a time, 16 MB.
const BLOCK_NUMBERS: usize = 1 << 21;

/// A point and the metric of its distance from the surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub(super) point: DVec3,
    pub(super) uv: DVec2,
    pub(super) weight: f64,
    /// The unit normal along which distances have full weight.
    pub(super) normal: DVec3,
    /// The relative weight of distances across it.
    pub(super) tangential: f64,
}

impl Sample {
    /// A sample for the plain distance at its parameters.
    pub(super) fn plain(point: DVec3, uv: DVec2, weight: f64) -> Self {
        Self { point, uv, weight, normal: DVec3::ZERO, tangential: 1.0 }
    }
}

/// Matrix and right-hand side of a fit of control points to samples.
#[derive(Clone)]
pub(super) struct NormalEquations {
    pub(super) matrix: BandMatrix,
    pub(super) right: Vec<[f64; 3]>,
}

/// Pairs of coordinates in the order of a block.
const PAIRS: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];

impl NormalEquations {
    /// The equations of distances with the same weight in all directions. One matrix serves x, y
    /// and z.
    pub(super) fn of_distances(
        space: &SplineSpace,
        samples: &[Sample],
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Self> {
        let coefficients = |sample: &Sample| ([sample.weight], sample.weight * sample.point);
        let mut equations = Self::empty(space, space.matrix(1));
        equations.add(
            space,
            samples,
            coefficients,
            check_interrupt,
            |matrix, [a, b], [value]| {
                matrix.add(a, b, value);
            },
        )?;
        Ok(equations)
    }

    /// The equations of distances with full weight along normals alone, which couple x, y and z.
    /// They are added to a zero matrix.
    pub(super) fn of_tangent_distances(
        space: &SplineSpace,
        samples: &[Sample],
        matrix: BandMatrix,
        check_interrupt: &mut InterruptCheck<'_>,
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
        let mut equations = Self::empty(space, matrix);
        equations.add(
            space,
            samples,
            coefficients,
            check_interrupt,
            |matrix, [a, b], values| {
                matrix.add_block(a, b, values);
            },
        )?;
        Ok(equations)
    }

    /// Adds the equations of other samples, multiplied by `factor`.
    pub(super) fn add_scaled(&mut self, factor: f64, other: &Self) {
        self.matrix.add_scaled(factor, &other.matrix);
        for (sum, value) in self.right.as_flattened_mut().iter_mut().zip(other.right.as_flattened())
        {
            *sum += factor * value;
        }
    }

    fn empty(space: &SplineSpace, matrix: BandMatrix) -> Self {
        Self { matrix, right: vec![[0.0; 3]; space.unknowns()] }
    }

    /// Adds the samples' blocks, with `C` numbers for each pair of basis functions.
    fn add<const C: usize>(
        &mut self,
        space: &SplineSpace,
        samples: &[Sample],
        coefficients: impl Fn(&Sample) -> ([f64; C], DVec3) + Sync,
        check_interrupt: &mut InterruptCheck<'_>,
        scatter: impl Fn(&mut BandMatrix, [usize; 2], [f64; C]) + Sync,
    ) -> Result<()> {
        let layout = Layout::of(space, C);
        let cells = Cells::of(space, samples, check_interrupt)?;
        let tasks = cells.tasks();
        let (length, sums) = (layout.length(), layout.height * layout.width);
        let few = samples.len() * sums < BLOCK_NUMBERS;
        let portions = if few { 1 } else { 2 * worker_pool::num_threads() };
        let batch = (BLOCK_NUMBERS / length).min(tasks.len().div_ceil(portions)).max(1);
        let least = if few { batch } else { 1 };
        let scratch = || vec![0.0; BATCH * (layout.height + layout.width)];
        let fill = |tasks: &[Task], blocks: &mut [f64]| {
            let blocks = blocks.par_chunks_mut(length).zip(tasks).with_min_len(least);
            blocks.for_each_init(scratch, |scratch, (block, task)| {
                block.fill(0.0);
                let members = &cells.order[task.points.clone()];
                let sizes = (layout.rows, layout.cols);
                let coefficients = &coefficients;
                let sums = Sums { space, samples, members, sizes, coefficients, scratch, block };
                Arch::new().dispatch(sums);
            });
        };
        let mut add = |tasks: &[Task], blocks: &[f64]| {
            for (block, task) in blocks.chunks(length).zip(tasks) {
                let corner = cells.corner(task.cell);
                let place = |k: usize| {
                    space.place(corner[0] + k / layout.cols, corner[1] + k % layout.cols)
                };
                let places: Vec<usize> = (0..layout.rows * layout.cols).map(place).collect();
                layout.each_pair(|pair, at| {
                    let pair = pair.map(|k| places[k]);
                    let value = |c: usize| block[c * layout.row_pairs * layout.width + at];
                    scatter(&mut self.matrix, pair, std::array::from_fn(value));
                });
                let rights = block[layout.height * layout.width..].as_chunks::<4>().0;
                for (&place, right) in places.iter().zip(rights) {
                    let sum = &mut self.right[place];
                    sum.iter_mut().zip(right).for_each(|(sum, value)| *sum += value);
                }
            }
        };
        // While some blocks are computed, others are added to the matrix.
        let (mut filled, mut next) = (vec![0.0; batch * length], vec![0.0; batch * length]);
        let mut ready: &[Task] = &[];
        for tasks in tasks.chunks(batch).chain([&[][..]]) {
            check_interrupt()?;
            rayon::join(|| fill(tasks, &mut next), || add(ready, &filled));
            std::mem::swap(&mut filled, &mut next);
            ready = tasks;
        }
        Ok(())
    }
}

/// The layout of a cell's block.
///
/// The product of two control points' functions is a product of two row functions times a product
/// of two column functions. So the sums over samples are a matrix product: pairs of rows, times
/// each coefficient, by pairs of columns. The right-hand sides follow.
struct Layout {
    /// Basis functions in u and in v.
    rows: usize,
    cols: usize,
    /// Pairs of rows, each once.
    row_pairs: usize,
    /// Lines of sums: pairs of rows for each coefficient, rounded up to a multiple of `LINES`.
    height: usize,
    /// Sums in a line: pairs of columns, rounded up to a multiple of `LANES`.
    width: usize,
}

/// Lines and columns of sums that stay in registers.
const LINES: usize = 4;
const LANES: usize = 8;

impl Layout {
    fn of(space: &SplineSpace, coefficients: usize) -> Self {
        let [rows, cols] = [0, 1].map(|d| space.knots[d].degree() + 1);
        Self::of_sizes((rows, cols), coefficients)
    }

    #[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
    #[inline(always)]
    fn of_sizes((rows, cols): (usize, usize), coefficients: usize) -> Self {
        let row_pairs = rows * (rows + 1) / 2;
        let height = (coefficients * row_pairs).next_multiple_of(LINES);
        Self { rows, cols, row_pairs, height, width: (cols * cols).next_multiple_of(LANES) }
    }

    /// Right-hand sides have a fourth number, which fills a register.
    fn length(&self) -> usize {
        self.height * self.width + 4 * self.rows * self.cols
    }

    /// Calls `call` once for each pair of functions, with the index of its sum.
    fn each_pair(&self, mut call: impl FnMut([usize; 2], usize)) {
        let mut line = 0;
        for i in 0..self.rows {
            for other_i in i..self.rows {
                for j in 0..self.cols {
                    for other_j in if other_i == i { j } else { 0 }..self.cols {
                        let pair = [i * self.cols + j, other_i * self.cols + other_j];
                        call(pair, line * self.width + j * self.cols + other_j);
                    }
                }
                line += 1;
            }
        }
    }
}

/// The contribution of some samples of one cell to its block.
struct Sums<'a, const C: usize, F> {
    space: &'a SplineSpace,
    samples: &'a [Sample],
    members: &'a [u32],
    /// Basis functions in u and in v.
    sizes: (usize, usize),
    coefficients: &'a F,
    /// Memory for the lines of `BATCH` samples.
    scratch: &'a mut [f64],
    block: &'a mut [f64],
}

impl<const C: usize, F: Fn(&Sample) -> ([f64; C], DVec3)> WithSimd for Sums<'_, C, F> {
    type Output = ();

    #[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        // Loops over constant sizes are unrolled; most surfaces are bicubic.
        match self.sizes {
            (CUBIC_ORDER, CUBIC_ORDER) => {
                self.add(&Layout::of_sizes((CUBIC_ORDER, CUBIC_ORDER), C));
            }
            sizes => self.add(&Layout::of_sizes(sizes, C)),
        }
    }
}

impl<const C: usize, F: Fn(&Sample) -> ([f64; C], DVec3)> Sums<'_, C, F> {
    #[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
    #[inline(always)]
    fn add(self, &Layout { rows, cols, row_pairs, height, width }: &Layout) {
        let Self { space, samples, members, coefficients, scratch, block, .. } = self;
        let (sums, right) = block.split_at_mut(height * width);
        let right = right.as_chunks_mut::<4>().0;
        let (of_rows, of_cols) = scratch.split_at_mut(BATCH * height);
        let (mut u, mut v) = ([0.0; MAX_ORDER], [0.0; MAX_ORDER]);
        for together in members.chunks(BATCH) {
            for (k, &member) in together.iter().enumerate() {
                let sample = &samples[member as usize];
                values_at(&space.knots[0], sample.uv.x, &mut u[..rows]);
                values_at(&space.knots[1], sample.uv.y, &mut v[..cols]);
                let (factors, target) = coefficients(sample);
                let target = target.extend(0.0).to_array();
                // The last coefficient's line contains the pairs until the others are computed.
                let lines = &mut of_rows[k * height..][..C * row_pairs];
                let (others, pairs) = lines.split_at_mut((C - 1) * row_pairs);
                let mut line = 0;
                for i in 0..rows {
                    for j in i..rows {
                        pairs[line] = u[i] * u[j];
                        line += 1;
                    }
                }
                for (factor, line) in factors.iter().zip(others.chunks_exact_mut(row_pairs)) {
                    line.iter_mut().zip(&*pairs).for_each(|(value, pair)| *value = factor * pair);
                }
                for pair in pairs {
                    *pair *= factors[C - 1];
                }
                for i in 0..cols {
                    for j in 0..cols {
                        of_cols[k * width + i * cols + j] = v[i] * v[j];
                    }
                }
                for i in 0..rows {
                    for j in 0..cols {
                        let value = u[i] * v[j];
                        let sums = right[i * cols + j].iter_mut().zip(&target);
                        sums.for_each(|(sum, target)| *sum += value * target);
                    }
                }
            }
            let count = together.len();
            add_product(
                [&of_rows[..count * height], &of_cols[..count * width]],
                [height, width],
                sums,
            );
        }
    }
}

/// Adds the product of two matrices to a third: for each sample, a line of `height` numbers times
/// one of `width`.
#[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
#[inline(always)]
fn add_product([of_rows, of_cols]: [&[f64]; 2], [height, width]: [usize; 2], sums: &mut [f64]) {
    for line in (0..height).step_by(LINES) {
        for lane in (0..width).step_by(LANES) {
            let mut tile = [[0.0; LANES]; LINES];
            for k in 0..of_rows.len() / height {
                let a: &[f64; LINES] = window(of_rows, k * height + line);
                let b: &[f64; LANES] = window(of_cols, k * width + lane);
                for i in 0..LINES {
                    for j in 0..LANES {
                        tile[i][j] += a[i] * b[j];
                    }
                }
            }
            for i in 0..LINES {
                for j in 0..LANES {
                    sums[(line + i) * width + lane + j] += tile[i][j];
                }
            }
        }
    }
}

/// Samples sorted by the cell between knots in which they lie, otherwise in their order.
pub(super) struct Cells {
    pub(super) order: Vec<u32>,
    /// The first index in `order` of each cell's samples.
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
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Self> {
        check_interrupt()?;
        let [u, v] = &space.knots;
        let counts = [u, v].map(|knots| knots.control_points() - knots.degree());
        let cell = |sample: &Sample| {
            let (row, col) = (u.span(sample.uv.x) - u.degree(), v.span(sample.uv.y) - v.degree());
            u32::try_from(row * counts[1] + col).unwrap_or(u32::MAX)
        };
        let cells: Vec<u32> = samples.par_iter().with_min_len(POINTS_PER_TASK).map(cell).collect();
        check_interrupt()?;
        let mut starts = vec![0; counts[0] * counts[1] + 1];
        for &cell in &cells {
            starts[cell as usize + 1] += 1;
        }
        (1..starts.len()).for_each(|i| starts[i] += starts[i - 1]);
        let mut next = starts.clone();
        let mut order = vec![0; samples.len()];
        for (index, &cell) in (0_u32..).zip(&cells) {
            if (index as usize).is_multiple_of(POINTS_PER_CALL) {
                check_interrupt()?;
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
