//! Checks of evaluation parameters against the domain, and of output lengths.

use glam::DVec2;
use rayon::prelude::*;

use super::knot_vector::KnotVector;
use super::surface::NurbsSurface;
use super::work_blocks::POINTS_PER_TASK;
use crate::error::{Error, Result};
use crate::worker_pool;

/// The treatment of parameters outside the domain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Outside {
    /// Refuse them.
    #[default]
    Refuse,
    /// Extrapolate the outermost patches.
    Extrapolate,
}

impl NurbsSurface {
    /// Checks scattered parameters and the length of their output.
    pub(super) fn check_scattered(&self, uv: &[DVec2], out: usize, outside: Outside) -> Result<()> {
        check_length(out, uv.len())?;
        let check = |(task, uv): (usize, &[DVec2])| {
            let first = task * POINTS_PER_TASK;
            check_inside("u", self.knots_u(), outside, first, uv.iter().map(|at| at.x))
                .and_then(|()| {
                    check_inside("v", self.knots_v(), outside, first, uv.iter().map(|at| at.y))
                })
                .err()
        };
        let failed = if uv.len() <= POINTS_PER_TASK {
            check((0, uv))
        } else {
            let tasks = uv.par_chunks(POINTS_PER_TASK).enumerate();
            worker_pool::install(|| tasks.find_map_first(check))
        };
        failed.map_or(Ok(()), Err)
    }

    /// Checks the parameters of a grid.
    pub(super) fn check_grid(&self, u: &[f64], v: &[f64], outside: Outside) -> Result<()> {
        check_inside("u", self.knots_u(), outside, 0, u.iter().copied())?;
        check_inside("v", self.knots_v(), outside, 0, v.iter().copied())
    }
}

/// Checks that an output has one element for each parameter.
pub(super) fn check_length(out: usize, needed: usize) -> Result<()> {
    if out == needed {
        return Ok(());
    }
    Err(Error::parameter("out", format!("of length {needed}, one for each parameter"), out))
}

/// Checks parameters; `first` is the index of the first one, for the error message.
pub(super) fn check_inside(
    name: &'static str,
    knots: &KnotVector,
    outside: Outside,
    first: usize,
    parameters: impl Iterator<Item = f64> + Clone,
) -> Result<()> {
    let (start, end) = match outside {
        Outside::Refuse => knots.domain(),
        // Infinite parameters would evaluate to NaN.
        Outside::Extrapolate => (f64::MIN, f64::MAX),
    };
    // Not `<` and `>`: NaN must fail.
    let inside = |t: f64| (start..=end).contains(&t);
    // First a test without branches: most parameters are inside.
    if parameters.clone().fold(true, |all, t| all & inside(t)) {
        return Ok(());
    }
    let found = parameters.enumerate().find(|(_, t)| !inside(*t));
    found.map_or(Ok(()), |(index, t)| {
        let must = match outside {
            Outside::Refuse => format!("inside the domain [{start}, {end}]"),
            Outside::Extrapolate => "finite".to_string(),
        };
        Err(Error::parameter(name, must, format!("{t} at index {}", first + index)))
    })
}
