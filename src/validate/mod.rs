//! Validation of a surface against its points: error terms and defects.

mod cell_grid;
mod defects;
mod error_terms;
mod settings;
mod validation;

pub use self::cell_grid::CellGrid;
pub use self::defects::{defects, folded_share};
pub use self::error_terms::{Comparison, Terms};
pub use self::settings::{DefectSettings, TermSettings};
pub use self::validation::validate;
