//! Digest lines on a machine with an operating system: of every index at the best SIMD level of the processor, or of
//! those that use SIMD at the level that the first argument names, `portable` or `avx2`.

use std::process::ExitCode;

use arboleda::SimdLevel;
use arboleda_bare_metal::{SIMD_KINDS, run, run_each};

fn main() -> ExitCode {
    let mut lines = String::new();
    let without_avx512 = SimdLevel::detect().without_avx512();
    let outcome = match std::env::args().nth(1).as_deref() {
        None => run(&mut lines),
        Some("portable") => run_each(&SIMD_KINDS, SimdLevel::COMPILED, &mut lines),
        Some("avx2") if without_avx512.has_avx2() => {
            run_each(&SIMD_KINDS, without_avx512, &mut lines)
        }
        Some(level) => {
            eprintln!("{level}: the levels are portable and, if the processor has it, avx2");
            return ExitCode::FAILURE;
        }
    };
    print!("{lines}");
    if outcome.is_ok() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
