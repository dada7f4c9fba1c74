//! The `std` side of Arboleda: scenes, photons, comparisons, reports.
//!
//! ```text
//! scene (files, built-in) -> index (on the heap, in files) -> photon (emit, trace, count) -> density -> render
//!                              |                                \-> parts (of a job, put together) <-/     |
//!                              v                                                                         v
//!                            benchmark (contenders -> harness -> studies) ----------------------------> report
//! ```
//! `files` reads rays and writes results; `commands` is the program.
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

pub mod benchmark;
pub mod commands;
pub mod density;
pub mod files;
mod index;
pub mod parts;
pub mod photon;
pub mod render;
pub mod report;
pub mod scene;

pub use index::{
    IndexFile, PackedIndex, PackedScene, Threads, TimedIndex, Validation, bounded, kind_by_name,
    kind_names, scene_path, select_index,
};

/// Code of the package's page, compiled and run as a doctest.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct PackagePage;
