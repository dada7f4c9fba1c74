//! Surfaces that photons meet: the side that is hit, where the next ray begins, and where it goes.

pub(crate) mod hemisphere;
pub(crate) mod offset;
pub(super) mod side;

pub use side::Side;
