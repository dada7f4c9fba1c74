//! Bytes of indices: the same everywhere, read by later versions and other languages, harmless if forged.

mod determinism;
mod hostile;
mod layout;
mod old_bytes;
mod opening;
