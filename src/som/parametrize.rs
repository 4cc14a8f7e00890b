//! Continuous lattice coordinates (u, v) of points: the parameters for a surface fit.

use glam::{DVec2, DVec3};

use super::map::SelfOrganizingMap;
use super::nearest_lists::Lookup;
use crate::error::{Error, Result};
use crate::progress::Observer;

/// Largest allowed extrapolation beyond the border, in cells.
const MAX_EXTRAPOLATION: f64 = 1.0;

/// Gauss-Newton steps of a projection onto a cell, at most. One step is exact on a parallelogram;
/// twisted cells need a few more.
const MAX_STEPS: usize = 6;

/// Steps shorter than this, in cells, end the projection.
const MIN_STEP: f64 = 1e-12;

impl SelfOrganizingMap {
    /// Each point's parameters (u, v) in [0, 1]², along rows and columns. The point is projected
    /// onto the bilinear cells around its nearest node; the nearest projection is taken. Beyond the
    /// border the outer cells are extrapolated by at most `extrapolation` cells (0.75 is a good
    /// choice), and 0 and 1 are the ends of that. With an extrapolation of 0 they are the outermost
    /// nodes. Closed directions have period 1 and give values in [0, 1).
    ///
    /// ```
    /// use neurbs::{DVec2, DVec3, progress::Silent};
    /// use neurbs::som::{Init, Lattice, SelfOrganizingMap, SomOptions};
    /// let nodes: Vec<DVec3> =
    ///     (0..12).map(|i| DVec3::new(f64::from(i / 4), f64::from(i % 4), 0.0)).collect();
    /// let options = SomOptions { init: Init::Given(nodes.clone()), ..SomOptions::default() };
    /// let som = SelfOrganizingMap::new(&nodes, Lattice::quad(3, 4)?, &options, &mut Silent)?;
    /// let points = [DVec3::new(0.5, 2.25, 7.0), DVec3::new(9.0, 9.0, 0.0)];
    /// let uv = som.parametrize(&points, 0.75, &mut Silent)?;
    /// // The lattice has 2 × 3 cells, and 1.5 more with the extrapolation.
    /// assert!(uv[0].distance(DVec2::new(1.25 / 3.5, 3.0 / 4.5)) < 1e-12);
    /// assert!(uv[1].distance(DVec2::new(1.0, 1.0)) < 1e-12); // three quarters of a cell beyond
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if the lattice is a graph, which has no rows and columns, or if
    /// `extrapolation` is not from 0 to 1; else as [`Self::predict`].
    pub fn parametrize(
        &self,
        points: &[DVec3],
        extrapolation: f64,
        observer: &mut dyn Observer,
    ) -> Result<Vec<DVec2>> {
        let mut places = Vec::with_capacity(points.len());
        let take = |piece: &[DVec2]| places.extend_from_slice(piece);
        self.parameters(points, extrapolation, observer, take)?;
        Ok(places)
    }

    /// As [`Self::parametrize`], passing the results on in pieces.
    pub(crate) fn parameters(
        &self,
        points: &[DVec3],
        extrapolation: f64,
        observer: &mut dyn Observer,
        mut take: impl FnMut(&[DVec2]),
    ) -> Result<()> {
        let (rows, cols) = self.lattice.shape();
        let closed = self.lattice.topology().closed();
        let inside = |place: f64, nodes: usize, closed: bool| {
            if closed {
                return place;
            }
            let cells = nodes as f64 - 1.0;
            ((place * cells + extrapolation) / (cells + 2.0 * extrapolation)).clamp(0.0, 1.0)
        };
        self.lattice_places(points, extrapolation, observer, |piece| {
            let parameters = piece.iter().map(|place| {
                DVec2::new(inside(place.x, rows, closed.0), inside(place.y, cols, closed.1))
            });
            take(&parameters.collect::<Vec<_>>());
        })
    }

    /// Passes on each point's place on the lattice in pieces: as [`Self::parametrize`], but 0 and 1
    /// are the outermost nodes, and places beyond them are outside of [0, 1].
    pub(crate) fn lattice_places(
        &self,
        points: &[DVec3],
        extrapolation: f64,
        observer: &mut dyn Observer,
        take: impl FnMut(&[DVec2]),
    ) -> Result<()> {
        if !self.lattice.is_grid() {
            return Err(Error::parameter(
                "lattice",
                "a grid, because a graph has no coordinates",
                "a graph",
            ));
        }
        if !(0.0..=MAX_EXTRAPOLATION).contains(&extrapolation) {
            let must = "from 0 to 1, in cells";
            return Err(Error::parameter("extrapolation", must, extrapolation));
        }
        let cells = Cells::of(self, extrapolation);
        let place = |lookup: &mut Lookup<'_>, point| cells.place(lookup.nearest(point).0, point);
        self.measure(points, 1, observer, place, take)
    }
}

/// The bilinear cells of a map's lattice.
struct Cells<'a> {
    nodes: &'a [DVec3],
    sides: [Side; 2],
    extrapolation: f64,
}

/// One direction of the lattice.
#[derive(Clone, Copy)]
struct Side {
    nodes: usize,
    closed: bool,
}

impl Side {
    fn cells(self) -> usize {
        if self.closed { self.nodes } else { self.nodes - 1 }
    }

    /// The cells before and after a node.
    fn around(self, node: usize) -> [usize; 2] {
        let before = if self.closed { self.nodes - 1 } else { 0 };
        [node.checked_sub(1).unwrap_or(before), node.min(self.cells() - 1)]
    }

    /// The allowed range of a coordinate within a cell, extrapolation included.
    fn range(self, cell: usize, extrapolation: f64) -> (f64, f64) {
        let first = !self.closed && cell == 0;
        let last = !self.closed && cell + 1 == self.cells();
        (if first { -extrapolation } else { 0.0 }, if last { 1.0 + extrapolation } else { 1.0 })
    }

    /// Converts a coordinate within a cell to one along the whole side.
    fn share(self, cell: usize, place: f64) -> f64 {
        let share = (cell as f64 + place) / self.cells() as f64;
        if self.closed && share >= 1.0 { 0.0 } else { share }
    }
}

impl<'a> Cells<'a> {
    fn of(map: &'a SelfOrganizingMap, extrapolation: f64) -> Self {
        let (rows, cols) = map.lattice.shape();
        let (closed_u, closed_v) = map.lattice.topology().closed();
        let sides =
            [Side { nodes: rows, closed: closed_u }, Side { nodes: cols, closed: closed_v }];
        Self { nodes: &map.nodes, sides, extrapolation }
    }

    /// The lattice coordinates of a point with a known nearest node. Ties go to the lowest cell.
    fn place(&self, nearest: usize, point: DVec3) -> DVec2 {
        let [u, v] = self.sides;
        let (row, col) = (nearest / v.nodes, nearest % v.nodes);
        let mut best = (f64::INFINITY, DVec2::ZERO);
        for i in u.around(row) {
            for j in v.around(col) {
                let (place, squared) = self.project(i, j, point);
                if squared < best.0 {
                    best = (squared, DVec2::new(u.share(i, place.x), v.share(j, place.y)));
                }
            }
        }
        best.1
    }

    /// The projection of a point onto cell (i, j), in the cell's coordinates, and the squared
    /// distance.
    fn project(&self, i: usize, j: usize, point: DVec3) -> (DVec2, f64) {
        let [u, v] = self.sides;
        let node = |i: usize, j: usize| self.nodes[i % u.nodes * v.nodes + j % v.nodes];
        let origin = node(i, j);
        let (along_u, along_v) = (node(i + 1, j) - origin, node(i, j + 1) - origin);
        let twist = node(i + 1, j + 1) - origin - along_u - along_v;
        let (low_u, high_u) = u.range(i, self.extrapolation);
        let (low_v, high_v) = v.range(j, self.extrapolation);
        let (low, high) = (DVec2::new(low_u, low_v), DVec2::new(high_u, high_v));
        let offset =
            |p: DVec2| point - (origin + p.x * along_u + p.y * along_v + p.x * p.y * twist);
        let mut place = DVec2::splat(0.5);
        for _ in 0..MAX_STEPS {
            let (du, dv) = (along_u + place.y * twist, along_v + place.x * twist);
            let before = place;
            place = constrained(place, du, dv, offset(place), low, high);
            if (place - before).abs().max_element() <= MIN_STEP {
                break;
            }
        }
        (place, offset(place).length_squared())
    }
}

/// A Gauss-Newton step within a box: the point of the box whose tangent plane is nearest.
fn constrained(place: DVec2, du: DVec3, dv: DVec3, rest: DVec3, low: DVec2, high: DVec2) -> DVec2 {
    let (uu, uv, vv) = (du.dot(du), du.dot(dv), dv.dot(dv));
    let (ru, rv) = (rest.dot(du), rest.dot(dv));
    // A cell collapsed to a line or point has no unique projection; any will do.
    let (uu, vv) = (uu.max(f64::MIN_POSITIVE), vv.max(f64::MIN_POSITIVE));
    let determinant = (uu * vv - uv * uv).max(f64::EPSILON * uu * vv).max(f64::MIN_POSITIVE);
    let step = DVec2::new(vv * ru - uv * rv, uu * rv - uv * ru) / determinant;
    let free = place + step;
    if free.cmpge(low).all() && free.cmple(high).all() {
        return free;
    }
    // The constrained minimum of a convex function lies on an edge of the box: take the best of
    // four.
    let along_v = |u: f64| {
        let v = place.y + (rv - uv * (u - place.x)) / vv;
        DVec2::new(u, v.clamp(low.y, high.y))
    };
    let along_u = |v: f64| {
        let u = place.x + (ru - uv * (v - place.y)) / uu;
        DVec2::new(u.clamp(low.x, high.x), v)
    };
    let cost = |p: &DVec2| {
        let d = *p - place;
        uu * d.x * d.x + 2.0 * uv * d.x * d.y + vv * d.y * d.y - 2.0 * (ru * d.x + rv * d.y)
    };
    let walls = [along_v(low.x), along_v(high.x), along_u(low.y), along_u(high.y)];
    walls.into_iter().min_by(|a, b| cost(a).total_cmp(&cost(b))).unwrap_or(place)
}
