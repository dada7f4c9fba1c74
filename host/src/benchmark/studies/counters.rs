//! Figures that are the same on every machine and in every run: for a diff between two people.
//!
//! Small scenes and few photons, but every index and every kind of scene. A copy in
//! `golden/counters.txt` is compared by a test; after a change that is meant to change them, renew it:
//!
//! ```text
//! cargo run --release -p arboleda-host -- compare counters > host/golden/counters.txt
//! ```

use std::fmt::Write;

use arboleda::{Counters, Hit, IndexKind};

use super::separation::clusters_apart;
use crate::benchmark::harness::measurement::{build, checked};
use crate::benchmark::harness::plan::Case;
use crate::benchmark::harness::workload::{Workload, bits};
use crate::scene::Model;
use crate::scene::city::{CityOptions, procedural_city};
use crate::scene::mixed::{MixedOptions, mixed_sizes};
use crate::scene::{paper, shapes};

/// Photons to a scene.
const PHOTONS: u64 = 1_000;
/// Photons of these that go through the linear scan.
const LINEAR_PHOTONS: u64 = 50;
/// Seed that the photons are drawn with, whatever the command line says.
const SEED: u64 = 1;

/// Makes scenes that are built within a fraction of a second by every index.
fn models() -> Vec<Model> {
    let city = CityOptions { blocks: [2, 2], buildings_per_side: 2, ..CityOptions::default() };
    let mixed = MixedOptions { object_count: 60, detail: 1, ..MixedOptions::default() };
    let mut sphere = clusters_apart(0);
    "sphere and lights".clone_into(&mut sphere.name);
    sphere.triangles = shapes::closed_sphere(3).into();
    sphere.reflectance = vec![0.5; sphere.triangles.len()].into();
    sphere.objects = vec![0; sphere.triangles.len()].into();
    vec![
        paper::fig2(),
        paper::fig3(),
        clusters_apart(1_000),
        procedural_city(city),
        mixed_sizes(mixed),
        sphere,
    ]
}

/// Writes all figures, one line for each scene and index.
///
/// # Errors
/// If two indices do not agree.
pub fn lines() -> anyhow::Result<String> {
    let mut text = String::from(
        "Equal on every machine: bytes, nodes visited and triangle tests of photons' rays, and a digest of their \
         hits.\n\
         Columns: index, bytes, clusters, deepest level, photons, closest-hit nodes and tests, occlusion nodes and \
         tests.\n",
    );
    for model in models() {
        let workload = Workload::of_photons(&model, PHOTONS, SEED)?;
        let hits = &workload.hits;
        writeln!(
            text,
            "\n{}: {} triangles, {} photons, {} rays, {} hits, digest {}",
            model.name,
            model.triangles.len(),
            PHOTONS,
            hits.len(),
            hits.iter().filter(|hit| !hit.is_none()).count(),
            digest(hits)
        )?;
        for &kind in IndexKind::ALL {
            let photons = if kind == IndexKind::Linear { LINEAR_PHOTONS } else { PHOTONS };
            let owned = build(&model, &Case::usual(kind), workload.sample())?;
            let index = owned.index();
            let closest = checked(&index, &workload, photons)?;
            let mut any = Counters::default();
            let asked = workload.rays_of_first(photons).iter();
            for (ray, hit) in asked.zip(workload.hits_of_first(photons)) {
                let occluded = index.occluded_counted(ray, &mut any);
                anyhow::ensure!(occluded != hit.is_none(), "{} contradicts itself", kind.name());
            }
            writeln!(
                text,
                "{:<20} {:>8} {:>3} {:>2} {:>5} {:>8} {:>8} {:>8} {:>8}",
                kind.name(),
                owned.bytes(),
                index.sections().cluster_count(),
                index.check()?.deepest_level,
                photons,
                closest.nodes_visited,
                closest.triangle_tests,
                any.nodes_visited,
                any.triangle_tests,
            )?;
        }
    }
    Ok(text)
}

/// Returns the first 16 hexadecimal digits of a hash over all answers.
fn digest(hits: &[Hit]) -> String {
    let mut hasher = blake3::Hasher::new();
    for hit in hits {
        for word in bits(*hit) {
            hasher.update(&word.to_le_bytes());
        }
    }
    hasher.finalize().to_hex()[..16].to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// If this fails after a change to an index that is meant to change its shape, renew the copy as the
    /// head of this file says, and look at the difference. If it fails on another machine, that is a
    /// defect: the same input must give the same bits everywhere.
    #[test]
    fn figures_are_those_of_the_golden_copy() {
        let (golden, now) = (include_str!("../../../golden/counters.txt"), lines().unwrap());
        for (golden, now) in golden.lines().zip(now.lines()) {
            assert_eq!(golden, now);
        }
        assert_eq!(golden.lines().count(), now.lines().count());
    }
}
