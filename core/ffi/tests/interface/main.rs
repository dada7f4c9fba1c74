//! Tests of the C interface, in one program. They call the functions as C does.
#![allow(unsafe_code)]

mod answers;
mod builds;
mod errors;
mod given;
mod piecewise;
mod sliced;
