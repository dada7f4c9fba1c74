//! Files of rays that nobody wrote.
//!
//! Workload: any bytes, with the words of the format from a dictionary.
//! Constraints: none. An error, or as many rays as the file has room for, each valid or with its reason;
//! memory in proportion to the input, which libFuzzer's limits watch.
#![no_main]

use arboleda_host::rays;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Ok(table) = rays::read(bytes) else { return };
    // Six numbers of four bytes.
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
