//! Boards: console, and end of a program, in an emulator with a debugger.
//!
//! [`program!`](crate::program) makes a function the one that the board starts.

#[cfg(target_arch = "arm")]
mod cortex_m;
#[cfg(target_arch = "riscv32")]
mod riscv;

#[cfg(target_arch = "arm")]
pub use cortex_m::{Console, end};
#[cfg(target_arch = "riscv32")]
pub use riscv::{Console, end};

/// Makes a function, of no arguments and a `core::fmt::Result`, the program that the board runs.
#[macro_export]
macro_rules! program {
    ($main:ident) => {
        #[cfg(target_arch = "arm")]
        #[cortex_m_rt::entry]
        fn start() -> ! {
            $crate::board::end($main())
        }

        #[cfg(target_arch = "riscv32")]
        #[unsafe(no_mangle)]
        extern "C" fn start() -> ! {
            $crate::board::end($main())
        }

        // Without a message: code to format one is larger than an index, and nothing in the core panics.
        #[panic_handler]
        fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
            $crate::board::end(Err(core::fmt::Error))
        }
    };
}
