//! The stack that builds and queries take on a Cortex-M, through the debugger's console.
#![no_std]
#![no_main]

use core::panic::PanicInfo;

use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hio, hprintln};

#[entry]
fn main() -> ! {
    let outcome = match hio::hstdout() {
        Ok(mut out) => arboleda_bare_metal::stack::run(&mut out),
        Err(()) => Err(core::fmt::Error),
    };
    loop {
        debug::exit(if outcome.is_ok() { debug::EXIT_SUCCESS } else { debug::EXIT_FAILURE });
    }
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    hprintln!("{}", info);
    loop {
        debug::exit(debug::EXIT_FAILURE);
    }
}
