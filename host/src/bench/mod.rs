//! How anything is measured: rays found once, answers compared, and only then the clock.
//!
//! ```text
//! scene -> rays (of photons, found once) -+
//! plan (cases, effort) -------------------+-> run (build, compare answers, time) -> record (CSV)
//! ```
//! Answers are compared bit for bit before anything is timed; all timing is on one thread. What is compared with what:
//! [`crate::studies`].

pub mod plan;
pub mod progress;
pub mod provenance;
pub mod rays;
pub mod record;
#[cfg(feature = "peers")]
pub mod ring;
pub mod run;
pub mod spread;
#[cfg(feature = "peers")]
pub mod workload;
