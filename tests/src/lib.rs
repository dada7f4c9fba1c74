//! Oracles, scenes and checks that the integration tests and the fuzz targets share.
//!
//! ```text
//! random --> scenes, rays, pairs, zeros --> checks <-- oracle
//!                                             |
//!                                           build
//! ```
//! `oracle` says what is right, in exact integers or by comparing all pairs, and knows none of the
//! core's shortcuts. `checks` run every index and compare with `==` on bits; they panic where a
//! promise is broken, so a test and a fuzz target are both one call.

pub mod build;
pub mod checks;
pub mod crowds;
pub mod digest;
pub mod hostile;
pub mod oracle;
pub mod pairs;
pub mod parallel;
pub mod random;
pub mod rays;
pub mod scenes;
pub mod work;
pub mod zeros;
