//! Stack of builds and queries on a Cortex-M, through the debugger's console.
#![no_std]
#![no_main]

use arboleda_bare_metal::cortex_m::run_and_exit;
use cortex_m_rt::entry;

#[entry]
fn main() -> ! {
    run_and_exit(arboleda_bare_metal::stack::run)
}
