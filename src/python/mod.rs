//! The Python extension module `neurbs._core`: a thin layer between NumPy and the crate.
//!
//! Nothing is computed here. Arrays become slices ([`arrays`]), arguments become options
//! ([`arguments`]) and errors become exceptions ([`errors`]). Long calls release the GIL and check
//! for Ctrl-C ([`call`]). The other files have the classes and functions, by module of the crate.

#![allow(clippy::doc_markdown, reason = "the doc comments are numpydoc")]
#![allow(clippy::needless_pass_by_value, reason = "PyO3 hands arguments over by value")]

mod arguments;
mod arrays;
mod batch_sums;
mod call;
mod closest_points;
mod construction;
mod curvature;
mod curve;
mod curve_algebra;
mod curve_construction;
mod curve_evaluation;
mod curve_points;
mod curve_splitting;
mod diagnostics;
mod epoch;
mod error_history;
mod errors;
mod evaluation;
mod export;
mod face;
mod face_measures;
mod face_points;
mod fit_rounds;
mod height_fit;
mod heights;
mod kind;
mod knots;
mod lattice;
mod measure;
mod mesh;
mod partial_sums;
mod pickling;
mod plot;
mod preparation;
mod primitives;
mod progress;
mod reconstruct;
mod recover_net;
mod save;
mod shell;
mod som;
mod som_options;
mod spline_arrays;
mod splitting;
mod surface;
mod surface_arguments;
mod swept;
mod tessellation;
mod threads;
mod transform;
mod trim;

use pyo3::pymodule;

/// The compiled core of neurbs.
#[pymodule]
mod _core {
    #[pymodule_export]
    use super::arrays::as_points;
    #[pymodule_export]
    use super::batch_sums::BatchSums;
    #[pymodule_export]
    use super::closest_points::ClosestPoints;
    #[pymodule_export]
    use super::curvature::Curvatures;
    #[pymodule_export]
    use super::curve::NurbsCurve;
    #[pymodule_export]
    use super::curve_points::CurvePoints;
    #[pymodule_export]
    use super::diagnostics::{candidates, validate};
    #[pymodule_export]
    use super::epoch::Epoch;
    #[pymodule_export]
    use super::errors::NeurbsError;
    #[pymodule_export]
    use super::export::{write_iges, write_obj, write_obj_shells, write_step};
    #[pymodule_export]
    use super::face::Face;
    #[pymodule_export]
    use super::face_points::FacePoints;
    #[pymodule_export]
    use super::fit_rounds::{isocurve_lengths, refined_knots, robust_weights};
    #[pymodule_export]
    use super::height_fit::{HeightFit, fit_heights, fit_weights};
    #[pymodule_export]
    use super::lattice::{Lattice, lattice_for_points};
    #[pymodule_export]
    use super::mesh::TriangleMesh;
    #[pymodule_export]
    use super::partial_sums::PartialSums;
    #[pymodule_export]
    use super::preparation::{
        Cleaning, Components, EvenSample, clean, cloud_distances, components,
    };
    #[pymodule_export]
    use super::progress::Progress;
    #[pymodule_export]
    use super::reconstruct::{check_options, default_options, reconstruct, reconstruct_paper};
    #[pymodule_export]
    use super::recover_net::recover_net;
    #[pymodule_export]
    use super::shell::{Edge, Shell};
    #[pymodule_export]
    use super::som::{Map, start_indices};
    #[pymodule_export]
    use super::som_options::som_options;
    #[pymodule_export]
    use super::surface::NurbsSurface;
    #[pymodule_export]
    use super::tessellation::tessellate;
    #[pymodule_export]
    use super::threads::{num_threads, set_num_threads};
    #[pymodule_export]
    use super::trim::{trim, trimmed};
    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        // The value of errors that are not about one argument.
        module.py().get_type::<NeurbsError>().setattr("argument", module.py().None())?;
        module.add("DIAGNOSTIC_CODES", crate::diagnostic::Diagnostic::CODES.to_vec())?;
        module.add("LENGTH_UNITS", super::export::length_units(module.py())?)?;
        let py = module.py();
        module.add("NeurbsMemoryError", super::errors::memory_error_class(py)?)?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
