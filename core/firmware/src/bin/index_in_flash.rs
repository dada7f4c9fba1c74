//! An index in flash, built on the PC and asked in place: what a range finder sees in a yard of 200 triangles.
//!
//! Fits a Cortex-M0 with 16 KB of RAM. Of that, the index takes nothing but the stack of a query.
#![no_std]
#![no_main]

use core::fmt::{self, Write};

use arboleda::Index;
use arboleda_firmware::board::Console;
use arboleda_firmware::kind::Kind;
use arboleda_firmware::{ANSWERS, IN_FLASH, program, yard};

program!(main);

fn main() -> fmt::Result {
    // 1. Open once, at start-up: that checks all links. The `Index<'static, _>` is `Copy` and `Sync`; keep it.
    let index = match Index::<Kind>::from_bytes(IN_FLASH) {
        Ok(index) => index,
        Err(error) => {
            writeln!(Console, "{error}")?;
            return Err(fmt::Error);
        }
    };

    // 2. Ask. A ray needs no memory but its stack.
    for (ray, answer) in yard::rays().zip(&ANSWERS) {
        let hit = index.closest_hit(&ray.map_err(|_| fmt::Error)?);
        match hit {
            // Directions have length 1, so `t` is in metres.
            Some(hit) => write!(Console, "{} ", (hit.t * 1000.0) as u32)?,
            None => write!(Console, "- ")?,
        }

        // 3. The PC got the same bits.
        if hit.map(|hit| (hit.triangle.0, hit.t.to_bits())) != *answer {
            writeln!(Console, "the PC answered {answer:?}")?;
            return Err(fmt::Error);
        }
    }
    writeln!(Console, "mm; {} bytes of index in flash", IN_FLASH.len())
}
