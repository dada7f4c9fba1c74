//! Pictures of the paper's scenes, in the light of photons.

use std::path::{Path, PathBuf};

use super::printed::PRINTED;
use crate::render::{Exposed, Look, Snapshot, paint};
use crate::report::UpAxis;
use crate::scene::builtin;

/// Width and height of a picture in pixels.
const SIZE: (u32, u32) = (960, 640);
/// Photons of a picture.
const PHOTONS: u64 = 1_000_000;
/// Photons of a quick picture.
const QUICK_PHOTONS: u64 = 100_000;

/// Picture of a scene, in a file.
pub struct ScenePicture {
    /// The PNG file.
    pub path: PathBuf,
    /// Scene, photons and method.
    pub caption: String,
}

/// Lists the scenes to render, each with the label of its figure: those of figures 2 and 3, and the parts of figure 4
/// whose scene `is_asked` accepts.
fn scenes(is_asked: impl Fn(&str) -> bool) -> impl Iterator<Item = (&'static str, &'static str)> {
    let tables = PRINTED.iter().map(|printed| (printed.scene, printed.label));
    let asked = tables.filter(move |(scene, _)| is_asked(scene));
    [("fig2", "2"), ("fig3", "3")].into_iter().chain(asked)
}

/// Renders the paper's scenes to PNG files in a folder, in the caller's pool: those of figures 2 and 3, and the scenes
/// of figure 4 that `is_asked` accepts. A `quick` picture has fewer photons.
///
/// # Errors
/// If a scene cannot be indexed, or a file cannot be written.
pub fn render_scenes(
    folder: &Path,
    is_asked: impl Fn(&str) -> bool,
    seed: u64,
    quick: bool,
) -> anyhow::Result<Vec<ScenePicture>> {
    let photons = if quick { QUICK_PHOTONS } else { PHOTONS };
    let picture = |(scene, label)| {
        let model = builtin::require(scene)?.with_default_light(UpAxis::Z);
        let snapshot = Snapshot { photons, seed, up: UpAxis::Z.vector(&model), size: SIZE };
        let Exposed { film, summary, radius } = snapshot.take(&model, None)?;
        let path = folder.join(format!("{scene}.png"));
        paint(&film, &Look::default()).save(&path)?;
        let caption = format!(
            "Figure {label}: {} triangles, {photons} photons of {} W in all, {} hits. By density estimation on the \
             tangent plane: {} estimates in visible parts of discs of radius {radius:.3}. arboleda render --scene \
             {scene} --up z --photons {photons} --seed {seed} --size {} {} --out {scene}.png",
            model.triangles.len(),
            summary.balance.total_flux,
            summary.balance.hits,
            summary.estimates,
            SIZE.0,
            SIZE.1
        );
        Ok(ScenePicture { path, caption })
    };
    scenes(is_asked).map(picture).collect()
}
