//! Settings of the boundary: where the points end on a surface.
//!
//! The scoreboard that calibrated them is `benches/scoreboard.py`; see the [crate](crate).

/// Boundary: four sides, straight or curved, and the weight that keeps them in place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BoundarySettings {
    /// Width of the domain at either end between straight sides, at least. Unit: mean widths.
    /// Source: calibrated on the scoreboard.
    pub(super) min_width: f64,
    /// Strips by which the points next to a straight side are found. Unit: strips. Source: cost:
    /// more change nothing visible.
    pub(super) hull_strips: usize,
    /// Strips in which the area below the lowest point is measured. Unit: strips. Source:
    /// calibrated on the scoreboard.
    pub(super) strips: usize,
    /// Strips at either end that are left out, since corners are rounded there. Unit: strips.
    /// Source: calibrated on the scoreboard.
    pub(super) end_strips: usize,
    /// Mean height of the empty area, beyond chance, from which on a boundary has a notch. Without
    /// one it is at most half of that; at the reentrant corner of an L it is two to seven times as
    /// much. Unit: sides of the domain. Source: calibrated on the scoreboard.
    pub(super) min_notch: f64,
    /// Least height of a boundary curve. Unit: sides of the domain. Source: calibrated on the
    /// scoreboard.
    pub(super) min_height: f64,
    /// Control points of a stiff curve, which does not follow rounded corners. Unit: points.
    /// Source: calibrated on the scoreboard.
    pub(super) stiff_control_points: usize,
    /// Penalties of a stiff curve; the search begins with the last. Unit: none, see
    /// `Likelihood::penalty`. Source: calibrated on the scoreboard.
    pub(super) stiff_penalties: &'static [f64],
    /// Largest height of a stiff curve. Unit: sides of the domain. Source: calibrated on the
    /// scoreboard.
    pub(super) stiff_max_height: f64,
    /// Height up to which points influence a stiff curve. Unit: sides of the domain. Source:
    /// calibrated on the scoreboard.
    pub(super) stiff_max_influence: f64,
    /// Height up to which points determine the density along a stiff curve. Unit: sides of the
    /// domain. Source: calibrated on the scoreboard.
    pub(super) stiff_density_height: f64,
    /// Control points of a flexible curve, which follows notches. Unit: points. Source: calibrated
    /// on the scoreboard.
    pub(super) flexible_control_points: usize,
    /// Penalties of a flexible curve. Unit: none, see `Likelihood::penalty`. Source: calibrated
    /// on the scoreboard.
    pub(super) flexible_penalties: &'static [f64],
    /// Largest height of a flexible curve. Unit: sides of the domain. Source: calibrated on the
    /// scoreboard.
    pub(super) flexible_max_height: f64,
    /// Height up to which points influence a flexible curve. Unit: sides of the domain. Source:
    /// calibrated on the scoreboard.
    pub(super) flexible_max_influence: f64,
    /// Least density of points along a curve, which keeps it within its limits. Unit: mean
    /// densities. Source: calibrated on the scoreboard.
    pub(super) min_density: f64,
    /// The same at the two control points at either end. Less cuts off points beside a rounded
    /// corner, more leaves the corner to the surface. Unit: mean densities. Source: calibrated on
    /// the scoreboard.
    pub(super) min_corner_density: f64,
    /// Margin of the surface beyond the curve, for each spacing of border, beside half a spacing.
    /// Unit: standard deviations of the curve. Source: calibrated on the scoreboard.
    pub(super) margin_deviations: f64,
    /// Density below which points belong to a rounded corner. Unit: mean densities. Source:
    /// calibrated on the scoreboard.
    pub(super) sparse_density: f64,
    /// Margin of the surface beyond a curve, at most, for each spacing of border. Unit: spacings of
    /// the control points. Source: calibrated on the scoreboard.
    pub(super) max_margin: f64,
    /// Weight of the boundary constraint where the fairness has as much weight as the points.
    /// Unit: ratio. Source: calibrated on the scoreboard.
    pub(super) constraint_weight: f64,
}

impl BoundarySettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self {
        min_width: 0.6,
        hull_strips: 1 << 12,
        strips: 24,
        end_strips: 4,
        min_notch: 0.03,
        min_height: -0.5,
        stiff_control_points: 8,
        stiff_penalties: &[1000.0, 100.0, 10.0],
        stiff_max_height: 0.1,
        stiff_max_influence: 0.4,
        stiff_density_height: 0.15,
        flexible_control_points: 10,
        flexible_penalties: &[1.0],
        flexible_max_height: 0.3,
        flexible_max_influence: 0.7,
        min_density: 0.02,
        min_corner_density: 0.85,
        margin_deviations: 5.0,
        sparse_density: 0.3,
        max_margin: 0.5,
        constraint_weight: 0.05,
    };
}

/// Closed boundary: one smooth curve around a sheet without corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ClosedBoundarySettings {
    /// Side of the triangles in the square's corners that must be empty. Unit: sides of the
    /// domain. Source: calibrated on the scoreboard.
    pub(super) corner: f64,
    /// The same where points are few, at most. Unit: sides of the domain. Source: calibrated on
    /// the scoreboard.
    pub(super) max_corner: f64,
    /// Control points of the curve. Unit: points. Source: calibrated on the scoreboard.
    pub(super) control_points: usize,
    /// Penalties among which the evidence chooses; the search begins with the middle one. Unit:
    /// none, see `Likelihood::penalty`. Source: calibrated on the scoreboard.
    pub(super) penalties: [f64; 5],
    /// Least and largest height: the squared distance from the center is 1 less the height. Unit:
    /// mean squared distances. Source: calibrated on the scoreboard.
    pub(super) heights: (f64, f64),
    /// Height above the curve up to which points determine the density along it. Unit: mean
    /// squared distances. Source: calibrated on the scoreboard.
    pub(super) density_height: f64,
    /// Mean height of the empty area that chance leaves, times the number of points. Unit: mean
    /// squared distances. Source: calibrated on the scoreboard.
    pub(super) chance_height: f64,
    /// Margin of the surface beyond the curve for each spacing of border. Unit: standard deviations
    /// of the curve. Source: calibrated on the scoreboard.
    pub(super) margin_deviations: f64,
    /// Distance of a point outside the curve, at most, in spacings of the points and in standard
    /// deviations of the noise, added up. Unit: spacings, deviations. Source: calibrated on the
    /// scoreboard.
    pub(super) max_outside: (f64, f64),
    /// Distance from the domain's end up to which a parameter lies on it. Unit: sides of the
    /// domain. Source: rounding.
    pub(super) rounding: f64,
    /// Directions in which the curve is interpolated. Unit: directions. Source: cost: more change
    /// the curve little.
    pub(super) directions: usize,
    /// Radius by which circles near the disc's center are scaled, at most. Along the shortest ray,
    /// half of the speed then remains at the boundary. Unit: least radii of the curve. Source:
    /// calibrated on the scoreboard.
    pub(super) max_center_radius: f64,
    /// Excess of a parameter's distance from the center over the interpolated curve, at most. Unit:
    /// share. Source: calibrated on the scoreboard.
    pub(super) max_excess: f64,
    /// Places on a ray at which its length is measured, and iterations to a place on it. Unit:
    /// places. Source: calibrated on the scoreboard.
    pub(super) ray_steps: usize,
    /// Last share of a ray by which it is extrapolated beyond the square. Unit: share. Source:
    /// calibrated on the scoreboard.
    pub(super) extrapolation_base: f64,
    /// Extrapolation of a ray beyond the square, at most. Unit: lengths of the ray. Source:
    /// calibrated on the scoreboard.
    pub(super) max_extrapolation: f64,
}

impl ClosedBoundarySettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self {
        corner: 0.2,
        max_corner: 0.3,
        control_points: 16,
        penalties: [30.0, 3.0, 0.3, 0.03, 0.003],
        heights: (-2.0, 0.9),
        density_height: 0.3,
        chance_height: 10.0,
        margin_deviations: 3.0,
        max_outside: (0.6, 4.0),
        rounding: 1e-9,
        directions: 64,
        max_center_radius: 1.2,
        max_excess: 0.05,
        ray_steps: 8,
        extrapolation_base: 0.1,
        max_extrapolation: 0.25,
    };
}

/// Boundary likelihood: the search for the likeliest curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LikelihoodSettings {
    /// Points used until the last scale of the blur, at most. Unit: points. Source: cost: the early
    /// scales only lead to the last one.
    pub(super) max_blurred_points: usize,
    /// Distance above a curve from which on a point does not influence it. Unit: scales of the
    /// blur. Source: rounding.
    pub(super) max_influence: f64,
    /// First scale of the blur. Unit: sides of the domain. Source: calibrated on the scoreboard.
    pub(super) first_scale: f64,
    /// Newton steps for each scale, and halvings of each step, at most. Unit: steps. Source:
    /// calibrated on the scoreboard.
    pub(super) max_steps: usize,
    /// Step below which the iteration ends. Unit: scales of the blur. Source: calibrated on the
    /// scoreboard.
    pub(super) converged_step: f64,
    /// Share of the mean diagonal entry added for control points that no point touches. Unit:
    /// share. Source: rounding.
    pub(super) ridge: f64,
}

impl LikelihoodSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self {
        max_blurred_points: 500,
        max_influence: 30.0,
        first_scale: 0.2,
        max_steps: 12,
        converged_step: 0.1,
        ridge: 1e-6,
    };
}
