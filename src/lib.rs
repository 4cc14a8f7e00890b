//! Scattered 3D points in, a standard NURBS surface out.
//!
//! Charts propose how the points may lie on a surface. Coarse fits of the proposals are scored, and
//! the best is refined: least squares with fairness pull a B-spline surface to the points while their
//! parameters follow it. The net grows until a tolerance holds or more control points would follow
//! noise. A Kohonen self-organizing map learns the points from the coarse surface.
//!
//! The source is *Free-form Surfaces for Scattered Data by Neural Networks* (M. Hoffmann, L. Várady,
//! 1998), called "the paper" here. There the trained lattice itself is the control net; that method is
//! [`reconstruct_paper()`].
//!
//! ```
//! use neurbs::{DVec3, ReconstructOptions, progress::Silent, reconstruct};
//!
//! // Points on a saddle, in no order that the library knows of.
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
//! neurbs::export::write_step(&result.surface, &mut file)?;
//! # Ok::<(), neurbs::Error>(())
//! ```
//!
//! [`reconstruct()`] is the whole job. Its stages are public, each over plain values that can be
//! saved, looked at and replaced: [`cloud`] (checks, cleaning, components), [`observe`] (local
//! planes, noise, border), [`chart`] (proposals), [`pipeline`] (score, selection, refinement), [`som`]
//! (the network), [`fit`] (least squares), [`nurbs`] (the surface), [`validate`] (defects), [`mesh`]
//! (triangles), [`export`] (STEP, IGES, OBJ). Long jobs report their progress to an [`Observer`],
//! which may stop them.
//!
//! Points are [`DVec3`] of the `glam` crate, in any unit; u runs along the rows of a net, v along
//! its columns, and arrays over a net are row-major.

#![forbid(unsafe_code)]

pub mod chart;
pub mod cloud;
pub mod diagnostic;
pub mod error;
pub mod export;
pub mod fit;
pub mod mesh;
mod numeric;
pub mod nurbs;
pub mod observe;
pub mod pipeline;
pub mod progress;
#[cfg(feature = "python")]
mod python;
pub mod som;
pub mod validate;
mod worker_pool;

pub use glam::{DAffine3, DVec2, DVec3};

pub use crate::diagnostic::{Cause, Diagnostic};
pub use crate::error::{Error, Result};
pub use crate::mesh::TriangleMesh;
pub use crate::nurbs::{NurbsCurve, NurbsSurface};
pub use crate::pipeline::{
    Candidate, PaperOptions, ReconstructOptions, Reconstruction, candidates, reconstruct,
    reconstruct_paper, recover_net,
};
pub use crate::progress::{Observer, Progress};
pub use crate::som::SelfOrganizingMap;
pub use crate::worker_pool::{num_threads, set_num_threads};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
