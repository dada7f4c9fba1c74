//! Digest lines from WebAssembly, run by `wasm.mjs`.
#![no_std]
#![no_main]

use core::arch::wasm32::unreachable;
use core::fmt::{self, Write};
use core::panic::PanicInfo;

#[link(wasm_import_module = "host")]
unsafe extern "C" {
    /// Prints the text at an address of the module's memory.
    safe fn print(first: *const u8, count: usize);
}

struct Console;

impl Write for Console {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        print(text.as_ptr(), text.len());
        Ok(())
    }
}

/// Prints the lines. Returns whether that succeeded.
#[unsafe(no_mangle)]
extern "C" fn run() -> bool {
    arboleda_bare_metal::run(&mut Console).is_ok()
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    let _ = writeln!(Console, "{info}"); // a failure cannot be reported
    unreachable()
}
