//! What is wrong with a surface beside its points.

mod defects;
mod grid;
mod terms;
mod validate;

pub use self::defects::{DefectSettings, defects, folded_share};
pub use self::grid::CellGrid;
pub use self::terms::{Compared, TermSettings, Terms};
pub use self::validate::validate;
