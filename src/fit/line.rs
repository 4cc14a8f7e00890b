//! Straight lines in the plane.

use glam::DVec2;

/// A straight line, by a place on it and its direction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    pub(crate) at: DVec2,
    pub(crate) along: DVec2,
}

impl Line {
    /// Where it meets another line; `None` if the sine of the angle between them is at most `slanted`.
    pub(crate) fn meeting(self, other: Self, slanted: f64) -> Option<DVec2> {
        let turn = self.along.perp_dot(other.along);
        let meets = turn.abs() > slanted * self.along.length() * other.along.length();
        meets.then(|| self.at + (other.at - self.at).perp_dot(other.along) / turn * self.along)
    }
}
