//! The same photons through several indices: the table and the digests that compare them.

use anyhow::ensure;
use arboleda::{AnyIndex, IndexKind, Options, Scene};

use crate::Threads;
use crate::benchmark::harness::progress::photon_bar;
use crate::commands::arguments::build_index;
use crate::commands::output::{bytes, count, duration, say, table};
use crate::photon::{Digest, ShootOptions, Shot, shoot};
use crate::scene::Model;

/// Photons that the linear scan shoots beside other indices. Every other index shoots this many too, for the same
/// digest.
pub const LINEAR_PHOTONS: u64 = 256;

/// Outcome of shooting through one index.
pub struct IndexShot {
    /// The index.
    pub kind: IndexKind,
    /// Clusters that have an index of their own; 1 for an index without a hierarchy.
    pub clusters: u32,
    /// Seconds of the build.
    pub build_seconds: f64,
    /// Bytes of the index.
    pub bytes: usize,
    /// The shot of all photons; for the linear scan beside other indices, of the first [`LINEAR_PHOTONS`].
    pub shot: Shot,
    /// Digest of the first [`LINEAR_PHOTONS`] photons, if the linear scan takes part.
    pub share: Option<Digest>,
}

/// The same photons through several indices.
pub struct ShotComparison<'m> {
    /// The triangles and the lights.
    pub model: &'m Model,
    /// The scene that the indices are built of.
    pub scene: Scene<'m>,
    /// Options of the builds.
    pub build: Options,
    /// Photons, seed and threads.
    pub options: ShootOptions,
}

impl ShotComparison<'_> {
    /// Builds each index and shoots through it, with a progress bar. The linear scan beside other indices shoots only
    /// the first [`LINEAR_PHOTONS`] photons.
    ///
    /// # Errors
    /// If an index cannot be built.
    pub fn run(&self, kinds: &[IndexKind]) -> anyhow::Result<Vec<IndexShot>> {
        let shares = kinds.len() > 1 && kinds.contains(&IndexKind::Linear);
        let few = ShootOptions {
            photons: self.options.photons.min(LINEAR_PHOTONS),
            ..self.options.clone()
        };
        let threads = Threads::new(self.options.threads);
        let mut rows = Vec::new();
        if shares {
            let photons = few.photons;
            log::info!(
                "{} shoots only the first {photons} photons: it tests every triangle for every ray",
                IndexKind::Linear.name()
            );
        }
        for &kind in kinds {
            let owned = build_index(kind, &self.scene, &self.build, &threads)?;
            let index = owned.index();
            let share =
                shares.then(|| shoot(self.model, index.as_ray_index(), &few, &|_| {}).digest);
            let options = if shares && kind == IndexKind::Linear { &few } else { &self.options };
            let build_seconds = owned.build_seconds();
            rows.push(IndexShot { build_seconds, share, ..self.through(&index, options) });
        }
        Ok(rows)
    }

    /// Shoots through one index that is there, with a progress bar.
    pub fn through(&self, index: &AnyIndex<'_>, options: &ShootOptions) -> IndexShot {
        let kind = index.kind();
        let bar = photon_bar(options.photons, kind.name());
        let progress = |photons| bar.inc(photons);
        let shot = shoot(self.model, index.as_ray_index(), options, &progress);
        bar.finish_and_clear();
        let (clusters, bytes) = (index.sections().cluster_count(), index.as_bytes().len());
        IndexShot { kind, clusters, build_seconds: 0.0, bytes, shot, share: None }
    }
}

/// Prints a table with a row for each index.
pub fn print_rows(rows: &[IndexShot]) {
    let counted = rows.iter().any(|row| row.shot.counters.is_some());
    let mut headings =
        vec!["index", "clusters", "build", "bytes", "photons", "rays/s", "photons/s"];
    if counted {
        headings.extend(["nodes/ray", "tests/ray"]);
    }
    let mut lines = table(&headings);
    for row in rows {
        let mut cells = vec![
            row.kind.name().to_owned(),
            count(u64::from(row.clusters)),
            duration(row.build_seconds),
            bytes(row.bytes),
            count(row.shot.balance.emitted),
            count(row.shot.rays_per_second() as u64),
            count(row.shot.photons_per_second() as u64),
        ];
        if let Some(counters) = row.shot.counters {
            let rays = row.shot.balance.rays.max(1) as f64;
            cells.push(format!("{:.1}", counters.nodes_visited as f64 / rays));
            cells.push(format!("{:.1}", counters.triangle_tests as f64 / rays));
        }
        lines.add_row(cells);
    }
    say!("{lines}");
}

/// Prints the digest that all indices have in common. If two digests differ, prints each digest and fails.
///
/// # Errors
/// If two digests differ: a defect of an index.
pub fn print_digests(rows: &[IndexShot]) -> anyhow::Result<()> {
    if let Err(defect) = check_digests(rows) {
        for row in rows {
            let share = row.share.map(|digest| format!(", {digest} of the first photons"));
            let photons = count(row.shot.balance.emitted);
            let share = share.unwrap_or_default();
            say!("digest {:<24} {} of {photons} photons{share}", row.kind.name(), row.shot.digest);
        }
        return Err(defect);
    }
    let photons = rows.iter().map(|row| row.shot.balance.emitted).max().unwrap_or(0);
    let full: Vec<&IndexShot> =
        rows.iter().filter(|row| row.shot.balance.emitted == photons).collect();
    let whole = match full[..] {
        [] => return Ok(()),
        [only] => format!("{} by {}", only.shot.digest, only.kind.name()),
        [first, ..] => format!("{}, the same by all {} indices", first.shot.digest, full.len()),
    };
    say!("digest of {} photons: {whole}", count(photons));
    let part = rows.iter().find(|row| row.shot.balance.emitted < photons);
    if let Some((part, share)) = part.and_then(|row| Some((row, row.share?))) {
        say!(
            "digest of the first {}: {share}, the same by all {} and {}",
            count(part.shot.balance.emitted),
            full.len(),
            part.kind.name()
        );
    }
    Ok(())
}

/// Compares the digests of each pair of indices that shot equally many photons.
fn check_digests(rows: &[IndexShot]) -> anyhow::Result<()> {
    for (at, row) in rows.iter().enumerate() {
        for other in &rows[..at] {
            let same_photons = row.shot.balance.emitted == other.shot.balance.emitted;
            let same =
                (!same_photons || row.shot.digest == other.shot.digest) && row.share == other.share;
            ensure!(
                same,
                "{} and {} DO NOT GIVE THE SAME RESULT: please report this scene",
                row.kind.name(),
                other.kind.name()
            );
        }
    }
    Ok(())
}
