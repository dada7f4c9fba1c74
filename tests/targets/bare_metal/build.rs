//! Hands the linker scripts to the programs that need one.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=link");
    println!("cargo::rustc-link-search={}/link", env!("CARGO_MANIFEST_DIR"));
    for program in ["thumb", "thumb_cost", "thumb_stack"] {
        println!("cargo::rustc-link-arg-bin={program}=-Tlink.x"); // of cortex-m-rt; reads memory.x
    }
    println!("cargo::rustc-link-arg-bin=linux=--no-pie"); // nobody would relocate it
    println!("cargo::rustc-link-arg-bin=riscv=-Triscv.x");
    for argument in ["-nostartfiles", "-static", "-no-pie", "-Tx86_64.x"] {
        println!("cargo::rustc-link-arg-bin=x86_64={argument}");
    }
}
