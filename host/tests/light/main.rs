//! Tests of the light, through the program: its commands, and jobs in parts.

#[path = "../program/mod.rs"]
mod program;

mod commands;
mod estimate_parts;
mod shot_parts;
