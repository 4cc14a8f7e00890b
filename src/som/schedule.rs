//! Schedules of gain and radius over the steps of a training (section 4.1 of the paper).

use std::f64::consts::PI;

use crate::error::{Error, Result};

/// The paper's gain at time 0: `1 / √(2π)`, about 0.4.
pub(super) fn paper_gain() -> f64 {
    (2.0 * PI).sqrt().recip()
}

/// A quantity that changes during training. For the gain it is the share of the distance to the
/// point by which nodes move, for the radius the reach of the neighborhood in cells.
///
/// ```
/// use neurbs::som::Schedule;
/// let radius = Schedule::Linear { start: 5.0, end: 1.0 };
/// assert_eq!(radius.at(50, 100), 3.0);
/// let paper = Schedule::Gaussian { start: Some(6.5), scale: Some(500.0) };
/// assert!((paper.at(500, 1) - 6.5 * (-0.5_f64).exp()).abs() < 1e-12);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum Schedule {
    /// The paper's `start · exp(-(t / scale)² / 2)` with t in steps. `None`: derived from points,
    /// lattice and number of steps, as the option describes.
    Gaussian {
        /// Value at time 0.
        start: Option<f64>,
        /// Scale of the time axis, in steps: the paper's q for the gain, s for the radius.
        scale: Option<f64>,
    },
    /// Linear from the first step to the last.
    Linear {
        /// Value at the first step.
        start: f64,
        /// Value at the last step.
        end: f64,
    },
    /// Multiplied by a constant factor at each step.
    Exponential {
        /// Value at the first step.
        start: f64,
        /// Value at the last step.
        end: f64,
    },
    /// Constant.
    Constant(f64),
    /// Given values at equal intervals from the first step to the last, linearly interpolated.
    Table(Vec<f64>),
}

impl Schedule {
    /// The value at `step`; constant after step `last`.
    ///
    /// A Gaussian without `start` starts at 1; without `scale` its scale is a third of the steps.
    ///
    /// ```
    /// use neurbs::som::Schedule;
    /// let gain = Schedule::Exponential { start: 0.4, end: 0.1 };
    /// assert!((gain.at(50, 100) - 0.2).abs() < 1e-15);
    /// assert_eq!(gain.at(200, 100), 0.1);
    /// ```
    #[must_use]
    pub fn at(&self, step: u64, last: u64) -> f64 {
        let share = || if last == 0 { 1.0 } else { (step.min(last) as f64) / last as f64 };
        match *self {
            Self::Gaussian { start, scale } => {
                let scale = scale.unwrap_or(GAIN_SCALE_SHARE * last as f64);
                let t = step as f64 / scale;
                start.unwrap_or(1.0) * (-0.5 * t * t).exp()
            }
            Self::Linear { start, end } => start + (end - start) * share(),
            Self::Exponential { start, end } => start * (end / start).powf(share()),
            Self::Constant(value) => value,
            Self::Table(ref values) => {
                let place = share() * (values.len() - 1) as f64;
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "a place in the table"
                )]
                let before = (place as usize).min(values.len().saturating_sub(2));
                let after = (before + 1).min(values.len() - 1);
                values[before] + (values[after] - values[before]) * (place - before as f64)
            }
        }
    }

    /// The first step at which the value is below `limit`. For a radius and limit 1 it is the
    /// paper's t₀, from which on only the winner moves. For a Gaussian it is `scale · √(2 ln(start
    /// / limit))`, rounded up, and may exceed `last`. For other schedules it is at most `last + 1`,
    /// which stands for never.
    ///
    /// ```
    /// use neurbs::som::Schedule;
    /// let radius = Schedule::Gaussian { start: Some(6.5), scale: Some(500.0) };
    /// assert_eq!(radius.falls_under(1.0, 100), 968);
    /// assert!(radius.at(967, 100) > 1.0 && radius.at(968, 100) < 1.0);
    /// assert_eq!(Schedule::Constant(2.0).falls_under(1.0, 100), 101);
    /// ```
    #[must_use]
    pub fn falls_under(&self, limit: f64, last: u64) -> u64 {
        if let Self::Gaussian { start, scale } = *self {
            let scale = scale.unwrap_or(GAIN_SCALE_SHARE * last as f64);
            let time = scale * unit_time(start.unwrap_or(1.0), limit);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "not negative; the cast saturates beyond any training"
            )]
            return time.ceil() as u64;
        }
        let (mut low, mut high) = (0, last + 1);
        if let Self::Table(values) = self {
            // A table may rise and fall: search after its last value not below the limit.
            let above = values.iter().rposition(|&value| value >= limit);
            let places = (values.len() - 1).max(1) as u64;
            let step_of = |place: usize| {
                place as u64 * (last / places) + place as u64 * (last % places) / places
            };
            low = above.map_or(0, step_of);
            high = above.map_or(0, |place| (step_of(place + 1) + 1).min(last + 1));
        }
        // From `low` to `high` the values fall or stay constant, so bisection applies.
        while low < high {
            let middle = low + (high - low) / 2;
            if self.at(middle, last) < limit { high = middle } else { low = middle + 1 }
        }
        low
    }

    /// Whether the value is constant after `step`.
    pub(super) fn constant_after(&self, step: u64, last: u64) -> bool {
        step >= last || matches!(self, Self::Constant(_))
    }

    /// The same schedule with the missing parts of a Gaussian filled in.
    pub(super) fn or(self, default_start: f64, default_scale: impl Fn(f64) -> f64) -> Self {
        match self {
            Self::Gaussian { start, scale } => {
                let start = start.unwrap_or(default_start);
                let scale = scale.unwrap_or_else(|| default_scale(start));
                Self::Gaussian { start: Some(start), scale: Some(scale) }
            }
            other => other,
        }
    }

    /// Checks that all values are finite numbers from 0 to `max`.
    pub(super) fn check(&self, name: &'static str, max: f64) -> Result<()> {
        let value = |value: f64| {
            if (0.0..=max).contains(&value) && value.is_finite() {
                return Ok(());
            }
            let must = if max.is_finite() {
                "from 0 to 1 at every step"
            } else {
                "finite and at least 0 at every step"
            };
            Err(Error::parameter(name, must, value))
        };
        let positive = |part: f64| {
            if part > 0.0 && part.is_finite() {
                return Ok(());
            }
            Err(Error::parameter(name, "positive in start, end and scale", part))
        };
        match self {
            Self::Gaussian { start, scale } => {
                scale.map_or(Ok(()), positive)?;
                start.map_or(Ok(()), value)
            }
            Self::Exponential { start, end } => {
                positive(*start)?;
                positive(*end)?;
                value(*start)?;
                value(*end)
            }
            Self::Linear { start, end } => value(*start).and_then(|()| value(*end)),
            Self::Constant(constant) => value(*constant),
            Self::Table(values) if values.is_empty() => {
                Err(Error::parameter(name, "a table of at least one value", "an empty one"))
            }
            Self::Table(values) => values.iter().try_for_each(|&v| value(v)),
        }
    }
}

/// Scale q of the gain as a share of the steps: the gain ends at `exp(-4.5)`, 1 % of its start.
pub(super) const GAIN_SCALE_SHARE: f64 = 1.0 / 3.0;

/// The scale at which a Gaussian falls from `start` to `value` in `steps` steps; `steps` if `start`
/// is below `value`.
pub(super) fn scale_for(start: f64, value: f64, steps: f64) -> f64 {
    let unit = unit_time(start, value);
    if unit > 0.0 { steps / unit } else { steps }
}

/// Time at which a Gaussian of scale 1 falls from `start` to `value`.
fn unit_time(start: f64, value: f64) -> f64 {
    (2.0 * (start / value).ln()).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_for_inverts_falls_under() {
        let scale = scale_for(40.0, 1.0, 1234.0);
        let radius = Schedule::Gaussian { start: Some(40.0), scale: Some(scale) };
        assert!((1234..=1235).contains(&radius.falls_under(1.0, 1)));
    }

    #[test]
    fn a_start_below_the_limit_falls_under_at_step_zero() {
        let radius = Schedule::Gaussian { start: Some(0.5), scale: Some(10.0) };
        assert_eq!(radius.falls_under(1.0, 100), 0);
        assert_eq!(scale_for(0.5, 1.0, 10.0), 10.0);
    }

    #[test]
    fn falls_under_agrees_with_at() {
        let schedules = [
            Schedule::Linear { start: 7.0, end: 0.0 },
            Schedule::Exponential { start: 9.0, end: 0.3 },
            Schedule::Table(vec![4.0, 0.5, 3.0, 0.0]),
        ];
        for schedule in schedules {
            let step = schedule.falls_under(1.0, 1000);
            assert!(schedule.at(step, 1000) < 1.0 && schedule.at(step - 1, 1000) >= 1.0);
            assert_eq!(schedule.at(1000, 1000), schedule.at(5000, 1000));
        }
    }

    #[test]
    fn tables_and_exponentials_interpolate() {
        let table = Schedule::Table(vec![4.0, 2.0, 0.0]);
        assert_eq!([0, 25, 50, 100].map(|t| table.at(t, 100)), [4.0, 3.0, 2.0, 0.0]);
        assert_eq!(Schedule::Table(vec![4.0]).at(3, 9), 4.0);
        let exponential = Schedule::Exponential { start: 8.0, end: 2.0 };
        assert_eq!([0, 1, 2].map(|t| exponential.at(t, 2)), [8.0, 4.0, 2.0]);
    }

    #[test]
    fn bad_values_are_refused_by_name() {
        let bad = [
            Schedule::Constant(-1.0),
            Schedule::Constant(1.5),
            Schedule::Linear { start: 0.5, end: f64::NAN },
            Schedule::Exponential { start: 0.5, end: 0.0 },
            Schedule::Gaussian { start: None, scale: Some(0.0) },
            Schedule::Table(vec![]),
            Schedule::Table(vec![0.5, 2.0]),
        ];
        for schedule in bad {
            let message = schedule.check("gain", 1.0).unwrap_err().to_string();
            assert!(message.starts_with("gain must be"), "{message}");
        }
    }
}
