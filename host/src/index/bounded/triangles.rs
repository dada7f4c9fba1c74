//! Stream of a scene's triangles to a file.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use anyhow::{Context, ensure};

use super::columns::{Columns, Wanted};
use super::{Pager, View};
use crate::benchmark::harness::progress::with_bar;
use crate::scene::{Model, Origin, SceneError, SceneFiles};

/// Most triangles of a scene: those that ids can name.
const MOST_TRIANGLES: usize = 1 << 30;

/// Triangles of a scene, written to a file, and its columns, to others.
pub struct WrittenScene {
    /// Number of triangles.
    pub count: usize,
    /// Point that was subtracted from all coordinates.
    pub origin: [f64; 3],
    /// Columns beside the triangles.
    pub columns: Columns<View>,
}

/// Error of streaming: of a scene file, or of writing.
struct StreamError(anyhow::Error);

impl From<SceneError> for StreamError {
    fn from(error: SceneError) -> Self {
        Self(error.into())
    }
}

/// Writes the triangles of all files, as they lie in memory, to where `triangles` is now; and what else is wanted to
/// temporary files in a folder.
///
/// # Errors
/// If a file cannot be read, the disk is full, or the scene has more triangles or objects than numbers.
pub fn stream(
    files: &SceneFiles,
    origin: Origin,
    triangles: &File,
    wanted: Wanted,
    folder: &Path,
    pager: &Pager,
) -> anyhow::Result<WrittenScene> {
    let full = "cannot write the scene to temporary files";
    let mut writer = BufWriter::with_capacity(1 << 20, triangles);
    let mut columns = Columns::new(wanted, folder).context(full)?;
    let mut count = 0;
    let passes = if origin == Origin::Automatic { 2 } else { 1 };
    let steps = files.paths().len() as u64;
    let mut append = |model: Model| -> anyhow::Result<()> {
        count += model.triangles.len();
        ensure!(
            count <= MOST_TRIANGLES,
            "the scene has more triangles than the {MOST_TRIANGLES} that ids can name"
        );
        writer.write_all(bytemuck::cast_slice(&model.triangles)).context(full)?;
        columns.append(&model, folder, pager).context(full)
    };
    log::info!(
        "reading {steps} file{}{}",
        if steps == 1 { "" } else { "s" },
        if passes == 2 { ", twice to find the origin" } else { "" }
    );
    let origin = with_bar(steps, "reading", |tick| {
        files.each(origin, |_, model| {
            append(model).map_err(StreamError)?;
            tick();
            Ok::<(), StreamError>(())
        })
    })
    .map_err(|error| error.0)?;
    writer.flush().context(full)?;
    Ok(WrittenScene { count, origin, columns: columns.view(pager).context(full)? })
}
