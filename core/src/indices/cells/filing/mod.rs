//! Filing triangles in cells: shared by all trees of cells.
//!
//! ```text
//! tree_cell (a cell) <- octants (its division by planes) <- cell_lists (the triangles of each part) <- level_search
//! ```

mod cell_lists;
mod level_search;
mod octants;
mod tree_cell;

pub(super) use cell_lists::{Filing, LEAF, List, Lists, most_references};
pub(super) use level_search::LevelSearch;
pub(super) use octants::Division;
pub use octants::Planes;
pub use tree_cell::{Cell, midpoints};
