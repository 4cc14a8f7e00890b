//! Settings of the exact recovery of a net.

/// Recovery: Levenberg-Marquardt steps from several parametrizations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RecoverySettings {
    /// Points for each control point that the search uses, at most. Unit: points. Source: cost:
    /// all points are used at the end.
    pub(super) points_per_control_point: usize,
    /// Distance of foot points beyond the domain, at most, during the search. Unit: shares of the
    /// domain. Source: calibrated on the scoreboard.
    pub(super) extension: f64,
    /// Steps at the end, which move the domain's ends to the outermost points, at most. Unit:
    /// steps. Source: calibrated on the scoreboard.
    pub(super) final_steps: usize,
    /// Rms distance below which the steps end. Unit: diameters of the cloud. Source: rounding.
    pub(super) exact_error: f64,
    /// First damping. Unit: shares of the mean diagonal entry. Source: calibrated on the
    /// scoreboard.
    pub(super) damping: f64,
    /// Least damping. Unit: shares of the mean diagonal entry. Source: rounding.
    pub(super) min_damping: f64,
    /// Factor by which the damping falls after a step that helps and rises after one that does
    /// not. Unit: ratio. Source: calibrated on the scoreboard.
    pub(super) damping_factor: f64,
    /// Share of a step at which its second derivative is measured. Unit: share. Source: M.
    /// Transtrum, J. Sethna, 2012.
    pub(super) probe: f64,
    /// Length of the second-order correction, at most. Unit: lengths of the step. Source: M.
    /// Transtrum, J. Sethna, 2012.
    pub(super) max_correction: f64,
    /// Steps of the first round; each round ends after twice as many. Unit: steps. Source:
    /// calibrated on the scoreboard.
    pub(super) first_round_steps: usize,
    /// Steps, at most. Unit: steps. Source: cost: a search that needs more rarely succeeds.
    pub(super) max_steps: usize,
    /// Trials after the first round, at most; each further round keeps half. Unit: trials. Source:
    /// calibrated on the scoreboard.
    pub(super) max_trials: usize,
    /// Ratio of the error after and before a round above which the search ends. Unit: ratio.
    /// Source: calibrated on the scoreboard.
    pub(super) stalled_ratio: f64,
}

impl RecoverySettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self {
        points_per_control_point: 32,
        extension: 0.15,
        final_steps: 24,
        exact_error: 1e-9,
        damping: 1e-3,
        min_damping: 1e-16,
        damping_factor: 4.0,
        probe: 0.1,
        max_correction: 0.5,
        first_round_steps: 3,
        max_steps: 384,
        max_trials: 32,
        stalled_ratio: 0.9,
    };
}
