//! Stack of a call: memory below the stack pointer is filled with a pattern; words that have changed were used.

use core::arch::asm;

/// Words that are filled, more than any call uses.
const PAINTED_WORDS: usize = 1 << 15;
/// Pattern of unused words.
const COLOUR: u32 = 0xa5c3_5a3c;

/// Measures the bytes of stack that `work` uses.
#[inline(never)]
pub fn used_by(work: &mut dyn FnMut()) -> usize {
    let top: usize;
    // SAFETY: reads a register.
    #[cfg(target_arch = "arm")]
    unsafe {
        asm!("mov {}, sp", out(reg) top, options(nomem, nostack, preserves_flags));
    }
    // SAFETY: reads a register.
    #[cfg(target_arch = "riscv32")]
    unsafe {
        asm!("mv {}, sp", out(reg) top, options(nomem, nostack, preserves_flags));
    }
    let words = top as *mut u32;
    // SAFETY: the stack has 2 MiB left, nothing below its pointer is in use, and there are no interrupts.
    (1..=PAINTED_WORDS).for_each(|down| unsafe { words.wrapping_sub(down).write_volatile(COLOUR) });
    work();
    // SAFETY: as above.
    let is_used = |down: &usize| unsafe { words.wrapping_sub(*down).read_volatile() != COLOUR };
    (1..=PAINTED_WORDS).rev().find(is_used).unwrap_or(0) * size_of::<u32>()
}
