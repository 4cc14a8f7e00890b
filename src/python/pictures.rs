//! Pictures of a surface, which the Python module `neurbs.plot` draws.

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
    ///     Points to draw with it, and to measure the deviation of.
    /// color : {"height", "deviation", "mean", "gaussian", "zebra"}, optional
    ///     What colours mean; by default the deviation if there are points, else the height.
    /// tolerance : float, optional
    ///     Where the colours of the deviation end, in the points' unit.
    /// unit : str, default ""
    ///     Name of the points' unit, for the legend.
    /// isolines : int, default 20
    ///     Isoparametric lines across the longer direction; 0 for none.
    /// control_net : bool, default False
    ///     Whether the control net is drawn, too.
    /// backend : {"matplotlib", "pyvista"}, default "matplotlib"
    ///     Who draws.
    ///
    /// Returns
    /// -------
    /// matplotlib.figure.Figure or pyvista.Plotter
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If an option is not one of these.
    #[pyo3(signature = (points=None, *, color=None, tolerance=None, unit="", isolines=20,
                        control_net=false, backend="matplotlib"))]
    #[expect(clippy::too_many_arguments, reason = "one for each of Python's keyword arguments")]
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

    /// Show the surface in a notebook, as a small picture and a table.
    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("neurbs.plot")?.call_method1("surface_html", (slf,))
    }
}
