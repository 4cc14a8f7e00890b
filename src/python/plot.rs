//! `neurbs.NurbsSurface`: plots, drawn by the Python module `neurbs.plot`.

use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyString};

use super::surface::NurbsSurface;

#[pymethods]
impl NurbsSurface {
    /// Draw the surface in a 3D view; see :func:`neurbs.plot.plot_surface`.
    ///
    /// Parameters
    /// ----------
    /// points : array_like of shape (n, 3), optional
    ///     Points to draw, and to measure deviations from.
    /// color : {"height", "deviation", "mean", "gaussian", "zebra"}, optional
    ///     The quantity shown by color; by default the deviation if there are points, else the
    ///     height.
    /// tolerance : float, optional
    ///     Largest deviation of the color scale, in the points' unit.
    /// unit : str, default ""
    ///     Name of the points' unit, for the legend.
    /// isolines : int, default 20
    ///     Number of isoparametric lines across the longer direction; 0 for none.
    /// control_net : bool, default False
    ///     Whether to draw the control net.
    /// backend : {"matplotlib", "pyvista"}, default "matplotlib"
    ///     The library that draws.
    ///
    /// Returns
    /// -------
    /// matplotlib.figure.Figure or pyvista.Plotter
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If an option has another value than those listed.
    #[pyo3(signature = (points=None, *, color=None, tolerance=None, unit="", isolines=20,
                        control_net=false, backend="matplotlib"))]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments of Python")]
    fn plot<'py>(
        slf: &Bound<'py, Self>,
        points: Option<Bound<'py, PyAny>>,
        color: Option<Bound<'py, PyAny>>,
        tolerance: Option<Bound<'py, PyAny>>,
        unit: &str,
        isolines: u32,
        control_net: bool,
        backend: &str,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = slf.py();
        let options = [("color", color), ("tolerance", tolerance)].into_py_dict(py)?;
        options.set_item("unit", PyString::new(py, unit))?;
        options.set_item("isolines", isolines)?;
        options.set_item("control_net", control_net)?;
        options.set_item("backend", backend)?;
        py.import("neurbs.plot")?.getattr("plot_surface")?.call((slf, points), Some(&options))
    }

    /// Show the surface in a notebook, as a small image and a table.
    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("neurbs.plot")?.call_method1("surface_html", (slf,))
    }
}
