//! Irradiance from the density of photons.
//!
//! ```text
//! source (model, index, numbers of photons)
//!    |-> photon_map: stored photons; k nearest or a radius --\
//!    |-> tangent_plane: streamed photons; discs indexed ------+-> estimate, at a receiver (visible disc, kernel)
//!    \-> triangle_light: hits on each side of each triangle
//! ```
//! `estimator` is the choice of a method, with its options and its radius; `light_field` estimates at many receivers.
//!
//! Every estimate is a function of the model and the options. It does not depend on the index, the threads or the
//! machine: photons are in a total order, sums are of whole numbers, and only `+ - * / sqrt` and `libm` are used on
//! floats.

mod estimate;
mod estimator;
#[cfg(test)]
pub(crate) mod fixtures;
mod light_field;
mod photon_map;
mod receiver;
mod source;
mod tangent_plane;
mod triangle_light;

pub(crate) use estimate::rounded;
pub use estimate::{Estimate, Sums};
pub use estimator::{Estimator, EstimatorError, automatic_radius, wanted_photons};
pub use light_field::{
    CountsOf, DiscCounter, EstimateWork, Harvest, Light, LightField, LightPiece, LightSums,
};
pub use photon_map::{
    Deposits, Facing, Found, Gather, MapError, MapEstimator, Neighbourhood, PhotonMap,
};
pub use receiver::{Fan, Kernel, Receiver, VisiblePolygon};
pub use source::{Bounces, PhotonSource};
pub use tangent_plane::{DiscError, Discs, Domain, TangentPlane};
pub use triangle_light::{PhotonHit, TriangleIrradiance, TriangleLight, first_hits};
