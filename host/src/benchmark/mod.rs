//! Comparisons of indices and of other people's libraries.
//!
//! ```text
//! contenders (what can be measured) -> harness (how) -> studies (what is compared) -> report
//! ```

pub mod contenders;
pub mod harness;
pub mod studies;
