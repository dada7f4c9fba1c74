//! Studies: each takes scenes, measures by [`harness`](super::harness), and returns its figures.
//!
//! ```text
//! indices      every index on a scene, and the automatic selection beside them
//! peers        other people's libraries and some of ours on a scene: answers, leaks, speed, builds
//! growth       the same kind of scene, larger and larger
//! separation   each index and its hierarchy on clusters that move apart
//! levels       the automatic level or resolution against all others
//! weights      time of a ray, a node and a test, fitted to measurements
//! calibration  the weights of the automatic selection
//! counters     figures that are the same on every machine
//! paper        the paper's figure 3 and tables 1 to 3, as printed and otherwise
//! ```

pub mod calibration;
pub mod counters;
pub mod growth;
pub mod indices;
pub mod levels;
pub mod paper;
pub mod peers;
pub mod separation;
pub mod weights;
