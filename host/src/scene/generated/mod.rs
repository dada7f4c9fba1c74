//! Scenes made by functions: simple shapes, the paper's figures, cities.
//!
//! ```text
//! shapes, teapot -> paper, city, mixed, sized
//!            hash -----------^------^
//! ```
//! Every scene is a function of its options and seed: no clock, no platform's mathematics. z is up.

pub mod city;
mod hash;
pub mod mixed;
pub mod paper;
pub mod shapes;
pub mod sized;
pub mod teapot;
