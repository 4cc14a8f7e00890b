//! What trimming found.

use std::fmt;

use super::outline::LoopForm;
use crate::brep::Face;
use crate::diagnostic::Diagnostic;
use crate::numeric::Short;

/// The faces of a surface that end where the points end.
#[derive(Clone, Debug, PartialEq)]
pub struct Trim {
    /// One face for each region with points; the whole surface if there are too few points.
    pub faces: Vec<Face>,
    /// What became of each border, in the order of the regions.
    pub loops: Vec<LoopOutcome>,
    /// Number of regions.
    pub regions: usize,
    /// Why the faces are doubtful, if they are.
    pub doubt: Option<Doubt>,
    /// Whether the outline follows the sides of the surface's rectangle, without holes: the whole
    /// surface is as good.
    pub pointless: bool,
    /// The share of places more than three quarters of a spacing outside of the faces.
    pub outside: f64,
    /// The share of the faces' area that lies farther than 1.5 spacings from every place; `None` if
    /// there are too few places for a spacing.
    pub beyond: Option<f64>,
    /// The same share of the whole surface.
    pub beyond_untrimmed: Option<f64>,
    /// The tenth, fifth and ninth decile of the local spacing, in the points' unit. A spacing is
    /// the side of a square with one point each, in a random scatter.
    pub spacing: [f64; 3],
    /// How unevenly the points scatter: 1 at random, up to 3.
    pub clumping: f64,
}

impl Trim {
    /// The doubt as a diagnostic.
    pub(crate) fn diagnostic(&self) -> Option<Diagnostic> {
        let reason = self.doubt?.to_string();
        Some(if self.loops.is_empty() {
            Diagnostic::Untrimmed { reason }
        } else {
            Diagnostic::TrimDoubtful { reason }
        })
    }
}

/// What became of a border of a region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopOutcome {
    /// The index of the region.
    pub region: usize,
    /// Whether it bounds a hole.
    pub is_hole: bool,
    /// Whether it winds around a closed surface.
    pub winds: bool,
    /// How it became curves.
    pub form: LoopForm,
    /// Number of corners.
    pub corners: usize,
    /// Its length in space.
    pub length: f64,
}

/// Why the faces are doubtful: the whole surface may be better.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Doubt {
    /// Too few distinct places for a region. The face is the whole surface.
    TooFewPlaces {
        /// Number of distinct places.
        places: usize,
        /// Number that is needed.
        needed: usize,
    },
    /// Points are so clumped that gaps and holes look alike.
    Clumped {
        /// How unevenly they scatter: 1 at random.
        clumping: f64,
    },
    /// There are more holes than a face should have.
    TooManyHoles {
        /// Number of holes.
        holes: usize,
        /// The largest number that is not doubtful.
        most: usize,
    },
    /// Not even polygons through the border points are simple. The face is the whole surface.
    NotSimple,
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFewPlaces { places, needed } => {
                write!(f, "{needed} points at distinct places are needed, got {places}")
            }
            Self::Clumped { clumping } => write!(
                f,
                "the points are clumped (by {}; 1 is random), so gaps and holes look alike",
                Short(*clumping)
            ),
            Self::TooManyHoles { holes, most } => {
                write!(f, "{holes} holes were found, more than {most}")
            }
            Self::NotSimple => f.write_str("the border of the points crosses itself"),
        }
    }
}
