//! Bézier coefficients on a triangle.
//!
//! They stand row by row: by how often the first corner counts, then the second.

use glam::DVec2;

use crate::nurbs::MAX_ORDER;

/// All triples of counts with this sum, in the order of coefficients.
pub(super) fn triples(sum: usize) -> Vec<[usize; 3]> {
    let pairs = (0..=sum).flat_map(|a| (0..=sum - a).map(move |b| (a, b)));
    pairs.map(|(a, b)| [a, b, sum - a - b]).collect()
}

/// The larger of two numbers, of which only the second may be NaN; unlike `f64::max` one instruction.
pub(super) fn larger(most: f64, x: f64) -> f64 {
    if x > most { x } else { most }
}

/// How many coefficients there are.
fn count(degree: usize) -> usize {
    (degree + 1) * (degree + 2) / 2
}

/// The largest ratio of the first to the second of a function's coefficients, or anything above
/// `limit` if there is a value above it. The triangle's coefficients are the last on the stack, and
/// are taken away. Where they leave doubt, those of its parts are looked at, `halvings` times.
pub(super) fn largest(
    stack: &mut Vec<DVec2>,
    degree: usize,
    limit: f64,
    near: f64,
    halvings: usize,
) -> f64 {
    let size = count(degree);
    let start = stack.len() - size;
    let triangle = &stack[start..];
    let ratio = |of: &DVec2| of.x.abs() / of.y;
    let most = triangle.iter().map(ratio).fold(0.0, larger);
    let corners = [0, degree, size - 1].map(|k| ratio(&triangle[k]));
    let above = corners.iter().any(|&value| value > limit);
    if most <= limit || most > near || above || halvings == 0 {
        stack.truncate(start);
        return most;
    }
    halve(stack, degree);
    let first = largest(stack, degree, limit, near, halvings - 1);
    if first > limit {
        stack.truncate(start);
        return first;
    }
    let second = largest(stack, degree, limit, near, halvings - 1);
    stack.truncate(start);
    first.max(second)
}

/// Appends the coefficients of both halves of the stack's last triangle, cut from its first corner
/// to the middle of the opposite side (de Casteljau's algorithm along the rows). Their first corner
/// is that middle, so that their next cut goes to another side.
fn halve(stack: &mut Vec<DVec2>, degree: usize) {
    let size = count(degree);
    let start = stack.len() - size;
    stack.resize(start + 3 * size, DVec2::ZERO);
    let (of, halves) = stack[start..].split_at_mut(size);
    let (second, first) = halves.split_at_mut(size);
    let mut row = [DVec2::ZERO; 2 * MAX_ORDER];
    let mut from = 0;
    for apex in 0..=degree {
        let n = degree - apex;
        let row = &mut row[..=n];
        row.copy_from_slice(&of[from..=from + n]);
        from += n + 1;
        // The middle counts `level` times, the first corner `apex` times.
        let mut at = apex;
        for level in 0..=n {
            first[at] = row[0];
            second[at] = row[n - level];
            at += degree + 1 - level;
            for k in 0..n - level {
                row[k] = 0.5 * (row[k] + row[k + 1]);
            }
        }
    }
}
