//! Cost against triangle count: the same kind of scene, larger and larger.

use arboleda::IndexKind;

use crate::bench::plan::{Case, Effort};
use crate::bench::rays::RaySet;
use crate::bench::run::{Measurement, check_against_oracle, measure};
use crate::scene::Model;
use crate::scene::city::{CityOptions, procedural_city};
use crate::scene::mixed::{MixedOptions, mixed_sizes};

/// A scene that comes in several sizes.
#[derive(Clone, Copy, Debug)]
pub struct Family {
    /// For headings.
    pub name: &'static str,
    /// What grows.
    pub description: &'static str,
    sizes: &'static [[u32; 2]],
    build: fn([u32; 2]) -> Model,
}

/// The families, with sizes a factor of three to five apart.
pub const FAMILIES: [Family; 2] = [
    Family {
        name: "city",
        description: "blocks of buildings, more and more of them",
        // Blocks along each side, buildings along each side of a block.
        sizes: &[[1, 2], [2, 2], [3, 3], [6, 3], [10, 3]],
        build: |[blocks, buildings_per_side]| {
            let blocks = [blocks; 2];
            procedural_city(CityOptions { blocks, buildings_per_side, ..CityOptions::default() })
        },
    },
    Family {
        name: "mixed",
        description: "balls, boxes and teapots of sizes 1 to 1000, more and more of them",
        // Objects, detail.
        sizes: &[[10, 1], [30, 1], [40, 2], [120, 2]],
        build: |[object_count, detail]| {
            mixed_sizes(MixedOptions { object_count, detail, ..MixedOptions::default() })
        },
    },
];

impl Family {
    /// The scenes, from small to large.
    pub fn models(&self) -> impl Iterator<Item = Model> {
        self.sizes.iter().map(|&size| (self.build)(size))
    }
}

/// One size of one family.
pub struct GrowthRow {
    /// The family's name.
    pub family: &'static str,
    /// All indices but the linear scan.
    pub measured: Vec<Measurement>,
}

/// All indices but the linear scan, whose cost needs no measuring: it is the number of triangles.
pub fn cases() -> Vec<Case> {
    IndexKind::ALL
        .iter()
        .filter(|&&kind| kind != IndexKind::Linear)
        .map(|&kind| Case::usual(kind))
        .collect()
}

/// How many steps `progress` takes.
pub fn steps() -> u64 {
    FAMILIES.iter().map(|family| family.sizes.len() * cases().len()).sum::<usize>() as u64
}

/// Measures every index at every size.
///
/// # Errors
/// If two indices do not agree.
pub fn run(
    effort: &Effort,
    seed: u64,
    progress: &mut dyn FnMut(),
) -> anyhow::Result<Vec<GrowthRow>> {
    let mut rows = Vec::new();
    for family in &FAMILIES {
        for model in family.models() {
            let rays = RaySet::shoot(&model, effort.photons, seed)?;
            check_against_oracle(&model, &rays)?;
            let measured = measure(&model, &cases(), &rays, effort, progress)?;
            rows.push(GrowthRow { family: family.name, measured });
        }
    }
    Ok(rows)
}
