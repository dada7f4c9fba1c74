//! Panic handler of a library that stands alone. No panic is reachable, so it is never called.

use core::panic::PanicInfo;

// What a shared library takes from the C library: `memcpy` and its kin.
#[cfg(unix)]
#[link(name = "c")]
unsafe extern "C" {}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
