//! Version of the interface.

use crate::error::arb_status;

/// Version of the interface that this header describes: 65536 * major + minor.
///
/// Names, numbers and layouts stay as they are within a major version. A higher minor version only adds to them.
pub const ARB_ABI_VERSION: u32 = 65537;

/// The version of the interface that the library has.
#[unsafe(no_mangle)]
pub extern "C" fn arb_abi_version() -> u32 {
    ARB_ABI_VERSION
}

/// Checks that the library has the interface of a header. Call it once, as `arb_check_abi(ARB_ABI_VERSION)`, before
/// anything else.
///
/// Errors: ARB_OTHER_ABI if the major versions differ, or if the header's minor version is higher than the library's.
#[unsafe(no_mangle)]
pub extern "C" fn arb_check_abi(header_version: u32) -> arb_status {
    let (major, minor) = (ARB_ABI_VERSION >> 16, ARB_ABI_VERSION & 0xffff);
    if header_version >> 16 == major && header_version & 0xffff <= minor {
        arb_status::ARB_OK
    } else {
        arb_status::ARB_OTHER_ABI
    }
}
