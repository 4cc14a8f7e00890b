//! The classes `neurbs.Shell` and `neurbs.Edge`.

use std::sync::OnceLock;

use numpy::PyArrayDyn;
use numpy::ndarray::IxDyn;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::arguments::{Items, choice, optional_real};
use super::arrays;
use super::call::Watcher;
use super::curve::NurbsCurve;
use super::errors::bad_argument;
use super::face::{Face, count};
use super::pickling::{Reduced, reduced};
use super::surface::NurbsSurface;
use super::transform::affine;
use crate::brep::{self, FaceSearch, LengthUnit};
use crate::error::Result;

/// The identifier of the edge of each curve of each loop of each face.
type Identifiers = Vec<Vec<Vec<Option<usize>>>>;

/// A curve in space where faces end or meet.
///
/// Returned by :attr:`Shell.edges`.
#[pyclass(frozen, module = "neurbs")]
pub(super) struct Edge {
    curve: Py<NurbsCurve>,
    /// The indices of the vertices at the start and the end; equal for a closed edge.
    #[pyo3(get)]
    vertices: (usize, usize),
    /// The indices of the faces that meet here: one at a border, two, or twice the same at a seam.
    #[pyo3(get)]
    faces: Vec<usize>,
}

#[pymethods]
impl Edge {
    /// Make the object from its attributes, for pickles and copies.
    #[staticmethod]
    #[pyo3(name = "_of_parts")]
    fn of_parts(curve: Py<NurbsCurve>, vertices: (usize, usize), faces: Vec<usize>) -> Self {
        Self { curve, vertices, faces }
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        reduced(slf, &["curve", "vertices", "faces"])
    }

    /// The curve in space.
    #[getter]
    fn curve(&self, py: Python<'_>) -> Py<NurbsCurve> {
        self.curve.clone_ref(py)
    }

    /// Whether only one face ends here.
    #[getter]
    fn is_border(&self) -> bool {
        self.faces.len() == 1
    }

    fn __repr__(&self) -> String {
        let Self { vertices: (start, end), faces, .. } = self;
        let kind = match faces[..] {
            [face] => format!("border of face {face}"),
            [a, b] if a == b => format!("seam of face {a}"),
            _ => format!("between faces {} and {}", faces[0], faces[1]),
        };
        format!("Edge(from vertex {start} to {end}, {kind})")
    }
}

impl Edge {
    fn new(py: Python<'_>, edge: &brep::Edge) -> PyResult<Self> {
        let curve = Py::new(py, NurbsCurve::new(py, edge.curve.clone())?)?;
        let faces = edge.uses.iter().map(|place| place.face).collect();
        Ok(Self { curve, vertices: edge.vertices.into(), faces })
    }
}

/// Faces joined along common edges.
///
/// Each edge belongs to one face (a border) or to two whose normals agree. A shell without border
/// is closed and bounds a solid; then the normals should point outward.
///
/// Immutable: every operation returns a new shell.
///
/// Parameters
/// ----------
/// items : Face, NurbsSurface, or iterable of these
///     The faces.
/// tolerance : float, optional
///     Distance within which edges are the same, in the points' unit. By default 1e-6 of the
///     diagonal of all control points.
/// unit : {"mm", "cm", "m", "in", "ft"}, optional
///     The unit of the coordinates, which files store.
/// edges : list of lists of lists of int or None, optional
///     An identifier of the edge of each curve of each loop of each face; None where a curve is one
///     point in space. Curves with the same identifier are joined, whatever their positions. By
///     default edges are joined by position, and divided where others end on them.
///
/// Raises
/// ------
/// NeurbsError
///     If there are no faces, more than two meet at an edge, or the normals of two are opposite
///     there. The message gives the place.
///
/// Examples
/// --------
/// >>> import neurbs
/// >>> torus = neurbs.NurbsSurface.torus([0, 0, 0], 3, 1)
/// >>> shell = neurbs.Shell(torus)
/// >>> shell
/// Shell(1 face, 2 edges, closed)
/// >>> shell.euler_characteristic
/// 0
#[pyclass(frozen, module = "neurbs")]
pub(super) struct Shell {
    core: brep::Shell,
    /// Built by the first search for closest points.
    search: OnceLock<FaceSearch>,
}

impl From<brep::Shell> for Shell {
    fn from(core: brep::Shell) -> Self {
        Self { core, search: OnceLock::new() }
    }
}

/// A face from a `Face` or a `NurbsSurface`.
fn face_of(item: &Bound<'_, PyAny>) -> PyResult<Option<brep::Face>> {
    if let Ok(face) = item.cast::<Face>() {
        return Ok(Some(face.get().core().clone()));
    }
    let Ok(surface) = item.cast::<NurbsSurface>() else { return Ok(None) };
    Ok(Some(brep::Face::whole(surface.get().core().clone())?))
}

/// The faces of the items of a shell.
fn faces_of(items: &Bound<'_, PyAny>) -> PyResult<Vec<brep::Face>> {
    if let Some(face) = face_of(items)? {
        return Ok(vec![face]);
    }
    let refused = |item: &Bound<'_, PyAny>| bad_argument("items", "faces or surfaces", item);
    let all = items.try_iter().map_err(|_| refused(items))?;
    all.map(|item| item.and_then(|item| face_of(&item)?.ok_or_else(|| refused(&item)))).collect()
}

impl Shell {
    pub(super) fn core(&self) -> &brep::Shell {
        &self.core
    }

    /// The search structure for closest points, built on first use.
    pub(super) fn search(&self, watcher: &mut Watcher) -> Result<&FaceSearch> {
        if let Some(search) = self.search.get() {
            return Ok(search);
        }
        // Two threads may build it at the same time; the first one to finish is kept.
        let search = FaceSearch::new(self.core.faces(), watcher)?;
        Ok(self.search.get_or_init(|| search))
    }

    /// The edges of the loops' curves; `None` if curves were divided where others end on them.
    fn identifiers(&self) -> Option<Identifiers> {
        let of_face = |(f, face): (usize, &brep::Face)| {
            let of_loop = |(coedges, all): (&Vec<brep::Coedge>, &brep::Loop)| {
                let edges = coedges.iter().map(|coedge| coedge.edge).collect();
                (coedges.len() == all.curves().len()).then_some(edges)
            };
            self.core.coedges(f).iter().zip(face.loops()).map(of_loop).collect()
        };
        self.core.faces().iter().enumerate().map(of_face).collect()
    }
}

#[pymethods]
impl Shell {
    #[new]
    #[pyo3(signature = (items, *, tolerance=None, unit=None, edges=None))]
    fn py_new(
        items: &Bound<'_, PyAny>,
        tolerance: Option<&Bound<'_, PyAny>>,
        unit: Option<&Bound<'_, PyAny>>,
        edges: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let tolerance = optional_real("tolerance", tolerance)?;
        let named = |value| choice("unit", &LengthUnit::ALL, LengthUnit::symbol, value);
        let unit = unit.map(named).transpose()?;
        let faces = faces_of(items)?;
        let core = match edges {
            Some(edges) => {
                let must = "lists of lists of lists of integers or None";
                let refused = |_| bad_argument("edges", must, edges);
                let edges: Identifiers = edges.extract().map_err(refused)?;
                brep::Shell::with_edges(faces, &edges, tolerance)?
            }
            None => brep::Shell::new(faces, tolerance)?,
        };
        Ok(core.with_unit(unit).into())
    }

    /// The faces.
    #[getter]
    fn faces(&self) -> Vec<Face> {
        self.core.faces().iter().map(|face| face.clone().into()).collect()
    }

    /// The edges.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.Shell(neurbs.NurbsSurface.cylinder([0, 0, 0], [0, 0, 1], 1)).edges[1]
    /// Edge(from vertex 0 to 1, seam of face 0)
    #[getter]
    fn edges(&self, py: Python<'_>) -> PyResult<Vec<Edge>> {
        self.core.edges().iter().map(|edge| Edge::new(py, edge)).collect()
    }

    /// The edges that only one face uses.
    ///
    /// Returns
    /// -------
    /// list of Edge
    ///     Empty if the shell is closed.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> len(neurbs.Shell(neurbs.NurbsSurface.cylinder([0, 0, 0], [0, 0, 1], 1)).border())
    /// 2
    fn border(&self, py: Python<'_>) -> PyResult<Vec<Edge>> {
        self.core.border().map(|edge| Edge::new(py, edge)).collect()
    }

    /// The vertices: ndarray of shape (n, 3), read-only.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let values: &[f64] = bytemuck::cast_slice(self.core.vertices());
        let shape = [self.core.vertices().len(), 3];
        let array: Py<PyArrayDyn<f64>> = arrays::constant::<f64, IxDyn>(py, &shape, values)?;
        arrays::view(py, &array)
    }

    /// Distance within which edges and vertices are the same, in the points' unit.
    #[getter]
    fn tolerance(&self) -> f64 {
        self.core.tolerance()
    }

    /// The unit of the coordinates: "mm", "cm", "m", "in", "ft"; None if unknown.
    #[getter]
    fn unit(&self) -> Option<&'static str> {
        self.core.unit().map(LengthUnit::symbol)
    }

    /// Whether there are no border edges.
    #[getter]
    fn is_closed(&self) -> bool {
        self.core.is_closed()
    }

    /// Vertices minus edges plus faces, a face with h holes counted as 1 - h.
    ///
    /// It is 2 for a closed shell like a sphere, 0 for one like a torus, 1 for a disc.
    #[getter]
    fn euler_characteristic(&self) -> i64 {
        self.core.euler_characteristic()
    }

    /// Transform the shell by an affine map, a reflection included.
    ///
    /// Parameters
    /// ----------
    /// matrix : array_like of shape (3, 4) or (4, 4)
    ///     The matrix applied to column vectors (x, y, z, 1).
    ///
    /// Returns
    /// -------
    /// Shell
    ///     With the same unit. Normals that point outward still do.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     As :meth:`NurbsSurface.transformed`.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> torus = neurbs.Shell(neurbs.NurbsSurface.torus([0, 0, 0], 3, 1))
    /// >>> torus.transformed([[1, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0]]).vertices
    /// array([[9., 0., 0.]])
    fn transformed(&self, matrix: &Bound<'_, PyAny>) -> PyResult<Self> {
        Ok(self.core.transformed(&affine(matrix)?)?.into())
    }

    /// Convert the shell to another unit: the numbers change, the size stays.
    ///
    /// Parameters
    /// ----------
    /// unit : {"mm", "cm", "m", "in", "ft"}
    ///     The new unit. A shell without a unit gets it, with its numbers unchanged.
    ///
    /// Returns
    /// -------
    /// Shell
    ///     With this unit, the tolerance converted too.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the unit is unknown.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> ball = neurbs.Shell(neurbs.NurbsSurface.sphere([0, 0, 0], 2), unit="in")
    /// >>> ball.to_unit("mm").bounding_box()[1].round(9), ball.to_unit("mm").unit
    /// (array([50.8, 50.8, 50.8]), 'mm')
    fn to_unit(&self, unit: &Bound<'_, PyAny>) -> PyResult<Self> {
        let unit = choice("unit", &LengthUnit::ALL, LengthUnit::symbol, unit)?;
        Ok(self.core.to_unit(unit)?.into())
    }

    /// The shell as a dict of plain lists and numbers, for example for JSON.
    ///
    /// Returns
    /// -------
    /// dict
    ///     ``faces`` (see :meth:`Face.to_dict`), ``edges`` (the argument of the constructor; None
    ///     if curves were divided where others end on them), ``tolerance`` and ``unit``.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.Shell(neurbs.NurbsSurface.sphere([0, 0, 0], 1)).to_dict().get("edges")
    /// [[[None, 0, None, 0]]]
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        let faces = self.faces().iter().map(|face| face.to_dict(py)).collect::<PyResult<Vec<_>>>();
        dict.set_item("faces", faces?)?;
        dict.set_item("edges", self.identifiers())?;
        dict.set_item("tolerance", self.tolerance())?;
        dict.set_item("unit", self.unit())?;
        Ok(dict)
    }

    /// Make a shell from a dict returned by :meth:`to_dict`.
    ///
    /// Parameters
    /// ----------
    /// data : dict
    ///     ``faces``, and optionally ``edges``, ``tolerance`` and ``unit``.
    ///
    /// Returns
    /// -------
    /// Shell
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If there are no faces, or as in the constructor.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> shell = neurbs.Shell(neurbs.NurbsSurface.sphere([0, 0, 0], 1), unit="m")
    /// >>> neurbs.Shell.from_dict(shell.to_dict()) == shell
    /// True
    #[staticmethod]
    fn from_dict(data: &Bound<'_, PyAny>) -> PyResult<Self> {
        let py = data.py();
        let must = "a dict with faces";
        let items = Items::of(data, must)?;
        let faces = items.needed("faces", must)?;
        let refused = |_| bad_argument("data", must, data);
        let faces: PyResult<Vec<Face>> =
            faces.try_iter().map_err(refused)?.map(|face| Face::from_dict(&face?)).collect();
        Self::py_new(
            faces?.into_pyobject(py)?.as_any(),
            items.get("tolerance")?.as_ref(),
            items.get("unit")?.as_ref(),
            items.get("edges")?.as_ref(),
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
        let border = self.core.border().count();
        let kind = if border == 0 { "closed".into() } else { count(border, "border edge") };
        let faces = count(self.core.faces().len(), "face");
        format!("Shell({faces}, {}, {kind})", count(self.core.edges().len(), "edge"))
    }
}
