//! The class `neurbs.Face`.

use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::arguments::{Items, truth};
use super::curve::NurbsCurve;
use super::errors::bad_argument;
use super::surface::NurbsSurface;
use super::transform::affine;
use crate::brep;

/// Curves of loops, one list for each loop.
type Loops = Vec<Vec<NurbsCurve>>;

/// A surface, or the part of it inside an outer loop and outside inner ones.
///
/// Immutable: every operation returns a new face.
///
/// Parameters
/// ----------
/// surface : NurbsSurface
///     The surface. Knots that are not clamped are clamped.
/// loops : list of lists of NurbsCurve, optional
///     The outer loop, then the inner ones. Each is a closed chain of curves in (u, v), with z = 0.
///     Their direction does not matter. By default the sides of the surface's rectangle.
/// name : str, optional
///     The name in files.
/// color : (float, float, float), optional
///     Red, green and blue between 0 and 1.
/// reversed : bool, default False
///     Whether the face's normals are opposite to the surface's.
///
/// Raises
/// ------
/// NeurbsError
///     If a loop is open, leaves the surface's rectangle, crosses or touches itself or another one,
///     or lies outside the outer loop or inside another inner one. The message gives the place.
///
/// See Also
/// --------
/// Shell : Faces joined along their edges.
///
/// Examples
/// --------
/// >>> import neurbs
/// >>> plane = neurbs.NurbsSurface.plane([0, 0, 0], [4, 0, 0], [0, 4, 0])
/// >>> circle = neurbs.NurbsCurve.arc([0.5, 0.5, 0], [0.25, 0, 0], [0, 0.25, 0])
/// >>> neurbs.Face(plane, [[circle]])
/// Face(net 2 × 2, outer loop of 1 curve, 0 holes)
#[pyclass(frozen, module = "neurbs")]
pub(super) struct Face {
    core: brep::Face,
}

impl From<brep::Face> for Face {
    fn from(core: brep::Face) -> Self {
        Self { core }
    }
}

impl Face {
    pub(super) fn core(&self) -> &brep::Face {
        &self.core
    }
}

/// A number with its noun, in the plural unless it is 1.
pub(super) fn count(number: usize, noun: &str) -> String {
    format!("{number} {noun}{}", if number == 1 { "" } else { "s" })
}

/// Curves from Python: lists of lists of `NurbsCurve`.
fn loops_of(value: &Bound<'_, PyAny>) -> PyResult<Vec<Vec<crate::nurbs::NurbsCurve>>> {
    let refused = |_| bad_argument("loops", "a list of lists of NurbsCurve", value);
    let loops: Vec<Vec<Py<NurbsCurve>>> = value.extract().map_err(refused)?;
    let curves = |curves: Vec<Py<NurbsCurve>>| {
        curves.iter().map(|curve| curve.get().core().clone()).collect()
    };
    Ok(loops.into_iter().map(curves).collect())
}

fn curves_of(py: Python<'_>, of: &brep::Loop) -> PyResult<Vec<NurbsCurve>> {
    of.curves().iter().map(|curve| NurbsCurve::new(py, curve.clone())).collect()
}

#[pymethods]
impl Face {
    #[new]
    #[pyo3(
        signature = (surface, loops=None, *, name=None, color=None, reversed=None),
        text_signature = "(surface, loops=None, *, name=None, color=None, reversed=False)"
    )]
    fn py_new(
        surface: &Bound<'_, PyAny>,
        loops: Option<&Bound<'_, PyAny>>,
        name: Option<String>,
        color: Option<(f64, f64, f64)>,
        reversed: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let Ok(surface) = surface.cast::<NurbsSurface>() else {
            return Err(bad_argument("surface", "a NurbsSurface", surface));
        };
        let surface = Arc::new(surface.get().core().clone());
        let face = match loops {
            Some(loops) => brep::Face::trimmed(surface, loops_of(loops)?)?,
            None => brep::Face::whole(surface)?,
        };
        let face = face.with_name(name).with_color(color.map(<[f64; 3]>::from))?;
        let reversed = reversed.map_or(Ok(false), |value| truth("reversed", value))?;
        Ok(Self { core: if reversed { face.reversed() } else { face } })
    }

    /// The surface, with clamped knots.
    #[getter]
    fn surface(&self, py: Python<'_>) -> PyResult<NurbsSurface> {
        NurbsSurface::new(py, (**self.core.surface()).clone())
    }

    /// The outer loop: curves in (u, v), counter-clockwise, each beginning where the one before
    /// ends.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> plane = neurbs.NurbsSurface.plane([0, 0, 0], [4, 0, 0], [0, 4, 0])
    /// >>> [curve.evaluate([0])[0].tolist() for curve in neurbs.Face(plane).outer]
    /// [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]
    #[getter]
    fn outer(&self, py: Python<'_>) -> PyResult<Vec<NurbsCurve>> {
        curves_of(py, self.core.outer())
    }

    /// The inner loops: curves in (u, v), clockwise.
    #[getter]
    fn inner(&self, py: Python<'_>) -> PyResult<Loops> {
        self.core.inner().iter().map(|inner| curves_of(py, inner)).collect()
    }

    /// The outer loop, then the inner ones, as the constructor takes them.
    #[getter]
    fn loops(&self, py: Python<'_>) -> PyResult<Loops> {
        self.core.loops().iter().map(|all| curves_of(py, all)).collect()
    }

    /// Whether the face was made with loops of its own.
    #[getter]
    fn is_trimmed(&self) -> bool {
        self.core.is_trimmed()
    }

    /// Whether the face's normals are opposite to the surface's.
    #[getter]
    fn is_reversed(&self) -> bool {
        self.core.is_reversed()
    }

    /// The name in files; None if unknown.
    #[getter]
    fn name(&self) -> Option<&str> {
        self.core.name()
    }

    /// Red, green and blue between 0 and 1; None if unknown.
    #[getter]
    fn color(&self) -> Option<(f64, f64, f64)> {
        self.core.color().map(Into::into)
    }

    /// The same face with opposite normals.
    ///
    /// Returns
    /// -------
    /// Face
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> sphere = neurbs.NurbsSurface.sphere([0, 0, 0], 1)
    /// >>> neurbs.Face(sphere).reversed().is_reversed
    /// True
    fn reversed(&self) -> Self {
        self.core.reversed().into()
    }

    /// Transform the face by an affine map, a reflection included.
    ///
    /// Parameters
    /// ----------
    /// matrix : array_like of shape (3, 4) or (4, 4)
    ///     The matrix applied to column vectors (x, y, z, 1).
    ///
    /// Returns
    /// -------
    /// Face
    ///     Its normals stay on the same side.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     As :meth:`NurbsSurface.transformed`.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> plane = neurbs.NurbsSurface.plane([0, 0, 0], [1, 0, 0], [0, 1, 0])
    /// >>> neurbs.Face(plane).transformed([[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]).is_reversed
    /// True
    fn transformed(&self, matrix: &Bound<'_, PyAny>) -> PyResult<Self> {
        Ok(self.core.transformed(&affine(matrix)?)?.into())
    }

    /// The face as a dict of plain lists and numbers, for example for JSON.
    ///
    /// Returns
    /// -------
    /// dict
    ///     ``surface`` (see :meth:`NurbsSurface.to_dict`), ``loops`` (lists of lists of
    ///     :meth:`NurbsCurve.to_dict`; None if the face is not trimmed), ``reversed``, ``name`` and
    ///     ``color``.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> sphere = neurbs.NurbsSurface.sphere([0, 0, 0], 1)
    /// >>> neurbs.Face(sphere, name="ball").to_dict().get("name")
    /// 'ball'
    pub(super) fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        dict.set_item("surface", self.surface(py)?.to_dict(py)?)?;
        let curve = |curve: &NurbsCurve| curve.to_dict(py);
        let of_loop =
            |curves: &Vec<NurbsCurve>| curves.iter().map(curve).collect::<PyResult<Vec<_>>>();
        let loops = self.core.is_trimmed().then(|| self.loops(py)).transpose()?;
        let loops = loops.map(|loops| loops.iter().map(of_loop).collect::<PyResult<Vec<_>>>());
        dict.set_item("loops", loops.transpose()?)?;
        dict.set_item("reversed", self.is_reversed())?;
        dict.set_item("name", self.name())?;
        dict.set_item("color", self.color())?;
        Ok(dict)
    }

    /// Make a face from a dict returned by :meth:`to_dict`.
    ///
    /// Parameters
    /// ----------
    /// data : dict
    ///     ``surface``, and optionally ``loops``, ``reversed``, ``name`` and ``color``.
    ///
    /// Returns
    /// -------
    /// Face
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If there is no surface, or as in the constructor.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> face = neurbs.Face(neurbs.NurbsSurface.sphere([0, 0, 0], 1), name="ball")
    /// >>> neurbs.Face.from_dict(face.to_dict()) == face
    /// True
    #[staticmethod]
    pub(super) fn from_dict(data: &Bound<'_, PyAny>) -> PyResult<Self> {
        let py = data.py();
        let must = "a dict with a surface";
        let items = Items::of(data, must)?;
        let surface = NurbsSurface::from_dict(&items.needed("surface", must)?)?;
        let loops = items.get("loops")?.map(|loops| {
            let refused = |_| bad_argument("loops", "a list of lists of dicts", &loops);
            let loops: Vec<Vec<Bound<'_, PyAny>>> = loops.extract().map_err(refused)?;
            let curve = |curve: &Bound<'_, PyAny>| Py::new(py, NurbsCurve::from_dict(curve)?);
            let of_loop = |curves: &Vec<_>| curves.iter().map(curve).collect();
            let loops: PyResult<Vec<Vec<_>>> = loops.iter().map(of_loop).collect();
            loops?.into_pyobject(py)
        });
        let text = items
            .get("name")?
            .map(|name| name.extract().map_err(|_: PyErr| bad_argument("name", "a string", &name)));
        let color = items.get("color")?.map(|color| {
            let refused = |_: PyErr| bad_argument("color", "three numbers", &color);
            color.extract::<[f64; 3]>().map(Into::into).map_err(refused)
        });
        Self::py_new(
            Py::new(py, surface)?.bind(py).as_any(),
            loops.transpose()?.as_ref(),
            text.transpose()?,
            color.transpose()?,
            items.get("reversed")?.as_ref(),
        )
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.core == other.core
    }

    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyDict>,))> {
        Ok((py.get_type::<Self>().getattr("from_dict")?, (self.to_dict(py)?,)))
    }

    fn __repr__(&self) -> String {
        let (rows, cols) = self.core.surface().shape();
        let loops = if self.core.is_trimmed() {
            let curves = count(self.core.outer().curves().len(), "curve");
            format!("outer loop of {curves}, {}", count(self.core.inner().len(), "hole"))
        } else {
            "whole".to_string()
        };
        format!("Face(net {rows} × {cols}, {loops})")
    }
}
