//! `arboleda compare levels`: the automatic levels and resolutions against all others.

use clap::Args;

use super::scenes::SceneChoice;
use crate::benchmark::harness::plan::{Effort, Share};
use crate::benchmark::harness::progress::with_bar;
use crate::benchmark::studies::levels::{self, LevelCheck};
use crate::commands::arguments::MeasureArguments;
use crate::commands::output::{say, table};
use crate::scene::{Model, builtin};

/// Check the automatic levels and resolutions against all others, by counters and by time
#[derive(Args)]
#[command(mut_arg("photons", |photons| photons.default_value("3000")))]
pub struct Levels {
    #[command(flatten)]
    scenes: SceneChoice,
    #[command(flatten)]
    measure: MeasureArguments,
}

impl Levels {
    /// Runs the command.
    ///
    /// # Errors
    /// If two indices do not agree, or a scene cannot be read.
    pub fn run(&self) -> anyhow::Result<()> {
        let models = self.scenes.models(builtin::names())?;
        print_checks(&check_levels(&models, &self.measure.effort(SECONDS, Share::Own))?);
        Ok(())
    }
}

/// About how long a repetition may take.
pub const SECONDS: f64 = 0.3;

/// Checks the automatic choices of every index against all others.
///
/// # Errors
/// If two indices do not agree.
pub fn check_levels(models: &[Model], effort: &Effort) -> anyhow::Result<Vec<LevelCheck>> {
    let mut checks = Vec::new();
    for model in models {
        checks.extend(with_bar(levels::steps(), &format!("{}, levels", model.name), |progress| {
            levels::run(model, effort, progress)
        })?);
    }
    Ok(checks)
}

/// Prints a line for each scene and index.
pub fn print_checks(checks: &[LevelCheck]) {
    let mut lines = table(&[
        "automatic choice",
        "level",
        "nodes",
        "tests",
        "cost/ray",
        "cheapest",
        "nodes",
        "tests",
        "cost/ray",
        "excess",
        "fastest",
        "excess time",
    ]);
    for check in checks {
        let (cheapest, fastest) = (check.best_by_counters(), check.best_by_time());
        lines.add_row([
            format!("{} {}", check.scene, check.automatic.case.kind.name()),
            check.automatic.deepest_level.to_string(),
            format!("{:.1}", check.automatic.nodes_per_ray()),
            format!("{:.1}", check.automatic.tests_per_ray()),
            format!("{:.2}", check.automatic.cost_per_ray()),
            cheapest.case.setting.clone(),
            format!("{:.1}", cheapest.nodes_per_ray()),
            format!("{:.1}", cheapest.tests_per_ray()),
            format!("{:.2}", cheapest.cost_per_ray()),
            format!("{:.1}%", check.excess_cost()),
            fastest.case.setting.clone(),
            format!("{:+.1}%", check.excess_time()),
        ]);
    }
    say!("{lines}");
}
