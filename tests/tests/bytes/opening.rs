//! Tests of ways to open an index and to size its memory that small devices need.

use arboleda::kinds::{Clustered, Linear, Octree, WideBvh};
use arboleda::{
    AnyIndex, Block, BuildError, Index, IndexKind, Mesh, OpenError, Options, Ray, Scene, Stored,
    Triangle, Vec3,
};
use arboleda_tests::build::Built;
use arboleda_tests::scenes;

const COUNT: usize = 200;
const SCRATCH: usize = IndexKind::OctreeHierarchy.scratch_capacity(COUNT, &Options::DEFAULT);

/// Scratch memory of a size that the compiler computes, as on a device.
static SCRATCH_BLOCKS: [Block; Block::count(SCRATCH)] = [Block::ZERO; Block::count(SCRATCH)];

fn triangles() -> Vec<Triangle> {
    scenes::soup(COUNT, 1)
}

fn ray() -> Ray {
    Ray::new(Vec3::new(-2.0, 0.1, 0.05), Vec3::new(1.0, -0.05, 0.02)).expect("the ray is valid")
}

#[test]
fn scratch_is_known_to_the_compiler() {
    fn of<R: arboleda::kinds::Representation>(options: &Options) -> usize {
        Index::<R>::scratch_capacity(COUNT, options)
    }
    let by_type = [
        (IndexKind::Linear, of::<Linear> as fn(&Options) -> usize),
        (IndexKind::OctreeHierarchy, of::<Clustered<Octree>>),
        (IndexKind::WideBvh, of::<WideBvh>),
        (IndexKind::WideBvhHierarchy, of::<Clustered<WideBvh>>),
    ];
    for (kind, bytes) in by_type {
        let options = Options::DEFAULT;
        assert_eq!(kind.scratch_capacity(COUNT, &options), bytes(&options), "{}", kind.name());
    }
    assert_eq!(SCRATCH_BLOCKS.len() * size_of::<Block>(), SCRATCH);
    assert_eq!(Options::DEFAULT, Options::default());
}

#[test]
fn any_index_opens_every_kind() {
    let triangles = triangles();
    let mesh = Mesh::Triangles(&triangles);
    for &kind in IndexKind::ALL {
        let alone = Built::new(kind, &Scene::of(mesh), &Options::DEFAULT).expect("it fits");
        let index = AnyIndex::from_bytes(alone.bytes()).expect("the bytes are valid");
        assert_eq!(index.kind(), kind);
        assert_eq!(index.closest_hit(&ray()), alone.index().closest_hit(&ray()));
        let error = AnyIndex::from_bytes_beside(alone.bytes(), mesh).err();
        assert_eq!(error, Some(OpenError::HasTriangles), "{}", kind.name());

        if !kind.holds_triangles() {
            let scene = Scene::of(mesh).beside();
            let beside = Built::new(kind, &scene, &Options::DEFAULT).expect("it fits");
            let index =
                AnyIndex::from_bytes_beside(beside.bytes(), mesh).expect("the bytes are valid");
            assert_eq!(index.kind(), kind);
            let error = AnyIndex::from_bytes(beside.bytes()).err();
            assert_eq!(error, Some(OpenError::MeshMissing), "{}", kind.name());
        }
    }
}

#[test]
fn a_stored_index_is_opened_again_and_again() {
    const BLOCKS: usize = 1024;
    let triangles = triangles();
    let (scene, options) = (Scene::new(&triangles), Options::DEFAULT);
    let built = Built::new(IndexKind::OctreeHierarchy, &scene, &options).expect("it fits");
    let expected = built.index().closest_hit(&ray());
    assert!(expected.is_some());

    // 1. A struct that holds the index and its arena, and is moved.
    struct Robot {
        name: &'static str,
        obstacles: Stored<[Block; BLOCKS], Clustered<Octree>>,
    }
    let mut scratch = SCRATCH_BLOCKS;
    let scratch = Block::bytes(&mut scratch);
    let blocks = [Block::ZERO; BLOCKS];
    let obstacles = Stored::build(&scene, &options, blocks, scratch).expect("it fits");
    let robots = vec![Robot { name: "one", obstacles }];
    for robot in &robots {
        let index = robot.obstacles.index();
        assert_eq!(index.closest_hit(&ray()), expected, "{}", robot.name);
        assert_eq!(index.as_bytes(), built.bytes());
        assert_eq!(index.cluster_count(), built.index().sections().cluster_count());
    }

    // 2. Blocks outside the struct, from which the index is opened.
    let mut elsewhere = vec![Block::ZERO; BLOCKS];
    let stored =
        Stored::<_, Clustered<Octree>>::build_in(&scene, &options, &mut elsewhere, scratch)
            .expect("it fits");
    assert_eq!(stored.index().closest_hit(&ray()), expected);
    let blocks: &[Block] = stored.into_storage();
    let opened = Stored::<_, Clustered<Octree>>::open(blocks).expect("the bytes are valid");
    assert_eq!(opened.index().closest_hit(&ray()), expected);

    // 3. Other kinds, other blocks and an index that needs a mesh are refused.
    let other = Stored::<_, Octree>::open(blocks).err();
    assert!(matches!(other, Some(OpenError::OtherKind { .. })), "{other:?}");
    let nothing = Stored::<_, Octree>::open([Block::ZERO; 2]).err();
    assert_eq!(nothing, Some(OpenError::NotAnIndex));
    let beside = Stored::<_, Octree>::build(&scene.beside(), &options, [Block::ZERO; 4], scratch);
    assert_eq!(beside.err(), Some(BuildError::CannotBeStored));
}

/// The scratch for 200 triangles stays within these bounds. They may be lowered.
#[test]
fn scratch_of_two_hundred_triangles() {
    let most = [
        ("linear", 896),
        ("octree", 13_952),
        ("octree-hierarchy", 17_664),
        ("octree-r", 13_952),
        ("octree-r-hierarchy", 17_664),
        ("uniform-grid", 20_160),
        ("grid-hierarchy", 20_928),
        ("kd-tree", 19_968),
        ("kd-tree-hierarchy", 20_736),
        ("bsp-tree", 19_968),
        ("bsp-tree-hierarchy", 20_736),
        ("bvh", 2_560),
        ("bvh-hierarchy", 17_664),
        ("wide-bvh", 12_160),
        ("wide-bvh-hierarchy", 29_824),
        ("compact-bvh", 12_160),
        ("compact-bvh-hierarchy", 29_824),
        ("lean-bvh", 12_160),
        ("lean-bvh-hierarchy", 29_824),
    ];
    assert_eq!(most.len(), IndexKind::ALL.len());
    let mut larger = Vec::new();
    for (kind, (name, most)) in IndexKind::ALL.iter().zip(most) {
        let bytes = kind.scratch_capacity(COUNT, &Options::DEFAULT);
        assert_eq!(kind.name(), name);
        if bytes > most {
            larger.push((name, bytes));
        }
    }
    assert!(larger.is_empty(), "{larger:?}");
}
