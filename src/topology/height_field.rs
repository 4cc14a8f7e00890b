//! Whether points are heights over a plane.

use glam::DVec3;
use rayon::prelude::*;

use super::direction::{FEWEST, across_rectangle, fills_as_well, least};
use crate::cloud::{KdTree, NeighborGraph, Plane, upward};

/// One of so many places may be steeper than the slope that counts.
pub(super) const STEEPER: usize = 50;

/// Steeper slopes (from the plane) are walls, over which heights would be no function or an
/// unevenly sampled one.
pub(crate) const WALL_DEGREES: f64 = 72.0;

/// Slopes from which on heights are steep, share of the points where those of a funnel may not be, and
/// resultant of the directions that slopes face in, as a share of their sum, from which on they face one side.
const STEEP_DEGREES: f64 = 40.0;
const GENTLE: f64 = 0.1;
const ONE_SIDED: f64 = 0.5;

/// Neighbours in the plane that must be neighbours on the surface.
const BELOW: usize = 5;

/// They are when they lie this near to the tangent plane, in spacings of the surface and in
/// deviations of its points from the plane.
const NEAR: (f64, f64) = (0.6, 4.0);

/// Share of points that may have something else above or below them: stray points, an overhanging
/// rim.
const OVERLAP: f64 = 0.02;

/// A direction along which the surface is a function of the plane across it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightField {
    /// The unit vector along which heights are measured: z if that will do, else, near the direction in which
    /// the points scatter least or that in which they face, the one across which they fill a rectangle.
    pub up: DVec3,
    /// Angle between the plane and the steepest places, two in a hundred points aside, in degrees.
    pub slope: f64,
    /// Whether they are those of a ground that other things stand on, as trees do: these are no heights.
    pub ground: bool,
}

/// Deviation of neighbours from their plane, in spacings, of most points below which layers a few spacings apart
/// are told from noise.
const SMOOTH: f64 = 0.15;

/// How many times farther than the median the farthest of the points around one may lie for the plane
/// nearest to them to tell how steep it is there: of tracks, those beside lie much farther than those
/// along.
const FARTHEST: f64 = 6.0;

/// How much steeper than walls, in degrees, a surface may be along a direction near that of its heights, and
/// along the one across which it fills a rectangle, which is known to a degree or two.
const ASIDE: f64 = 6.0;
const OVER_RECTANGLE: f64 = 2.0;

/// Normals by which the direction is found that a surface faces in, and the power by which the steepest of
/// them count.
const TELLING: usize = 500;
const POWER: i32 = 8;

/// What the surface is like around a point.
#[derive(Clone, Copy)]
pub(super) struct Tangent {
    normal: DVec3,
    /// How far its points scatter about the plane.
    deviation: f64,
    /// Mean distance to the neighbours.
    pub(super) spacing: f64,
}

impl Tangent {
    pub(super) fn is_smooth(&self) -> bool {
        self.deviation < SMOOTH * self.spacing
    }

    /// The angle between the tangent plane and the plane across a direction, in degrees.
    pub(super) fn slope(&self, up: DVec3) -> f64 {
        self.cosine(up).acos().to_degrees()
    }

    fn cosine(&self, up: DVec3) -> f64 {
        self.normal.dot(up).abs().min(1.0)
    }
}

/// The heights along z, or over the plane nearest to the points, if they are any.
pub(super) fn over_plane(points: &[DVec3], graph: &NeighborGraph) -> Option<HeightField> {
    let tangents = tangents(points, graph);
    let up = Plane::of(points.iter().copied()).upward();
    let mut directions = [DVec3::Z, up].into_iter();
    directions.find_map(|up| heights(points, &tangents, up, WALL_DEGREES))
}

/// The heights that the points are along whatever direction, if they are any.
pub(super) fn find(points: &[DVec3], graph: &NeighborGraph) -> Option<HeightField> {
    let tangents = tangents(points, graph);
    let plane = Plane::of(points.iter().copied()).upward();
    let over_plane = || near(points, &tangents, plane);
    let facing = || {
        // Slopes of scan lines are not those of the surface, but outlines are.
        let found = near(points, &tangents, facing(&tangents)?);
        found.filter(|found| fills_as_well(points, found.up, [DVec3::Z, plane]))
    };
    heights(points, &tangents, DVec3::Z, WALL_DEGREES).or_else(over_plane).or_else(facing)
}

/// The heights along this direction, if the points are, or near it along that across which they fill a
/// rectangle.
pub(super) fn along(points: &[DVec3], graph: &NeighborGraph, up: DVec3) -> Option<HeightField> {
    near(points, &tangents(points, graph), up)
}

fn near(points: &[DVec3], tangents: &[Tangent], up: DVec3) -> Option<HeightField> {
    let aside = heights(points, tangents, up, WALL_DEGREES + ASIDE)?;
    let better = across_rectangle(points, up);
    let found = (better != up)
        .then(|| heights(points, tangents, better, WALL_DEGREES + OVER_RECTANGLE))
        .flatten();
    found.or_else(|| Some(aside).filter(|aside| aside.slope <= WALL_DEGREES))
}

/// The heights along this direction, if the points are, with no walls steeper than so many degrees.
fn heights(
    points: &[DVec3],
    tangents: &[Tangent],
    up: DVec3,
    steepest: f64,
) -> Option<HeightField> {
    let slope = slope(tangents.iter(), up);
    let fits = slope <= steepest && overlap(points, tangents, up) <= OVERLAP;
    fits.then_some(HeightField { up, slope, ground: false })
}

/// The direction in which the surface faces: along which the steepest places are as gentle as may be. None of
/// few points, or of such as scatter, whose slopes are those of noise.
fn facing(tangents: &[Tangent]) -> Option<DVec3> {
    if tangents.len() < FEWEST || !mostly_smooth(tangents) {
        return None;
    }
    let telling = || tangents.iter().step_by(tangents.len().div_ceil(TELLING).max(1));
    let normals: Vec<DVec3> =
        telling().flat_map(|tangent| [tangent.normal, -tangent.normal]).collect();
    let steep = |tangent: &Tangent, up| (1.0 - tangent.cosine(up)).powi(POWER);
    let [first, second, _] = Plane::of(normals).axes;
    let cost = |up: DVec3| {
        let all = telling().map(|tangent| steep(tangent, up)).sum::<f64>();
        let aside = second.reject_from(up).normalize_or(up.any_orthonormal_vector());
        (all, [aside, up.cross(aside)])
    };
    Some(upward(least(first, cost)))
}

/// Whether points lie above one another along this direction, as far as noise lets that be seen.
pub(super) fn is_folded(points: &[DVec3], graph: &NeighborGraph, up: DVec3) -> bool {
    let tangents = tangents(points, graph);
    mostly_smooth(&tangents) && overlap(points, &tangents, up) > OVERLAP
}

/// Whether more than half of the points scatter so little that layers show.
pub(super) fn mostly_smooth(tangents: &[Tangent]) -> bool {
    2 * tangents.iter().filter(|tangent| tangent.is_smooth()).count() > tangents.len()
}

/// Whether heights are those of a funnel: steep, but for a tenth of the points at most, as no ground is, and
/// facing all around, as no slope does.
pub(super) fn is_funnel(points: &[DVec3], graph: &NeighborGraph, heights: &HeightField) -> bool {
    let up = heights.up;
    if heights.slope < STEEP_DEGREES {
        return false;
    }
    let tangents = tangents(points, graph);
    let gentle = tangents.iter().filter(|tangent| tangent.slope(up) < STEEP_DEGREES).count();
    let facing = |tangent: &Tangent| {
        let upward = tangent.normal * tangent.normal.dot(up).signum();
        upward - upward.dot(up) * up
    };
    let sum: DVec3 = tangents.iter().map(facing).sum();
    let lengths: f64 = tangents.iter().map(|tangent| facing(tangent).length()).sum();
    gentle as f64 <= GENTLE * points.len() as f64 && sum.length() < ONE_SIDED * lengths
}

pub(super) fn tangents(points: &[DVec3], graph: &NeighborGraph) -> Vec<Tangent> {
    let tangent = |index: usize| {
        let (own, edges) = (points[index], graph.edges(index));
        let around = || edges.iter().map(|edge| points[edge.to as usize]);
        let mut plane = Plane::of(std::iter::once(own).chain(around()));
        let deviation = plane.deviations[2];
        let mut lengths: Vec<f64> = edges.iter().map(|edge| edge.length).collect();
        lengths.sort_by(f64::total_cmp);
        if lengths.last() > lengths.get(lengths.len() / 2).map(|median| FARTHEST * median).as_ref()
        {
            // Directions count, however far they lead.
            let ways = around().map(|point| (point - own).normalize_or_zero());
            plane = Plane::of(ways.flat_map(|way| [way, -way]));
        }
        Tangent { normal: plane.normal(), deviation, spacing: graph.spacing(index) }
    };
    (0..points.len()).into_par_iter().map(tangent).collect()
}

/// The angle that all but the steepest places stay below, in degrees.
pub(super) fn slope<'a>(tangents: impl Iterator<Item = &'a Tangent>, up: DVec3) -> f64 {
    let mut cosines: Vec<f64> = tangents.map(|tangent| tangent.cosine(up)).collect();
    if cosines.is_empty() {
        return 90.0;
    }
    let steepest = (cosines.len() / STEEPER).min(cosines.len() - 1);
    let (_, cosine, _) = cosines.select_nth_unstable_by(steepest, f64::total_cmp);
    cosine.acos().to_degrees()
}

/// Share of the points that have something above or below them that is not their own surface.
fn overlap(points: &[DVec3], tangents: &[Tangent], up: DVec3) -> f64 {
    let covered = covers(points, tangents, up).iter().filter(|covers| !covers.is_empty()).count();
    covered as f64 / points.len() as f64
}

/// What each point has above or below it that is not its own surface.
pub(super) fn covers(points: &[DVec3], tangents: &[Tangent], up: DVec3) -> Vec<Vec<usize>> {
    let flat: Vec<DVec3> = points.iter().map(|&p| p - p.dot(up) * up).collect();
    let tree = KdTree::new(&flat);
    let covers = |index: u32| {
        let mut found = Vec::new();
        tree.nearest_to(index, BELOW, &mut found);
        let own = index as usize;
        let tangent = &tangents[own];
        let near = NEAR.0 * tangent.spacing + NEAR.1 * tangent.deviation;
        found.retain(|n| {
            let apart = points[n.index as usize] - points[own];
            tangent.normal.dot(apart).abs() > near + n.distance()
        });
        found.into_iter().map(|n| n.index as usize).collect()
    };
    let indices: Vec<u32> = (0..).zip(points).map(|(index, _)| index).collect();
    indices.into_par_iter().map(covers).collect()
}
