//! What ends a training.

use super::SelfOrganizingMap;

/// What ended a training (step 7 of the paper's section 4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StoppedBy {
    /// Nothing yet: it was interrupted, or is fed chunk by chunk.
    Unfinished,
    /// All points are on the lattice: the paper's criterion for few points.
    Reached,
    /// The lattice no longer moves: the paper's criterion for many points.
    Settled,
    /// `max_steps` are over.
    MaxSteps,
}

impl StoppedBy {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Unfinished, Self::Reached, Self::Settled, Self::MaxSteps];

    /// The criterion's name, as Python and reports spell it.
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

impl SelfOrganizingMap {
    /// Step 7's criterion for many points, at the end of an epoch.
    pub(super) fn settled(&self) -> bool {
        let rests = |change| change <= self.plan.min_change;
        self.plan.ordered_after(self.steps) && self.change.is_some_and(rests)
    }

    /// Step 7's criterion for all.
    pub(super) fn stop_at_last_step(&mut self) {
        if self.stopped_by == StoppedBy::Unfinished && self.steps >= self.plan.max_steps {
            self.stopped_by = StoppedBy::MaxSteps;
        }
    }
}
