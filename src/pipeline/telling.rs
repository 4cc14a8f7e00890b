//! What some points of a cloud tell of the units of its axes.

use glam::DVec3;

use super::ReconstructOptions;
use super::measured::PORTION;
use super::relief::{Relief, thicknesses};
use super::start::whole;
use super::units::Units;
use crate::cloud::{EvenSample, KdTree, Plane, across_lines, any_of, pieces};
use crate::error::Result;
use crate::progress::Observer;
use crate::topology::{HeightField, Kind, around_axis, detect, heights, heights_along};
use crate::validate::UNEVEN;

/// Points that tell, about so many: any of the cloud, as the more there are in a place the more it
/// counts.
const TELLING: usize = 1000;

/// Points that show heights from near: the more there are, the steeper may be what lies between.
const CLOSE: usize = 20_000;

/// Points that show whether they go around.
const SHOWING_LOOPS: usize = 2500;

/// Share of the points that may lie beyond what counts as their extent on either side: outliers.
const BEYOND: f64 = 0.02;

/// Neighbours of a point that tell how points lie around it.
const NEIGHBORS: usize = 8;

/// How many times more alike neighbours must lie in all directions if a cloud a hundred times longer
/// than wide is taken for a strip.
const STRIP: f64 = 4.0;

/// Share of its width under which the thickness of a cloud makes it a plate, which may stand.
const PLATE: f64 = 0.1;

/// Points that have a height in common, on average, if they lie on levels.
const LEVEL: usize = 10;

/// Height of a surface by its extents across, and of a ground that is rough: its slopes may be many times
/// steeper than all of it; and of one where its heights have another unit for sure, as they extend so much
/// farther.
const HEIGHT: f64 = 0.25;
const GROUND: f64 = 1.0 / 16.0;
const FAR_HIGHER: f64 = 1.0 / 64.0;

/// Share of a surface that must be wall for its units to be doubted, and for them to be wrong unless it is the
/// surface for sure that its points sample evenly: no ground is wall all over.
const MOSTLY: f64 = 0.3;
const ALL_OVER: f64 = 0.9;
const SURELY_ON_SURFACE: f64 = 2.0;

/// Share of what planes leave of heights in the points' own units that they may leave of others, and of the
/// heights of a ground, or of one that has another unit for sure: both sides of a body leave more than twice as much.
const UNEXPLAINED: f64 = 0.5;
const MOSTLY_EXPLAINED: f64 = 0.3;
const PARTLY_EXPLAINED: f64 = 0.5;

/// How many times flatter a surface must be around most points for their own units to be right; and the thickness
/// of what is around points, as a share of its width, that three quarters of those on a smooth one stay below,
/// and how many times thicker its thickest tenth may be than in other units; and what that stays below on a body.
const FLATTER: f64 = 1.2;
const SMOOTH: f64 = 0.33;
const AS_FLAT: f64 = 1.3;
const SMOOTH_BODY: f64 = 0.5;

/// What some points tell.
pub(super) struct Telling<'a> {
    cloud: &'a [DVec3],
    points: Vec<DVec3>,
    extents: DVec3,
}

impl<'a> Telling<'a> {
    pub(super) fn of(cloud: &'a [DVec3]) -> Self {
        let points = any_of(cloud, TELLING);
        let extent = |axis: usize| {
            let mut along: Vec<f64> = points.iter().map(|point| point[axis]).collect();
            along.sort_by(f64::total_cmp);
            let beyond = whole(BEYOND * along.len() as f64);
            along
                .get(beyond..along.len() - beyond)
                .and_then(|kept| Some(kept.last()? - kept.first()?))
        };
        let extents = DVec3::from([0, 1, 2].map(|axis| extent(axis).unwrap_or(0.0)));
        Self { cloud, points, extents }
    }

    /// What makes an axis about as long as others, where it is longer than both by so much that it has another
    /// unit, or shorter, and the points lie on a body then.
    pub(super) fn evened(&self, observer: &mut dyn Observer) -> Result<DVec3> {
        let mut axes = [0, 1, 2];
        axes.sort_by(|&a, &b| self.extents[b].total_cmp(&self.extents[a]));
        let [longest, second, shortest] = axes;
        let [long, middle, short] = axes.map(|axis| self.extents[axis]);
        let mut by = DVec3::ONE;
        if long > UNEVEN * middle && middle > 0.0 {
            let evened = with(by, longest, power(middle / long));
            let unlike = |by| self.unlikeness(by, (longest, second));
            let strip = STRIP * unlike(by) < unlike(evened);
            if !strip && (self.explained(evened, observer)? || self.are_smooth(evened, by)) {
                by = evened;
            }
        }
        if middle > UNEVEN * short && short > 0.0 {
            let long = by[longest] * long;
            let evened = self.flattest(by, shortest, [middle, long]);
            if self.are_on_body(evened, shortest, observer)? {
                by = evened;
            }
        }
        Ok(by)
    }

    /// What makes an axis as long as the longest, or less, so that the surface is flattest where it is thickest:
    /// it is squeezed nowhere then. If it is the flatter the less the axis counts, as what is straight along it,
    /// what makes that as long as the middle one.
    fn flattest(&self, by: DVec3, axis: usize, [middle, long]: [f64; 2]) -> DVec3 {
        let thickness = |count: f64| self.thickness(with(by, axis, count), [0.9])[0];
        let [mut count, evened] = [long, middle].map(|length| power(length / self.extents[axis]));
        let (mut flattest, mut found) = (f64::INFINITY, count);
        while count >= HEIGHT * evened {
            let thickness = thickness(count);
            if thickness < flattest {
                (flattest, found) = (thickness, count);
            }
            count *= 0.5;
        }
        with(by, axis, if thickness(count) < flattest { evened } else { found })
    }

    /// How thick what lies around these shares of the points is at most, beside how wide, if coordinates count so
    /// much; infinitely, if most lie in lines.
    fn thickness<const N: usize>(&self, by: DVec3, shares: [f64; N]) -> [f64; N] {
        let sorted = thicknesses(&self.counted(by));
        let at = |share: f64| sorted.get(whole(share * sorted.len() as f64)).copied();
        shares.map(|share| at(share).unwrap_or(f64::INFINITY))
    }

    /// Whether the points lie on a smooth surface if coordinates count so much, and less so if they count as
    /// much as that.
    fn are_smooth(&self, by: DVec3, than: DVec3) -> bool {
        let [[half], [other_half]] = [by, than].map(|by| self.thickness(by, [0.5]));
        half < SMOOTH && FLATTER * half < other_half
    }

    /// Whether the points lie on one smooth surface if coordinates count so much, that is no heights along an axis.
    fn are_on_body(&self, by: DVec3, axis: usize, observer: &mut dyn Observer) -> Result<bool> {
        let [nearly_all] = self.thickness(by, [0.9]);
        if nearly_all > SMOOTH_BODY {
            return Ok(false);
        }
        for height in [HEIGHT, GROUND] {
            let flat = with(by, axis, height * by[axis]);
            let (up, points) = (DVec3::AXES[axis], self.evenly(|point| flat * point, flat, CLOSE));
            if Relief::of(&self.counted(flat), up).unexplained() < MOSTLY_EXPLAINED
                && heights_along(&points, up, observer)?.is_some()
            {
                return Ok(false);
            }
        }
        let pieces = pieces(&self.evenly(|point| by * point, by, CLOSE), observer)?;
        Ok(pieces.sizes.len() == 1)
    }

    /// How many times farther neighbours lie along one of two axes than along the other.
    fn unlikeness(&self, by: DVec3, (a, b): (usize, usize)) -> f64 {
        let points = self.counted(by);
        let tree = KdTree::new(&points);
        let (mut sum, mut found) = (DVec3::ZERO, Vec::new());
        for (index, &point) in (0..).zip(&points) {
            tree.nearest_to(index, NEIGHBORS, &mut found);
            sum +=
                found.iter().map(|near| (points[near.index as usize] - point).abs()).sum::<DVec3>();
        }
        (sum[a] / sum[b]).max(sum[b] / sum[a])
    }

    /// What makes heights over x and y no higher than those of a surface, where the points are such heights
    /// then, and in their own units most of the surface would be wall; and whether it is the plane that was
    /// sampled evenly.
    pub(super) fn laid_flat(
        &self,
        mut by: DVec3,
        observer: &mut dyn Observer,
    ) -> Result<Option<(Units, bool)>> {
        let extents = by * self.extents;
        let shorter = extents.x.min(extents.y);
        if !(shorter > 0.0 && extents.z > 0.0) {
            return Ok(None);
        }
        let narrow = extents.x.max(extents.y) > UNEVEN * shorter;
        if narrow {
            let longer = usize::from(extents.y > extents.x);
            by[longer] *= power(shorter / extents[longer]);
        }
        let [_, wide, thick] = Plane::of(self.points.iter().copied()).deviations;
        if !narrow && thick < PLATE * wide {
            return Ok(None);
        }
        let across = by;
        let farther = self.extents.z > UNEVEN * self.extents.x.max(self.extents.y);
        for height in [HEIGHT, GROUND].into_iter().chain(farther.then_some(FAR_HIGHER)) {
            by.z = across.z * power(height * shorter / extents.z);
            let telling = self.counted(by);
            let relief = Relief::of(&telling, DVec3::Z);
            let left = if farther { PARTLY_EXPLAINED } else { MOSTLY_EXPLAINED };
            let explained = height == HEIGHT || relief.unexplained() < left;
            let walls = relief.walls(by);
            if !(explained && walls >= MOSTLY) {
                continue;
            }
            let heights = self.are_heights(by, observer)?;
            if heights.is_none() {
                continue;
            }
            if !self.explained(by, observer)? {
                return Ok(None);
            }
            let even = self.over_ground(by, TELLING);
            let all_over = walls >= ALL_OVER;
            let on_surface = if all_over { SURELY_ON_SURFACE } else { 1.0 };
            let sampled = Relief::of(&even, DVec3::Z).sampled(by, &telling);
            let on_plane = sampled.map_or(all_over, |sampled| sampled < on_surface);
            let sure = on_plane || self.on_levels();
            return Ok(Some((Units { by, heights }, sure)));
        }
        Ok(None)
    }

    /// Whether a closer look at points that are heights in these units still shows heights, and no body as they were
    /// evened.
    pub(super) fn are_no_body(
        &self,
        by: DVec3,
        flat: &Units,
        options: &ReconstructOptions<'_>,
        observer: &mut dyn Observer,
    ) -> Result<bool> {
        let is_body = self.is_body(by, flat.by)
            || !self.are_flat_across_lines(by, flat.by, observer)?
            || options.kind.is_none() && self.is_tube(flat.by.with_z(by.z), observer)?;
        Ok(!is_body)
    }

    /// Whether the points lie on a smoother surface in their own units, or as these were evened, than as heights;
    /// but levels that were evened are flat themselves, however far apart.
    fn is_body(&self, by: DVec3, flat: DVec3) -> bool {
        let flat_levels = by.z != 1.0 && self.on_levels();
        !flat_levels && self.is_smoother(flat.with_z(by.z), flat)
    }

    /// Whether the points lie on a surface in their own units that is flatter around most of them than in
    /// others, as layers seen from the side are, or so flat as chance lets few heights in another unit never be;
    /// and hardly flatter in others where it is thickest.
    fn is_smoother(&self, own: DVec3, flat: DVec3) -> bool {
        let [[half, most, nearly_all], [other_half, _, other_all]] =
            [own, flat].map(|by| self.thickness(by, [0.5, 0.75, 0.9]));
        let in_lines = other_half == f64::INFINITY;
        !in_lines
            && (FLATTER * half < other_half || most < SMOOTH)
            && nearly_all < AS_FLAT * other_all
    }

    /// Whether the points show a tube in their own units, or as these were evened: a cup is no ground with a hole,
    /// though its wall is heights over a ring in any other unit of z.
    fn is_tube(&self, own: DVec3, observer: &mut dyn Observer) -> Result<bool> {
        let points = self.evenly(|point| own * point, own, SHOWING_LOOPS);
        let pipe = around_axis(&points, observer)?;
        Ok(pipe.is_some_and(|pipe| pipe.round && pipe.open)
            || matches!(detect(&points, observer)?.kind, Kind::Tube | Kind::Torus))
    }

    /// Whether the points are still heights if there are as many along lines as across, where they lie in
    /// lines: those on the far side of a body may lie between those on the near one.
    fn are_flat_across_lines(
        &self,
        by: DVec3,
        flat: DVec3,
        observer: &mut dyn Observer,
    ) -> Result<bool> {
        let points = self.evenly(|point| flat * point, flat, CLOSE);
        let Some(few) = across_lines(&points, None, None) else { return Ok(true) };
        let few: Vec<DVec3> = few.into_iter().map(|point| point / flat).collect();
        Ok(Telling::of(&few).laid_flat(by, observer)?.is_some())
    }

    /// What heights over x and y they are, if they are any when coordinates count so much, seen from afar
    /// and from near.
    fn are_heights(&self, by: DVec3, observer: &mut dyn Observer) -> Result<Option<HeightField>> {
        let mut seen = None;
        for count in [TELLING, CLOSE] {
            seen = heights(&self.over_ground(by, count), observer)?;
            if seen.is_none_or(|found| found.up != DVec3::Z) {
                return Ok(None);
            }
        }
        Ok(seen)
    }

    /// About so many points, evenly over x and y.
    fn over_ground(&self, by: DVec3, count: usize) -> Vec<DVec3> {
        self.evenly(|point| (by * point).with_z(0.0), by, count)
    }

    /// Whether points lie on contour lines: these run closest together where it is steep.
    fn on_levels(&self) -> bool {
        let mut heights: Vec<f64> = self.points.iter().map(|point| point.z).collect();
        heights.sort_by(f64::total_cmp);
        heights.dedup();
        LEVEL * heights.len() < self.points.len()
    }

    /// The points that tell, if coordinates count so much.
    fn counted(&self, by: DVec3) -> Vec<DVec3> {
        self.points.iter().map(|&point| by * point).collect()
    }

    /// So many, evenly over space where `place` puts them, if coordinates count so much.
    fn evenly(&self, place: impl Fn(DVec3) -> DVec3, by: DVec3, count: usize) -> Vec<DVec3> {
        let mut sample = EvenSample::new(count);
        for portion in self.cloud.chunks(PORTION) {
            let places: Vec<DVec3> = portion.iter().map(|&point| place(point)).collect();
            sample.extend(&places);
        }
        #[expect(clippy::cast_possible_truncation, reason = "an index into memory")]
        sample.indices().into_iter().map(|index| by * self.cloud[index as usize]).collect()
    }

    /// Whether heights over x and y are better explained by planes if coordinates count so much than the
    /// points are in their own units, as heights over whatever plane.
    fn explained(&self, by: DVec3, observer: &mut dyn Observer) -> Result<bool> {
        let even = self.evenly(|point| point, DVec3::ONE, TELLING);
        let Some(own) = heights(&even, observer)? else { return Ok(true) };
        let own = Relief::of(&self.points, own.up).unexplained();
        Ok(Relief::of(&self.counted(by), DVec3::Z).unexplained() < UNEXPLAINED * own)
    }
}

/// What coordinates count, with what one counts replaced.
fn with(mut by: DVec3, axis: usize, count: f64) -> DVec3 {
    by[axis] = count;
    by
}

/// The power of two nearest to a ratio.
fn power(ratio: f64) -> f64 {
    ratio.log2().round().exp2()
}
