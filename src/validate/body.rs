//! What a surface encloses.

use super::samples::Samples;
use crate::error::Result;
use crate::nurbs::NurbsSurface;
use crate::progress::Observer;

/// The body that a surface encloses which is closed in both directions.
pub(crate) struct Body {
    /// Of the surface.
    pub(crate) area: f64,
    /// What lies on both sides of a fold cancels.
    pub(crate) volume: f64,
}

impl Body {
    /// By four samples to a span.
    pub(crate) fn of(surface: &NurbsSurface, observer: &mut dyn Observer) -> Result<Self> {
        let Samples { rows, cols, places, .. } = Samples::of(surface, observer)?;
        let (mut area, mut volume) = (0.0, 0.0);
        for cell in (0..(rows - 1) * (cols - 1)).map(|i| i + i / (cols - 1)) {
            // About a sample, so that surfaces far from the origin keep their digits.
            let [a, b, c, d] =
                [cell, cell + cols, cell + cols + 1, cell + 1].map(|at| places[at] - places[0]);
            let halves = [[a, b, c], [a, c, d]];
            area += halves.map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0).iter().sum::<f64>();
            volume += halves.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).iter().sum::<f64>();
        }
        Ok(Self { area, volume: f64::abs(volume) })
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::progress::Silent;
    use glam::DVec3;

    #[test]
    fn a_torus_has_its_area_and_volume() {
        let centre = DVec3::new(1e3, -2e3, 5.0);
        let torus = NurbsSurface::torus(centre, 3.0, 1.0).unwrap();
        let Body { area, volume } = Body::of(&torus, &mut Silent).unwrap();
        // Polygons of sixteen corners instead of circles.
        assert!((area / (12.0 * PI * PI) - 1.0).abs() < 0.03, "{area}");
        assert!((volume / (6.0 * PI * PI) - 1.0).abs() < 0.07, "{volume}");
    }
}
