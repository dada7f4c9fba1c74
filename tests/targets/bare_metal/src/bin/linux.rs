//! Digest lines on Linux without its C library: i686, ARMv7, AArch64, s390x. Nothing but `core` has to be built for
//! such a target, and the program runs in QEMU's emulation of a process.
#![no_std]
#![no_main]

use core::arch::global_asm;
use core::fmt::{self, Write};
use core::panic::PanicInfo;

// The start of the program, and `system_call`: its arguments are those of a C function, and go to the registers in
// which the kernel expects them (`man 2 syscall`).
#[cfg(target_arch = "x86")]
global_asm!(
    ".globl _start",
    "_start:",
    "and esp, -16",
    "call rust_main",
    "system_call:",
    "push ebx",
    "mov eax, [esp + 8]",
    "mov ebx, [esp + 12]",
    "mov ecx, [esp + 16]",
    "mov edx, [esp + 20]",
    "int 0x80",
    "pop ebx",
    "ret",
);
#[cfg(target_arch = "arm")]
global_asm!(
    ".globl _start",
    "_start:",
    "bl rust_main",
    "system_call:",
    "push {{r7, lr}}",
    "mov r7, r0",
    "mov r0, r1",
    "mov r1, r2",
    "mov r2, r3",
    "svc 0",
    "pop {{r7, pc}}",
);
#[cfg(target_arch = "aarch64")]
global_asm!(
    ".globl _start",
    "_start:",
    "bl rust_main",
    "system_call:",
    "mov x8, x0",
    "mov x0, x1",
    "mov x1, x2",
    "mov x2, x3",
    "svc 0",
    "ret",
);
#[cfg(target_arch = "s390x")]
global_asm!(
    ".globl _start",
    "_start:",
    "aghi %r15, -160", // where a function may save its caller's registers
    "brasl %r14, rust_main",
    "system_call:",
    "lgr %r1, %r2",
    "lgr %r2, %r3",
    "lgr %r3, %r4",
    "lgr %r4, %r5",
    "svc 0",
    "br %r14",
);

unsafe extern "C" {
    fn system_call(number: usize, first: usize, second: usize, third: usize) -> isize;
}

/// Numbers of the system calls.
const WRITE: usize = if cfg!(target_arch = "aarch64") { 64 } else { 4 };
const EXIT: usize = if cfg!(target_arch = "aarch64") { 93 } else { 1 };
const STANDARD_OUTPUT: usize = 1;

struct Console;

impl Write for Console {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        // SAFETY: the call reads the text.
        let count =
            unsafe { system_call(WRITE, STANDARD_OUTPUT, text.as_ptr().addr(), text.len()) };
        if count == text.len() as isize { Ok(()) } else { Err(fmt::Error) }
    }
}

fn exit(status: usize) -> ! {
    loop {
        // SAFETY: the call takes a number.
        unsafe { system_call(EXIT, status, 0, 0) };
    }
}

#[unsafe(no_mangle)]
extern "C" fn rust_main() -> ! {
    exit(usize::from(arboleda_bare_metal::run(&mut Console).is_err()))
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    let _ = writeln!(Console, "{info}"); // a failure cannot be reported
    exit(1)
}
