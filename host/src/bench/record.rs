//! Rows for a file that outlives the terminal.

use std::path::Path;

use serde::Serialize;

use super::provenance::Provenance;
use super::run::Measurement;
use crate::file_output::write_file;

/// One measurement, complete with where it comes from.
#[derive(Clone, Debug, Serialize)]
pub struct Record {
    /// What it was measured for.
    pub study: String,
    /// The scene.
    pub scene: String,
    /// How many triangles the scene has.
    pub triangle_count: usize,
    /// The index.
    pub index: &'static str,
    /// What is special about its options; empty for the defaults.
    pub setting: String,
    /// See [`Measurement`] for these.
    pub build_seconds: f64,
    /// The whole index, in bytes.
    pub bytes: usize,
    /// The index without the triangles, in bytes; with them where it keeps them in a form of its own.
    pub subdivision_bytes: usize,
    /// How many clusters.
    pub cluster_count: u32,
    /// The level of the deepest leaf.
    pub deepest_level: u32,
    /// Photons to each repetition.
    pub photons: u64,
    /// Their rays.
    pub ray_count: usize,
    /// By the median.
    pub photons_per_second: f64,
    /// By the median.
    pub rays_per_second: f64,
    /// Of a repetition.
    pub seconds_median: f64,
    /// Of the fastest repetition.
    pub seconds_min: f64,
    /// Of the slowest repetition.
    pub seconds_max: f64,
    /// How many repetitions.
    pub repetitions: usize,
    /// Per ray.
    pub nodes_visited: f64,
    /// Per ray.
    pub triangle_tests: f64,
    /// What the photons were drawn with.
    pub seed: u64,
    /// See [`Provenance`] for these.
    pub processor: String,
    /// The compiler.
    pub rustc: &'static str,
    /// What it compiled for.
    pub target: &'static str,
    /// How.
    pub profile: &'static str,
    /// With which flags beside.
    pub flags: &'static str,
    /// From which sources.
    pub commit: String,
}

/// Collects records of one run.
pub struct Recorder {
    provenance: Provenance,
    seed: u64,
    records: Vec<Record>,
}

impl Recorder {
    /// An empty one.
    pub fn new(seed: u64) -> Self {
        Self { provenance: Provenance::gather(), seed, records: Vec::new() }
    }

    /// Where all records come from.
    pub fn provenance(&self) -> &Provenance {
        &self.provenance
    }

    /// Appends measurements of a scene.
    pub fn add(&mut self, study: &str, scene: &str, measurements: &[Measurement]) {
        for one in measurements {
            let from = &self.provenance;
            self.records.push(Record {
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

    /// Writes all records as comma-separated values.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_csv(&self, path: &Path) -> anyhow::Result<()> {
        write_file(path, |file| {
            let mut writer = csv::Writer::from_writer(file);
            for record in &self.records {
                writer.serialize(record)?;
            }
            writer.flush()
        })
    }
}
