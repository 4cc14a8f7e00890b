//! What coordinates count in a fit, where distances count alike in all directions: axes in different
//! units would make most of them count nothing.

use glam::DVec3;

use super::ReconstructOptions;
use super::telling::Telling;
use crate::error::Result;
use crate::progress::Observer;
use crate::topology::{HeightField, Kind, Topology};

/// What a fit counts each coordinate times: a power of two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Units {
    pub(super) by: DVec3,
    /// Of points that are heights over x and y then, which others may not be in other units.
    pub(super) heights: Option<HeightField>,
}

impl Units {
    /// Whether not all are one.
    pub(super) fn differ(&self) -> bool {
        self.by != DVec3::ONE
    }

    pub(super) fn apply(&self, point: DVec3) -> DVec3 {
        self.by * point
    }

    pub(super) fn undo(&self, point: DVec3) -> DVec3 {
        point / self.by
    }

    /// What a distance from a surface counts at least: of heights all of it is along z.
    pub(super) fn distance(&self, distance: f64, kind: Kind) -> f64 {
        let by = if kind == Kind::Height { self.by.z } else { self.by.min_element() };
        by * distance
    }

    /// The units that the points seem to have, their own unless these are no use, and others that they
    /// may have if no surface is found in those.
    pub(super) fn of(
        cloud: &[DVec3],
        options: &ReconstructOptions<'_>,
        observer: &mut dyn Observer,
    ) -> Result<(Self, Option<Others>)> {
        if let Some(scale) = options.axis_scale {
            return Ok((Self { by: scale.recip(), heights: None }, None));
        }
        let telling = Telling::of(cloud);
        let by = telling.evened(observer)?;
        let units = Self { by, heights: None };
        let may_be_heights = options.kind.is_none_or(|kind| kind == Kind::Height);
        let laid_flat = if may_be_heights { telling.laid_flat(by, observer)? } else { None };
        Ok(match laid_flat {
            Some((flat, true)) if telling.are_no_body(by, &flat, options, observer)? => {
                (flat, Some(Others::Evened(units)).filter(|_| by != flat.by))
            }
            Some((flat, false)) => (units, Some(Others::LaidFlat { flat, evened: by })),
            _ => (units, None),
        })
    }

    /// That the points are heights, where that is what their units were told by.
    pub(super) fn heights(&self) -> Option<Topology> {
        self.heights.map(Topology::of_heights)
    }
}

/// Other units that points may have.
pub(super) enum Others {
    /// Those in which their axes are about as long as one another.
    Evened(Units),
    /// Those in which they are heights, and what makes the axes about as long.
    LaidFlat { flat: Units, evened: DVec3 },
}

impl Others {
    /// The units, unless a closer look shows that the points of this cloud are no heights in them.
    pub(super) fn of(
        self,
        cloud: &[DVec3],
        options: &ReconstructOptions<'_>,
        observer: &mut dyn Observer,
    ) -> Result<Option<Units>> {
        match self {
            Self::Evened(units) => Ok(Some(units)),
            Self::LaidFlat { flat, evened } => {
                let heights = Telling::of(cloud).are_no_body(evened, &flat, options, observer)?;
                Ok(Some(flat).filter(|_| heights))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;

    /// Points over a square, as high as `height` makes them.
    fn scattered(height: impl Fn(f64, f64) -> f64) -> Vec<DVec3> {
        let point = |k: u32| {
            let (x, y) = (2.0 * (f64::from(k) * 0.618_034).fract(), f64::from(k) / 1000.0);
            DVec3::new(x, y, height(x, y))
        };
        (0..2000).map(point).collect()
    }

    fn found(points: &[DVec3], by: [f64; 3]) -> (Units, Option<Units>) {
        let points: Vec<DVec3> = points.iter().map(|&point| DVec3::from(by) * point).collect();
        let options = ReconstructOptions::default();
        let (units, others) = Units::of(&points, &options, &mut Silent).unwrap();
        let others = others.and_then(|others| others.of(&points, &options, &mut Silent).unwrap());
        (units, others)
    }

    #[test]
    fn grounds_are_counted_alike() {
        let ground = scattered(|x, y| 0.1 * (3.0 * x + y).sin() + 0.1 * (4.0 * y - x).cos());
        let counted = |by| found(&ground, by).0.by.to_array();
        assert_eq!(counted([1.0, 1.0, 1.0]), [1.0, 1.0, 1.0]);
        assert_eq!(counted([1.0, 1024.0, 1.0]), [1.0, 1.0 / 1024.0, 1.0]);
        assert_eq!(counted([1.0, 1.0, 1024.0]), [1.0, 1.0, 1.0 / 1024.0]);
        assert_eq!(counted([1.0, 1.0, 32.0]), [1.0, 1.0, 1.0 / 32.0]);
        let (units, _) = found(&ground, [1024.0, 1.0, 1024.0]);
        assert_eq!(units.by, DVec3::new(1.0, 1024.0, 1.0));
    }

    #[test]
    fn walls_keep_their_units() {
        let standing = scattered(|x, y| 0.1 * (3.0 * x + y).sin()).into_iter();
        let standing: Vec<DVec3> = standing.map(|p| DVec3::new(p.x, p.z, 3.0 * p.y)).collect();
        assert!(!found(&standing, [1.0; 3]).0.differ());
    }

    #[test]
    fn more_points_where_it_is_steep_are_a_wall() {
        // Rows of points at equal steps along waves that are as high as they are long.
        let mut rows = vec![];
        for row in 0..25 {
            let mut x = 0.02 * f64::from(row);
            while x < 12.0 {
                rows.push(DVec3::new(x, 0.5 * f64::from(row), 6.0 * x.sin()));
                x += 0.4 / (1.0 + (6.0 * x.cos()).powi(2)).sqrt();
            }
        }
        let (units, others) = found(&rows, [1.0; 3]);
        assert!(!units.differ());
        assert!(others.is_some_and(|others| others.by.z < 1.0));
    }
}
