//! Digest lines on a 32-bit RISC-V without firmware, through the debugger's console.
#![no_std]
#![no_main]

use core::arch::{asm, global_asm};
use core::fmt::{self, Write};
use core::panic::PanicInfo;

global_asm!(
    ".section .text.start, \"ax\"",
    ".globl _start",
    "_start:",
    "la sp, _stack_top",
    "j rust_main",
);

/// Semihosting operations (*Semihosting for AArch32 and AArch64*, Arm), which RISC-V uses too.
const WRITE_CHARACTER: usize = 0x03;
const EXIT: usize = 0x18;
const EXIT_SUCCESS: usize = 0x2_0026;
const EXIT_FAILURE: usize = 0x2_0023;

/// Calls a semihosting operation of the debugger.
///
/// # Safety
/// `argument` must be valid for the operation.
unsafe fn call(operation: usize, argument: usize) {
    // SAFETY: the call consists of these three consecutive, uncompressed instructions; its result is in a0.
    unsafe {
        asm!(
            ".balign 16",
            ".option push",
            ".option norvc",
            "slli x0, x0, 0x1f",
            "ebreak",
            "srai x0, x0, 7",
            ".option pop",
            inout("a0") operation => _,
            in("a1") argument,
        );
    }
}

struct Console;

impl Write for Console {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for byte in text.as_bytes() {
            // SAFETY: the operation reads one byte.
            unsafe { call(WRITE_CHARACTER, core::ptr::from_ref(byte).addr()) };
        }
        Ok(())
    }
}

fn exit(reason: usize) -> ! {
    loop {
        // SAFETY: the operation takes a number.
        unsafe { call(EXIT, reason) };
    }
}

#[unsafe(no_mangle)]
extern "C" fn rust_main() -> ! {
    let outcome = arboleda_bare_metal::run(&mut Console);
    exit(if outcome.is_ok() { EXIT_SUCCESS } else { EXIT_FAILURE })
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    let _ = writeln!(Console, "{info}"); // a failure cannot be reported
    exit(EXIT_FAILURE)
}
