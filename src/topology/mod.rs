//! What kind of surface points lie on: sheet, tube, torus, or heights over a plane.
//!
//! Heights have nothing above one another, or are a ground on which things stand that are rough and high,
//! as trees are in a scan from the air.
//!
//! Loops of the surface that cannot be shrunk tell tubes and tori from sheets, wherever these are
//! bent; they come with angles around them ([`Chart`]), which are an ordered start for a closed
//! lattice. Loops around holes do not count: a hole's rim is short as compared with the outline.

mod axis;
mod border;
mod circle;
mod cloud;
mod cohomology;
mod conjugate;
mod cylinder;
mod direction;
mod disc;
mod form;
mod ground;
mod height_field;
mod kind;
mod laplacian;
mod lengthwise;
mod nearest_circle;
mod pairs;
mod ring;
mod spread_out;
mod start;

use glam::DVec3;

use self::cloud::MOST_FOR_LOOPS;
use crate::cloud::{Neighborhoods, own_sample};
use crate::error::Result;
use crate::progress::Observer;

pub(crate) use self::axis::Pipe;
pub(crate) use self::cloud::Cloud;
pub(crate) use self::disc::disc;
pub use self::height_field::HeightField;
pub(crate) use self::height_field::WALL_DEGREES;
pub(crate) use self::kind::Kind;
pub use self::kind::Topology;
pub(crate) use self::lengthwise::{Lengthwise, lengthwise};
pub(crate) use self::ring::ring;
pub use self::start::Chart;

/// Points that slopes are told from, evenly over space.
const MOST: usize = 5000;

/// Points among which loops are looked for where a sheet is wanted, whatever they show.
const MOST_OF_SHEET: usize = 2500;

/// Points that are looked at for layers close above one another.
const MOST_OF_LAYERS: usize = 20_000;

/// Fewer points show a loop only where it does not exist, unless one is known to exist.
const FEWEST: usize = 60;

/// Fewer may lie near a cylinder whatever they lie on.
const FEWEST_AROUND: usize = 40;

/// What a user should know who asks for a sheet around a closed body.
const CLOSED: &str = "the points lie on a body that is closed, or nearly so: a sheet can cover it only with a slit or \
    by great stretching";

/// Finds out what kind of surface the points lie on. They should be
/// [clean](crate::cloud::clean).
///
/// Looks at 5,000 points at most for slopes, chosen evenly over space, at 10,000 for loops, at 20,000 for
/// layers above one another, and at 200,000 for a ground on which things stand, unless it has walls.
///
/// ```
/// use neurbs::{DVec3, chart::Kind, progress::Silent, topology::detect};
/// let points: Vec<DVec3> = (0..1000)
///     .map(|i| (f64::from(i) * 2.4, f64::from(i) / 250.0))
///     .map(|(angle, z)| DVec3::new(angle.cos(), angle.sin(), z))
///     .collect();
/// let topology = detect(&points, &mut Silent)?;
/// assert_eq!(topology.kind, Kind::Tube);
/// assert!(topology.reason.contains("closes around"));
/// # Ok::<(), neurbs::Error>(())
/// ```
///
/// # Errors
///
/// [`crate::Error::Interrupted`] if the observer stops it.
pub fn detect(points: &[DVec3], observer: &mut dyn Observer) -> Result<Topology> {
    Ok(detect_among(points, points, None, None, observer)?.0)
}

/// As [`detect`], of points that a surface of this kind is wanted for, whatever they lie on: looks no
/// closer than that needs. For a sheet, loops are only looked for where the lack of a border shows
/// that it may be one of a closed body; what is to be closed is not asked whether it is heights, and a
/// tube that shows at first sight is not looked at again for the second loop of a torus.
///
/// ```
/// use neurbs::{DVec3, chart::Kind, progress::Silent, topology::detect_wanted};
/// let points: Vec<DVec3> = (0..1000)
///     .map(|i| (f64::from(i) * 2.4, f64::from(i) / 250.0))
///     .map(|(angle, z)| DVec3::new(angle.cos(), angle.sin(), z))
///     .collect();
/// let topology = detect_wanted(&points, Kind::Tube, &mut Silent)?;
/// assert!(topology.chart.is_some());
/// # Ok::<(), neurbs::Error>(())
/// ```
///
/// # Errors
///
/// [`crate::Error::Interrupted`] if the observer stops it.
pub fn detect_wanted(
    points: &[DVec3],
    wanted: Kind,
    observer: &mut dyn Observer,
) -> Result<Topology> {
    Ok(detect_among(points, points, Some(wanted), None, observer)?.0)
}

/// As [`detect`], of points that are only asked whether they are heights along z or over the plane nearest to
/// them: in another unit than theirs, other directions mean nothing.
pub(crate) fn heights(
    points: &[DVec3],
    observer: &mut dyn Observer,
) -> Result<Option<HeightField>> {
    let cloud = Cloud::of(points, MOST, Some(Kind::Height), observer)?;
    Ok(height_field::over_plane(&cloud.points, &cloud.graph))
}

/// As [`detect`], of points that are only asked whether they are heights along this direction.
pub(crate) fn heights_along(
    points: &[DVec3],
    up: DVec3,
    observer: &mut dyn Observer,
) -> Result<Option<HeightField>> {
    let cloud = Cloud::of(points, MOST, Some(Kind::Height), observer)?;
    let found = height_field::along(&cloud.points, &cloud.graph, up);
    let folded = found.is_some() && is_folded(points, cloud.points.len(), up, observer)?;
    Ok(found.filter(|_| !folded))
}

/// As [`detect`], or as [`detect_wanted`], of points that are evenly over space some of `all`, and around which may be
/// known what is near; and the points that were looked at.
pub(crate) fn detect_among(
    points: &[DVec3],
    all: &[DVec3],
    wanted: Option<Kind>,
    known: Option<&Neighborhoods>,
    observer: &mut dyn Observer,
) -> Result<(Topology, Cloud)> {
    let sheet = wanted == Some(Kind::Sheet);
    let closed = matches!(wanted, Some(Kind::Tube | Kind::Torus));
    let mut cloud = match known {
        Some(known) => Cloud::among(points, known, wanted),
        None => Cloud::of(points, MOST, wanted, observer)?,
    };
    if !closed
        && let Some(height) = height_field::find(&cloud.points, &cloud.graph)
        && !is_folded(points, cloud.points.len(), height.up, observer)?
        // Seen askew, rings far from one another do not lie above one another.
        && (wanted.is_some() || cloud.near_cylinder().is_none())
    {
        let heights = Topology::of_heights(height);
        let settled = wanted.is_some() || cloud.points.len() < FEWEST;
        if settled || !height_field::is_funnel(&cloud.points, &cloud.graph, &height) {
            return Ok((heights, cloud));
        }
        // A funnel is heights over a ring; what it leaves open is no hole to be filled.
        cloud = cloud.closer(points, observer)?;
        let found = cloud.shown(observer)?;
        return Ok((if found.kind == Kind::Tube { found } else { heights }, cloud));
    }
    if wanted.is_none()
        && let Some(height) = ground::find(&cloud.points, &cloud.graph, all, observer)?
    {
        return Ok((Topology::of_heights(height), cloud));
    }
    if sheet && cloud.points.len() >= FEWEST {
        match cloud.border() {
            None => {
                return Ok((
                    Topology::new(Kind::Sheet, "noise hides whether it has a border"),
                    cloud,
                ));
            }
            Some(_) if !cloud.is_closed() => {
                return Ok((Topology::new(Kind::Sheet, "it has a border"), cloud));
            }
            Some(_) => {}
        }
    }
    cloud = cloud.closer(points, observer)?;
    let count = cloud.points.len();
    if count < FEWEST && !closed {
        let reason = format!("{count} points are too few to show that it closes");
        let round = if sheet || count < FEWEST_AROUND { None } else { cloud.round() };
        return Ok((round.unwrap_or_else(|| Topology::new(Kind::Sheet, reason)), cloud));
    }
    if sheet && count > MOST_OF_SHEET {
        cloud = Cloud::of(&cloud.points, MOST_OF_SHEET, wanted, observer)?;
    }
    let found = cloud.shown(observer)?;
    if sheet && found.kind != Kind::Sheet {
        let warning = format!("{CLOSED}; {}: ask for a {}", found.reason, found.kind.name());
        let found = Topology { warning: Some(warning), ..Topology::new(Kind::Sheet, found.reason) };
        return Ok((found, cloud));
    }
    Ok((found, cloud))
}

/// The tube that is wanted around points, by its loops alone: places along it are ways on the surface.
fn tube_by_loops(points: &[DVec3], observer: &mut dyn Observer) -> Result<Topology> {
    let cloud = Cloud::of(points, MOST, Some(Kind::Tube), observer)?;
    cloud.closer(points, observer)?.by_loops(observer)
}

/// The pipe on which points lie, if they lie around an axis that is much longer than the ways around it, or few near a
/// cylinder.
pub(crate) fn around_axis(points: &[DVec3], observer: &mut dyn Observer) -> Result<Option<Pipe>> {
    let cloud = Cloud::of(&own_sample(points, MOST_FOR_LOOPS), MOST_FOR_LOOPS, None, observer)?;
    Ok(cloud.pipe(&cloud.points))
}

/// Whether hardly any of the points are seen to lie on a border: that what they lie on is closed, or too rough to tell.
pub(crate) fn hardly_ends(points: &[DVec3]) -> bool {
    cloud::hardly_ends(border::count(points), points.len())
}

/// Whether more points than were looked at show layers above one another along this direction.
fn is_folded(
    points: &[DVec3],
    looked_at: usize,
    up: DVec3,
    observer: &mut dyn Observer,
) -> Result<bool> {
    if points.len() == looked_at {
        return Ok(false);
    }
    let cloud = Cloud::of(&own_sample(points, MOST_OF_LAYERS), MOST_OF_LAYERS, None, observer)?;
    Ok(height_field::is_folded(&cloud.points, &cloud.graph, up))
}
