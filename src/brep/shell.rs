//! The shell: faces joined along their edges.

use std::sync::Arc;

use glam::{DAffine3, DVec3};

use super::edge::Edge;
use super::edge_matching::{match_by_identifier, match_by_position};
use super::face::Face;
use super::length_unit::LengthUnit;
use super::loops::Coedge;
use super::section::{Section, sections, split_at_ends};
use super::settings::BrepSettings;
use super::shell_builder::Topology;
use crate::error::{Error, Result, positive};
use crate::nurbs::NurbsSurface;

/// Faces joined along common edges.
///
/// Each edge is used by one loop, or by two in opposite directions. A shell without border edges is
/// closed and bounds a solid; then the faces' normals should point outward.
///
/// ```
/// use neurbs::{DVec3, Face, NurbsSurface, Shell};
/// let torus = Face::whole(NurbsSurface::torus(DVec3::ZERO, 3.0, 1.0)?)?;
/// let shell = Shell::new(vec![torus], None)?;
/// assert!(shell.is_closed());
/// // Two seams that meet in one vertex.
/// assert_eq!((shell.edges().len(), shell.vertices().len()), (2, 1));
/// # Ok::<(), neurbs::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Shell {
    faces: Vec<Face>,
    topology: Topology,
    unit: Option<LengthUnit>,
    tolerance: f64,
}

impl Shell {
    /// Joins faces along edges that are the same within `tolerance`, in the points' unit; `None`:
    /// 1e-6 of the diagonal of all control points.
    ///
    /// Edges are divided where edges of other faces end on them, and at the surface's creases.
    /// Edges shorter than the tolerance become vertices.
    ///
    /// ```
    /// use neurbs::{DVec3, Face, NurbsSurface, Shell};
    /// let plane = |x: f64| NurbsSurface::plane(x * DVec3::X, DVec3::X, DVec3::Y);
    /// let faces = vec![Face::whole(plane(0.0)?)?, Face::whole(plane(1.0)?)?];
    /// let shell = Shell::new(faces, None)?;
    /// assert_eq!((shell.edges().len(), shell.border().count()), (7, 6));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// - [`Error::Parameter`] if there are no faces, or the tolerance is not positive and finite.
    /// - [`Error::Shell`] with the place, if more than two faces meet at an edge, or the normals of
    ///   two faces are opposite there.
    pub fn new(faces: Vec<Face>, tolerance: Option<f64>) -> Result<Self> {
        let tolerance = tolerance_for(&faces, tolerance)?;
        let mut sections = sections(&faces, tolerance)?;
        if faces.len() > 1 {
            sections = split_at_ends(sections, tolerance)?;
        }
        let matches = match_by_position(&faces, &sections, tolerance)?;
        let topology = Topology::new(&faces, sections, &matches);
        Ok(Self { faces, topology, unit: None, tolerance })
    }

    /// The shell of one whole surface, with the default tolerance.
    ///
    /// ```
    /// use neurbs::{DVec3, NurbsSurface, Shell};
    /// let torus = NurbsSurface::torus(DVec3::ZERO, 3.0, 1.0)?;
    /// assert!(Shell::whole(torus)?.is_closed());
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Face::whole`] and [`Shell::new`].
    pub fn whole(surface: impl Into<Arc<NurbsSurface>>) -> Result<Self> {
        Self::new(vec![Face::whole(surface)?], None)
    }

    /// Joins faces along edges with the same identifier.
    ///
    /// `edges` gives the identifier of each curve of each loop of each face; `None` where the curve
    /// is one point in space. Positions are not compared, and no curve is divided.
    ///
    /// ```
    /// use neurbs::{DVec3, Face, NurbsSurface, Shell};
    /// let tube = Face::whole(NurbsSurface::cylinder(DVec3::ZERO, DVec3::Z, 1.0)?)?;
    /// // The second and the fourth side are the seam.
    /// let edges = [vec![vec![Some(0), Some(1), Some(2), Some(1)]]];
    /// assert_eq!(Shell::with_edges(vec![tube], &edges, None)?.edges().len(), 3);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Shell::new`]; also [`Error::Shell`] if the numbers of loops or curves do not match.
    pub fn with_edges(
        faces: Vec<Face>,
        edges: &[Vec<Vec<Option<usize>>>],
        tolerance: Option<f64>,
    ) -> Result<Self> {
        let tolerance = tolerance_for(&faces, tolerance)?;
        check_counts(&faces, edges)?;
        let mut sections = vec![];
        for (f, face) in faces.iter().enumerate() {
            for (l, of_loop) in face.loops().iter().enumerate() {
                for (curve, edge) in of_loop.curves().iter().zip(&edges[f][l]) {
                    let section = Section::new((f, l), face, curve.clone(), tolerance)?;
                    sections.push(Section { is_point: edge.is_none(), ..section });
                }
            }
        }
        let identifiers: Vec<Option<usize>> = edges.iter().flatten().flatten().copied().collect();
        let matches = match_by_identifier(&faces, &sections, &identifiers)?;
        let topology = Topology::new(&faces, sections, &matches);
        Ok(Self { faces, topology, unit: None, tolerance })
    }

    /// The faces.
    #[must_use]
    pub fn faces(&self) -> &[Face] {
        &self.faces
    }

    /// The coedges of each loop of a face, in the order of [`Face::loops`].
    #[must_use]
    pub fn coedges(&self, face: usize) -> &[Vec<Coedge>] {
        &self.topology.loops[face]
    }

    /// The edges.
    #[must_use]
    pub fn edges(&self) -> &[Edge] {
        &self.topology.edges
    }

    /// The vertices.
    #[must_use]
    pub fn vertices(&self) -> &[DVec3] {
        &self.topology.vertices
    }

    /// The distance within which edges and vertices are the same, in the points' unit.
    #[must_use]
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// The unit of length, if it is known.
    #[must_use]
    pub fn unit(&self) -> Option<LengthUnit> {
        self.unit
    }

    /// The same shell with a unit of length; coordinates are unchanged.
    #[must_use]
    pub fn with_unit(self, unit: Option<LengthUnit>) -> Self {
        Self { unit, ..self }
    }

    /// The shell in another unit: coordinates are converted, and the size stays. A shell without a
    /// unit keeps its coordinates and gets this one.
    ///
    /// ```
    /// use neurbs::{DVec3, Face, LengthUnit, NurbsSurface, Shell};
    /// let sphere = Face::whole(NurbsSurface::sphere(DVec3::ZERO, 1.0)?)?;
    /// let inches = Shell::new(vec![sphere], None)?.to_unit(LengthUnit::Inch)?;
    /// let millimeters = inches.to_unit(LengthUnit::Millimeter)?;
    /// assert_eq!(millimeters.vertices()[0], DVec3::new(0.0, 0.0, -25.4));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Net`] if a coordinate overflows.
    pub fn to_unit(&self, unit: LengthUnit) -> Result<Self> {
        let own = self.unit.unwrap_or(unit);
        if own == unit {
            return Ok(self.clone().with_unit(Some(unit)));
        }
        let factor = own.in_millimeters() / unit.in_millimeters();
        let scaled = self.transformed(&DAffine3::from_scale(DVec3::splat(factor)))?;
        Ok(scaled.with_unit(Some(unit)))
    }

    /// Whether there are no border edges.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.border().next().is_none()
    }

    /// The edges that only one loop uses.
    pub fn border(&self) -> impl Iterator<Item = &Edge> {
        self.topology.edges.iter().filter(|edge| edge.is_border())
    }

    /// The Euler characteristic: vertices minus edges plus faces, a face with h holes counted as
    /// 1 - h. It is 2 for a closed shell like a sphere, 0 like a torus, 1 for a disc.
    ///
    /// ```
    /// use neurbs::{DVec3, Face, NurbsSurface, Shell};
    /// let sphere = Face::whole(NurbsSurface::sphere(DVec3::ZERO, 1.0)?)?;
    /// assert_eq!(Shell::new(vec![sphere], None)?.euler_characteristic(), 2);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn euler_characteristic(&self) -> i64 {
        let count = |n: usize| i64::try_from(n).unwrap_or(i64::MAX);
        let faces: i64 = self.faces.iter().map(|face| 1 - count(face.inner().len())).sum();
        count(self.vertices().len()) - count(self.edges().len()) + faces
    }

    /// Applies an affine map, a reflection included.
    ///
    /// ```
    /// use neurbs::{DAffine3, DVec3, Face, NurbsSurface, Shell};
    /// let sphere = Face::whole(NurbsSurface::sphere(DVec3::ZERO, 1.0)?)?;
    /// let moved = Shell::new(vec![sphere], None)?
    ///     .transformed(&DAffine3::from_translation(DVec3::X))?;
    /// assert!(moved.vertices()[0].distance(DVec3::new(1.0, 0.0, -1.0)) < 1e-15);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Net`] if a coordinate overflows.
    pub fn transformed(&self, map: &DAffine3) -> Result<Self> {
        let faces = self.faces.iter().map(|face| face.transformed(map)).collect::<Result<_>>()?;
        let mut topology = self.topology.clone();
        for edge in &mut topology.edges {
            edge.curve = edge.curve.transformed(map)?;
        }
        for vertex in &mut topology.vertices {
            *vertex = map.transform_point3(*vertex);
        }
        let scale = map.matrix3.determinant().abs().cbrt();
        Ok(Self { faces, topology, unit: self.unit, tolerance: scale * self.tolerance })
    }
}

/// The tolerance, checked, or the default one.
fn tolerance_for(faces: &[Face], tolerance: Option<f64>) -> Result<f64> {
    if faces.is_empty() {
        return Err(Error::parameter("faces", "at least one", "none"));
    }
    if let Some(tolerance) = tolerance {
        return positive("tolerance", tolerance);
    }
    let boxes = faces.iter().map(|face| face.surface().net_box());
    let whole = boxes.reduce(|(a, b), (c, d)| (a.min(c), b.max(d)));
    let diagonal = whole.map_or(0.0, |(low, high)| low.distance(high));
    Ok((BrepSettings::STANDARD.matching * diagonal).max(f64::MIN_POSITIVE))
}

/// Checks that there is one identifier for each curve of each loop.
fn check_counts(faces: &[Face], edges: &[Vec<Vec<Option<usize>>>]) -> Result<()> {
    let counts = |face: &Face| -> Vec<usize> {
        face.loops().iter().map(|of_loop| of_loop.curves().len()).collect()
    };
    let given = edges.iter().map(|loops| loops.iter().map(Vec::len).collect::<Vec<usize>>());
    if faces.iter().map(counts).eq(given) {
        return Ok(());
    }
    let must = "have one identifier for each curve of each loop";
    Err(Error::Shell { must, got: "their numbers differ".into() })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;
    use crate::nurbs::{Direction, NurbsCurve};
    use crate::progress::Silent;

    fn shell(surface: NurbsSurface) -> Shell {
        Shell::new(vec![Face::whole(surface).unwrap()], None).unwrap()
    }

    /// Numbers of vertices, edges, border edges, and the Euler characteristic.
    fn counts(shell: &Shell) -> (usize, usize, usize, i64) {
        let border = shell.border().count();
        (shell.vertices().len(), shell.edges().len(), border, shell.euler_characteristic())
    }

    fn revolved(points: [DVec3; 3], angle: f64) -> Shell {
        let profile = NurbsCurve::clamped(points.to_vec(), 2).unwrap();
        let axis = (DVec3::ZERO, DVec3::Z);
        shell(NurbsSurface::revolved(&profile, axis.0, axis.1, angle, &mut Silent).unwrap())
    }

    #[test]
    fn one_surface_has_seams_and_poles() {
        let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0).unwrap();
        assert_eq!(counts(&shell(sphere.clone())), (2, 1, 0, 2));
        let (half, _) = sphere.split(Direction::V, 0.5, &mut Silent).unwrap();
        assert_eq!(counts(&shell(half)), (2, 2, 1, 1));
        let (lune, _) = sphere.split(Direction::U, 0.3, &mut Silent).unwrap();
        assert_eq!(counts(&shell(lune)), (2, 2, 2, 1));
        let torus = NurbsSurface::torus(DVec3::ZERO, 3.0, 1.0).unwrap();
        assert_eq!(counts(&shell(torus)), (1, 2, 0, 0));
        let tube = NurbsSurface::cylinder(DVec3::ZERO, DVec3::Z, 1.0).unwrap();
        assert_eq!(counts(&shell(tube)), (2, 3, 2, 0));
        let cone = NurbsSurface::cone(DVec3::ZERO, DVec3::Z, 1.0, 0.0).unwrap();
        assert_eq!(counts(&shell(cone)), (2, 2, 1, 1));
        let plane = NurbsSurface::plane(DVec3::ZERO, DVec3::X, DVec3::Y).unwrap();
        assert_eq!(counts(&shell(plane)), (4, 4, 4, 1));
        let poles = [DVec3::ZERO, DVec3::new(2.0, 0.0, 1.0), 3.0 * DVec3::Z];
        assert_eq!(counts(&revolved(poles, TAU)), (2, 1, 0, 2));
        assert_eq!(counts(&revolved(poles, PI)), (2, 2, 2, 1));
    }

    #[test]
    fn a_moebius_band_has_border_edges_where_it_meets_itself() {
        let row = |k: i32| {
            let turn = DVec3::new(f64::from(k).cos(), f64::from(k).sin(), 0.0);
            let out = 0.3 * (0.5 * f64::from(k)).cos();
            [turn * (2.0 - out), turn * (2.0 + out)]
        };
        let mut net: Vec<DVec3> = (0..6).flat_map(row).collect();
        let turned = [net[1], net[0]];
        net.extend(turned);
        let band = NurbsSurface::clamped(net, (7, 2), 2).unwrap();
        assert_eq!(shell(band).border().count(), 4);
    }

    /// The faces of the box from the origin to a corner, normals outward.
    fn box_faces(corner: DVec3) -> Vec<Face> {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis * corner);
        let mut faces = vec![];
        for k in 0..3 {
            let (a, b, c) = (axes[k], axes[(k + 1) % 3], axes[(k + 2) % 3]);
            let face = |origin| Face::whole(NurbsSurface::plane(origin, a, b).unwrap()).unwrap();
            faces.extend([face(DVec3::ZERO).reversed(), face(c)]);
        }
        faces
    }

    #[test]
    fn six_planes_make_a_closed_box() {
        let shell = Shell::new(box_faces(DVec3::new(1.0, 2.0, 3.0)), None).unwrap();
        assert_eq!(counts(&shell), (8, 12, 0, 2));
        let mut wrong = box_faces(DVec3::ONE);
        wrong[3] = wrong[3].reversed();
        let message = Shell::new(wrong, None).unwrap_err().to_string();
        assert!(message.contains("normals agree"), "{message}");
        let mut thrice = box_faces(DVec3::ONE);
        let inner = NurbsSurface::plane(DVec3::ZERO, DVec3::X, DVec3::Y + DVec3::Z).unwrap();
        thrice.push(Face::whole(inner).unwrap());
        let message = Shell::new(thrice, None).unwrap_err().to_string();
        assert!(message.contains("at most two faces"), "{message}");
    }

    #[test]
    fn edges_are_divided_where_others_end_on_them() {
        let plane = |x: f64, y: f64, a: f64| {
            let surface =
                NurbsSurface::plane(DVec3::new(x, y, 0.0), a * DVec3::X, DVec3::Y).unwrap();
            Face::whole(surface).unwrap()
        };
        // One wide rectangle below two narrow ones.
        let shell = Shell::new(
            vec![plane(0.0, 0.0, 2.0), plane(0.0, 1.0, 1.0), plane(1.0, 1.0, 1.0)],
            None,
        );
        let shell = shell.unwrap();
        assert_eq!(counts(&shell), (8, 10, 7, 1));
        assert_eq!(shell.coedges(0)[0].len(), 5);
    }

    #[test]
    fn a_trimmed_cap_closes_a_tube_with_another_start_of_the_circle() {
        let tube = NurbsSurface::cylinder(DVec3::ZERO, 2.0 * DVec3::Z, 1.0).unwrap();
        let cap = |z: f64| {
            let origin = DVec3::new(-2.0, -2.0, z);
            let plane = NurbsSurface::plane(origin, 4.0 * DVec3::X, 4.0 * DVec3::Y).unwrap();
            let turned = |angle: f64| 0.25 * DVec3::new(angle.cos(), angle.sin(), 0.0);
            let center = DVec3::new(0.5, 0.5, 0.0);
            let circle = NurbsCurve::arc(center, turned(1.0), turned(1.0 + PI / 2.0), TAU).unwrap();
            Face::trimmed(plane, vec![vec![circle]]).unwrap()
        };
        let faces = vec![Face::whole(tube).unwrap(), cap(0.0).reversed(), cap(2.0)];
        let shell = Shell::new(faces, None).unwrap();
        assert!(shell.is_closed());
        assert_eq!(shell.euler_characteristic(), 2);
        for edge in shell.edges() {
            for [end, vertex] in [[0, 0], [1, 1]] {
                let (start, stop) = edge.curve.knots().domain();
                let point = edge.curve.point([start, stop][end]);
                let place = shell.vertices()[edge.vertices[vertex]];
                assert!(point.distance(place) < 2.0 * shell.tolerance());
            }
        }
    }

    #[test]
    fn edge_curves_follow_the_surface_within_the_tolerance() {
        let torus = NurbsSurface::torus(DVec3::ZERO, 3.0, 1.0).unwrap();
        let center = DVec3::new(0.52, 0.47, 0.0);
        let circle = NurbsCurve::arc(center, 0.3 * DVec3::X, 0.2 * DVec3::Y, TAU).unwrap();
        let face = Face::trimmed(torus, vec![vec![circle]]).unwrap();
        let shell = Shell::new(vec![face.clone()], None).unwrap();
        // The knots at each quarter turn are no creases: the tangents do not jump.
        assert_eq!(shell.edges().len(), 1);
        assert_eq!(shell.euler_characteristic(), 1);
        for coedge in &shell.coedges(0)[0] {
            let edge = &shell.edges()[coedge.edge.unwrap()];
            let (start, end) = coedge.curve.knots().domain();
            for k in 0..=200 {
                let at = start + (end - start) * f64::from(k) / 200.0;
                let uv = coedge.curve.point(at);
                let distance = face.surface().point(uv.x, uv.y).distance(edge.curve.point(at));
                assert!(distance <= shell.tolerance(), "{distance}");
            }
        }
    }

    #[test]
    fn edges_are_divided_at_creases() {
        let net = [0.0, 1.0, 0.0]
            .into_iter()
            .zip(0..)
            .flat_map(|(z, k)| [0.0, 1.0].map(|y| DVec3::new(f64::from(k), y, z)));
        let roof = NurbsSurface::clamped(net.collect(), (3, 2), 1).unwrap();
        let center = DVec3::new(0.5, 0.5, 0.0);
        let circle = NurbsCurve::arc(center, 0.3 * DVec3::X, 0.3 * DVec3::Y, TAU).unwrap();
        let shell =
            Shell::new(vec![Face::trimmed(roof, vec![vec![circle]]).unwrap()], None).unwrap();
        // At the start of the circle and at both crossings.
        assert_eq!((shell.edges().len(), shell.euler_characteristic()), (3, 1));
    }

    #[test]
    fn reflections_keep_a_shell_closed_and_turn_its_faces() {
        let shell = Shell::new(box_faces(DVec3::ONE), None).unwrap();
        let mirrored =
            shell.transformed(&DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0))).unwrap();
        assert!(mirrored.is_closed());
        assert_eq!(Shell::new(mirrored.faces().to_vec(), None).unwrap().edges().len(), 12);
        assert!(mirrored.faces()[1].is_reversed());
    }
}
