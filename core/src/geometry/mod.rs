//! Geometry: rays, boxes, triangles, and the exact test between a ray and a triangle.
//!
//! ```text
//! Ray (checked once) --+-- kernel::meet ---- f32 filter -> f64 filter -> Planar, Lattice, LongSum
//!                      +-- RaySpan (clip, plane) --- conservative slabs for the indices
//! ```
//!
//! - `kernel` decides hits exactly.
//! - `span` is conservative: it never clips a ray away from a box that holds a hit.
//!
//! Together they make every index agree with the linear scan, bit for bit.

mod aabb;
mod box4;
pub mod kernel;
mod lane_filter;
mod lane_ray;
mod overlap;
mod ray;
mod span;
mod triangle;
pub(crate) mod vector64;

pub use aabb::Aabb;
pub(crate) use box4::Box4;
pub use kernel::intersect;
pub(crate) use lane_filter::{Candidates, Numbers, Points, longest_edges, meet_triangles};
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
pub(crate) use lane_filter::{DISTANCE, ROUNDED, SUM};
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
pub(crate) use lane_ray::{EARLIER, LATER, LEAST_DIRECTION, MOST_COORDINATE, MOST_DIRECTION};
pub(crate) use lane_ray::{LaneRay, UNDERFLOW};
pub(crate) use overlap::OctantFilter;
pub use overlap::may_overlap;
pub use ray::{Ray, RayError};
pub use span::{AxisCrossing, RaySpan, Span};
pub use triangle::Triangle;
