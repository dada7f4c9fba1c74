//! Instructions of a call, on an emulator that counts them.

use core::fmt;

/// Counts the instructions of `work`, to within some dozen.
///
/// # Errors
/// If the timer of a Cortex-M went round.
#[cfg(target_arch = "arm")]
pub fn instructions(work: &mut dyn FnMut()) -> Result<u64, fmt::Error> {
    /// Registers of the system timer (*Armv7-M Architecture Reference Manual*, B3.3).
    const CONTROL: usize = 0xe000_e010;
    const RELOAD: usize = 0xe000_e014;
    const VALUE: usize = 0xe000_e018;
    /// Control bits: run, and count the processor's clock; the timer went round.
    const ON: u32 = 0b101;
    const ROUND: u32 = 1 << 16;
    /// Reload value, the largest.
    const FROM: u32 = 0x00ff_ffff;
    /// Instructions in a tick: the board's clock is 25 MHz, and an instruction takes a nanosecond.
    const INSTRUCTIONS: u64 = 40;

    let register = |at: usize| core::ptr::with_exposed_provenance_mut::<u32>(at);
    for (at, value) in [(CONTROL, 0), (RELOAD, FROM), (VALUE, 0), (CONTROL, ON)] {
        // SAFETY: no other code uses the timer.
        unsafe { register(at).write_volatile(value) };
    }
    work();
    // SAFETY: no other code uses the timer.
    let (left, control) =
        unsafe { (register(VALUE).read_volatile(), register(CONTROL).read_volatile()) };
    if control & ROUND != 0 { Err(fmt::Error) } else { Ok(u64::from(FROM - left) * INSTRUCTIONS) }
}

/// Counts the instructions of `work`, to within some dozen.
///
/// # Errors
/// Never.
#[cfg(target_arch = "riscv32")]
pub fn instructions(work: &mut dyn FnMut()) -> Result<u64, fmt::Error> {
    let begun = retired();
    work();
    Ok(retired() - begun)
}

/// Reads the counter of instructions, in two halves that belong together.
#[cfg(target_arch = "riscv32")]
fn retired() -> u64 {
    loop {
        let (high, low, again): (u32, u32, u32);
        // SAFETY: reads registers.
        unsafe {
            core::arch::asm!(
                "csrr {}, instreth",
                "csrr {}, instret",
                "csrr {}, instreth",
                out(reg) high,
                out(reg) low,
                out(reg) again,
                options(nomem, nostack),
            );
        }
        if high == again {
            return u64::from(high) << 32 | u64::from(low);
        }
    }
}
