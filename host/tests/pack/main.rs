//! Tests of packed indices and scenes, through the program: what `pack` writes, in any memory, and who reads it.

#[path = "../program/mod.rs"]
mod program;

mod answers;
mod index_file;
mod memory;
