//! The build script: keeps what the compiler was told, for [`Provenance`](provenance.rs).

use std::env::var;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=src/benchmark/harness/build_facts.rs");
    let compiler = var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
    let version = Command::new(compiler).arg("--version").output();
    let version = version.ok().and_then(|output| String::from_utf8(output.stdout).ok());
    let flags = var("CARGO_ENCODED_RUSTFLAGS").unwrap_or_default().replace('\u{1f}', " ");
    let profile = format!(
        "{} opt-level {}",
        var("PROFILE").unwrap_or_default(),
        var("OPT_LEVEL").unwrap_or_default()
    );
    for (name, value) in [
        ("ARBOLEDA_RUSTC", version.as_deref().map_or("unknown", str::trim)),
        ("ARBOLEDA_TARGET", &var("TARGET").unwrap_or_default()),
        ("ARBOLEDA_PROFILE", &profile),
        ("ARBOLEDA_FLAGS", if flags.is_empty() { "none" } else { &flags }),
    ] {
        println!("cargo::rustc-env={name}={value}");
    }
}
