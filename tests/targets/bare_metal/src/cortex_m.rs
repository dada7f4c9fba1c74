//! Console and exit of the programs for a Cortex-M, by semihosting.

use core::fmt::{self, Write};
use core::panic::PanicInfo;

use cortex_m_semihosting::{debug, hio, hprintln};

/// Runs a program that writes to the debugger's console, then ends the emulator with the outcome.
pub fn run_and_exit(program: impl FnOnce(&mut dyn Write) -> fmt::Result) -> ! {
    let outcome = match hio::hstdout() {
        Ok(mut out) => program(&mut out),
        Err(()) => Err(fmt::Error),
    };
    exit(if outcome.is_ok() { debug::EXIT_SUCCESS } else { debug::EXIT_FAILURE })
}

/// Ends the emulator. `debug::exit` returns if no debugger is attached.
fn exit(status: debug::ExitStatus) -> ! {
    loop {
        debug::exit(status);
    }
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    hprintln!("{}", info);
    exit(debug::EXIT_FAILURE)
}
