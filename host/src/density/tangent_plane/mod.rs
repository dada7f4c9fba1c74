//! Density estimation on the tangent plane (DETP): photons that cross a disc around a point.
//!
//! ```text
//! receivers -> discs -> carriers -> index <- all hits <- segments of photons (streamed, not stored)
//!                                     \-> crossing rules -> counts -> Estimate
//! ```
//! A photon map counts the photons that fell on surfaces near a point. DETP counts the segments of photon paths that
//! cross a disc in the plane of the point, wherever they end. So the estimate keeps its value at the open edge of a
//! surface, on small and thin objects, and in mid-air, where no surface is. On a flat surface both count the same
//! photons.
//!
//! # Expectation and error
//! `E = photon flux * count / (pi r^2)` has the mean of the irradiance over the disc, so a smooth field is blurred by
//! `r^2 / 8` times its Laplacian; the variance is `E * photon flux / (pi r^2)`. Where a wall stands on the plane, the
//! disc reaches into it or behind it, and the estimate is too low or has light from the other side; see
//! [`Domain::Visible`]. On the inside of a curved surface every segment ends before the plane; see
//! [`TangentPlane::beyond`].
//!
//! # Cost
//! The index over the carriers is built in `O(D log D)` for `D` discs, and answers `S` segments in
//! `O(S log D + X)` for `X` crossings. Memory does not depend on the number of photons.
//!
//! # Source
//! M. Lastra, C. Ureña, J. Revelles, R. Montes, *A Particle-Path Based Method for Monte Carlo Density Estimation*,
//! Rendering Techniques 2002 (poster papers).
//!
//! Deviations: a point that lies in the plane up to rounding counts as in the plane, because a plane that is not along
//! the axes has hardly any `f32` points. Kernels, the slack for concave surfaces, and the visible polygon are
//! additions.

mod carriers;
mod crossing;
mod discs;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod wall_tests;

use super::Kernel;

pub use discs::{DiscError, Discs};

/// Part of the tangent plane in which photons count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Domain {
    /// The disc, as in the paper.
    #[default]
    Disc,
    /// The part of the disc that the point sees: a polygon.
    Visible,
}

/// Options of density estimation on the tangent plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TangentPlane {
    /// Radius of the discs, finite and above 0.
    pub radius: f32,
    /// Largest height above the plane, in radii, at which a segment may end and still count, on its extension. 0 is the
    /// paper's rule. A concave surface of curvature radius `R` needs `radius / (2 R)`.
    pub beyond: f32,
    /// Weight by distance; constant in the paper.
    pub kernel: Kernel,
    /// Part of the plane in which photons count.
    pub domain: Domain,
}
