//! Property tests of batch queries: the bits of single rays, whatever the other rays of the batch, their order and number,
//! the scratch and the vector instructions.

use arboleda::{
    AnyIndex, BATCH_SCRATCH, Hit, IndexKind, Mesh, Options, Ray, RayIndex, Scene, SimdLevel,
    Triangle, Vec3,
};
use arboleda_tests::build::Built;
use arboleda_tests::checks::bits;
use arboleda_tests::random::Random;
use arboleda_tests::rays;
use arboleda_tests::scenes::{self, crowds};

/// The kinds whose batches differ from single rays.
const KINDS: [IndexKind; 3] = [IndexKind::WideBvh, IndexKind::CompactBvh, IndexKind::LeanBvh];

/// Numbers of rays: none, one, and around the 128 from which on there are rays in flight, 32 of them.
const LENGTHS: [usize; 9] = [0, 1, 127, 128, 129, 159, 160, 161, 1000];

fn all_scenes() -> Vec<Vec<Triangle>> {
    vec![
        vec![],
        scenes::lattice(1, 4, 1),
        scenes::lattice(9, 4, 2),
        scenes::soup(500, 3),
        scenes::lattice(700, 6, 4),
        scenes::coincident(60),
        scenes::flat(12, 1),
        scenes::huge(200, 5),
        scenes::tiny(200, 6),
        scenes::touching_boxes(4),
        scenes::icosphere(4),
        crowds::concentric(300),
        crowds::planes_through_a_point(200),
        crowds::slivers(300),
    ]
}

/// Rays of all sorts around a scene: also such as lanes cannot take, in a third of the places.
fn mixed(triangles: &[Triangle], count: usize, seed: u64) -> Vec<Ray> {
    let mut random = Random::new(seed);
    let mut rays = rays::around(triangles, count, seed);
    for ray in &mut rays {
        let (origin, direction) = (ray.origin(), ray.direction());
        let changed = match random.below(9) {
            0 => Ray::with_interval(origin, direction, -1.0, ray.t_max().max(1.0)),
            1 => Ray::new(origin + Vec3::splat(3.0e9), direction),
            2 => Ray::new(origin, direction.normalize_or(Vec3::X) * 1.0e-30),
            3 => Ray::new(origin, Vec3::new(0.0, direction.y, 0.0)),
            4 => Ray::with_interval(origin, direction, 0.0, 0.5),
            _ => continue,
        };
        *ray = changed.unwrap_or(*ray);
    }
    rays
}

/// The same index with each set of vector instructions.
fn at_every_level(index: AnyIndex<'_>, check: &mut dyn FnMut(&dyn RayIndex)) {
    let detected = SimdLevel::detect();
    for level in [detected, detected.without_avx512(), SimdLevel::COMPILED] {
        match index {
            AnyIndex::WideBvh(index) => check(&index.with_simd_level(level)),
            AnyIndex::CompactBvh(index) => check(&index.with_simd_level(level)),
            AnyIndex::LeanBvh(index) => check(&index.with_simd_level(level)),
            other => check(&other),
        }
    }
}

fn on_every_index(triangles: &[Triangle], mut check: impl FnMut(&dyn RayIndex)) {
    for kind in KINDS {
        let built = Built::new(kind, &Scene::new(triangles), &Options::DEFAULT).expect("an index");
        at_every_level(built.index(), &mut check);
    }
}

/// Asks about a batch in some scratch, and compares with single rays.
fn equals_single_rays(index: &dyn RayIndex, rays: &[Ray], scratch: &mut [u8]) {
    let mut hits = vec![Hit { u: -7.0, ..Hit::NONE }; rays.len()];
    let mut occluded: Vec<bool> = rays.iter().map(|ray| !index.occluded(ray)).collect();
    index.closest_hits_in(rays, &mut hits, scratch);
    index.occluded_each_in(rays, &mut occluded, scratch);
    for (at, ray) in rays.iter().enumerate() {
        let single = index.closest_hit(ray).unwrap_or(Hit::NONE);
        assert_eq!(bits(&hits[at]), bits(&single), "ray {at} of {}: {ray:?}", rays.len());
        assert_eq!(occluded[at], !single.is_none(), "ray {at} of {}: {ray:?}", rays.len());
    }
}

#[test]
fn batches_of_any_length_equal_single_rays() {
    let mut scratch = vec![0xff; BATCH_SCRATCH];
    for (number, triangles) in all_scenes().iter().enumerate() {
        let rays = mixed(triangles, 1000, number as u64);
        on_every_index(triangles, |index| {
            for length in LENGTHS {
                equals_single_rays(index, &rays[..length], &mut scratch);
            }
        });
    }
}

#[test]
fn single_rays_equal_the_linear_scan() {
    for (number, triangles) in all_scenes().iter().enumerate() {
        let rays = mixed(triangles, 300, 100 + number as u64);
        let linear = Built::new(IndexKind::Linear, &Scene::new(triangles), &Options::DEFAULT);
        let linear = linear.expect("an index");
        let expected: Vec<_> =
            rays.iter().map(|ray| linear.index().closest_hit(ray).unwrap_or(Hit::NONE)).collect();
        on_every_index(triangles, |index| {
            let mut hits = vec![Hit::NONE; rays.len()];
            index.closest_hits(&rays, &mut hits);
            for (at, hit) in hits.iter().enumerate() {
                assert_eq!(bits(hit), bits(&expected[at]), "ray {at}: {:?}", rays[at]);
            }
        });
    }
}

/// The lean BVH beside a mesh that shares vertices, and beside triangles.
#[test]
fn batches_beside_a_mesh_equal_single_rays() {
    let triangles = scenes::icosphere(4);
    let rays = mixed(&triangles, 500, 15);
    let (vertices, corners) = scenes::welded(&triangles);
    let indexed = Mesh::Indexed { vertices: &vertices, corners: &corners };
    for mesh in [indexed, Mesh::Triangles(&triangles)] {
        let scene = Scene::of(mesh).beside();
        let built = Built::new(IndexKind::LeanBvh, &scene, &Options::DEFAULT).expect("an index");
        at_every_level(built.index_beside(mesh), &mut |index| {
            equals_single_rays(index, &rays, &mut vec![0; BATCH_SCRATCH]);
        });
    }
}

#[test]
fn any_order_of_the_rays_gives_the_same_hits() {
    let triangles = scenes::soup(2000, 7);
    let rays = mixed(&triangles, 500, 8);
    on_every_index(&triangles, |index| {
        let mut expected = vec![Hit::NONE; rays.len()];
        let mut scratch = vec![0; BATCH_SCRATCH];
        index.closest_hits_in(&rays, &mut expected, &mut scratch);
        let mut order: Vec<usize> = (0..rays.len()).collect();
        let mut random = Random::new(9);
        for _ in 0..4 {
            random.shuffle(&mut order);
            let shuffled: Vec<Ray> = order.iter().map(|&at| rays[at]).collect();
            let mut hits = vec![Hit::NONE; rays.len()];
            index.closest_hits_in(&shuffled, &mut hits, &mut scratch);
            for (hit, &at) in hits.iter().zip(&order) {
                assert_eq!(bits(hit), bits(&expected[at]), "{:?}", rays[at]);
            }
        }
    });
}

#[test]
fn any_scratch_gives_the_same_hits() {
    let triangles = scenes::soup(2000, 10);
    let rays = mixed(&triangles, 400, 11);
    let mut memory = vec![0xa5; BATCH_SCRATCH + 64];
    on_every_index(&triangles, |index| {
        // Any alignment, exactly enough.
        for skipped in [0, 1, 4, 31, 63, 64] {
            equals_single_rays(index, &rays, &mut memory[skipped..][..BATCH_SCRATCH]);
        }
        // Too short.
        for length in [0, 1, BATCH_SCRATCH / 2, BATCH_SCRATCH.saturating_sub(64)] {
            equals_single_rays(index, &rays, &mut memory[..length.min(BATCH_SCRATCH)]);
        }
    });
}

/// Boxes in boxes, each next to many others: stacks of waiting nodes grow as high as the tree.
#[test]
fn deep_trees_give_the_same_hits() {
    // Each triangle half as large and half as far as the one before.
    let nested: Vec<Triangle> = (0..100)
        .flat_map(|level| {
            let size = 0.5_f32.powi(level);
            (0..9).map(move |at| {
                let corner = Vec3::new(1.0 + 0.1 * at as f32, 1.0, 1.0 + 0.05 * at as f32) * size;
                Triangle::new(
                    corner,
                    corner + Vec3::X * size,
                    corner + Vec3::new(0.0, 1.0, 1.0) * size,
                )
            })
        })
        .collect();
    let mut rays = rays::around(&nested, 200, 12);
    // Along the diagonal, through the boxes of all levels, from the far end.
    rays.extend((0..200).filter_map(|at| {
        let origin = Vec3::new(4.0, 4.0 + at as f32 * 1.0e-3, 4.0);
        Ray::new(origin, Vec3::new(-1.0, -1.0 - at as f32 * 2.5e-4, -1.0)).ok()
    }));
    let mut scratch = vec![0; BATCH_SCRATCH];
    on_every_index(&nested, |index| {
        equals_single_rays(index, &rays, &mut scratch);
        equals_single_rays(index, &rays, &mut []);
    });
}

#[test]
fn entries_beyond_the_shorter_slice_are_not_written() {
    let triangles = scenes::soup(300, 13);
    let rays = mixed(&triangles, 200, 14);
    let mut scratch = vec![0; BATCH_SCRATCH];
    on_every_index(&triangles, |index| {
        let untouched = Hit { u: -7.0, ..Hit::NONE };
        let mut hits = vec![untouched; 200];
        index.closest_hits_in(&rays[..150], &mut hits, &mut scratch);
        assert!(hits[150..].iter().all(|hit| bits(hit) == bits(&untouched)));
        let mut few = vec![untouched; 140];
        index.closest_hits_in(&rays, &mut few, &mut scratch);
        assert!(few.iter().zip(&hits).all(|(few, hit)| bits(few) == bits(hit)));
    });
}
