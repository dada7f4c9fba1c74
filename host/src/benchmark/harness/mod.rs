//! The measuring machine: rays are found once, answers are compared, and only then the clock runs.
//!
//! ```text
//! workload (rays of photons, exact answers) -+
//! plan (cases, effort) ----------------------+-> measurement (build, compare answers, count) -> timing (in turns)
//!                                                                                                |
//!                                     record (CSV, with its provenance) <- summary (spreads) <---+
//! ```
//! Answers are compared bit for bit before anything is timed; all timing is on one thread.

pub mod measurement;
pub mod plan;
pub mod progress;
pub mod provenance;
pub mod record;
pub mod summary;
pub mod timing;
pub mod workload;
