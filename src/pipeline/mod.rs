//! The whole job: scattered points in, a surface out.

mod candidate;
mod candidates;
mod clock;
mod diagnose;
mod fitted;
mod map;
mod measure;
mod net_shape;
mod options;
mod orientation;
mod outliers;
mod paper;
mod ranked;
mod reconstruct;
mod reconstruction;
mod recover_net;
mod refine;
mod refined;
mod repair;
mod report;
mod score;
mod select;
mod start;
mod whole;

pub use self::candidate::Candidate;
pub use self::candidates::candidates;
pub use self::options::{Aspect, ReconstructOptions, Start};
pub use self::paper::{PaperOptions, reconstruct_paper};
pub use self::reconstruct::reconstruct;
pub use self::reconstruction::Reconstruction;
pub use self::recover_net::recover_net;
pub use self::report::{Deviations, PERCENTILES, Report, TrainingReport};
pub use self::score::{Score, ScoreSettings};
pub use self::select::{DropSettings, Model, Ranking, SelectSettings, rank};
