//! In place of tinybvh where it was not compiled in: says how to get it.

use crate::contenders::PeerError;
use crate::contenders::contender::{Peer, Setting};

/// Cannot be built.
pub const PEER: Peer = Peer {
    name: "tinybvh",
    settings: &[Setting {
        name: "absent",
        build: |_| {
            Err(PeerError::NotCompiled {
                library: "tinybvh",
                feature: "tinybvh",
                why_apart: "it needs a C++20 compiler",
            })
        },
    }],
};
