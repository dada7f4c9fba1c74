//! Cost of rays in each index on a Cortex-M, in instructions; `cost` describes the columns.
//!
//! Run by an emulator that counts instructions, `qemu-system-arm -M mps2-an386 -icount shift=0`: an instruction takes a
//! nanosecond, and the timer ticks once in 40 of them.
#![no_std]
#![no_main]

use core::panic::PanicInfo;
use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m_rt::{entry, exception};
use cortex_m_semihosting::{debug, hio, hprintln};

/// The system timer (*Armv7-M Architecture Reference Manual*, B3.3): control, reload value, current value.
const TIMER: [usize; 3] = [0xe000_e010, 0xe000_e014, 0xe000_e018];
/// Counts the processor's clock, interrupts at zero, is on.
const ON: u32 = 0b111;
const FROM: u32 = 0x00ff_ffff;
/// Instructions to a tick: the board's clock is 25 MHz.
const INSTRUCTIONS: u64 = 40;

static ROUNDS: AtomicU32 = AtomicU32::new(0);

#[exception]
fn SysTick() {
    ROUNDS.store(ROUNDS.load(Ordering::Relaxed) + 1, Ordering::Relaxed);
}

fn register(at: usize) -> *mut u32 {
    core::ptr::with_exposed_provenance_mut(TIMER[at])
}

/// Instructions since the timer was started.
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
        // SAFETY: the timer is nobody else's; its interrupt only counts.
        unsafe { register(at).write_volatile(value) };
    }
    let outcome = match hio::hstdout() {
        Ok(mut out) => arboleda_bare_metal::cost::run(&mut out, clock),
        Err(()) => Err(core::fmt::Error),
    };
    loop {
        debug::exit(if outcome.is_ok() { debug::EXIT_SUCCESS } else { debug::EXIT_FAILURE });
    }
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    hprintln!("{}", info);
    loop {
        debug::exit(debug::EXIT_FAILURE);
    }
}
