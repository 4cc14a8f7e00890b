//! Scattered 3D points in, a standard NURBS surface out.
//!
//! Charts propose how the points may lie on a surface. Coarse fits of their hypotheses are scored,
//! and the best is refined. Least squares with fairness fit a B-spline surface, and the points'
//! parameters are corrected in turn. The net grows until a tolerance holds, or until more control
//! points would follow noise. A Kohonen self-organizing map is trained on the points from the
//! coarse surface.
//!
//! The source is *Free-form Surfaces for Scattered Data by Neural Networks* (M. Hoffmann, L.
//! Várady, 1998), called "the paper" here. In it the trained lattice itself is the control net;
//! that method is [`reconstruct_paper()`].
//!
//! ```
//! use neurbs::export::{StepOptions, write_step};
//! use neurbs::{DVec3, ReconstructOptions, Shell, progress::Silent, reconstruct};
//!
//! // Points on a saddle; their order does not matter.
//! let points: Vec<DVec3> = (0..200)
//!     .map(|i| {
//!         let (x, y) = (f64::from(i % 20) / 20.0, f64::from(i / 20) / 10.0);
//!         DVec3::new(x, y, x * y)
//!     })
//!     .collect();
//!
//! let options = ReconstructOptions { grid: Some((8, 6)), ..ReconstructOptions::default() };
//! let result = reconstruct(&points, &options, &mut Silent)?;
//!
//! assert_eq!(result.surface.shape(), (8, 6));
//! assert!(result.report.deviations.rms < 1e-3);
//!
//! let mut file = Vec::new(); // or a std::fs::File
//! write_step(&[Shell::whole(result.surface)?], &StepOptions::default(), &mut file)?;
//! # Ok::<(), neurbs::Error>(())
//! ```
//!
//! [`reconstruct()`] is the whole job. Its stages are public, too, with plain values between them:
//!
//! - [`cloud`] (checks, cleaning, components);
//! - [`observe`] (local planes, noise, border);
//! - [`chart`] (hypotheses);
//! - [`pipeline`] (ranking, selection, refinement);
//! - [`som`] (the network);
//! - [`fit`] (least squares);
//! - [`nurbs`] (curves and surfaces);
//! - [`mod@validate`] (defects);
//! - [`brep`] (faces, edges, shells);
//! - [`mod@trim`] (faces that end where points end);
//! - [`mesh`] (triangles);
//! - [`export`] (STEP, IGES, OBJ).
//!
//! Long jobs report their progress to an [`Observer`], which may stop them. Functions that Python
//! has at the top level are at the top level here, too.
//!
//! Each stage has its thresholds in `settings.rs`, with unit and source. The source "calibrated on
//! the scoreboard" means `benches/scoreboard.py`: it reconstructs clouds of every kind by the
//! default options, and measures error, folds and time. The value is the one with which most clouds
//! come out right.
//!
//! Points are [`DVec3`] of the `glam` crate, in any unit; u runs along the rows of a net, v along
//! its columns, and arrays over a net are row-major.

#![forbid(unsafe_code)]

pub mod brep;
mod bytes;
pub mod chart;
pub mod cloud;
pub mod diagnostic;
mod disjoint_sets;
pub mod error;
pub mod export;
pub mod fit;
mod memory;
pub mod mesh;
mod numeric;
pub mod nurbs;
pub mod observe;
pub mod pipeline;
pub mod progress;
#[cfg(feature = "python")]
mod python;
pub mod som;
pub mod trim;
pub mod validate;
mod worker_pool;

pub use glam::{DAffine3, DVec2, DVec3};

pub use crate::brep::{Face, FacePoint, FaceSearch, LengthUnit, Shell};
pub use crate::cloud::{Cleaning, Components, EvenSample, clean, components};
pub use crate::diagnostic::{Cause, Diagnostic};
pub use crate::error::{Error, Result};
pub use crate::fit::{HeightFit, fit_heights, fit_weights};
pub use crate::mesh::TriangleMesh;
pub use crate::nurbs::{NurbsCurve, NurbsSurface};
pub use crate::pipeline::{
    Candidate, PaperOptions, ReconstructOptions, Reconstruction, Report, candidates, reconstruct,
    reconstruct_paper, recover_net,
};
pub use crate::progress::{Epoch, Observer, Progress};
pub use crate::som::{Lattice, SelfOrganizingMap};
pub use crate::validate::validate;
pub use crate::worker_pool::{num_threads, set_num_threads};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
