//! Plane chart: height fields along the given z, or along the direction of most normals.

use glam::{DVec2, DVec3};

use super::bounding_rectangle::BoundingRectangle;
use super::hypothesis::Hypothesis;
use super::input::ChartInput;
use super::kind::Kind;
use super::settings::PlaneChartSettings;
use super::traits::Chart;

const SETTINGS: PlaneChartSettings = PlaneChartSettings::STANDARD;

/// Height fields over a plane, and sheets that start from them.
pub(super) struct Plane;

impl Chart for Plane {
    fn name(&self) -> &'static str {
        "plane"
    }

    fn kinds(&self) -> &'static [Kind] {
        &[Kind::Height, Kind::Sheet]
    }

    fn propose(&self, input: &ChartInput<'_>) -> Vec<Hypothesis> {
        let observations = input.observations;
        let steep = |up: DVec3| {
            let share = || observations.share_along(up, SETTINGS.min_cosine);
            observations.planes().reliable && share() < SETTINGS.min_share
        };
        let z = input.given_axes.z_axis;
        if input.requested == Some(Kind::Height) {
            return vec![Footprint::along("plane z", input, z).heights()];
        }
        let mut normal = observations.normal_axes()[0];
        if normal.dot(z) < 0.0 {
            normal = -normal;
        }
        let along_z = (!steep(z)).then(|| Footprint::along("plane z", input, z));
        let along_normal =
            (!steep(normal)).then(|| Footprint::along("plane normal", input, normal));
        let mut found = Vec::new();
        match (along_z, along_normal) {
            (Some(z), Some(normal)) => {
                if z.filled + SETTINGS.max_emptier >= normal.filled {
                    found.push(z.heights());
                }
                found.push(normal.heights());
                found.push(normal.sheet());
            }
            (Some(one), None) | (None, Some(one)) => found.extend([one.heights(), one.sheet()]),
            (None, None) => {}
        }
        found
    }
}

/// The points' projection onto a plane, with parameters on its bounding rectangle.
struct Footprint {
    name: &'static str,
    axes: [DVec3; 3],
    uv: Vec<DVec2>,
    lengths: [f64; 2],
    filled: f64,
}

impl Footprint {
    /// The footprint along a direction.
    fn along(name: &'static str, input: &ChartInput<'_>, up: DVec3) -> Self {
        // Along z the axes are the given ones; otherwise they rotate with the points.
        let first = if up == input.given_axes.z_axis {
            input.given_axes.x_axis
        } else {
            let [a, b, _] = input.observations.axes().axes;
            let flat = |axis: DVec3| axis.reject_from(up);
            let longer = if flat(a).length() >= flat(b).length() { a } else { b };
            flat(longer).normalize()
        };
        let second = up.cross(first);
        let place = |point: &DVec3| DVec2::new(first.dot(*point), second.dot(*point));
        let places: Vec<DVec2> = input.observations.points().iter().map(place).collect();
        let rectangle = BoundingRectangle::around(&places);
        let along = rectangle.along.x * first + rectangle.along.y * second;
        Self {
            name,
            axes: [along, up.cross(along), up],
            uv: places.iter().map(|place| rectangle.uv(*place)).collect(),
            lengths: rectangle.size.to_array(),
            filled: rectangle.filled(&places),
        }
    }

    /// The height field over the plane.
    fn heights(&self) -> Hypothesis {
        let (heights, unfilled) = (Some(self.axes), (1.0 - self.filled).max(0.0));
        Hypothesis {
            heights,
            unfilled,
            ..Hypothesis::new(self.name, Kind::Height, self.uv.clone(), self.lengths)
        }
    }

    /// The sheet with the same parameters.
    fn sheet(&self) -> Hypothesis {
        Hypothesis::new(self.name, Kind::Sheet, self.uv.clone(), self.lengths)
    }
}
