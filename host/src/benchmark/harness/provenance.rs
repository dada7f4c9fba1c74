//! Provenance of figures: the machine, the compiler and the commit, without which they mean nothing.

use std::process::Command;

/// Facts that a figure depends on beside the program's arguments. No date: the same run gives the same.
#[derive(Clone, Debug)]
pub struct Provenance {
    /// The processor's name, or the architecture where the system does not tell.
    pub processor: String,
    /// The compiler that built this program.
    pub rustc: &'static str,
    /// The machine it was built for.
    pub target: &'static str,
    /// The profile and its optimisation level.
    pub profile: &'static str,
    /// Flags given to the compiler beside the profile's; `none` if there were none.
    pub flags: &'static str,
    /// The commit of the sources, `-dirty` if they were changed since, `unknown` outside a repository.
    pub commit: String,
}

impl Provenance {
    /// Asks the system.
    pub fn gather() -> Self {
        Self {
            processor: processor().unwrap_or_else(|| std::env::consts::ARCH.to_owned()),
            rustc: env!("ARBOLEDA_RUSTC"),
            target: env!("ARBOLEDA_TARGET"),
            profile: env!("ARBOLEDA_PROFILE"),
            flags: env!("ARBOLEDA_FLAGS"),
            commit: commit().unwrap_or_else(|| "unknown".to_owned()),
        }
    }

    /// Writes all facts in one line.
    pub fn line(&self) -> String {
        let Self { processor, rustc, target, profile, flags, commit } = self;
        format!("{processor}; {rustc}; {target}, {profile}, flags: {flags}; commit {commit}")
    }
}

/// Reads the model name as Linux tells it.
fn processor() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

fn commit() -> Option<String> {
    let arguments = ["describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"];
    let output = Command::new("git")
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .ok()
        .filter(|output| output.status.success())?;
    Some(String::from_utf8(output.stdout).ok()?.trim().to_owned())
}
