//! How far a study has come.

use indicatif::{ProgressBar, ProgressStyle};

/// A bar on stderr that counts measurements; nothing where stderr is no terminal.
pub fn step_bar(steps: u64, label: &str) -> ProgressBar {
    let style =
        ProgressStyle::with_template("{prefix:>18} {bar:40} {pos}/{len}, {elapsed}, {eta} left");
    let bar = ProgressBar::new(steps).with_prefix(label.to_owned());
    match style {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
