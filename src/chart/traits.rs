//! The trait of all charts.

use super::hypothesis::Hypothesis;
use super::input::ChartInput;
use super::kind::Kind;

/// A way to put points on a parameter domain.
pub trait Chart: Sync {
    /// Its name in reports.
    fn name(&self) -> &'static str;

    /// The kinds of surface that it may propose.
    fn kinds(&self) -> &'static [Kind];

    /// Its hypotheses for these points; none where it does not apply.
    fn propose(&self, input: &ChartInput<'_>) -> Vec<Hypothesis>;
}
