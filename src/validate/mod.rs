//! What is wrong with a surface beside its points.

mod defects;
mod grid;
mod surface;
mod terms;

pub use self::defects::{DefectSettings, defects, folded_share};
pub use self::grid::CellGrid;
pub use self::surface::validate;
pub use self::terms::{Compared, TermSettings, Terms};
