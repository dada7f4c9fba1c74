//! Tests of what the interface answers: the bytes, hits and counters of the core.

use std::fmt::Write;
use std::ptr::{null, null_mut};

use crate::given::*;
use arboleda::{
    AllHits, AnyIndex, Block, Counters, Hit, IndexKind, Mesh, Options, Ray, Scene, Vec3,
};
use arboleda_ffi::arb_status::ARB_OK;
use arboleda_ffi::*;

const RAYS: usize = 1000;

fn core_ray(ray: &arb_ray) -> Ray {
    let (origin, direction) = (Vec3::from(ray.origin), Vec3::from(ray.direction));
    Ray::with_interval(origin, direction, ray.t_min, ray.t_max).expect("the ray is valid")
}

fn describe(index: &arb_index) -> arb_description {
    let mut description = arb_description {
        bytes: null(),
        byte_count: 0,
        kind: 0,
        triangle_count: 0,
        cluster_count: 0,
        beside: 0,
    };
    assert_eq!(unsafe { arb_describe(index, &mut description) }, ARB_OK);
    description
}

/// Asks everything about rays, and compares with the core.
fn compare(index: &arb_index, core: &AnyIndex<'_>, rays: &[arb_ray]) {
    let mut scratch = vec![0xa5; arb_batch_scratch_bytes()];
    let with = closest_each(index, rays, &mut scratch);
    assert_eq!(with, closest_each(index, rays, &mut []));
    // Every truth value that C may have left there.
    let mut occluded: Vec<u8> = (0..rays.len()).map(|i| i as u8).collect();
    let (room, bytes) = (scratch.as_mut_ptr().cast(), scratch.len());
    let status = unsafe {
        let to = occluded.as_mut_ptr().cast();
        arb_occluded_each(index, rays.as_ptr(), rays.len(), to, room, bytes, null_mut())
    };
    assert_eq!(status, ARB_OK);
    for ((ray, batch), shadow) in rays.iter().zip(with).zip(occluded) {
        let (mut hit, mut counted) = (NO_HIT, NO_HIT);
        let (mut any, mut any_counted) = (false, false);
        let mut counters = arb_counters { nodes_visited: 5, triangle_tests: 6 };
        let (mut hits, mut count, mut truncated) = ([NO_HIT; 2], 0, false);
        unsafe {
            assert_eq!(arb_check_ray(ray), ARB_OK);
            assert_eq!(arb_closest(index, ray, &mut hit), ARB_OK);
            assert_eq!(arb_occluded(index, ray, &mut any), ARB_OK);
            assert_eq!(arb_closest_counted(index, ray, &mut counted, &mut counters), ARB_OK);
            assert_eq!(arb_occluded_counted(index, ray, &mut any_counted, &mut counters), ARB_OK);
            let to = hits.as_mut_ptr();
            assert_eq!(arb_all_hits(index, ray, to, 2, &mut count, &mut truncated), ARB_OK);
        }
        let ray = core_ray(ray);
        let mut work = Counters { nodes_visited: 5, triangle_tests: 6 };
        let expected = core.closest_hit_counted(&ray, &mut work);
        let is_hit = core.occluded_counted(&ray, &mut work);
        assert_eq!([hit, counted, batch].map(core_hit), [expected; 3]);
        assert_eq!((any, any_counted, shadow), (is_hit, is_hit, u8::from(is_hit)));
        assert_eq!(counters.nodes_visited, work.nodes_visited);
        assert_eq!(counters.triangle_tests, work.triangle_tests);
        let mut buffer = [Hit::NONE; 2];
        let AllHits { hits: found, truncated: more } = core.all_hits(&ray, &mut buffer);
        let written: Vec<Hit> = hits[..count].iter().map(|hit| bytemuck::cast(*hit)).collect();
        assert_eq!((&written[..], truncated), (found, more));
    }
}

#[test]
fn every_kind_answers_as_the_core_does() {
    let given = Given::groups();
    let (mesh, rays) = (given.indexed(), given.rays(RAYS));
    let vertices: Vec<Vec3> = given.vertices.iter().copied().map(Vec3::from).collect();
    let scene = Scene::of(Mesh::Indexed { vertices: &vertices, corners: &given.corners });
    for &kind in IndexKind::ALL {
        let built = build(kind as u32, &mesh, &default_options()).unwrap();
        let mut scratch =
            vec![
                Block::ZERO;
                Block::count(kind.scratch_capacity(given.corners.len(), &Options::DEFAULT))
            ];
        let mut arena = vec![Block::ZERO; built.memory.len()];
        let (arena, scratch) = (Block::bytes(&mut arena), Block::bytes(&mut scratch));
        let core = kind.build(&scene, &Options::DEFAULT, arena, scratch).unwrap();
        let description = describe(&built.index);
        assert_eq!(description.bytes, built.memory.as_ptr().cast());
        assert_eq!((description.byte_count, description.kind), (built.bytes, kind as u32));
        assert_eq!((description.triangle_count, description.beside), (456, 0));
        assert_eq!(description.cluster_count, core.sections().cluster_count());
        let bytes: &[u8] = bytemuck::cast_slice(&built.memory);
        assert!(bytes[..built.bytes] == *core.as_bytes(), "{}", kind.name());

        // The bytes are moved, opened elsewhere, and the handle is copied.
        let moved = built.memory.clone();
        let mut opened = CLOSED;
        let mut error = empty_error();
        let status = unsafe {
            arb_open(&mut opened, moved.as_ptr().cast(), built.bytes, null(), &mut error)
        };
        assert_eq!((status, error.status, error.element), (ARB_OK, ARB_OK, 0));
        assert_eq!(message(&error), "");
        let copied = opened;
        assert_eq!(unsafe { arb_close(&mut opened) }, ARB_OK);
        compare(&copied, &core, &rays);
    }
}

#[test]
fn an_index_lies_beside_the_mesh_in_either_form() {
    let given = Given::groups();
    let (indexed, triangles, rays) = (given.indexed(), given.triangles(), given.rays(RAYS));
    let list = arb_mesh {
        triangles: triangles.as_ptr().cast(),
        triangle_count: triangles.len(),
        ..no_mesh()
    };
    let linear = build(0, &indexed, &default_options()).expect("a linear scan");
    let expected = closest_each(&linear.index, &rays, &mut []);
    let beside = arb_options { beside: 1, ..default_options() };
    for kind in [arb_kind::ARB_LEAN_BVH, arb_kind::ARB_BVH, arb_kind::ARB_OCTREE_HIERARCHY] {
        let built = build(kind as u32, &list, &beside).expect("an index beside a list");
        assert_eq!(describe(&built.index).beside, 1);
        assert_eq!(closest_each(&built.index, &rays, &mut []), expected);
        let mut opened = CLOSED;
        let bytes = built.memory.as_ptr().cast();
        let status = unsafe { arb_open(&mut opened, bytes, built.bytes, &indexed, null_mut()) };
        assert_eq!(status, ARB_OK);
        assert_eq!(closest_each(&opened, &rays, &mut []), expected);
    }
}

#[test]
fn threads_use_one_handle_at_once() {
    let given = Given::groups();
    let rays = given.rays(RAYS);
    let built = build(arb_kind::ARB_WIDE_BVH as u32, &given.indexed(), &default_options()).unwrap();
    let expected = closest_each(&built.index, &rays, &mut []);
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                let mut scratch = vec![0; arb_batch_scratch_bytes()];
                assert_eq!(closest_each(&built.index, &rays, &mut scratch), expected);
            });
        }
    });
}

#[test]
fn a_mesh_without_triangles_has_an_index_that_nothing_hits() {
    let rays = Given::groups().rays(70);
    for &kind in IndexKind::ALL {
        let built = build(kind as u32, &no_mesh(), &default_options()).unwrap();
        assert!(closest_each(&built.index, &rays, &mut []).iter().all(|hit| *hit == NO_HIT));
        assert!(closest_each(&built.index, &[], &mut []).is_empty());
    }
}

#[test]
fn objects_are_kept_in_one_cluster() {
    let given = Given::groups();
    let one = vec![0_u32; given.corners.len()];
    let hierarchy = arb_kind::ARB_BVH_HIERARCHY as u32;
    let divided = build(hierarchy, &given.indexed(), &default_options()).expect("clusters");
    assert!(describe(&divided.index).cluster_count > 1);
    let mesh = arb_mesh { objects: one.as_ptr(), ..given.indexed() };
    let whole = build(hierarchy, &mesh, &default_options()).expect("a cluster");
    assert_eq!(describe(&whole.index).cluster_count, 1);
}

#[test]
fn options_reach_the_core() {
    let given = Given::groups();
    let defaults = default_options();
    let bytes = |kind: arb_kind, options: &arb_options| {
        build(kind as u32, &given.indexed(), options).expect("an index").bytes
    };
    use arb_kind::{ARB_BVH, ARB_BVH_HIERARCHY, ARB_KD_TREE, ARB_OCTREE, ARB_UNIFORM_GRID};
    let changes = [
        (ARB_OCTREE, arb_options { leaf_capacity: 1, ..defaults }),
        (ARB_OCTREE, arb_options { level: 1, ..defaults }),
        (ARB_OCTREE, arb_options { least_side: 1.0, ..defaults }),
        (ARB_BVH_HIERARCHY, arb_options { proximity: 100.0, ..defaults }),
        (ARB_BVH_HIERARCHY, arb_options { size_classes: 1, ..defaults }),
        (
            ARB_UNIFORM_GRID,
            arb_options { resolution: ARB_CELLS_PER_TRIANGLE, cells_per_triangle: 9.0, ..defaults },
        ),
        (ARB_UNIFORM_GRID, arb_options { resolution: ARB_CELLS, cells: [2, 3, 5], ..defaults }),
        (ARB_BVH, arb_options { bvh_build: ARB_BVH_INSERTION, ..defaults }),
        (ARB_KD_TREE, arb_options { traversal_cost: 90.0, intersection_cost: 1.0, ..defaults }),
    ];
    for (kind, options) in changes {
        assert_ne!(bytes(kind, &options), bytes(kind, &defaults), "{kind:?} {options:?}");
    }
}

/// The lines of `expected.txt`, which each target has to print in `.ci/run c_interface`, are those of the core's hits.
#[test]
fn examples_print_what_the_core_finds() {
    let given = Given::groups();
    let rays = given.rays(RAYS);
    let mut lines = String::new();
    let wide = build(arb_kind::ARB_WIDE_BVH as u32, &given.indexed(), &default_options());
    let wide = wide.expect("a wide BVH");
    let core = AnyIndex::from_bytes(bytemuck::cast_slice(&wide.memory)).expect("an index");
    let mut work = Counters::default();
    let hits: Vec<arb_hit> = rays
        .iter()
        .map(|ray| core.closest_hit_counted(&core_ray(ray), &mut work).unwrap_or(Hit::NONE))
        .map(bytemuck::cast)
        .collect();
    let hit_count = hits.iter().filter(|hit| hit.triangle != ARB_NO_TRIANGLE).count();
    let (nodes, tests, digest) = (work.nodes_visited, work.triangle_tests, digest(&hits));
    writeln!(
        lines,
        "wide-bvh: 456 triangles, {} bytes, {RAYS} rays, {hit_count} hit, {hit_count} occluded, \
         {nodes} nodes, {tests} tests, hits={digest:016x}",
        wide.bytes
    )
    .expect("a string grows");
    let beside = arb_options { beside: 1, ..default_options() };
    let lean = build(arb_kind::ARB_LEAN_BVH as u32, &given.indexed(), &beside);
    let bytes = lean.expect("a lean BVH").bytes;
    writeln!(
        lines,
        "lean-bvh: 456 triangles, {bytes} bytes, {RAYS} rays, {hit_count} hit, hits={digest:016x}"
    )
    .expect("a string grows");
    let expected = include_str!("../../examples/expected.txt");
    let rest = expected.strip_prefix(&lines).expect("the lines of the first two examples");
    // The third example compares its bytes itself.
    assert_eq!(rest.lines().count(), 2);
}
