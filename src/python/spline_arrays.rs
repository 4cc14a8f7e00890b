//! The data of curves and surfaces as read-only arrays and as dicts of plain lists.

use glam::DVec3;
use numpy::PyArrayDyn;
use numpy::ndarray::IxDyn;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::arguments::Items;
use super::arrays;
use crate::nurbs::KnotVector;

type Array = Py<PyArrayDyn<f64>>;

/// The arrays of a curve or surface, created once.
pub(super) struct SplineArrays {
    control_points: Array,
    weights: Option<Array>,
    knots: Vec<Array>,
}

impl SplineArrays {
    /// The arrays of control points with one knot vector for each axis.
    pub(super) fn new(
        py: Python<'_>,
        control_points: &[DVec3],
        weights: Option<&[f64]>,
        knots: &[&KnotVector],
    ) -> PyResult<Self> {
        let shape: Vec<usize> = knots.iter().map(|knots| knots.control_points()).collect();
        let array =
            |shape: &[usize], values: &[f64]| arrays::constant::<f64, IxDyn>(py, shape, values);
        let points = bytemuck::cast_slice(control_points);
        let vector = |knots: &&KnotVector| array(&[knots.as_slice().len()], knots.as_slice());
        Ok(Self {
            control_points: array(&[&shape[..], &[3]].concat(), points)?,
            weights: weights.map(|weights| array(&shape, weights)).transpose()?,
            knots: knots.iter().map(vector).collect::<PyResult<_>>()?,
        })
    }

    pub(super) fn control_points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        arrays::view(py, &self.control_points)
    }

    pub(super) fn weights<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.weights.as_ref().map(|weights| arrays::view(py, weights)).transpose()
    }

    /// The knot vector of an axis of the control points.
    pub(super) fn knots<'py>(&self, py: Python<'py>, axis: usize) -> PyResult<Bound<'py, PyAny>> {
        arrays::view(py, &self.knots[axis])
    }

    /// The arguments of the constructor, by name, as plain lists and numbers.
    pub(super) fn to_dict<'py>(
        &self,
        py: Python<'py>,
        degree: impl IntoPyObject<'py>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let list = |array: Bound<'py, PyAny>| array.call_method0("tolist");
        let dict = PyDict::new(py);
        dict.set_item("control_points", list(self.control_points(py)?)?)?;
        dict.set_item("weights", self.weights(py)?.map(list).transpose()?)?;
        dict.set_item("degree", degree)?;
        match &self.knots[..] {
            [_] => dict.set_item("knots", list(self.knots(py, 0)?)?)?,
            _ => dict.set_item("knots", [list(self.knots(py, 0)?)?, list(self.knots(py, 1)?)?])?,
        }
        Ok(dict)
    }
}

/// The constructor's arguments from a dict that `to_dict` made. Missing items and None stand for
/// the defaults.
pub(super) struct SplineItems<'py> {
    pub(super) control_points: Bound<'py, PyAny>,
    pub(super) weights: Option<Bound<'py, PyAny>>,
    pub(super) degree: Option<Bound<'py, PyAny>>,
    pub(super) knots: Option<Bound<'py, PyAny>>,
}

impl<'py> SplineItems<'py> {
    pub(super) fn new(data: &Bound<'py, PyAny>) -> PyResult<Self> {
        let must = "a dict with control_points";
        let items = Items::of(data, must)?;
        Ok(Self {
            control_points: items.needed("control_points", must)?,
            weights: items.get("weights")?,
            degree: items.get("degree")?,
            knots: items.get("knots")?,
        })
    }
}
