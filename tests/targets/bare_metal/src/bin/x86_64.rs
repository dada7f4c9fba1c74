//! Digest lines of the indices that use SIMD, on an x86_64 with AVX-512 and without firmware, through its serial port.
//! The script `bochs` runs it.
#![no_std]
#![no_main]

use core::arch::{asm, global_asm};
use core::fmt::{self, Write};
use core::panic::PanicInfo;

use arboleda::SimdLevel;
use arboleda_bare_metal::SIMD_KINDS;

// Start-up (*Intel 64 and IA-32 Architectures Software Developer's Manual*, volume 3, "Initializing IA-32e Mode"):
// 1. switches from 16 to 32 bits;
// 2. copies the program from the ROM to the address that it was linked for;
// 3. writes page tables, at 4 and 8 KiB, that map the first 4 GiB to themselves;
// 4. switches to 64 bits, with all vector registers on.
global_asm!(
    ".section .start, \"ax\"",
    "segments: .quad 0, 0x00cf9a000000ffff, 0x00cf92000000ffff, 0x00af9a000000ffff",
    ".word 31", // size of the descriptors, less 1
    ".long segments",
    ".code16",
    "start:",
    "cli",
    "lgdtd cs:[0xf000 + 32]",
    "mov eax, cr0",
    "or eax, 1", // protected mode
    "mov cr0, eax",
    ".byte 0x66, 0xea", // a far jump to 32 bits
    ".long protected",
    ".word 8",
    ".code32",
    "protected:",
    "mov eax, 16",
    "mov ds, eax",
    "mov es, eax",
    "mov ss, eax",
    "mov esi, offset _program_in_rom",
    "mov edi, offset _program",
    "mov ecx, offset _program_words",
    "rep movsd",
    "mov dword ptr [0x1000], 0x2003",     // present and writable
    "mov dword ptr [0x2000], 0x00000083", // and 1 GiB large
    "mov dword ptr [0x2008], 0x40000083",
    "mov dword ptr [0x2010], 0x80000083",
    "mov dword ptr [0x2018], 0xc0000083",
    "mov eax, 0x1000",
    "mov cr3, eax",
    "mov eax, 0x40620", // PAE, OSFXSR, OSXMMEXCPT, OSXSAVE
    "mov cr4, eax",
    "mov ecx, 0xc0000080", // EFER: long mode
    "mov eax, 0x100",
    "xor edx, edx",
    "wrmsr",
    "xor ecx, ecx", // XCR0: the registers of x87, SSE, AVX and AVX-512
    "mov eax, 0xe7",
    "xsetbv",
    "mov eax, 0x80000003", // paging
    "mov cr0, eax",
    ".byte 0xea", // a far jump to 64 bits
    ".long long_mode",
    ".word 24",
    ".code64",
    "long_mode:",
    "lea rsp, [_stack_top]",
    "lea rax, [rust_main]",
    "call rax",
    ".org 0xff0",
    ".code16",
    "jmp start", // the first instruction
    ".org 0x1000",
    ".text",
    ".code64",
);

/// First serial port, a 16550, with settings for eight bits a byte at its highest speed.
const DATA: u16 = 0x3f8;
const SETTINGS: [(u16, u8); 4] = [(3, 0x80), (0, 1), (1, 0), (3, 0x03)];
const STATUS: u16 = 5;
const READY: u8 = 0x20;
const ALL_SENT: u8 = 0x40;
/// Port on which the emulator receives the word that ends it with a failure.
const PANIC: u16 = 0x8900;

/// Writes a byte to a port.
fn write(port: u16, byte: u8) {
    // SAFETY: only the devices above are written to, which do not access memory.
    unsafe { asm!("out dx, al", in("dx") port, in("al") byte, options(nomem, nostack)) };
}

/// Waits for a bit of the serial port's status.
fn wait_for(bit: u8) {
    let mut status = 0_u8;
    while status & bit == 0 {
        // SAFETY: reading the status changes nothing.
        unsafe {
            asm!("in al, dx", in("dx") DATA + STATUS, out("al") status, options(nomem, nostack));
        }
    }
}

struct Console;

impl Write for Console {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for &byte in text.as_bytes() {
            wait_for(READY);
            write(DATA, byte);
        }
        Ok(())
    }
}

#[unsafe(no_mangle)]
extern "C" fn rust_main() -> ! {
    for (register, byte) in SETTINGS {
        write(DATA + register, byte);
    }
    let level = SimdLevel::detect();
    let outcome = if level.has_avx512() {
        // The other kinds would take the emulator a minute.
        arboleda_bare_metal::run_each(&SIMD_KINDS, level, &mut Console)
    } else {
        writeln!(Console, "AVX-512 was not found").and(Err(fmt::Error))
    };
    end(outcome)
}

fn end(outcome: fmt::Result) -> ! {
    wait_for(ALL_SENT);
    if outcome.is_ok() {
        // SAFETY: the instruction does nothing on a processor; the emulator ends at it.
        unsafe { asm!("xchg bx, bx", options(nomem, nostack)) };
    }
    loop {
        b"Shutdown".iter().for_each(|&byte| write(PANIC, byte));
    }
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    let _ = writeln!(Console, "{info}"); // a failure cannot be reported
    end(Err(fmt::Error))
}
