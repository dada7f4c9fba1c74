//! Runs on the PC. Hands to the programs the index of the yard, the answers that are expected of the device, and the
//! linker scripts.

use std::error::Error;
use std::path::Path;
use std::{env, fs};

use arboleda::{Block, Index, Options, Scene};

#[path = "src/kind.rs"]
mod kind;
#[path = "src/yard.rs"]
mod yard;

fn main() -> Result<(), Box<dyn Error>> {
    for input in ["build.rs", "link", "src/kind.rs", "src/yard.rs"] {
        println!("cargo::rerun-if-changed={input}");
    }
    write_index(Path::new(&env::var("OUT_DIR")?))?;
    choose_scripts(&env::var("CARGO_CFG_TARGET_ARCH")?);
    Ok(())
}

/// Writes the bytes of the index, `yard.arb`, and what the PC answers, `answers.rs`.
fn write_index(out: &Path) -> Result<(), Box<dyn Error>> {
    let triangles = yard::triangles();
    let (scene, options) = (Scene::new(&triangles), Options::DEFAULT);
    let bytes = Index::<kind::Kind>::scratch_capacity(triangles.len(), &options);
    let mut scratch = vec![Block::ZERO; Block::count(bytes)];
    let scratch = Block::bytes(&mut scratch);
    let bytes = Index::<kind::Kind>::capacity(&scene, &options, scratch)?.index;
    let mut arena = vec![Block::ZERO; Block::count(bytes)];
    let index = Index::<kind::Kind>::build(&scene, &options, Block::bytes(&mut arena), scratch)?;
    fs::write(out.join("yard.arb"), index.as_bytes())?;

    let mut answers = Vec::new();
    for ray in yard::rays() {
        answers.push(index.closest_hit(&ray?).map(|hit| (hit.triangle.0, hit.t.to_bits())));
    }
    fs::write(out.join("answers.rs"), format!("{answers:?}"))?;
    Ok(())
}

/// `index_in_flash` has the memory of a small part, the others that of a large board.
fn choose_scripts(architecture: &str) {
    let link = concat!(env!("CARGO_MANIFEST_DIR"), "/link");
    for program in ["index_in_flash", "index_on_device", "no_index", "asks", "builds", "measure"] {
        let arguments = match (architecture, program) {
            ("arm", "index_in_flash") => ["-Tlink.x".to_owned(), format!("-L{link}/microbit")],
            ("arm", _) => ["-Tlink.x".to_owned(), format!("-L{link}/mps2")],
            _ => ["-Triscv.x".to_owned(), format!("-L{link}")],
        };
        for argument in arguments {
            println!("cargo::rustc-link-arg-bin={program}={argument}");
        }
    }
}
