//! Cost of rays in each index on a Cortex-M, in instructions. The module `cost` describes the columns.
//!
//! The program runs on an emulator that counts instructions, `qemu-system-arm -M mps2-an386 -icount shift=0`. There an
//! instruction takes a nanosecond, and the timer ticks once in 40 instructions.
#![no_std]
#![no_main]

use core::sync::atomic::{AtomicU32, Ordering};

use arboleda_bare_metal::cortex_m::run_and_exit;
use cortex_m_rt::{entry, exception};

/// Registers of the system timer (*Armv7-M Architecture Reference Manual*, B3.3): control, reload value, current value.
const TIMER: [usize; 3] = [0xe000_e010, 0xe000_e014, 0xe000_e018];
/// Control bits: count the processor's clock, interrupt at zero, run.
const ON: u32 = 0b111;
/// Reload value, the largest.
const FROM: u32 = 0x00ff_ffff;
/// Instructions in a tick, because the board's clock is 25 MHz.
const INSTRUCTIONS: u64 = 40;

static ROUNDS: AtomicU32 = AtomicU32::new(0);

#[exception]
fn SysTick() {
    ROUNDS.store(ROUNDS.load(Ordering::Relaxed) + 1, Ordering::Relaxed);
}

fn register(at: usize) -> *mut u32 {
    core::ptr::with_exposed_provenance_mut(TIMER[at])
}

/// Returns the instructions since the start of the timer.
fn clock() -> u64 {
    loop {
        let rounds = ROUNDS.load(Ordering::Relaxed);
        // SAFETY: reading the timer's value changes nothing.
        let left = unsafe { register(2).read_volatile() };
        if rounds == ROUNDS.load(Ordering::Relaxed) {
            let ticks = u64::from(rounds) * u64::from(FROM + 1) + u64::from(FROM - left);
            return ticks * INSTRUCTIONS;
        }
    }
}

#[entry]
fn main() -> ! {
    for (at, value) in [(1, FROM), (2, 0), (0, ON)] {
        // SAFETY: no other code uses the timer, and its interrupt only counts.
        unsafe { register(at).write_volatile(value) };
    }
    run_and_exit(|out| arboleda_bare_metal::cost::run(out, clock))
}
