//! `neurbs.NurbsSurface`: plots, drawn by the Python module `neurbs.plot`.

use pyo3::prelude::*;
use pyo3::types::PyDict;

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
    /// view : {"iso", "top", "front", "side"}, default "iso"
    ///     The direction of the viewer.
    /// size : (float, float), optional
    ///     Width and height in inches; by default without empty space.
    /// dpi : float, default 100
    ///     Dots per inch.
    /// exaggeration : float, optional
    ///     The factor by which heights are drawn longer; 1 is to scale. By default only heights that
    ///     would hardly be seen are drawn longer.
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
    #[pyo3(signature = (points=None, **options),
           text_signature = "($self, points=None, *, color=None, tolerance=None, unit='', \
                             isolines=20, control_net=False, view='iso', size=None, dpi=100.0, \
                             exaggeration=None, backend='matplotlib')")]
    fn plot<'py>(
        slf: &Bound<'py, Self>,
        points: Option<Bound<'py, PyAny>>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let plot = slf.py().import("neurbs.plot")?;
        plot.getattr("plot_surface")?.call((slf, points), options)
    }

    /// Show the surface in a notebook, as a small image and a table.
    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("neurbs.plot")?.call_method1("surface_html", (slf,))
    }
}
