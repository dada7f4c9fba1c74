//! Tests that index bytes and answers are the same everywhere.
//!
//! Every kind of index is built of a fixed scene, and digests of its bytes and answers are compared with golden values.
//! The golden values were computed on x86_64. Other targets, optimisation levels and instruction sets must reproduce
//! them. Index bytes change with the format or the build of an index. Answers never change, and are the same for every
//! kind.

use arboleda::kinds::{CompactBvh, LeanBvh, Representation, WideBvh};
use arboleda::{
    Counters, Executor, Hit, Index, IndexKind, Options, Ray, Scene, SimdLevel, Triangle, Vec3,
};
use arboleda_tests::build::Built;
use arboleda_tests::digest::Digest;
use arboleda_tests::parallel::AtOnce;
use arboleda_tests::{rays, scenes};

/// Digest of the answers, the same for every kind.
const ANSWERS: u64 = 0x26c5_5cfd_5d28_b3f9;

/// Digest of the index bytes of each kind, by name.
const INDEX_BYTES: &[(&str, u64)] = &[
    ("linear", 0xfff0_5021_2d98_9325),
    ("octree", 0x1d15_97e3_466b_1b1c),
    ("octree-hierarchy", 0x5586_3c5e_5850_567f),
    ("octree-r", 0x9f82_0eb7_6239_f242),
    ("octree-r-hierarchy", 0xcfba_7255_7550_2f91),
    ("uniform-grid", 0xa489_08c9_9e20_ef43),
    ("grid-hierarchy", 0x4da3_860f_f9ea_e762),
    ("kd-tree", 0xde2e_643d_1550_d4df),
    ("kd-tree-hierarchy", 0x2d00_bc11_6fa1_931b),
    ("bsp-tree", 0x8da2_a343_cdc7_0ec3),
    ("bsp-tree-hierarchy", 0x708e_9625_d095_da74),
    ("bvh", 0x12cc_27f2_0d71_055c),
    ("bvh-hierarchy", 0xf5b0_52bd_b8f7_fbeb),
    ("wide-bvh", 0x0b7383becdc58f3c),
    ("wide-bvh-hierarchy", 0x75eef9079faa880b),
    ("compact-bvh", 0x912698c2fcecb0e2),
    ("compact-bvh-hierarchy", 0xe4069dbf8624c476),
    ("lean-bvh", 0xc96b1e49e0dff604),
    ("lean-bvh-hierarchy", 0xd5b746b21f0dedde),
];

/// Makes a lattice, a soup and a sphere in three groups of different sizes. Only sums, products and square roots are
/// used, which are rounded in the same way everywhere.
fn scene() -> Vec<Triangle> {
    let mut triangles = scenes::lattice(300, 5, 1);
    triangles.extend(scenes::moved(&scenes::soup(500, 2), 10.0, Vec3::new(100.0, -3.0, 0.1)));
    triangles.extend(scenes::moved(&scenes::icosphere(2), 0.37, Vec3::new(-40.0, 7.0, 1e-3)));
    triangles.extend(scenes::flat(6, 1));
    triangles
}

fn hard_rays(triangles: &[Triangle]) -> Vec<Ray> {
    rays::around(triangles, 600, 4)
}

#[test]
fn index_bytes_are_the_golden_ones() {
    let triangles = scene();
    let mut wrong = Vec::new();
    for &kind in IndexKind::ALL {
        let built = Built::new(kind, &Scene::new(&triangles), &Options::default());
        let mut digest = Digest::default();
        digest.index_bytes(built.expect("an ordinary scene").bytes());
        let golden = INDEX_BYTES.iter().find(|(name, _)| *name == kind.name());
        if golden.map(|golden| golden.1) != Some(digest.0) {
            wrong.push(format!("    (\"{}\", {:#018x}),", kind.name(), digest.0));
        }
    }
    assert!(
        wrong.is_empty(),
        "index bytes changed or are new; if that was intended, the lines are\n{}",
        wrong.join("\n")
    );
}

/// Executor that runs the second branch first.
struct Backwards;

impl Executor for Backwards {
    fn join<A: Send, B: Send>(
        &self,
        a: impl FnOnce() -> A + Send,
        b: impl FnOnce() -> B + Send,
    ) -> (A, B) {
        let b = b();
        (a(), b)
    }
}

/// The scenes are large enough that builds pass branches to the executor, in one cluster and in several.
#[test]
fn executors_change_nothing() {
    let mut triangles = scenes::soup(20_000, 3);
    triangles.extend(scenes::moved(&scenes::icosphere(5), 0.1, Vec3::new(500.0, 0.0, 0.0)));
    let (scene, options) = (Scene::new(&triangles), Options::default());
    for kind in [
        IndexKind::WideBvh,
        IndexKind::WideBvhHierarchy,
        IndexKind::CompactBvh,
        IndexKind::LeanBvh,
        IndexKind::BvhHierarchy,
    ] {
        let one = Built::new(kind, &scene, &options).expect("an ordinary scene");
        let backwards = Built::with(kind, &scene, &options, &Backwards).expect("the same scene");
        assert!(one.bytes() == backwards.bytes(), "{} backwards", kind.name());
        let at_once = Built::with(kind, &scene, &options, &AtOnce).expect("the same scene");
        assert!(one.bytes() == at_once.bytes(), "{} at once", kind.name());
    }
}

/// Answers and counters are the same at every SIMD level of the processor.
#[test]
fn vector_instructions_change_nothing() {
    let triangles = scene();
    let hard_rays = hard_rays(&triangles);
    same_with_and_without::<WideBvh>(IndexKind::WideBvh, &triangles, &hard_rays);
    same_with_and_without::<CompactBvh>(IndexKind::CompactBvh, &triangles, &hard_rays);
    same_with_and_without::<LeanBvh>(IndexKind::LeanBvh, &triangles, &hard_rays);
}

fn same_with_and_without<R: Representation>(kind: IndexKind, triangles: &[Triangle], rays: &[Ray]) {
    let built = Built::new(kind, &Scene::new(triangles), &Options::default());
    let built = built.expect("an ordinary scene");
    let with = Index::<R>::from_bytes(built.bytes()).expect("a built index is valid");
    let without = with.with_simd_level(SimdLevel::COMPILED);
    for vectors in [SimdLevel::detect(), SimdLevel::detect().without_avx512()] {
        let with = with.with_simd_level(vectors);
        let (mut counted_with, mut counted_without) = (Counters::default(), Counters::default());
        for ray in rays {
            assert_eq!(
                with.closest_hit_counted(ray, &mut counted_with),
                without.closest_hit_counted(ray, &mut counted_without)
            );
            assert_eq!(counted_with, counted_without, "{} {vectors:?} {ray:?}", kind.name());
        }
    }
}

#[test]
fn answers_are_the_golden_ones() {
    let triangles = scene();
    let rays = hard_rays(&triangles);
    for &kind in IndexKind::ALL {
        let built = Built::new(kind, &Scene::new(&triangles), &Options::default());
        let built = built.expect("an ordinary scene");
        let index = built.index();
        let mut digest = Digest::default();
        let mut hits = 0;
        for ray in &rays {
            let closest = index.closest_hit(ray);
            hits += usize::from(closest.is_some());
            digest.closest(closest);
            digest.word(u32::from(index.occluded(ray)));
            let mut buffer = [Hit::NONE; 4];
            digest.all(&index.all_hits(ray, &mut buffer));
        }
        assert!(hits * 4 > rays.len() && hits * 4 < 3 * rays.len(), "{hits} hits show little");
        assert_eq!(digest.0, ANSWERS, "{}: {:#018x}", kind.name(), digest.0);
    }
}
