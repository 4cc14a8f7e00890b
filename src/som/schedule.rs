//! How gain and radius fall in time (the paper's section 4.1).

use std::f64::consts::PI;

/// A Gaussian of time, `start · exp(-(t / scale)² / 2)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussianDecay {
    /// Value at time 0.
    pub start: f64,
    /// The scale on the time axis, in steps: the paper's q for the gain, s for the radius.
    pub scale: f64,
}

impl GaussianDecay {
    /// The paper's gain: it starts at `1 / √(2π)`, about 0.4.
    #[must_use]
    pub fn gain(scale: f64) -> Self {
        Self { start: (2.0 * PI).sqrt().recip(), scale }
    }

    /// The value after `step` steps.
    #[must_use]
    pub fn at(&self, step: u64) -> f64 {
        let t = step as f64 / self.scale;
        self.start * (-0.5 * t * t).exp()
    }

    /// When it falls to `value`, in steps: `scale · √(2 ln(start / value))`, and 0 if it starts
    /// below. For a radius and the value 1 this is the paper's t₀.
    ///
    /// ```
    /// use neurbs::som::GaussianDecay;
    /// let radius = GaussianDecay { start: 6.5, scale: 500.0 };
    /// let t0 = radius.time_of(1.0);
    /// assert!((t0 - 967.4).abs() < 0.1);
    /// assert!(radius.at(967) > 1.0 && radius.at(968) < 1.0);
    /// ```
    #[must_use]
    pub fn time_of(&self, value: f64) -> f64 {
        self.scale * unit_time(self.start, value)
    }

    /// The scale that lets it fall from `start` to `value` after `steps` steps; `steps` if it
    /// starts below.
    #[must_use]
    pub fn scale_for(start: f64, value: f64, steps: f64) -> f64 {
        let unit = unit_time(start, value);
        if unit > 0.0 { steps / unit } else { steps }
    }
}

/// When a Gaussian of scale 1 falls from `start` to `value`.
fn unit_time(start: f64, value: f64) -> f64 {
    (2.0 * (start / value).ln()).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_and_time_are_inverse() {
        let scale = GaussianDecay::scale_for(40.0, 1.0, 1234.0);
        let radius = GaussianDecay { start: 40.0, scale };
        assert!((radius.time_of(1.0) - 1234.0).abs() < 1e-9);
    }

    #[test]
    fn a_radius_under_one_is_zero_from_the_beginning() {
        assert_eq!(GaussianDecay { start: 0.5, scale: 10.0 }.time_of(1.0), 0.0);
        assert_eq!(GaussianDecay::scale_for(0.5, 1.0, 10.0), 10.0);
    }
}
