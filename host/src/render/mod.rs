//! Pictures of scenes by photons: primary rays, estimates of irradiance, passes, tone.
//!
//! ```text
//! Camera -> samples (primary rays, merged) -> receivers -> density: LightField -> estimates
//!                                                                                    |
//!   PNG <- picture <- tone, false colour <- Film (the mean of the passes) <----------+
//!   EXR, PFM <- values <--------------------/
//! ```
//! A diffuse surface of reflectance `rho` has the radiance `rho E / pi`, and that which it emits. Every value of a
//! picture is a function of the model and the options; it does not depend on the index, the threads or the machine.

mod film;
mod passes;
mod picture;
mod samples;
#[cfg(test)]
mod tests;
mod tone;
mod values;
mod viewpoint;

pub use film::{Film, Pixel};
pub use passes::{Passes, Progress, RenderError, Summary, render};
pub use picture::{Look, Quantity, Range, Unit, paint};
pub use samples::{Sampling, Share, TileSamples};
pub use tone::{exposure_of, to_srgb};
pub use values::write_values;
pub use viewpoint::viewpoint;
