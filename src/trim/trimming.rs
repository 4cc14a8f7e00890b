//! Trimming: from points' parameters to faces.

use std::sync::Arc;

use glam::DVec2;

use super::border::Border;
use super::coverage::shares_beyond;
use super::options::TrimOptions;
use super::outcome::{Doubt, LoopOutcome, Trim};
use super::outline::{Outline, faces};
use super::outside::outside_shares;
use super::places::{Places, Rectangle};
use super::rectangle_distance::follows_sides;
use super::region::Region;
use super::seam::with_free_seams;
use super::settings::{DoubtSettings, OutlineSettings};
use super::triangulation::Triangulation;
use crate::brep::Face;
use crate::error::Result;
use crate::numeric::quantile;
use crate::nurbs::NurbsSurface;
use crate::progress::{Observer, Stage, interrupt_check};
use crate::worker_pool;

const SETTINGS: DoubtSettings = DoubtSettings::STANDARD;

/// The faces of a surface that end where points end.
///
/// `uv` are the parameters of points on the surface. Faces are bounded by curves around the
/// regions that hold points, and around holes. Parts without points are outside if a disc finds
/// room there that a random scatter hardly has. The faces' loops are proved to be simple and
/// disjoint. Where a region does not wind around a closed surface, the faces' surface begins
/// elsewhere: its parameters differ by whole turns. O(n log n) for up to 200,000 points; of more, one a square counts.
///
/// ```
/// use std::sync::Arc;
/// use neurbs::{DVec2, DVec3, NurbsSurface, progress::Silent, trim::{TrimOptions, trim}};
/// let plane = Arc::new(NurbsSurface::plane(DVec3::ZERO, DVec3::X, DVec3::Y)?);
/// let grid = (0..1600).map(|k| DVec2::new(f64::from(k / 40) / 39.0, f64::from(k % 40) / 39.0));
/// let disc: Vec<DVec2> = grid.filter(|at| at.distance(DVec2::splat(0.5)) < 0.4).collect();
/// let trimmed = trim(&plane, &disc, &TrimOptions::default(), &mut Silent)?;
/// assert_eq!(trimmed.faces.len(), 1);
/// assert!(trimmed.faces[0].inner().is_empty() && !trimmed.pointless);
/// # Ok::<(), neurbs::Error>(())
/// ```
///
/// # Errors
///
/// - [`Error::Parameter`](crate::Error::Parameter) if a parameter is outside of the surface's
///   domain, or `border` is out of range.
/// - [`Error::Net`](crate::Error::Net) if clamping the surface's knots overflows.
/// - [`Error::Interrupted`](crate::Error::Interrupted) if the observer stops it.
pub fn trim(
    surface: &Arc<NurbsSurface>,
    uv: &[DVec2],
    options: &TrimOptions,
    observer: &mut dyn Observer,
) -> Result<Trim> {
    let offset = options.offset()?;
    worker_pool::run_observed(uv.len(), observer, |observer| {
        // Clamped, as faces have it, so that all faces share it.
        let whole = Face::whole(Arc::clone(surface))?;
        let places = Places::of(surface, uv, observer)?;
        if places.len() < SETTINGS.min_places {
            let (places, needed) = (places.len(), SETTINGS.min_places);
            return Ok(untrimmed(whole, Doubt::TooFewPlaces { places, needed }));
        }
        let mut check_interrupt = interrupt_check(observer, Stage::Fitting, uv.len());
        let triangulation = Triangulation::of(&places);
        check_interrupt()?;
        let region = Region::of(&places, &triangulation, &mut check_interrupt)?;
        let surface = with_free_seams(whole.surface(), &places, &triangulation, &region)?;
        let rectangle = Rectangle::of(&surface);
        let mut borders = Border::all(&places, &triangulation, &region);
        if !options.holes {
            borders.retain(|border| !border.is_hole());
        }
        let mut made = Trim {
            faces: vec![],
            loops: vec![],
            regions: region.islands(),
            doubt: doubt(&region, &borders),
            pointless: false,
            outside: 0.0,
            beyond: None,
            beyond_untrimmed: None,
            spacing: [0.1, 0.5, 0.9].map(|share| quantile(region.spacing.iter().copied(), share)),
            clumping: region.clumping,
        };
        let mut outside = region.left_out;
        for piece in 0..made.regions {
            check_interrupt()?;
            let own: Vec<&Border> = borders.iter().filter(|b| b.piece as usize == piece).collect();
            let Some((faces, outlines)) = faces(&surface, &rectangle, &own, offset)? else {
                return Ok(untrimmed(whole, Doubt::NotSimple));
            };
            made.faces.extend(faces);
            for (border, outline) in own.iter().zip(&outlines) {
                made.loops.push(LoopOutcome::of(border, outline, piece));
                outside += count_outside(border, outline, &surface)?;
            }
        }
        if made.faces.is_empty() {
            return Ok(untrimmed(whole, Doubt::NotSimple));
        }
        made.outside = outside as f64 / places.len() as f64;
        check_interrupt()?;
        let beyond = shares_beyond(&made.faces, &surface, &places, &region.spacing)?;
        (made.beyond, made.beyond_untrimmed) = (Some(beyond.0), Some(beyond.1));
        made.pointless = is_pointless(&made, &surface, &rectangle)?;
        Ok(made)
    })
}

/// The whole surface, with the reason.
fn untrimmed(whole: Face, doubt: Doubt) -> Trim {
    Trim {
        faces: vec![whole],
        loops: vec![],
        regions: 1,
        doubt: Some(doubt),
        pointless: true,
        outside: 0.0,
        beyond: None,
        beyond_untrimmed: None,
        spacing: [0.0; 3],
        clumping: 1.0,
    }
}

/// Why a region is doubtful.
fn doubt(region: &Region, borders: &[Border]) -> Option<Doubt> {
    let holes = borders.iter().filter(|border| border.is_hole()).count();
    if region.clumping >= SETTINGS.clumping {
        Some(Doubt::Clumped { clumping: region.clumping })
    } else if holes > SETTINGS.max_holes {
        Some(Doubt::TooManyHoles { holes, most: SETTINGS.max_holes })
    } else {
        None
    }
}

/// The number of places of a border that are outside of its curves.
fn count_outside(border: &Border, outline: &Outline, surface: &NurbsSurface) -> Result<usize> {
    let outside = outside_shares(border, &outline.curves, surface)?;
    let least = OutlineSettings::STANDARD.outside;
    Ok(outside.iter().filter(|distance| **distance > least).count())
}

/// Whether the whole surface is as good as the faces.
fn is_pointless(made: &Trim, surface: &NurbsSurface, rectangle: &Rectangle) -> Result<bool> {
    let [face] = &made.faces[..] else { return Ok(false) };
    let plain = made.regions == 1 && made.loops.iter().all(|of| !of.is_hole);
    Ok(plain && follows_sides(face, surface, rectangle, made.spacing[1])?)
}

impl LoopOutcome {
    fn of(border: &Border, outline: &Outline, region: usize) -> Self {
        Self {
            region,
            is_hole: border.is_hole(),
            winds: border.winds(),
            form: outline.form,
            corners: outline.corners,
            length: border.length(),
        }
    }
}
