//! Progress of long work, on stderr where that is a terminal, unless `--quiet` was given.

use std::time::Duration;

use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Called after each step of long work, from any thread.
pub type Tick<'t> = &'t (dyn Fn() + Sync);

/// Shows a bar while `work` is done, which calls what it is given `steps` times.
pub fn with_bar<T>(steps: u64, label: &str, work: impl FnOnce(Tick<'_>) -> T) -> T {
    let bar = bar(steps, label, "{prefix:>18} {bar:40} {pos}/{len}, {elapsed}, {eta} left");
    let result = work(&|| bar.inc(1));
    bar.finish_and_clear();
    result
}

/// Makes a bar that counts photons.
pub fn photon_bar(photons: u64, label: &str) -> ProgressBar {
    bar(
        photons,
        label,
        "{prefix:>18} {bar:40} {human_pos}/{human_len} photons, {per_sec}, {eta} left",
    )
}

/// Makes a bar that counts up to an unknown number.
pub fn count_bar(label: &str) -> ProgressBar {
    bar(0, label, "{prefix:>18} {human_pos}, {elapsed}")
}

/// Shows bars below each other.
pub fn together<const COUNT: usize>(bars: [ProgressBar; COUNT]) -> [ProgressBar; COUNT] {
    let all = MultiProgress::with_draw_target(target());
    bars.map(|bar| all.add(bar))
}

/// Shows the label and the time elapsed while `work` is done.
pub fn during<T>(label: &str, work: impl FnOnce() -> T) -> T {
    let spinner = bar(0, label, "{spinner} {prefix}, {elapsed}");
    spinner.enable_steady_tick(Duration::from_millis(250));
    let result = work();
    spinner.finish_and_clear();
    result
}

fn bar(length: u64, label: &str, template: &str) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(length), target()).with_prefix(label.to_owned());
    match ProgressStyle::with_template(template) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

/// Returns stderr, unless `--quiet` was given.
fn target() -> ProgressDrawTarget {
    if log::log_enabled!(log::Level::Info) {
        ProgressDrawTarget::stderr()
    } else {
        ProgressDrawTarget::hidden()
    }
}
