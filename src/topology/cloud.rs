//! The points that are looked at, and what loops around them show.

use std::sync::OnceLock;

use glam::DVec3;
use rayon::prelude::*;

use super::CLOSED;
use super::axis::{self, Pipe};
use super::border;
use super::circle::{self, Circle, Landmarks, Loops};
use super::conjugate::Conjugate;
use super::cylinder::{cylinder, groove};
use super::form::Course;
use super::kind::{Kind, Topology};
use super::start::{self, Chart};
use crate::cloud::{NEIGHBORS, NeighborGraph, Neighborhoods, own_sample, rough_sample};
use crate::error::Result;
use crate::progress::{Observer, Progress, Stage, report};

/// Points among which loops are looked for: windings are told apart that are five spacings apart.
pub(super) const MOST_FOR_LOOPS: usize = 10_000;

/// So many show those of a tube, unless they lie in few rings.
const MANY: usize = 500;

/// More points show all loops of a surface at first sight, but perhaps the second of a torus.
const CERTAIN: usize = 1000;

/// So many show those of long tubes, too; fewer are looked at once more.
const LONG: usize = 3000;

/// Reaches at which a second look is taken, as multiples of the landmarks' distance.
const CLOSER: [f64; 3] = [4.5, 4.0, 3.5];

/// And a third, among more landmarks.
const CLOSEST: [f64; 4] = [4.0, 3.5, 3.0, 2.6];

/// Loops of a tube have much the same length wherever they are: those of a cone whose rims are as 1
/// to 4 differ by 3.5. Around a hole in a sheet they grow from its rim to the outline. The second and third
/// bounds are for loops that only a second look finds, or a third, which may be accidental.
const SPREAD: [f64; 3] = [4.0, 2.0, 2.5];

/// How many times longer than around a tube is at least that only shows itself closely, since it has hardly any
/// border: loops on an egg whose tip is open are as short, but go around what is hardly longer.
const PIPE: f64 = 2.0;

/// Points on the border of a sheet of n points, for each √n of them: four sides of a square have 4,
/// a circle has 3.5. With less than this the body is closed but for small holes.
const OUTLINE: f64 = 0.95;

/// Share of a tube's rims that must be seen.
const RIMS: f64 = 0.3;

/// The points that are looked at.
pub(crate) struct Cloud {
    pub(crate) points: Vec<DVec3>,
    /// Fewer, among which the border is looked for; none if it is among all of these.
    few: Vec<DVec3>,
    pub(super) graph: NeighborGraph,
    /// The kind of surface that is wanted, if one is.
    wanted: Option<Kind>,
    border: OnceLock<Option<f64>>,
}

impl Cloud {
    pub(super) fn of(
        points: &[DVec3],
        most: usize,
        wanted: Option<Kind>,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let points = rough_sample(points, most);
        let graph = NeighborGraph::of(&points, NEIGHBORS, observer)?;
        Ok(Self { points, few: Vec::new(), graph, wanted, border: OnceLock::new() })
    }

    /// Of few points, around which is known what is near.
    pub(super) fn among(points: &[DVec3], known: &Neighborhoods, wanted: Option<Kind>) -> Self {
        let graph = NeighborGraph::among(points, known);
        Self { points: points.to_vec(), few: Vec::new(), graph, wanted, border: OnceLock::new() }
    }

    /// As it is seen with more of the points, if there are more: slopes and borders show best through noise
    /// with fewer, narrow gaps and short loops with more.
    pub(super) fn closer(self, points: &[DVec3], observer: &mut dyn Observer) -> Result<Self> {
        if self.points.len() == points.len() {
            return Ok(self);
        }
        let more = own_sample(points, MOST_FOR_LOOPS);
        let closer = Self::of(&more, MOST_FOR_LOOPS, self.wanted, observer)?;
        Ok(Self { few: self.points, ..closer })
    }

    /// The points among which the border is looked for.
    fn outlined(&self) -> &[DVec3] {
        if self.few.is_empty() { &self.points } else { &self.few }
    }

    /// How many of these lie on the border; `None` if they scatter too much to show one.
    pub(super) fn border(&self) -> Option<f64> {
        *self.border.get_or_init(|| border::count(self.outlined()))
    }

    /// Whether hardly any of the points are seen to lie on a border: that what they lie on is closed, or too rough to
    /// tell.
    pub(crate) fn hardly_ends(&self) -> bool {
        hardly_ends(self.border(), self.outlined().len())
    }

    /// Whether the body that the points lie on has hardly any border.
    pub(super) fn is_closed(&self) -> bool {
        self.border().is_some_and(|border| border < outline(self.outlined().len()))
    }

    /// The kind of surface that its loops show, or, if it is a tube, the cylinder that few points lie near.
    pub(super) fn shown(&self, observer: &mut dyn Observer) -> Result<Topology> {
        let asked = self.wanted == Some(Kind::Tube);
        if asked && let Some(round) = self.round() {
            return Ok(round);
        }
        let found = self.by_loops(observer)?;
        let round = if found.kind == Kind::Tube { self.round() } else { None };
        Ok(round.unwrap_or(found))
    }

    /// The kind of surface that its loops show.
    pub(super) fn by_loops(&self, observer: &mut dyn Observer) -> Result<Topology> {
        // Who asks for a tube knows that the loop is none around a hole.
        let asked = self.wanted == Some(Kind::Tube);
        if asked && let Some(pipe) = self.around_axis(axis::WITHOUT_LOOPS) {
            return Ok(pipe);
        }
        let landmarks = Landmarks::of(&self.points, &self.graph);
        let found = landmarks.loops(circle::REACH);
        let spread = if asked { [f64::INFINITY; 3] } else { SPREAD };
        let mut judged = self.torus(&found).or_else(|| self.tube(&found, spread[0]));
        let doubtful = match &judged {
            Some(found) if self.wanted == Some(found.kind) => false,
            Some(Topology { kind: Kind::Tube, chart: Some(chart), .. }) => {
                self.rims_seen(chart) != Some(true)
            }
            Some(_) => false,
            None => self.points.len() < CERTAIN,
        };
        if doubtful {
            // Short loops of few points, or the second one of a torus, show themselves to who looks
            // closer; what is no loop of the surface as a whole is not taken for one.
            report(observer, &Progress::of_stage(Stage::Cleaning, 0, 0, self.points.len()))?;
            let closer: Vec<Loops> =
                CLOSER.par_iter().map(|&reach| landmarks.loops(reach)).collect();
            let torus = closer.iter().find_map(|loops| self.torus(loops));
            judged = torus.or(judged).or_else(|| self.tube(&closer[0], spread[1]));
        }
        if judged.is_none() && (CERTAIN..LONG).contains(&self.points.len()) {
            report(observer, &Progress::of_stage(Stage::Cleaning, 0, 0, self.points.len()))?;
            judged = self.tube(&landmarks.loops(CLOSER[0]), spread[1]);
        }
        if judged.is_none() && self.points.len() >= CERTAIN && self.is_closed() {
            report(observer, &Progress::of_stage(Stage::Cleaning, 0, 0, self.points.len()))?;
            judged = self.long_tube(&landmarks);
        }
        if judged.is_none() && self.points.len() < CERTAIN {
            report(observer, &Progress::of_stage(Stage::Cleaning, 0, 0, self.points.len()))?;
            let landmarks = Landmarks::close(&self.points, &self.graph);
            let closest: Vec<Loops> =
                CLOSEST.par_iter().map(|&reach| landmarks.loops(reach)).collect();
            let torus = closest.iter().find_map(|loops| self.torus(loops));
            judged = torus.or_else(|| closest.iter().find_map(|loops| self.tube(loops, spread[2])));
        }
        judged = judged.map(|found| self.closed_across(&found).unwrap_or(found));
        let even = || found.all().any(|circle| circle.course.spread <= SPREAD[0]);
        // Accidental ones of few points may be even, but wind through what lies apart.
        let few = self.points.len() < CERTAIN;
        let winds_once = |chart: &Chart| !few || start::winds_once(chart, &self.graph);
        let is_sure = |found: &Topology| {
            found.warning.is_none() && even() && found.chart.as_ref().is_some_and(winds_once)
        };
        if asked && !judged.as_ref().is_some_and(is_sure) {
            let groove = || groove(&self.points).map(Topology::around_axis);
            if let Some(pipe) = self.around_axis(axis::LONG_IF_ROUND).or_else(groove) {
                return Ok(pipe);
            }
        }
        Ok(judged.unwrap_or_else(|| self.open(&found)))
    }

    /// The tube of few points that lie near a cylinder: rings of them far from one another do not hang together.
    pub(super) fn round(&self) -> Option<Topology> {
        self.near_cylinder().map(Topology::around_axis)
    }

    /// Where few points are on a cylinder, if they are near to one.
    pub(super) fn near_cylinder(&self) -> Option<Chart> {
        self.few_around(&self.points)
    }

    /// The same, in a frame in which they have these places.
    fn few_around(&self, places: &[DVec3]) -> Option<Chart> {
        let (few, asked) = (places.len() < MANY, self.wanted == Some(Kind::Tube));
        few.then(|| cylinder(places, asked)).flatten()
    }

    /// The pipe on which they lie, if they lie around an axis that is much longer than the ways around it, or few near a
    /// cylinder; in a frame in which they have these places.
    pub(crate) fn pipe(&self, places: &[DVec3]) -> Option<Pipe> {
        let long = axis::around_axis(places, &self.graph, axis::LONG_IF_ROUND);
        let few = || self.few_around(places).map(Pipe::perhaps);
        long.or_else(few)
    }

    /// The tube around an axis so many times longer than the ways around it.
    fn around_axis(&self, least: f64) -> Option<Topology> {
        let Pipe { chart, .. } = axis::around_axis(&self.points, &self.graph, least)?;
        Some(Topology::around_axis(chart))
    }

    /// The torus around which these loops go.
    fn torus(&self, loops: &Loops) -> Option<Topology> {
        let [ring, section] = &loops.shortest[..] else { return None };
        let chart = start::torus(&self.points, ring, section)?;
        let (long, short) = chart.lengths;
        let reason = format!("it closes around two ways, {long:.4} and {short:.4} long");
        Some(Topology { chart: Some(chart), ..Topology::new(Kind::Torus, reason) })
    }

    /// The torus that was taken for a tube because its other loop is too short to be seen: where no rims are.
    fn closed_across(&self, found: &Topology) -> Option<Topology> {
        let tube = found.kind == Kind::Tube && self.wanted != Some(Kind::Tube);
        let chart =
            found.chart.as_ref().filter(|chart| tube && self.rims_seen(chart) != Some(true))?;
        let turns: Vec<f64> = chart.uv.iter().map(|uv| uv.x).collect();
        let across = Conjugate::of_turns(&self.points, &turns, &self.graph).circle()?;
        let around = Circle { turns, course: Course { length: chart.lengths.0, spread: 1.0 } };
        let mut shortest = vec![around, across];
        shortest.sort_by(|a, b| b.course.length.total_cmp(&a.course.length));
        self.torus(&Loops { shortest, sum: None })
    }

    /// The tube around which these loops go; `None` if they go around holes: their lengths differ by
    /// more than `spread` from place to place, or they go around several.
    fn tube(&self, loops: &Loops, spread: f64) -> Option<Topology> {
        let asked = self.wanted == Some(Kind::Tube);
        // Around a body without a border there are no holes.
        let sure = asked || self.is_closed();
        let mut around: Vec<&Circle> = loops.all().collect();
        around.retain(|circle| circle.course.spread <= spread);
        around.sort_by(|a, b| a.course.spread.total_cmp(&b.course.spread));
        let mut charts = around.iter().map(|circle| start::tube(&self.points, circle, &self.graph));
        let found = charts.find(|(chart, _)| sure || start::winds_once(chart, &self.graph));
        let (chart, one_sided) = found?;
        let (long, high) = chart.lengths;
        let reason = format!("it closes around one way, {long:.4} long, and is {high:.4} high");
        let warning = if one_sided {
            Some(
                "the points lie on a strip with one side only, as a Moebius strip: no tube follows it, nor \
                  any other surface of this kind; cut it across, or choose a part",
            )
        } else {
            let torus = !asked && self.rims_seen(&chart) == Some(false);
            torus.then_some("the points close around one way and have no border: if they lie on a torus, say so")
        };
        let warning = warning.map(str::to_string);
        Some(Topology { warning, chart: Some(chart), ..Topology::new(Kind::Tube, reason) })
    }

    /// The tube that is so long that it has hardly any border: its loops are short. Few landmarks show some
    /// that are none, the chart of which covers places twice or begins in the middle.
    fn long_tube(&self, landmarks: &Landmarks<'_>) -> Option<Topology> {
        let close = Landmarks::close(&self.points, &self.graph);
        let looks = CLOSER[1..].iter().map(|&reach| landmarks.loops(reach));
        let mut looks = looks.chain(CLOSEST.iter().map(|&reach| close.loops(reach)));
        let is_pipe = |chart: &Chart| {
            chart.lengths.1 > PIPE * chart.lengths.0
                && start::winds_once(chart, &self.graph)
                && start::begins_at_an_end(chart, &self.graph)
        };
        looks.find_map(|loops| {
            self.tube(&loops, SPREAD[1]).filter(|found| found.chart.as_ref().is_some_and(is_pipe))
        })
    }

    /// Whether points lie on the rims of a tube; `None` if noise hides them.
    fn rims_seen(&self, chart: &Chart) -> Option<bool> {
        let (long, high) = chart.lengths;
        let spacing = (long * high / self.outlined().len() as f64).sqrt();
        self.border().map(|border| border >= RIMS * 2.0 * long / spacing)
    }

    fn open(&self, loops: &Loops) -> Topology {
        let reason = match &loops.shortest[..] {
            [] => "no loop closes around it".to_string(),
            [hole] => format!("its one loop, {:.4} long, closes around a hole", hole.course.length),
            loops => format!("its {} loops close around holes", loops.len()),
        };
        let warning = (loops.shortest.is_empty() && self.is_closed())
            .then(|| format!("{CLOSED}; cut it, or choose a part"));
        Topology { warning, ..Topology::new(Kind::Sheet, reason) }
    }
}

/// Whether so many of so many points are fewer than lie on the border of a sheet, or noise hides how many do.
pub(super) fn hardly_ends(border: Option<f64>, count: usize) -> bool {
    border.is_none_or(|border| border < outline(count))
}

/// The least number of points on the border of a sheet of so many.
fn outline(count: usize) -> f64 {
    OUTLINE * (count as f64).sqrt()
}
