//! The same rays, every index: who is faster, by how much, and why.
//!
//! ```text
//! scene -> rays (of photons, found once) -+
//! plan (cases, effort) -> equal_bytes     +-> run (build, compare answers, time) -> record (CSV)
//!                                         |          |
//!   comparison, growth, separation,       |          +-> report (tables, plots, one page)
//!   levels, paper_figure3, paper_tables --+
//!   counters: figures that are the same on every machine
//! ```
//! Answers are compared bit for bit before anything is timed; all timing is on one thread.

pub mod calibration;
pub mod comparison;
pub mod counters;
pub mod equal_bytes;
pub mod growth;
pub mod levels;
pub mod paper_figure3;
pub mod paper_tables;
pub mod plan;
pub mod progress;
pub mod provenance;
pub mod rays;
pub mod record;
pub mod run;
pub mod separation;
pub mod spread;
