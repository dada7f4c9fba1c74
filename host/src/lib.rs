//! The `std` side of Arboleda: scenes, photons, comparisons, reports.
//!
//! ```text
//! scene (files, built-in) -> index (arena sized by a dry run) -> photon (emit, trace, count) -> report
//!                                    |
//!                 contenders (what can be measured) -> bench (how) -> studies (what is compared) -> report
//! ```
#![warn(clippy::pedantic)]
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    clippy::cast_sign_loss,
    clippy::many_single_char_names,
    clippy::similar_names,
    clippy::must_use_candidate,
    clippy::module_name_repetitions,
    clippy::float_cmp
)]

mod automatic;
pub mod bench;
pub mod commands;
pub mod contenders;
mod file_output;
mod owned_index;
pub mod photon;
pub mod rays;
pub mod report;
pub mod scene;
mod signature;
pub mod studies;
mod threads;
mod vector;

pub use automatic::select_index;
pub use owned_index::{OwnedIndex, kind_by_name, kind_names};
pub use threads::Threads;

/// Code of the project's front page, compiled and run as a doctest.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
pub struct FrontPage;
