//! The paper's measurements, made again: figure 3, and tables 1 to 3.

pub mod equal_bytes;
pub mod figure3;
pub mod tables;
