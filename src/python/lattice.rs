//! The class `neurbs.Lattice`.

use pyo3::prelude::*;

use super::arguments;
use super::arrays::Numbers;
use crate::error::Error;
use crate::som::{Cells, Lattice as Core, Topology};

/// The nodes of a self-organizing map and their connections.
///
/// Create one with `Lattice.grid` or `Lattice.graph`.
///
/// Attributes
/// ----------
/// shape : (int, int)
///     Rows and columns; (nodes, 1) for a graph.
/// nodes : int
///     Number of nodes.
/// topology : str
///     ``"sheet"``, ``"tube"`` or ``"torus"``.
/// cells : str or None
///     ``"quad"`` or ``"triangular"``; None for a graph.
/// edges : list of (int, int)
///     Each edge once, the lower node first.
#[pyclass(frozen, eq, module = "neurbs")]
#[derive(Clone, PartialEq)]
pub(super) struct Lattice(pub(super) Core);

#[pymethods]
impl Lattice {
    /// A grid of nodes, numbered row by row.
    ///
    /// Parameters
    /// ----------
    /// rows, cols : int
    ///     Nodes along the two sides, at least 2 each, or 3 where the side is closed.
    /// cells : {"quad", "triangular"}, default "quad"
    ///     Whether inner nodes have four or six neighbors.
    /// topology : {"sheet", "tube", "torus"}, default "sheet"
    ///     Closed directions: none, u (rows), or both.
    #[staticmethod]
    #[pyo3(signature = (rows, cols, *, cells = None, topology = None))]
    fn grid(
        rows: &Bound<'_, PyAny>,
        cols: &Bound<'_, PyAny>,
        cells: Option<&Bound<'_, PyAny>>,
        topology: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let (rows, cols) = (arguments::count("rows", rows)?, arguments::count("cols", cols)?);
        let cells = match cells {
            Some(name) => arguments::choice("cells", &Cells::ALL, Cells::name, name)?,
            None => Cells::Quad,
        };
        let topology = match topology {
            Some(name) => arguments::choice("topology", &Topology::ALL, Topology::name, name)?,
            None => Topology::Sheet,
        };
        Ok(Self(Core::grid(rows, cols, cells, topology)?))
    }

    /// A lattice of any other topology.
    ///
    /// Parameters
    /// ----------
    /// nodes : int
    ///     Number of nodes, at least 2.
    /// edges : sequence of (int, int)
    ///     Pairs of different nodes, numbered from 0, or an array of shape (k, 2). The graph must
    ///     be connected.
    #[staticmethod]
    fn graph(nodes: &Bound<'_, PyAny>, edges: &Bound<'_, PyAny>) -> PyResult<Self> {
        let nodes = arguments::count("nodes", nodes)?;
        let expected = "a sequence of pairs of nodes";
        let numbers = Numbers::new(edges, "edges", expected, &[&[None, Some(2)], &[Some(0)]])?;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a non-negative integer; the cast saturates beyond all nodes"
        )]
        let node =
            |number: f64| (number.fract() == 0.0 && number >= 0.0).then_some(number as usize);
        let pair = |&[a, b]: &[f64; 2]| {
            node(a).zip(node(b)).ok_or_else(|| {
                let got = format!("({a}, {b})");
                Error::parameter("edges", "pairs of nodes, integers from 0", got)
            })
        };
        let edges: &[[f64; 2]] = numbers.as_slice()?;
        let edges: Vec<(usize, usize)> = edges.iter().map(pair).collect::<Result<_, _>>()?;
        Ok(Self(Core::graph(nodes, &edges)?))
    }

    #[getter]
    fn shape(&self) -> (usize, usize) {
        self.0.shape()
    }

    #[getter]
    fn nodes(&self) -> usize {
        self.0.len()
    }

    #[getter]
    fn topology(&self) -> &'static str {
        self.0.topology().name()
    }

    #[getter]
    fn cells(&self) -> Option<&'static str> {
        self.0.cells().map(Cells::name)
    }

    #[getter]
    fn edges(&self) -> Vec<(usize, usize)> {
        self.0.edges()
    }

    /// The nodes at most `radius` edges from `node`, ascending.
    fn neighborhood(
        &self,
        node: &Bound<'_, PyAny>,
        radius: &Bound<'_, PyAny>,
    ) -> PyResult<Vec<usize>> {
        let (node, radius) = (arguments::count("node", node)?, arguments::count("radius", radius)?);
        if node >= self.0.len() {
            let must = format!("a node from 0 to {}", self.0.len() - 1);
            return Err(Error::parameter("node", must, node).into());
        }
        Ok(self.0.neighborhood(node, radius))
    }

    fn __repr__(&self) -> String {
        let (rows, cols) = self.0.shape();
        match self.0.cells() {
            Some(cells) => {
                let (cells, topology) = (cells.name(), self.0.topology().name());
                format!("Lattice.grid({rows}, {cols}, cells='{cells}', topology='{topology}')")
            }
            None => format!("Lattice.graph({rows}, {} edges)", self.0.edges().len()),
        }
    }

    fn __hash__(&self) -> u64 {
        self.0.len() as u64
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let (py, lattice) = (slf.py(), &slf.get().0);
        let (rows, cols) = lattice.shape();
        let kind = slf.get_type();
        let functools = py.import("functools")?.getattr("partial")?;
        let kwargs = pyo3::types::PyDict::new(py);
        let maker = if let Some(cells) = lattice.cells() {
            kwargs.set_item("rows", rows)?;
            kwargs.set_item("cols", cols)?;
            kwargs.set_item("cells", cells.name())?;
            kwargs.set_item("topology", lattice.topology().name())?;
            kind.getattr("grid")?
        } else {
            kwargs.set_item("nodes", rows)?;
            kwargs.set_item("edges", lattice.edges())?;
            kind.getattr("graph")?
        };
        let maker = functools.call((maker,), Some(&kwargs))?;
        Ok((maker, pyo3::types::PyTuple::empty(py).into_any()))
    }
}

/// Rows and columns of the default lattice for this many points.
#[pyfunction]
pub(super) fn lattice_for_points(points: usize) -> (usize, usize) {
    Core::for_points(points).shape()
}
