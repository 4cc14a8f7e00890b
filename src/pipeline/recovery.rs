//! The surface of a given net through all points, from the order that a surface with a larger net has found in them.

use glam::DVec3;

use super::candidate::{Candidate, Learned, Placed, Wanted};
use super::fitted::default_grid;
use super::own_frame::OwnFrame;
use super::report::Clock;
use super::shape::Shape;
use super::start::{OrderedStart, lattice, learn};
use super::{Aspect, ReconstructOptions};
use crate::error::{Error, Result};
use crate::fit::{EndedBy, Growth};
use crate::nurbs::NurbsSurface;
use crate::progress::Observer;
use crate::som::{Lattice, Topology};
use crate::topology::Kind;

/// Nodes either way of the map that takes the order over: enough for rolls by a net of four by four.
const SIDE: usize = 10;

impl<'a> Wanted<'a> {
    /// The sheet, or, where one through all points was looked for in vain, what is found in the order of a sheet
    /// whose net grows, or else by longer searches.
    pub(super) fn or_exact(
        &self,
        found: Candidate<'a>,
        clock: &mut Clock,
        observer: &mut dyn Observer,
    ) -> Result<Candidate<'a>> {
        if self.thorough || !found.job.in_vain {
            return Ok(found);
        }
        match self.in_order_of_grown(clock, observer) {
            Ok(other) if other.fit.ended_by == EndedBy::Exact => return Ok(other),
            Err(Error::Interrupted) => return Err(Error::Interrupted),
            _ => {}
        }
        Self { thorough: true, ..*self }.candidate(sheet(), None, clock, observer)
    }

    /// The sheet from a map that lies on one with as large a net as the points hold.
    fn in_order_of_grown(
        &self,
        clock: &mut Clock,
        observer: &mut dyn Observer,
    ) -> Result<Candidate<'a>> {
        let &Self { placed: Placed { frame, points, sample, .. }, budget, options, .. } = self;
        let options = &ReconstructOptions { grid: None, aspect: Aspect::Data, ..*options };
        let growth = Some(Growth { tolerance: None, most: options.max_control_points });
        let wanted = Wanted { budget: default_grid(points.len()), growth, options, ..*self };
        let grown = wanted.candidate(sheet(), None, clock, observer)?.fit.surface;
        let lattice = lattice((SIDE, SIDE), sample.len(), Topology::Sheet)?;
        let start = OrderedStart::new(lattice.clone(), in_cells(&grown, &lattice), budget);
        let observer: &mut dyn Observer = &mut OwnFrame { frame: *frame, observer };
        let map = learn(sample, &start, observer)?;
        let OrderedStart { net, creases, .. } = start;
        self.fitted(Learned { map, net, creases }, sheet(), self.growth, clock, observer)
    }
}

fn sheet() -> Shape {
    Shape::new(Kind::Sheet, None)
}

/// Places on a surface in the middle of as many cells as a lattice has nodes.
fn in_cells(surface: &NurbsSurface, lattice: &Lattice) -> Vec<DVec3> {
    let (rows, cols) = lattice.shape();
    let ends = [surface.knots_u().domain(), surface.knots_v().domain()];
    let at = |d: usize, share: f64| ends[d].0 + share * (ends[d].1 - ends[d].0);
    let middle = |i: usize, count: usize| (i as f64 + 0.5) / count as f64;
    let node = |i: usize| {
        let (row, col) = (i / cols, i % cols);
        surface.point(at(0, middle(row, rows)), at(1, middle(col, cols)))
    };
    (0..rows * cols).map(node).collect()
}
