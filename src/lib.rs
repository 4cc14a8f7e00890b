//! Scattered 3D points in, a standard NURBS surface out.
//!
//! A Kohonen self-organizing map with a quadrilateral lattice learns the points; the lattice is
//! the ordered control net that tensor-product surfaces need. The method is that of *Free-form
//! Surfaces for Scattered Data by Neural Networks* (M. Hoffmann, L. Várady, 1998), called "the
//! paper" here.
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
//! assert!(result.report.quantization_error < 0.1);
//!
//! let mut file = Vec::new(); // or a std::fs::File
//! neurbs::export::write_step(&result.surface, &mut file)?;
//! # Ok::<(), neurbs::Error>(())
//! ```
//!
//! [`reconstruct()`] is the whole job. Its stages are public, each over plain values that can be
//! saved, looked at and replaced: [`point_cloud`] (checks, normalization), [`som`] (the network),
//! [`nurbs`] (the surface), [`fit`] (least squares), [`mesh`] (triangles), [`export`] (STEP, IGES, OBJ). Long jobs take an
//! [`Observer`], which is told how far they are and may stop them.
//!
//! Points are [`DVec3`] of the `glam` crate, in any unit; u runs along the rows of a net, v along
//! its columns, and arrays over a net are row-major.

#![forbid(unsafe_code)]

pub mod error;
pub mod export;
pub mod fit;
pub mod inspection;
pub mod mesh;
pub mod nurbs;
pub mod point_cloud;
pub mod progress;
#[cfg(feature = "python")]
mod python;
pub mod reconstruct;
pub mod som;
pub mod topology;

pub use glam::{DAffine3, DVec2, DVec3};

pub use crate::error::{Error, Result};
pub use crate::mesh::TriangleMesh;
pub use crate::nurbs::{NurbsCurve, NurbsSurface};
pub use crate::progress::{Observer, Progress};
pub use crate::reconstruct::{ReconstructOptions, Reconstruction, reconstruct};
pub use crate::som::SelfOrganizingMap;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
