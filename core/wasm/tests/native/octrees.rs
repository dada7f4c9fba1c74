//! Cells, paths and clusters against the core's own answers.

use std::ptr;

use arboleda::clusters::{find, scratch_capacity};
use arboleda::{
    Aabb, AnyIndex, Block, Counters, IndexKind, Options, OwnedIndex, Ray, Scene, Triangle, Vec3,
};
use arboleda_ffi::{
    ARB_INDEX_WORDS, ARB_NO_TRIANGLE, arb_hit, arb_index, arb_mesh, arb_open, arb_ray, arb_status,
};
use arboleda_wasm::clusters::{arb_cluster_tree, arb_clusters, arb_clusters_scratch_bytes};
use arboleda_wasm::octree::{arb_octree_cells, arb_path};

use crate::scene;

const OCTREES: [IndexKind; 4] = [
    IndexKind::Octree,
    IndexKind::OctreeHierarchy,
    IndexKind::OctreeR,
    IndexKind::OctreeRHierarchy,
];

fn opened(index: AnyIndex<'_>) -> arb_index {
    let mut handle = arb_index { opaque: [0; ARB_INDEX_WORDS] };
    let bytes = index.as_bytes();
    let status = unsafe {
        arb_open(&mut handle, bytes.as_ptr().cast(), bytes.len(), ptr::null(), ptr::null_mut())
    };
    assert_eq!(status, arb_status::ARB_OK);
    handle
}

struct Path {
    steps: Vec<[u32; 11]>,
    tests: Vec<u32>,
    hit: arb_hit,
}

fn path(handle: &arb_index, ray: &Ray, rooms: [usize; 2]) -> (Path, [usize; 2]) {
    let (mut steps, mut tests) = (vec![[7; 11]; rooms[0]], vec![7; rooms[1]]);
    let mut counts = [0; 2];
    let mut hit = arb_hit { triangle: 0, t: 0.0, u: 0.0, v: 0.0 };
    let given = arb_ray {
        origin: ray.origin().to_array(),
        direction: ray.direction().to_array(),
        t_min: ray.t_min(),
        t_max: ray.t_max(),
    };
    let status = unsafe {
        arb_path(
            handle,
            &given,
            steps.as_mut_ptr().cast(),
            rooms[0],
            tests.as_mut_ptr(),
            rooms[1],
            counts.as_mut_ptr(),
            &mut hit,
            ptr::null_mut(),
        )
    };
    assert_eq!(status, arb_status::ARB_OK);
    (Path { steps, tests, hit }, counts)
}

/// Rays of all sorts: ordinary ones, along axes, in planes of cells, from far away, with an interval.
fn rays(triangles: &[Triangle]) -> Vec<Ray> {
    let mut rays = scene::rays(3000);
    for triangle in triangles.iter().step_by(40) {
        let middle = triangle.bounds().lo.midpoint(triangle.bounds().hi);
        for direction in [Vec3::X, Vec3::NEG_Y, Vec3::Z, Vec3::new(1.0, -1.0, 0.0)] {
            rays.extend(Ray::new(middle - direction * 100.0, direction));
            rays.extend(Ray::new(middle - direction * 1e7, direction));
            rays.extend(Ray::new(triangle.a - direction * 8.0, direction));
            rays.extend(Ray::with_interval(middle - direction * 100.0, direction, 0.0, 90.0));
            rays.extend(Ray::with_interval(middle, direction, -200.0, f32::INFINITY));
        }
    }
    rays
}

#[test]
fn a_path_is_what_the_query_does() {
    let triangles = scene::triangles();
    let rays = rays(&triangles);
    for kind in OCTREES {
        let owned =
            OwnedIndex::build(kind, &Scene::new(&triangles), &Options::DEFAULT).expect("builds");
        let (index, handle) = (owned.index(), opened(owned.index()));
        let mut sum = Counters::default();
        for ray in &rays {
            let mut counters = Counters::default();
            let hit = index.closest_hit_counted(ray, &mut counters);
            let (found, counts) = path(&handle, ray, [2000, 4000]);
            let name = kind.name();
            assert_eq!(
                counts.map(|count| count as u64),
                [counters.nodes_visited, counters.triangle_tests],
                "{name} {ray:?}"
            );
            let expected =
                hit.map_or((ARB_NO_TRIANGLE, f32::INFINITY), |hit| (hit.triangle.0, hit.t));
            assert_eq!((found.hit.triangle, found.hit.t), expected, "{name} {ray:?}");
            assert_eq!((found.hit.u, found.hit.v), hit.map_or((0.0, 0.0), |hit| (hit.u, hit.v)));
            // The tests of the steps follow each other, and the hit is one of them.
            let steps = &found.steps[..counts[0]];
            let mut next = 0;
            for step in steps {
                assert_eq!(step[3], next);
                next += step[4];
            }
            assert_eq!(next as usize, counts[1]);
            assert!(hit.is_none_or(|hit| found.tests[..counts[1]].contains(&hit.triangle.0)));
            sum += counters;
        }
        assert!(sum.nodes_visited > rays.len() as u64, "the rays visit nodes");
    }
}

#[test]
fn a_path_without_room_is_counted() {
    let triangles = scene::triangles();
    let owned =
        OwnedIndex::build(IndexKind::OctreeHierarchy, &Scene::new(&triangles), &Options::DEFAULT)
            .expect("builds");
    let handle = opened(owned.index());
    for ray in &scene::rays(50) {
        let (all, counts) = path(&handle, ray, [2000, 4000]);
        let few = counts.map(|count| count / 2);
        let (cut, counted) = path(&handle, ray, few);
        assert_eq!(counted, counts);
        assert_eq!(cut.steps[..], all.steps[..few[0]]);
        assert_eq!(cut.tests[..], all.tests[..few[1]]);
    }
}

fn cells(handle: &arb_index, level: u32) -> (arb_status, Vec<[u32; 9]>) {
    let mut count = 0;
    let null = ptr::null_mut();
    let status = unsafe { arb_octree_cells(handle, level, null, 0, &mut count, null.cast()) };
    let mut cells = vec![[0; 9]; count];
    if status == arb_status::ARB_OK {
        let room = cells.as_mut_ptr().cast();
        let again =
            unsafe { arb_octree_cells(handle, level, room, count, &mut count, null.cast()) };
        assert_eq!(again, status);
    }
    (status, cells)
}

#[test]
fn the_deepest_cells_are_the_leaves() {
    let triangles = scene::triangles();
    for kind in OCTREES {
        let owned =
            OwnedIndex::build(kind, &Scene::new(&triangles), &Options::DEFAULT).expect("builds");
        let (index, handle) = (owned.index(), opened(owned.index()));
        let statistics = index.check().expect("a sound index");
        let (status, leaves) = cells(&handle, 20);
        assert_eq!(status, arb_status::ARB_OK);
        assert_eq!(leaves.len() as u64, statistics.leaves);
        assert_eq!(
            leaves.iter().map(|leaf| u64::from(leaf[8])).sum::<u64>(),
            statistics.references
        );
        assert_eq!(leaves.iter().map(|leaf| leaf[7]).max(), Some(statistics.deepest_level));
        // At level 0 there is the box of each cluster.
        let (_, roots) = cells(&handle, 0);
        let tree: Vec<Aabb> = index.cluster_tree().iter().map(|node| node.bounds).collect();
        assert_eq!(roots.len() as u32, index.cluster_tree().cluster_count());
        for (number, root) in roots.iter().enumerate() {
            let bits: Vec<u32> = tree[number]
                .lo
                .to_array()
                .into_iter()
                .chain(tree[number].hi.to_array())
                .map(f32::to_bits)
                .collect();
            assert_eq!((&root[..6], root[6], root[7]), (&bits[..], number as u32, 0));
        }
    }
    let owned = OwnedIndex::build(IndexKind::WideBvh, &Scene::new(&triangles), &Options::DEFAULT)
        .expect("builds");
    assert_eq!(cells(&opened(owned.index()), 3).0, arb_status::ARB_INVALID_OPTION);
}

#[test]
fn clusters_are_those_of_the_core() {
    let triangles = scene::triangles();
    let mut room = vec![Block::ZERO; Block::count(scratch_capacity(triangles.len()))];
    let scratch = Block::bytes(&mut room);
    let expected: Vec<Vec<u32>> = find(&Scene::new(&triangles), &Options::DEFAULT, scratch)
        .expect("clusters")
        .iter()
        .map(<[u32]>::to_vec)
        .collect();
    assert!(expected.len() > 6);

    let mesh = arb_mesh {
        triangles: triangles.as_ptr().cast(),
        vertices: ptr::null(),
        corners: ptr::null(),
        objects: ptr::null(),
        triangle_count: triangles.len(),
        vertex_count: 0,
    };
    let (mut cluster_of, mut count) = (vec![u32::MAX; triangles.len()], 0);
    let needed = arb_clusters_scratch_bytes(triangles.len());
    for (bytes, expected_status) in
        [(needed, arb_status::ARB_OK), (needed - 64, arb_status::ARB_SCRATCH_TOO_SMALL)]
    {
        let scratch = Block::bytes(&mut room);
        let status = unsafe {
            arb_clusters(
                &mesh,
                ptr::null(),
                scratch.as_mut_ptr().cast(),
                bytes,
                cluster_of.as_mut_ptr(),
                &mut count,
                ptr::null_mut(),
            )
        };
        assert_eq!(status, expected_status);
    }
    assert_eq!(count, expected.len());
    for (number, ids) in expected.iter().enumerate() {
        assert!(ids.iter().all(|&id| cluster_of[id as usize] == number as u32));
    }
}

#[test]
fn the_cluster_tree_is_that_of_the_index() {
    let triangles = scene::triangles();
    let owned =
        OwnedIndex::build(IndexKind::OctreeHierarchy, &Scene::new(&triangles), &Options::DEFAULT)
            .expect("builds");
    let (tree, handle) = (owned.index().cluster_tree(), opened(owned.index()));
    let (mut nodes, mut count) = (vec![[0; 9]; tree.len()], 0);
    let status = unsafe {
        arb_cluster_tree(
            &handle,
            nodes.as_mut_ptr().cast(),
            nodes.len(),
            &mut count,
            ptr::null_mut(),
        )
    };
    assert_eq!((status, count), (arb_status::ARB_OK, tree.len()));
    for (node, expected) in nodes.iter().zip(tree.iter()) {
        let corner = |at: usize| {
            Vec3::from_array([node[at], node[at + 1], node[at + 2]].map(f32::from_bits))
        };
        assert_eq!((corner(0), corner(3)), (expected.bounds.lo, expected.bounds.hi));
        assert_eq!(node[6], expected.parent.map_or(u32::MAX, |id| id.0));
        assert_eq!(
            [node[7], node[8]],
            expected.children.map_or([u32::MAX; 2], |ids| ids.map(|id| id.0))
        );
    }
}
