//! Output of a film: pictures for people, and files of values.
//!
//! ```text
//! film -> picture <- tone      PNG files
//!   \---> values               EXR and PFM files
//! ```

mod picture;
mod tone;
mod values;

pub use picture::{Look, Quantity, Range, Unit, paint};
pub use tone::{exposure_of, to_srgb};
#[cfg(test)]
pub(super) use values::pfm_bytes;
pub use values::write_values;
