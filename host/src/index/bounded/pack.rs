//! Index of scene files to a file, and their scene to another, within a stated memory.

use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::Path;

use anyhow::{Context, ensure};
use arboleda::clusters;
use arboleda::{AnyIndex, BuildError, Executor, IndexKind, Options, Scene, Statistics, Triangle};
use blake3::Hash;

use super::columns::Wanted;
use super::pager::LEAST_MARGIN;
use super::triangles::{WrittenScene, stream};
use super::{Pager, Scratch, View, cast, reading};
use crate::Threads;
use crate::benchmark::harness::progress::{during, with_bar};
use crate::files::output::replace_file;
use crate::index::packed::digest_of;
use crate::scene::{Origin, SceneFiles};

/// Memory that the program takes beside what reading takes: at most 60 MB of its own, the pager's margin, and 140 MB of
/// mapped pages, below which they would be given back all the time.
const BASE: u64 = 200_000_000 + LEAST_MARGIN;
/// Bytes of room for the words of a cluster, for each of its triangles; more is asked for where it is not enough.
const ROOM_PER_TRIANGLE: usize = 16;
/// Least room for the words of a cluster.
const LEAST_ROOM: usize = 1 << 20;
/// Bytes of words of a hierarchy for each triangle, roughly, for what is told beforehand.
const WORD_BYTES: usize = 16;
/// Bytes of an index for each triangle, roughly, for what is told beforehand.
const INDEX_BYTES: usize = 50;
/// Bytes of the header of an index, behind which its triangles lie.
const HEADER: usize = 64;

/// Packs the index of scene files within a stated memory.
pub struct BoundedPack<'p> {
    /// Files of the scene.
    pub files: &'p SceneFiles,
    /// Point that is subtracted from all coordinates.
    pub origin: Origin,
    /// Kind of the index.
    pub kind: IndexKind,
    /// Options of the build.
    pub options: Options,
    /// True if clusters are found among whole objects.
    pub by_objects: bool,
    /// Most resident bytes of the process.
    pub memory: u64,
    /// File of the scene, which is beside that of the index; `None` to write the index only.
    pub scene: Option<&'p Path>,
}

/// Result of a bounded pack.
pub struct Packed {
    /// Point that was subtracted from all coordinates.
    pub origin: [f64; 3],
}

/// Function that sees the finished index, what it consists of, and its BLAKE3.
pub type Show<'s> = dyn FnMut(&AnyIndex<'_>, &Statistics, &Hash) + 's;

impl BoundedPack<'_> {
    /// Checks that the memory is enough.
    fn check_memory(&self) -> anyhow::Result<()> {
        let largest = reading::largest(self.files.paths())?;
        let least = BASE.saturating_add(largest.bytes);
        ensure!(
            self.memory >= least,
            "--memory {} is too small: {least} is the least that would do, {} of it to read {}",
            self.memory,
            largest.bytes,
            largest.path.display()
        );
        Ok(())
    }

    /// Builds the index and writes it and its scene to files, which are replaced when all is done. `show` sees the
    /// finished index, before they are.
    ///
    /// # Process-wide
    /// On Linux, the limit is that of the whole process: the timer `ITIMER_PROF` and the handler of its signal, `SIGPROF`,
    /// are set. The timer ends with the pack, the handler stays. A process packs one scene at a time.
    ///
    /// # Errors
    /// If the memory is too small, a file cannot be read, the index cannot be built, or the disk is full. The old files
    /// then stay, and temporary files are removed.
    pub fn run(&self, out: &Path, show: &mut Show<'_>) -> anyhow::Result<Packed> {
        self.check_memory()?;
        self.build(out, show)
    }

    /// Builds as [`run`](Self::run) does, in any memory.
    fn build(&self, out: &Path, show: &mut Show<'_>) -> anyhow::Result<Packed> {
        let mut origin = [0.0; 3];
        replace_file(out, |file, folder| {
            let pager = Pager::start(self.memory);
            let work = Work { pack: self, pager: &pager, folder };
            let (written, triangles) = if self.kind.can_be_built_in_pieces() {
                work.pieces(file)?
            } else {
                work.whole(file)?
            };
            origin = written.origin;
            // What was built is validated, as every index that is opened.
            let length = usize::try_from(file.metadata()?.len())?;
            let view = View::new(file, 0, length, &pager)?;
            let (index, statistics) =
                during("validating", || AnyIndex::from_bytes_counted(view.bytes()))?;
            let digest = during("hashing", || on_few_threads(|| digest_of(&index)));
            show(&index, &statistics, &digest);
            if let Some(path) = self.scene {
                // The scene is renamed first, as in every pack: whoever opens both meanwhile finds that they do not match.
                // All that may fail is done before.
                during("writing the index", || file.sync_all())?;
                let triangles = cast(&triangles)?;
                let parts = written.columns.scene(self.files.title(), origin, triangles);
                let parts = parts.context("the scene was not streamed")?;
                during("writing the scene", || {
                    on_few_threads(|| parts.write(path, &index, &digest))
                })?;
            }
            Ok(())
        })?;
        Ok(Packed { origin })
    }
}

/// Work of a pack, and where its temporary files lie.
struct Work<'w> {
    pack: &'w BoundedPack<'w>,
    pager: &'w Pager,
    folder: &'w Path,
}

impl Work<'_> {
    /// Builds a hierarchy piece by piece. The triangles go to their section of the index at once.
    fn pieces(&self, mut out: &File) -> anyhow::Result<(WrittenScene, View)> {
        let BoundedPack { kind, options, .. } = *self.pack;
        // 1. The triangles.
        out.write_all(&[0; HEADER])?;
        let (written, triangles) = self.stream(out, HEADER)?;
        let scene = self.scene_of(&written, &triangles)?;

        // 2. The clusters.
        let scratch_bytes = clusters::scratch_capacity(written.count);
        self.tell_need(&written, scratch_bytes, written.count * WORD_BYTES)?;
        let mut scratch = self.scratch(scratch_bytes)?;
        let found = during("finding clusters", || {
            clusters::find_with(&scene, &options, scratch.bytes(), &threads())
        });
        let found = found?;

        // 3. The words of each cluster, behind the triangles and the cluster tree.
        let mut memory = self.scratch(kind.memory_in_pieces(&found, &options))?;
        let mut build = kind.build_in_pieces(&scene, &options, &found, memory.bytes())?;
        let largest = found.iter().map(<[u32]>::len).max().unwrap_or(0);
        let mut room = self.scratch(LEAST_ROOM.max(largest * ROOM_PER_TRIANGLE))?;
        out.set_len(build.length() as u64)?;
        out.seek(SeekFrom::Start(build.length() as u64))?;
        let mut writer = BufWriter::with_capacity(1 << 20, out);
        with_bar(found.count() as u64, kind.name(), |tick| -> anyhow::Result<()> {
            loop {
                let needed = match build.build_next(room.bytes()) {
                    Ok(Some(piece)) => {
                        writer.write_all(piece.bytes)?;
                        tick();
                        continue;
                    }
                    Ok(None) => return Ok(()),
                    Err(BuildError::ArenaFull { needed, .. }) => needed,
                    Err(error) => return Err(error.into()),
                };
                room = self.scratch(needed)?;
            }
        })?;

        // 4. The cluster tree, and the header last.
        for piece in build.finish()? {
            writer.seek(SeekFrom::Start(piece.offset as u64))?;
            writer.write_all(piece.bytes)?;
        }
        writer.flush()?;
        Ok((written, triangles))
    }

    /// Builds one index over all triangles, in mapped memory.
    fn whole(&self, out: &File) -> anyhow::Result<(WrittenScene, View)> {
        let BoundedPack { kind, options, .. } = *self.pack;
        // 1. The triangles, to a file of their own.
        let file = tempfile::tempfile_in(self.folder)?;
        let (written, triangles) = self.stream(&file, 0)?;
        let scene = self.scene_of(&written, &triangles)?;

        // 2. Count the bytes of the index, and build it.
        let scratch_bytes = kind.scratch_capacity(written.count, &options);
        self.tell_need(&written, scratch_bytes, written.count * INDEX_BYTES)?;
        let mut scratch = self.scratch(scratch_bytes)?;
        let threads = threads();
        let capacity = during("measuring the index", || {
            kind.capacity_with(&scene, &options, scratch.bytes(), &threads)
        });
        let capacity = capacity?;
        let mut arena =
            self.reserved(Scratch::over(out, capacity.index, self.pager), capacity.index)?;
        during(&format!("building {}", kind.name()), || {
            kind.build_with(&scene, &options, arena.bytes(), scratch.bytes(), &threads).map(drop)
        })?;
        Ok((written, triangles))
    }

    /// Streams the triangles to a file, from `start` on, and columns to temporary ones.
    fn stream(&self, file: &File, start: usize) -> anyhow::Result<(WrittenScene, View)> {
        let BoundedPack { files, origin, by_objects, scene, .. } = *self.pack;
        let wanted = match (scene, by_objects) {
            (Some(_), _) => Wanted::Scene,
            (None, true) => Wanted::Objects,
            (None, false) => Wanted::Triangles,
        };
        let written = stream(files, origin, file, wanted, self.folder, self.pager)?;
        let bytes = written.count * size_of::<Triangle>();
        Ok((written, View::new(file, start, bytes, self.pager)?))
    }

    /// Makes the scene of mapped triangles, and of the numbers of their objects if it is divided by them.
    fn scene_of<'v>(
        &self,
        written: &'v WrittenScene,
        triangles: &'v View,
    ) -> anyhow::Result<Scene<'v>> {
        let scene = Scene::new(cast(triangles)?);
        let objects = written.columns.objects().filter(|_| self.pack.by_objects);
        Ok(match objects {
            Some(objects) => scene.objects(cast(objects)?),
            None => scene,
        })
    }

    /// Tells how much disk is needed beside what was streamed, and stops if there is less. Temporary files are gone
    /// before the scene is written.
    fn tell_need(
        &self,
        written: &WrittenScene,
        scratch: usize,
        index: usize,
    ) -> anyhow::Result<()> {
        let megabytes = |bytes: usize| bytes.div_ceil(1_000_000);
        let folder = self.folder.display();
        let has_triangles = self.pack.scene.is_some() && self.pack.kind.holds_triangles();
        let triangles = if has_triangles { written.count * size_of::<Triangle>() } else { 0 };
        let scene = written.columns.bytes() + triangles;
        log::info!(
            "{} triangles; {} MB of temporary files in {folder}, and about {} MB more of the index{}",
            written.count,
            megabytes(scratch),
            megabytes(index),
            if scene > 0 {
                format!(", {} MB of its scene", megabytes(scene))
            } else {
                String::new()
            }
        );
        let most = scratch.max(scene).saturating_add(index);
        if let Some(free) = free_bytes(self.folder) {
            ensure!(
                free >= most as u64,
                "{folder} has {} MB free, and {} MB are needed",
                free / 1_000_000,
                megabytes(most)
            );
        }
        Ok(())
    }

    fn scratch(&self, bytes: usize) -> anyhow::Result<Scratch> {
        self.reserved(Scratch::new(self.folder, bytes, self.pager), bytes)
    }

    fn reserved(&self, made: io::Result<Scratch>, bytes: usize) -> anyhow::Result<Scratch> {
        let folder = self.folder.display();
        made.with_context(|| format!("cannot make a file of {bytes} bytes in {folder}"))
    }
}

/// Makes threads, few enough that they touch little between two looks of the pager.
fn threads() -> Threads {
    const MOST_THREADS: usize = 4;
    let processors = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    Threads::new(Some(processors.min(MOST_THREADS)))
}

/// Runs `work`, whose parallel parts have the [`threads`].
fn on_few_threads<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    threads().join(work, || ()).0
}

/// Bytes that are free on the disk of a folder; `None` where the system does not say.
#[cfg(target_os = "linux")]
fn free_bytes(folder: &Path) -> Option<u64> {
    let disk = rustix::fs::statvfs(folder).ok()?;
    disk.f_bavail.checked_mul(disk.f_frsize)
}

/// Bytes that are free on the disk of a folder; `None` where the system does not say.
#[cfg(not(target_os = "linux"))]
fn free_bytes(_: &Path) -> Option<u64> {
    None
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::super::pager::tests::alone;
    use super::*;
    use crate::TimedIndex;

    /// A grid of 300 x 300 cells, as an STL file.
    fn grid() -> Vec<u8> {
        let mut bytes = vec![b' '; 80];
        bytes.extend(90_000_u32.to_le_bytes());
        for cell in 0..90_000_u32 {
            let (x, y) = ((cell % 300) as f32, (cell / 300) as f32);
            bytes.extend([0; 12]);
            for number in [x, y, 0.0, x + 0.7, y, 0.0, x, y + 0.7, 0.0] {
                bytes.extend(number.to_le_bytes());
            }
            bytes.extend([0; 2]);
        }
        bytes
    }

    #[test]
    fn pages_that_are_given_back_all_the_time_change_no_byte() {
        let _alone = alone();
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path();
        std::fs::write(at.join("a.stl"), grid()).unwrap();
        let files = SceneFiles::list(&[at.join("a.stl")]).unwrap();
        let model = files.load(Origin::Unchanged).unwrap();
        for kind in [IndexKind::OctreeHierarchy, IndexKind::WideBvh] {
            let before = Pager::times_full();
            let pack = BoundedPack {
                files: &files,
                origin: Origin::Unchanged,
                kind,
                options: Options::DEFAULT,
                by_objects: false,
                memory: 1,
                scene: None,
            };
            pack.build(&at.join("a.arb"), &mut |_, _, _| {}).unwrap();
            assert!(Pager::times_full() > before, "the memory was full");
            let once = TimedIndex::build(kind, &model.scene(), &Options::DEFAULT).unwrap();
            assert!(std::fs::read(at.join("a.arb")).unwrap() == once.as_bytes(), "{}", kind.name());
        }
    }
}
