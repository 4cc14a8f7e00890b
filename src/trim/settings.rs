//! Settings of trimming, one struct for each stage. A spacing is the side of a square with one
//! place each: 1 over the square root of the density.

/// Places: the distinct parameters of points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PlaceSettings {
    /// Difference of parameters below which places are the same. Unit: share of the rectangle.
    /// Source: closed form: a thousandth of the gap below which loops touch.
    pub(super) merge_share: f64,
    /// Largest number of places; of more, one a square remains. Unit: places. Source: the
    /// triangulation of as many takes half a second.
    pub(super) max_places: usize,
    /// Places at which the mean lengths of tangents are measured. Unit: places. Source: closed
    /// form: their error is a fortieth of one length's.
    pub(super) scale_samples: usize,
}

impl PlaceSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self =
        Self { merge_share: 1e-9, max_places: 200_000, scale_samples: 2000 };
}

/// The triangulation in the lengths of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TriangulationSettings {
    /// Sine by which opposite angles must exceed half a turn for a flip. Unit: sine. Source:
    /// rounding, with ties as grids have.
    pub(super) angle: f64,
    /// Least area of a triangle after a flip. Unit: share of the quadrangle. Source: rounding.
    pub(super) convexity: f64,
    /// Flips at most. Unit: flips a triangle. Source: closed form: the lengths are those of no
    /// plane, so that flips need not end.
    pub(super) max_flips: usize,
    /// Width of the strip that is copied across a seam. Unit: spacings. Source: closed form: no
    /// disc without a place is wider in a scatter of a million places, three times over.
    pub(super) strip: f64,
    /// Moves of places on closed surfaces, against ties. Unit: spacings. Source: closed form:
    /// above rounding, below what changes a circumradius.
    pub(super) jitter: f64,
}

impl TriangulationSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self =
        Self { angle: 1e-6, convexity: 1e-9, max_flips: 10, strip: 10.0, jitter: 1e-6 };
}

/// The local spacing, from circumradii.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SpacingSettings {
    /// Median circumradius of the Delaunay triangles of a random scatter. Unit: spacings. Source:
    /// closed form: the median of the density 2 π² r³ exp(-π r²).
    pub(super) median_circumradius: f64,
    /// Rings of neighbors over which the median is taken. Unit: rings. Source: some 40 places.
    pub(super) median_rings: usize,
    /// Rings of neighbors over which the logarithms are averaged. Unit: rings. Source: as smooth
    /// as the medians.
    pub(super) mean_rings: usize,
}

impl SpacingSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self =
        Self { median_circumradius: 0.7309, median_rings: 3, mean_rings: 2 };
}

/// Thresholds of circumradii.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ThresholdSettings {
    /// Radius of discs that reach from the outside. Unit: spacings. Source: calibrated on random
    /// shapes: it rounds corners and leaves out few triangles of a random scatter.
    pub(super) grow: f64,
    /// Chance that a random scatter has a false hole. Unit: probability. Source: one cloud in a
    /// hundred.
    pub(super) false_hole: f64,
    /// Ninth decile of the circumradii of a random scatter. Unit: spacings. Source: closed form:
    /// the decile of the density 2 π² r³ exp(-π r²).
    pub(super) ninth_decile: f64,
    /// Largest clumping that counts. Unit: ratio. Source: beyond it, no hole can be found.
    pub(super) max_clumping: f64,
}

impl ThresholdSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self =
        Self { grow: 1.8, false_hole: 0.01, ninth_decile: 1.113, max_clumping: 3.0 };
}

/// The region that holds the points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RegionSettings {
    /// Radii of discs that reach from the outside, tried until few places are left out. Unit:
    /// ratio to the standard radius. Source: steps of a quarter to a third.
    pub(super) growth: [f64; 5],
    /// Places that the region may leave out. Unit: share of the places. Source: the points that
    /// may lie outside of a face.
    pub(super) left_out: f64,
    /// Rounds of spacing and region. Unit: rounds. Source: the third changes few triangles.
    pub(super) rounds: usize,
    /// Smallest area of a hole. Unit: share of the disc by which it is found. Source: closed form:
    /// slivers of triangles have large circles without being holes.
    pub(super) hole_share: f64,
    /// Places of a piece that is kept. Unit: share of the places. Source: twice
    /// `left_out`.
    pub(super) island_share: f64,
    /// Rounds in which gaps at pinches may be filled. Unit: rounds. Source: clouds need three.
    pub(super) mending_rounds: usize,
}

impl RegionSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self {
        growth: [1.0, 1.25, 1.6, 2.0, 2.5],
        left_out: 0.01,
        rounds: 3,
        hole_share: 0.5,
        island_share: 0.02,
        mending_rounds: 100,
    };
}

/// Borders: chains of places around the region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BorderSettings {
    /// Length of border over which the depth of places is averaged. Unit: spacings. Source: some
    /// ten places.
    pub(super) depth_window: f64,
    /// Rings of triangles over which the area of a place is averaged. Unit: rings. Source: some 40
    /// places.
    pub(super) cell_rings: usize,
    /// Depth of the border of a random scatter. Unit: ratio to that of a lattice. Source: measured
    /// on random discs; it would be 2 with discs that fill gaps (B. Efron 1965).
    pub(super) random_depth: f64,
    /// Power of the irregularity in the depth. Unit: exponent. Source: measured on jittered
    /// lattices; the borders of those are nearly as deep as a lattice's.
    pub(super) depth_exponent: i32,
}

impl BorderSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self =
        Self { depth_window: 16.0, cell_rings: 3, random_depth: 1.45, depth_exponent: 3 };
}

/// Corners of a border.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CornerSettings {
    /// Length of the arms before and behind a corner. Unit: spacings. Source: calibrated on random
    /// shapes.
    pub(super) arm: f64,
    /// Arms are at most the loop's length over this. Unit: ratio. Source: closed form: a triangle
    /// has three corners with two arms each.
    pub(super) arms_per_loop: f64,
    /// Shortest arms: without them a loop has no corners. Unit: spacings. Source: calibrated on
    /// random shapes.
    pub(super) min_arm: f64,
    /// Fewest places on both arms. Unit: places. Source: closed form: twice the unknowns.
    pub(super) min_places: usize,
    /// Widths of the turn of a corner: discs round it off. Unit: spacings. Source: calibrated on
    /// random shapes.
    pub(super) sharp_widths: [f64; 3],
    /// Widths of turns that are no corners. Unit: spacings. Source: calibrated on random shapes.
    pub(super) wide_widths: [f64; 3],
    /// Largest squares with a sharp turn over those with a wide one. Unit: ratio. Source:
    /// calibrated on random shapes.
    pub(super) ratio: f64,
    /// Least angle of a corner. Unit: degrees. Source: calibrated on random shapes.
    pub(super) angle: f64,
    /// Noise that is there at least. Unit: spacings. Source: rounding, with exact grids.
    pub(super) noise_floor: f64,
    /// Least distance between corners. Unit: spacings. Source: calibrated on random shapes.
    pub(super) distance: f64,
}

impl CornerSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self {
        arm: 13.0,
        arms_per_loop: 6.0,
        min_arm: 4.0,
        min_places: 8,
        sharp_widths: [0.5, 1.0, 2.0],
        wide_widths: [6.0, 9.0, 12.0],
        ratio: 1.1,
        angle: 35.0,
        noise_floor: 0.05,
        distance: 5.0,
    };
}

/// Which corners hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CornerCheckSettings {
    /// Cost of a corner. Unit: variances of places. Source: calibrated on random shapes.
    pub(super) corner_cost: f64,
    /// Cost of a control point. Unit: variances of places. Source: calibrated on random shapes;
    /// neighboring places are not independent.
    pub(super) point_cost: f64,
}

impl CornerCheckSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self { corner_cost: 6.0, point_cost: 8.0 };
}

/// Arcs: the smooth parts between corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ArcSettings {
    /// Length beside a corner that discs round off. Unit: spacings. Source: closed form: the radius
    /// of the discs.
    pub(super) rounding: f64,
    /// The same on short arcs. Unit: share of the arc. Source: three fifths remain.
    pub(super) rounding_share: f64,
    /// Least angle between arcs at a corner. Unit: degrees. Source: calibrated on random shapes.
    pub(super) min_bend: f64,
    /// Length along which the direction of an arc at its end is measured. Unit: spacings. Source:
    /// some five border places.
    pub(super) lever: f64,
    /// Farthest that arcs are carried on to meet. Unit: spacings. Source: twice the rounding of a
    /// sharp corner.
    pub(super) reach: f64,
    /// Sine of the least angle at which carried-on arcs meet. Unit: sine. Source: rounding.
    pub(super) min_sine: f64,
    /// Distance from a side of the rectangle within which a straight arc is part of it. Unit:
    /// spacings. Source: the depth of border places; arcs are less certain than that.
    pub(super) snap: f64,
}

impl ArcSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self {
        rounding: 2.0,
        rounding_share: 0.2,
        min_bend: 25.0,
        lever: 5.0,
        reach: 6.0,
        min_sine: 1e-3,
        snap: 0.5,
    };
}

/// Splines: how many control points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SplineSettings {
    /// Numbers of control points of curves with ends; 2 is a straight line. Unit: control points.
    /// Source: steps of a quarter.
    pub(super) open_sizes: [usize; 22],
    /// Numbers of distinct control points of periodic curves. Unit: control points. Source: steps
    /// of a quarter.
    pub(super) periodic_sizes: [usize; 24],
    /// Least distance of knots. Unit: spacings. Source: some four border places.
    pub(super) knot_distance: f64,
    /// Most control points. Unit: control points a place. Source: a third; fewer are determined.
    pub(super) max_share: f64,
    /// Weight of third differences: gaps between places stay harmless. Unit: ratio. Source: far
    /// below the weight of places.
    pub(super) fairness: f64,
    /// Noise that is there at least. Unit: spacings. Source: places on a straight line.
    pub(super) noise_floor: f64,
    /// Score of a fit over the best one with fewer control points, below which it is taken. Unit:
    /// ratio. Source: calibrated on random shapes.
    pub(super) gain: f64,
    /// Places that a control point uses up. Unit: places. Source: above 1, cross-validation seldom
    /// overfits (C. Gu 2013, section 3.2).
    pub(super) penalty: f64,
    /// Largest share of places that counts as used up. Unit: share. Source: rounding.
    pub(super) max_used: f64,
}

impl SplineSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self {
        open_sizes: [
            2, 4, 5, 6, 8, 10, 13, 16, 20, 26, 32, 40, 52, 64, 84, 110, 140, 180, 230, 300, 400,
            520,
        ],
        periodic_sizes: [
            4, 5, 6, 7, 8, 10, 12, 15, 18, 22, 28, 34, 42, 52, 64, 80, 100, 130, 170, 220, 280,
            360, 460, 600,
        ],
        knot_distance: 4.0,
        max_share: 1.0 / 3.0,
        fairness: 1e-3,
        noise_floor: 0.02,
        gain: 0.92,
        penalty: 1.5,
        max_used: 0.95,
    };
}

/// Ragged borders: curves with a control point for each place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RaggedSettings {
    /// Fewest control points. Unit: control points. Source: twice the degree, and one.
    pub(super) min_control_points: usize,
    /// Weights of third differences, tried in order. Unit: ratio. Source: steps of ten.
    pub(super) fairness: [f64; 6],
}

impl RaggedSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self =
        Self { min_control_points: 7, fairness: [1e2, 1e1, 1.0, 1e-1, 1e-2, 1e-3] };
}

/// The outline: checks of its curves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OutlineSettings {
    /// Farthest that a border place may lie outside. Unit: spacings. Source: three depths of
    /// border places.
    pub(super) farthest_outside: f64,
    /// Distance from which a place counts as outside. Unit: spacings. Source: half of the farthest.
    pub(super) outside: f64,
    /// Border places that may be outside. Unit: share. Source: the tail of a normal distribution
    /// with the standard deviation of their depths.
    pub(super) outside_share: f64,
    /// Cost of a corner on closer curves, over the standard one. Unit: ratio. Source: a missed
    /// corner spoils the arcs beside it.
    pub(super) closer_corner_cost: f64,
    /// Farthest that a border place may be from closer curves. Unit: spacings. Source: between
    /// `outside` and `farthest_outside`, less the offset.
    pub(super) band: f64,
    /// Distance of samples along curves. Unit: spacings. Source: errors of distances stay below a
    /// hundredth.
    pub(super) sample_distance: f64,
    /// Distance of a polygon's places from its simplified sides. Unit: spacings. Source: half of
    /// the depth of border places.
    pub(super) simplify: f64,
    /// Distance from a side up to which a part that begins and ends there belongs to the side.
    /// Unit: spacings. Source: the depth of border places.
    pub(super) sliver: f64,
    /// Samples of each side of the rectangle, and most between two places of an outline. Unit:
    /// samples. Source: two hundred are a smooth picture.
    pub(super) side_samples: usize,
    /// Largest distance of the rectangle's border from the outline where trimming is pointless.
    /// Unit: spacings. Source: the radius of the smallest hole.
    pub(super) pointless_distance: f64,
    /// Mean distance of the rectangle's border from the outline where trimming is pointless. Unit:
    /// spacings. Source: two and a half depths of border places.
    pub(super) pointless_mean: f64,
}

impl OutlineSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self {
        farthest_outside: 1.5,
        outside: 0.75,
        outside_share: 0.06,
        closer_corner_cost: -5.0,
        band: 1.0,
        sample_distance: 0.25,
        simplify: 0.25,
        sliver: 0.5,
        side_samples: 200,
        pointless_distance: 3.0,
        pointless_mean: 1.25,
    };
}

/// How much of the surface lies beyond the points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CoverageSettings {
    /// Distance from the nearest place from which on the surface is beyond the points. Unit:
    /// spacings. Source: closed form: a random scatter has a thousandth of its area farther.
    pub(super) far: f64,
    /// Samples of the surface. Unit: samples a place. Source: a place's cell has several.
    pub(super) samples_per_place: f64,
    /// Largest number of samples along a side of the rectangle. Unit: samples. Source: shares to a
    /// ten-thousandth.
    pub(super) max_side: usize,
}

impl CoverageSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self { far: 1.5, samples_per_place: 8.0, max_side: 128 };
}

/// When trimming is doubtful.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DoubtSettings {
    /// Fewest places with which a region can be found. Unit: places. Source: half of them are on
    /// the border.
    pub(super) min_places: usize,
    /// Clumping from which holes are doubtful. Unit: ratio. Source: the largest that counts.
    pub(super) clumping: f64,
    /// Most holes. Unit: holes. Source: more are a net, or gaps of clumped points.
    pub(super) max_holes: usize,
}

impl DoubtSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self { min_places: 30, clumping: 3.0, max_holes: 64 };
}
