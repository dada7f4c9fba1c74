//! Pictures of scenes by photons: primary rays, estimates of irradiance, passes, tone.
//!
//! ```text
//! Camera -> samples (primary rays, merged) -> receivers -> density: LightField -> estimates
//!                                                 \-> gather (optional) ---^          |
//!                                                                                    |
//!   PNG, EXR, PFM <- output <----------------- Film (the mean of the passes) <-------+
//! ```
//! A diffuse surface of reflectance `rho` has the radiance `rho E / pi`, and that which it emits. Every value of a
//! picture is a function of the model and the options; it does not depend on the index, the threads or the machine.

mod batch;
mod film;
mod gather;
mod harvest;
mod output;
mod passes;
mod samples;
mod snapshot;
#[cfg(test)]
mod tests;
mod viewpoint;

pub use film::{Film, Pixel};
pub use harvest::PictureGround;
pub use output::{Look, Quantity, Range, Unit, exposure_of, paint, to_srgb, write_values};
pub use passes::{Passes, PictureLight, Progress, RenderError, Summary, render};
pub use samples::{PixelShare, Sampling, TileSamples};
pub use snapshot::{Exposed, Snapshot};
pub use viewpoint::viewpoint;
