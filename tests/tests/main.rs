//! All tests of the promises, in one program: a program each would be linked with everything below them.
//!
//! `cargo test -p arboleda-tests determinism::` runs those of one file.

mod answers;
mod builds;
mod bytes;
mod house;
