//! Cost against triangle count: the same kind of scene, larger and larger.
//!
//! A good build grows as n log n and a good query as log n. What grows faster is memory: a scene of a
//! thousand triangles lies in the closest cache, one of ten million in none.

use arboleda::IndexKind;

use crate::benchmark::harness::measurement::{Measurement, measure, verified_workload};
use crate::benchmark::harness::plan::{Case, Effort};
use crate::benchmark::harness::progress::Tick;
use crate::scene::Model;
use crate::scene::builtin::SIZED;
use crate::scene::city::{CityOptions, procedural_city};
use crate::scene::mixed::{MixedOptions, mixed_sizes};

/// Kind of scene that comes in several sizes.
#[derive(Clone, Copy, Debug)]
pub struct SceneFamily {
    /// Name for headings.
    pub name: &'static str,
    /// The part of it that grows.
    pub description: &'static str,
    sizes: &'static [[u32; 2]],
    build: fn([u32; 2]) -> Model,
}

/// The families, with sizes a factor of three to five apart.
pub const FAMILIES: [SceneFamily; 2] = [
    SceneFamily {
        name: "city",
        description: "blocks of buildings, more and more of them",
        // Blocks along each side, buildings along each side of a block.
        sizes: &[[1, 2], [2, 2], [3, 3], [6, 3], [10, 3]],
        build: |[blocks, buildings_per_side]| {
            let blocks = [blocks; 2];
            procedural_city(CityOptions { blocks, buildings_per_side, ..CityOptions::default() })
        },
    },
    SceneFamily {
        name: "mixed",
        description: "balls, boxes and teapots of sizes 1 to 1000, more and more of them",
        // Objects, detail.
        sizes: &[[10, 1], [30, 1], [40, 2], [120, 2]],
        build: |[object_count, detail]| {
            mixed_sizes(MixedOptions { object_count, detail, ..MixedOptions::default() })
        },
    },
];

impl SceneFamily {
    /// Makes the scenes, from small to large.
    pub fn models(&self) -> impl Iterator<Item = Model> {
        self.sizes.iter().map(|&size| (self.build)(size))
    }
}

/// Measurements on one size of one family.
pub struct GrowthRow {
    /// The family's name.
    pub family: &'static str,
    /// All indices but the linear scan.
    pub measured: Vec<Measurement>,
}

/// Lists all indices but the linear scan, whose cost needs no measuring: it is the number of triangles.
pub fn cases() -> Vec<Case> {
    IndexKind::ALL
        .iter()
        .filter(|&&kind| kind != IndexKind::Linear)
        .map(|&kind| Case::usual(kind))
        .collect()
}

/// Counts the steps of `progress`.
pub fn steps() -> u64 {
    FAMILIES.iter().map(|family| family.sizes.len() * cases().len()).sum::<usize>() as u64
}

/// Measures every index at every size.
///
/// # Errors
/// If two indices do not agree.
pub fn run(effort: &Effort, progress: Tick<'_>) -> anyhow::Result<Vec<GrowthRow>> {
    let mut rows = Vec::new();
    for family in &FAMILIES {
        for model in family.models() {
            let workload = verified_workload(&model, effort)?;
            let measured = measure(&model, &cases(), &workload, effort, progress)?;
            rows.push(GrowthRow { family: family.name, measured });
        }
    }
    Ok(rows)
}

/// Sizes of the scenes for other libraries, ten times larger each step.
const SIZES: [u32; 5] = [1_000, 10_000, 100_000, 1_000_000, 10_000_000];

/// Names meshes and cities up to `largest` triangles: few sizes, far apart, for the two or three contenders that are
/// compared on each.
pub fn sized_scenes(largest: u32) -> Vec<String> {
    let sizes = || SIZES.into_iter().filter(|&size| size <= largest);
    let named = |family| sizes().map(move |size| format!("{family}-{size}"));
    SIZED.iter().flat_map(|(family, _)| named(family)).collect()
}
