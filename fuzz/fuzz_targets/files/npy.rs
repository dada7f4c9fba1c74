//! Random files of rays.
//!
//! Workload: any bytes, with the keywords of the format from a dictionary.
//!
//! Constraints: an error, or at most as many rays as fit in the file, each valid or with an error; memory in proportion
//! to the input, which libFuzzer's limits check.
#![no_main]

use arboleda_host::files::rays;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Ok(table) = rays::read(bytes) else { return };
    // A ray has at least six numbers of four bytes.
    assert!(table.len() <= bytes.len() / 24, "{} rays", table.len());
    for origin in [[0.0; 3], [-2_487_003.0, 4_684_683.0, f64::MAX]] {
        let rays = table.rays(origin);
        assert_eq!((rays.len(), rays.is_empty()), (table.len(), table.is_empty()));
        for ray in rays.into_iter().flatten() {
            assert!(ray.origin().is_finite() && ray.direction().is_finite());
            assert!(!ray.t_min().is_nan() && !ray.t_max().is_nan());
        }
    }
});
