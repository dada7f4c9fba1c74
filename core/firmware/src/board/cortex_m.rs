//! A Cortex-M with a debugger.

use core::fmt;

use cortex_m_semihosting::{debug, hio};

/// The debugger's console.
pub struct Console;

impl fmt::Write for Console {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        hio::hstdout().map_err(|()| fmt::Error)?.write_str(text)
    }
}

/// Ends the emulator.
pub fn end(outcome: fmt::Result) -> ! {
    let status = if outcome.is_ok() { debug::EXIT_SUCCESS } else { debug::EXIT_FAILURE };
    loop {
        debug::exit(status); // returns if there is no debugger
    }
}
