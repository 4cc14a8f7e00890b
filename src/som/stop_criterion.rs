//! The criterion that ended a training.

/// The criterion that ended a training (step 7 of the paper's section 4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StoppedBy {
    /// None yet: the training was interrupted, or points come in chunks.
    Unfinished,
    /// All points are on the lattice: the paper's criterion for few points.
    Reached,
    /// No node moved farther than `min_change`: the paper's criterion for many points.
    Settled,
    /// All `max_steps` steps are done.
    MaxSteps,
}

impl StoppedBy {
    /// All variants.
    pub const ALL: [Self; 4] = [Self::Unfinished, Self::Reached, Self::Settled, Self::MaxSteps];

    /// The criterion's name in Python and in reports.
    ///
    /// ```
    /// use neurbs::som::StoppedBy;
    /// assert_eq!(StoppedBy::Settled.name(), "settled");
    /// ```
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Unfinished => "unfinished",
            Self::Reached => "reached",
            Self::Settled => "settled",
            Self::MaxSteps => "max_steps",
        }
    }
}
