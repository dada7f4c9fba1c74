//! Library of the programs: the yard of 200 triangles, its index in flash, and the console of each board.
#![no_std]

pub mod board;
pub mod kind;
pub mod yard;

use arboleda::include_index;

/// Index of the yard, built on the PC by the build script, in flash.
pub static IN_FLASH: &[u8] = include_index!(concat!(env!("OUT_DIR"), "/yard.arb"));

/// For each ray of a turn, the triangle and the bits of `t` that the PC found.
pub static ANSWERS: [Option<(u32, u32)>; yard::RAYS] =
    include!(concat!(env!("OUT_DIR"), "/answers.rs"));
