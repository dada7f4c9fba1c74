//! Description of an index, as a value for any kind.

use crate::input::CostModel;
use crate::structure::{Described, Representation, Structure, Weights};

/// Mask of the bits of a format that name the family.
pub(super) const FAMILY: u32 = 0xffff;

/// Description of an index: the constants of [`Described`] and [`Representation`] as a value.
pub(super) struct Description {
    pub name: &'static str,
    pub family: &'static str,
    pub format: u32,
    pub is_clustered: bool,
    pub holds_triangles: bool,
    pub uses_rays: bool,
    pub cost: CostModel,
    pub weights: Weights,
    pub software_weights: Weights,
}

impl Description {
    pub const fn of<R: Representation>() -> Self {
        Self {
            name: R::NAME,
            family: <R::Structure as Described>::NAME,
            format: R::FORMAT,
            is_clustered: R::CLUSTERED,
            holds_triangles: R::Structure::HOLDS_TRIANGLES,
            uses_rays: R::Structure::USES_RAYS,
            cost: R::Structure::COST,
            weights: R::Structure::WEIGHTS,
            software_weights: R::Structure::SOFTWARE_WEIGHTS,
        }
    }
}

/// Tells whether two names are equal, in a constant.
pub(super) const fn are_equal(a: &str, b: &str) -> bool {
    let (a, b) = (a.as_bytes(), b.as_bytes());
    let mut at = 0;
    while at < a.len() && at < b.len() && a[at] == b[at] {
        at += 1;
    }
    at == a.len() && at == b.len()
}
