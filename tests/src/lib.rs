//! Oracles, scenes and checks that the integration tests and the fuzz targets share.
//!
//! ```text
//! random --> scenes, rays, pairs --> checks <-- oracle
//!                                      |
//!                                    build
//! ```
//! `oracle` computes right answers in exact integers or by comparing all pairs, without the core's shortcuts. `checks`
//! run every index and compare bits with `==`. They panic where a promise is broken, so a test and a fuzz target are
//! one call each.

pub mod build;
pub mod checks;
pub mod digest;
pub mod oracle;
pub mod pairs;
pub mod parallel;
pub mod random;
pub mod rays;
pub mod scenes;

/// Compiles and runs the code of the project's front page, which no published package contains.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
pub struct FrontPage;
