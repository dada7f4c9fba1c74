//! Stream of a scene's triangles to a file.

use std::fs::File;
use std::io::{BufWriter, Write};

use anyhow::{Context, ensure};

use crate::bench::progress::with_bar;
use crate::scene::{Model, Origin, SceneError, SceneFiles};

/// Most triangles of a scene: those that ids can name.
const MOST_TRIANGLES: usize = 1 << 30;

/// Triangles of a scene, written to a file, and the numbers of their objects to another.
pub struct Written {
    /// Number of triangles.
    pub count: usize,
    /// Number of object names.
    pub object_count: usize,
    /// Point that was subtracted from all coordinates.
    pub origin: [f64; 3],
}

/// Error of streaming: of a scene file, or of writing.
struct StreamError(anyhow::Error);

impl From<SceneError> for StreamError {
    fn from(error: SceneError) -> Self {
        Self(error.into())
    }
}

/// Writes the triangles of all files, as they lie in memory, to where `triangles` is now; and the object of each to
/// `objects`, if given.
///
/// # Errors
/// If a file cannot be read, the disk is full, or the scene has more than 2^30 triangles.
pub fn stream(
    files: &SceneFiles,
    origin: Origin,
    triangles: &File,
    objects: Option<&File>,
) -> anyhow::Result<Written> {
    let mut writer = BufWriter::with_capacity(1 << 20, triangles);
    let mut object_writer = objects.map(|file| BufWriter::with_capacity(1 << 20, file));
    let (mut count, mut object_count) = (0, 0);
    let passes = if origin == Origin::Automatic { 2 } else { 1 };
    let steps = files.paths().len() as u64;
    let mut append = |model: Model| -> anyhow::Result<()> {
        count += model.triangles.len();
        ensure!(
            count <= MOST_TRIANGLES,
            "the scene has more triangles than the {MOST_TRIANGLES} that ids can name"
        );
        let full = "cannot write the triangles to a temporary file";
        writer.write_all(bytemuck::cast_slice(&model.triangles)).context(full)?;
        if let Some(writer) = &mut object_writer {
            for object in &model.objects {
                let number = object_count as u32 + object;
                writer.write_all(&number.to_ne_bytes()).context(full)?;
            }
        }
        object_count += model.object_names.len();
        Ok(())
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
    let full = "cannot write the triangles to a temporary file";
    writer.flush().context(full)?;
    if let Some(mut writer) = object_writer {
        writer.flush().context(full)?;
    }
    Ok(Written { count, object_count, origin })
}
