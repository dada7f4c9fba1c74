//! A 32-bit RISC-V with a debugger.

use core::arch::{asm, global_asm};
use core::fmt;

global_asm!(
    ".section .text.start, \"ax\"",
    ".globl _start",
    "_start:",
    "la sp, _stack_top",
    "j start",
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

/// The debugger's console.
pub struct Console;

impl fmt::Write for Console {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for byte in text.as_bytes() {
            // SAFETY: the operation reads one byte.
            unsafe { call(WRITE_CHARACTER, core::ptr::from_ref(byte).addr()) };
        }
        Ok(())
    }
}

/// Ends the emulator.
pub fn end(outcome: fmt::Result) -> ! {
    let reason = if outcome.is_ok() { EXIT_SUCCESS } else { EXIT_FAILURE };
    loop {
        // SAFETY: the operation takes a number.
        unsafe { call(EXIT, reason) };
    }
}
