//! Rows for a file that outlives the terminal.

use std::path::Path;

use serde::Serialize;

use super::measurement::Measurement;
use super::provenance::Provenance;
use crate::files::output::write_file;

/// Writes rows as comma-separated values below the names of their fields.
///
/// # Errors
/// If the file cannot be written.
pub fn write_csv(path: &Path, rows: impl IntoIterator<Item: Serialize>) -> anyhow::Result<()> {
    write_file(path, |file| {
        let mut writer = csv::Writer::from_writer(file);
        for row in rows {
            writer.serialize(row)?;
        }
        writer.flush()
    })
}

/// Row of one [`Measurement`], complete with its [`Provenance`]; what was measured several times by the median.
#[derive(Clone, Debug, Serialize)]
struct IndexRecord {
    study: String,
    scene: String,
    triangle_count: usize,
    index: &'static str,
    setting: String,
    build_seconds: f64,
    bytes: usize,
    subdivision_bytes: usize,
    cluster_count: u32,
    deepest_level: u32,
    photons: u64,
    ray_count: usize,
    photons_per_second: f64,
    rays_per_second: f64,
    seconds_median: f64,
    seconds_min: f64,
    seconds_max: f64,
    repetitions: usize,
    /// For each ray.
    nodes_visited: f64,
    /// For each ray.
    triangle_tests: f64,
    seed: u64,
    processor: String,
    rustc: &'static str,
    target: &'static str,
    profile: &'static str,
    flags: &'static str,
    commit: String,
}

/// Records of the measurements of one run.
pub struct Recorder {
    provenance: Provenance,
    seed: u64,
    records: Vec<IndexRecord>,
}

impl Recorder {
    /// Begins without records, for photons drawn with `seed`.
    pub fn new(seed: u64) -> Self {
        Self { provenance: Provenance::gather(), seed, records: Vec::new() }
    }

    /// Returns the provenance of all records.
    pub fn provenance(&self) -> &Provenance {
        &self.provenance
    }

    /// Appends measurements of a scene.
    pub fn add(&mut self, study: &str, scene: &str, measurements: &[Measurement]) {
        for one in measurements {
            let from = &self.provenance;
            self.records.push(IndexRecord {
                study: study.to_owned(),
                scene: scene.to_owned(),
                triangle_count: one.triangle_count,
                index: one.case.kind.name(),
                setting: one.case.setting.clone(),
                build_seconds: one.build_seconds,
                bytes: one.bytes,
                subdivision_bytes: one.subdivision_bytes,
                cluster_count: one.cluster_count,
                deepest_level: one.deepest_level,
                photons: one.photons,
                ray_count: one.ray_count,
                photons_per_second: one.photons_per_second(),
                rays_per_second: one.rays_per_second(),
                seconds_median: one.seconds.median,
                seconds_min: one.seconds.min,
                seconds_max: one.seconds.max,
                repetitions: one.repetitions,
                nodes_visited: one.nodes_per_ray(),
                triangle_tests: one.tests_per_ray(),
                seed: self.seed,
                processor: from.processor.clone(),
                rustc: from.rustc,
                target: from.target,
                profile: from.profile,
                flags: from.flags,
                commit: from.commit.clone(),
            });
        }
    }

    /// Writes all records.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_csv(&self, path: &Path) -> anyhow::Result<()> {
        write_csv(path, &self.records)
    }
}
