//! Nothing: what the start of a program takes, to be subtracted from the others.
#![no_std]
#![no_main]

use arboleda_firmware::program;

program!(main);

fn main() -> core::fmt::Result {
    core::hint::black_box(Ok(()))
}
