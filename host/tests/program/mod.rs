//! Helpers that run the program in a folder of its own.
// Each file of tests is a crate of its own and uses only some of these functions.
#![allow(dead_code)]

use std::fs::File;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use npyz::{AutoSerialize, WriteOptions, WriterBuilder};
use tempfile::TempDir;

/// Makes an empty folder, which is deleted when dropped.
pub fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder for temporary files")
}

/// Runs the program in a folder.
pub fn run_in(folder: &Path, arguments: &[&str]) -> Output {
    command_in(folder, arguments).output().expect("the program starts")
}

/// Prepares the program to run in a folder.
pub fn command_in(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_arboleda"));
    command.current_dir(folder).args(arguments).stdin(Stdio::null());
    command
}

/// Prepares the program to run in a folder, with the words of a line.
pub fn command_line(folder: &Path, line: &str) -> Command {
    command_in(folder, &line.split_whitespace().collect::<Vec<_>>())
}

/// Asserts that two files in a folder have the same bytes.
pub fn same_bytes(folder: &Path, a: &str, b: &str) {
    let [left, right] = [a, b].map(|name| std::fs::read(folder.join(name)).expect(name));
    assert!(left == right, "{a} is not {b}");
}

/// Asserts that the program succeeded. Returns the texts of stdout and stderr.
pub fn success(output: &Output) -> (String, String) {
    let [shown, said] = [&output.stdout, &output.stderr].map(|bytes| text(bytes));
    assert!(output.status.success(), "{shown}{said}");
    (shown, said)
}

/// Asserts that the program failed. Returns the text of stderr.
pub fn failure(output: &Output) -> String {
    let said = text(&output.stderr);
    assert!(!output.status.success(), "{}{said}", text(&output.stdout));
    said
}

/// Writes a `.npy` file of rays; each has an origin and a direction.
pub fn write_rays<T: AutoSerialize + Copy>(path: &Path, rays: &[[T; 6]]) {
    let file = File::create(path).expect("a new file");
    let options = WriteOptions::new().default_dtype().shape(&[rays.len() as u64, 6]);
    let mut writer = options.writer(file).begin_nd().expect("a header");
    writer.extend(rays.as_flattened().iter().copied()).expect("rows");
    writer.finish().expect("a whole file");
}

/// Lists the names of files and folders in a folder, sorted.
pub fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let mut names: Vec<String> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}
