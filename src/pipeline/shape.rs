//! The kind of surface that is fitted, and what it stands on.

use glam::DVec3;

use super::start::net;
use super::units::Units;
use super::{ReconstructOptions, heights};
use crate::error::Result;
use crate::fit::{Arms, Base};
use crate::progress::Observer;
use crate::som;
use crate::topology::{Kind, Topology};

/// Slope in degrees from which on a sheet may come nearer to points than heights, if there are not few; and more
/// points are not fitted twice: a net for so many has room for what is steep.
const GENTLE: f64 = 45.0;
const MOST_TWICE: usize = 20_000;

/// The kind of surface that is fitted.
pub(super) struct Shape {
    pub(super) kind: Kind,
    /// What heights stand on, of [`Kind::Height`].
    pub(super) base: Option<Base>,
    /// Whether heights were found out that are so steep that a sheet may come nearer to the points.
    pub(super) steep: bool,
    /// Whether distances are heights: in another unit than x and y, they have no ways beside them.
    pub(super) straight: bool,
}

impl Shape {
    /// Of points, for which there is this budget of control points; in other units than their own they
    /// are heights wherever they end, which distances along x and y would not make a sheet of. Corrects what was
    /// found where they are heights along another direction than z.
    pub(super) fn of(
        found: &mut Topology,
        points: &[DVec3],
        units: &Units,
        budget: (usize, usize),
        options: &ReconstructOptions<'_>,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let known = found.height;
        let along_z = known.is_some_and(|height| height.up == DVec3::Z);
        Ok(match options.kind {
            Some(Kind::Height) => {
                Self::over(points, known.map_or(DVec3::Z, |height| height.up), units)
            }
            None if units.differ() && along_z && !options.rational => {
                Self::over(points, DVec3::Z, units)
            }
            Some(Kind::Sheet) | None if found.kind == Kind::Height => {
                // Free weights are for what is round, and heights cannot go round.
                let height = known.filter(|_| !options.rational);
                let has_rows = |strip: &Arms| {
                    let (rows, _) = net(budget, strip.aspect(), options);
                    rows > strip.arms().len() * options.degree
                };
                let mut base = height.and_then(|height| heights::base(points, height.up, has_rows));
                if along_z
                    && height.is_some()
                    && let Some((height, leaning)) =
                        heights::leaning(points, base.as_ref(), has_rows, observer)?
                {
                    (*found, base) = (Topology::of_heights(height), Some(leaning));
                }
                let ground = height.is_some_and(|height| height.ground);
                if ground {
                    // Over a plane there is an order in what stands on a ground, along a sheet there is none.
                    base = base.or_else(|| Some(Base::over(points, DVec3::Z)));
                }
                let slope = found.height.map_or(0.0, |height| height.slope);
                let many = (heights::FEW..=MOST_TWICE).contains(&points.len());
                let steep = base.is_some() && !ground && slope > GENTLE && many;
                let kind = if base.is_some() { Kind::Height } else { Kind::Sheet };
                Self { steep, ..Self::new(kind, base) }
            }
            wanted => Self::new(wanted.unwrap_or(found.kind), None),
        })
    }

    /// Of this kind, with what heights stand on.
    pub(super) fn new(kind: Kind, base: Option<Base>) -> Self {
        Self { kind, base, steep: false, straight: false }
    }

    /// Heights over the rectangle around points.
    fn over(points: &[DVec3], up: DVec3, units: &Units) -> Self {
        let straight = units.differ() && up == DVec3::Z;
        Self { straight, ..Self::new(Kind::Height, Some(Base::over(points, up))) }
    }

    pub(super) fn closed(&self) -> som::Topology {
        match self.kind {
            Kind::Sheet | Kind::Height | Kind::Body => som::Topology::Sheet,
            Kind::Tube => som::Topology::Tube,
            Kind::Torus => som::Topology::Torus,
        }
    }
}
