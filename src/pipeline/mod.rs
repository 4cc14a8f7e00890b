//! The whole job: scattered points in, a surface with its report out.

mod axis_scale;
mod candidates;
mod diagnose;
mod fit_problem;
mod initial_net;
mod options;
mod orientation;
mod overall_progress;
mod point_deviations;
mod projection;
mod ranked_cloud;
mod ranking;
mod reconstruct;
mod reconstruct_paper;
mod reconstruction;
mod recover_net;
mod refine;
mod repair;
mod report;
mod robust_weights;
mod score;
mod select;
mod settings;
mod stage_times;
mod surface_fit;
mod trained_map;

pub use self::candidates::{Candidate, candidates};
pub use self::options::{Aspect, ReconstructOptions, Start};
pub use self::ranking::{Dropped, Model, Ranking, rank};
pub use self::reconstruct::reconstruct;
pub use self::reconstruct_paper::{PaperOptions, reconstruct_paper};
pub use self::reconstruction::Reconstruction;
pub use self::recover_net::recover_net;
pub use self::report::{Deviations, PERCENTILES, Report, TrainingReport};
pub use self::score::Score;
pub use self::settings::{RankingSettings, ScoreSettings, SearchSettings};
