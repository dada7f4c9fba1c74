//! Tests of builds in slices: the bytes of a build at once, wherever they pause; the errors of a build at once.

use std::mem::MaybeUninit;

use arboleda::kinds::WideBvh;
use arboleda::{Block, BuildError, Index, MeshError, Options, Scene, SlicedBuild, Triangle, Vec3};
use arboleda_tests::parallel;
use arboleda_tests::random::Random;
use arboleda_tests::scenes::{self, crowds};

fn blocks(bytes: usize) -> Vec<Block> {
    vec![Block::ZERO; Block::count(bytes)]
}

/// A build at once: its bytes and its steps.
fn at_once(triangles: &[Triangle]) -> (Vec<u8>, u64) {
    let (scene, options) = (Scene::new(triangles), Options::DEFAULT);
    let mut scratch = blocks(Index::<WideBvh>::scratch_capacity(triangles.len(), &options));
    let scratch = Block::bytes(&mut scratch);
    let capacity = Index::<WideBvh>::capacity(&scene, &options, scratch).expect("a scene");
    let mut arena = blocks(capacity.index);
    let index = Index::<WideBvh>::build(&scene, &options, Block::bytes(&mut arena), scratch);
    (index.expect("room for the index").as_bytes().to_vec(), capacity.steps)
}

/// A build in slices of as many looks as `looks` says each time: its bytes and the number of steps.
fn in_slices(
    triangles: &[Triangle],
    room: usize,
    mut looks: impl FnMut() -> usize,
) -> (Vec<u8>, u64) {
    let mut scratch = blocks(SlicedBuild::scratch_capacity(triangles.len()));
    let mut arena = blocks(room);
    // What lies in the memory before does not matter.
    Block::bytes(&mut scratch).fill(0xa5);
    Block::bytes(&mut arena).fill(0x5a);
    let (arena, scratch) = (Block::bytes(&mut arena), Block::bytes(&mut scratch));
    let scene = Scene::new(triangles);
    let mut build = SlicedBuild::new(&scene, &Options::DEFAULT, arena, scratch).expect("memory");
    let mut steps = 1;
    while !build.step(looks()).expect("room for the index") {
        steps += 1;
    }
    // Further steps do nothing.
    assert_eq!(build.step(1), Ok(true));
    (build.finish().expect("it is done").as_bytes().to_vec(), steps)
}

/// A build that stays where it is begun has the bytes of one that is moved, and is over once it has returned the index.
#[test]
fn a_build_is_begun_and_finished_in_place() {
    for count in [0, 1, 2_000] {
        let triangles = scenes::soup(count, 7);
        let (expected, _) = at_once(&triangles);
        let (mut scratch, mut arena) =
            (blocks(SlicedBuild::scratch_capacity(count)), blocks(expected.len()));
        let (arena, scratch) = (Block::bytes(&mut arena), Block::bytes(&mut scratch));
        let (scene, options, given) = (Scene::new(&triangles), Options::DEFAULT, scratch.len());
        let mut room = MaybeUninit::uninit();
        let refused = SlicedBuild::begin_in(&mut room, &scene, &options, &mut [], &mut []);
        let needed = SlicedBuild::scratch_capacity(count);
        let full = BuildError::ScratchFull { needed, given: 0 };
        assert_eq!(refused.err(), (given > 0).then_some(full));

        let mut room = MaybeUninit::uninit();
        let build = SlicedBuild::begin_in(&mut room, &scene, &options, arena, scratch).unwrap();
        while !build.step(300).unwrap() {}
        assert!(build.finish_in_place().unwrap().as_bytes() == expected, "{count} triangles");
        let over = BuildError::ArenaFull { needed: expected.len(), given: 0 };
        assert_eq!(build.finish_in_place().err(), Some(over));
    }
}

#[test]
fn slices_write_the_bytes_of_a_build_at_once() {
    // Counts around leaves, around what is sorted at once, and around samples.
    let counts = [0, 1, 2, 8, 9, 95, 96, 511, 512, 513, 1_025, 3_000, 16_383, 16_385, 20_000];
    let mut all: Vec<Vec<Triangle>> = Vec::new();
    for (seed, count) in (0..).zip(counts) {
        all.push(scenes::soup(count, seed));
        all.push(scenes::lattice(count, 12, seed));
    }
    // No plane separates them, so splits are equal to the last level.
    all.push(scenes::coincident(5_000));
    all.push(crowds::concentric(3_000));
    all.push(crowds::slivers(3_000));
    all.push(crowds::needle_and_dust(6_000));
    all.push(crowds::large_and_small(6_000));
    parallel::map(all.len(), |at| {
        let triangles = &all[at];
        let (expected, work) = at_once(triangles);
        let mut random = Random::new(at as u64);
        for looks in [1, 7, 1_000, 50_000, usize::MAX] {
            // One look at a time would take minutes for the large scenes.
            if looks == 1 && triangles.len() > 1_100 {
                continue;
            }
            let (bytes, steps) = in_slices(triangles, expected.len(), || looks);
            assert!(bytes == expected, "{at}: {} triangles by {looks}", triangles.len());
            // A step that did more than it may would need fewer of them.
            let most = looks.saturating_add(20_000) as u64;
            assert!(steps >= work / most, "{at}: {steps} steps of {looks} for {work}");
            if looks == usize::MAX {
                assert_eq!(steps, 1);
            }
        }
        let (bytes, _) = in_slices(triangles, expected.len(), || random.below(3_000));
        assert!(bytes == expected, "{at}: {} triangles by chance", triangles.len());
    });
}

#[test]
fn errors_are_those_of_a_build_at_once_and_stay() {
    let good = scenes::soup(2_000, 1);
    let mut bad = good.clone();
    bad[1_999].b = Vec3::new(0.0, f32::NAN, 0.0);
    let needed = at_once(&good).0.len();
    let wrong_objects = vec![0; 3];
    let few_steps = Options { work_limit: Some(2_000), ..Options::DEFAULT };
    let some_steps = Options { work_limit: Some(17_000), ..Options::DEFAULT };
    let cases: [(Scene<'_>, Options, usize, BuildError); 5] = [
        (
            Scene::new(&bad),
            Options::DEFAULT,
            needed,
            BuildError::Mesh(MeshError::NonFiniteVertex { triangle: 1_999 }),
        ),
        (
            Scene::new(&good),
            Options::DEFAULT,
            needed - 64,
            BuildError::ArenaFull { needed, given: needed - 64 },
        ),
        (Scene::new(&good), Options::DEFAULT, 0, BuildError::ArenaFull { needed, given: 0 }),
        (Scene::new(&good), some_steps, needed, BuildError::TooMuchWork { limit: 17_000 }),
        (
            Scene::with_objects(&good, &wrong_objects),
            Options::DEFAULT,
            needed,
            BuildError::ObjectsMismatch { triangles: 2_000, objects: 3 },
        ),
    ];
    for (scene, options, room, expected) in cases {
        for looks in [100, usize::MAX] {
            let (mut arena, mut scratch) =
                (blocks(room), blocks(SlicedBuild::scratch_capacity(2_000)));
            let (arena, scratch) =
                (&mut Block::bytes(&mut arena)[..room], Block::bytes(&mut scratch));
            let mut build = SlicedBuild::new(&scene, &options, arena, scratch).expect("it begins");
            let error = loop {
                match build.step(looks) {
                    Ok(done) => assert!(!done, "{expected}"),
                    Err(error) => break error,
                }
            };
            assert_eq!(error, expected);
            assert_eq!(build.step(looks), Err(expected));
            assert_eq!(build.finish().err(), Some(expected));
        }
    }

    // What is known at once is said at once.
    let begin = |scene: &Scene<'_>, options: &Options, scratch: usize, from: usize| {
        let (mut arena, mut memory) = (blocks(needed), blocks(scratch + 64));
        let memory = &mut Block::bytes(&mut memory)[from..from + scratch];
        SlicedBuild::new(scene, options, Block::bytes(&mut arena), memory).err()
    };
    let (scene, all) = (Scene::new(&good), SlicedBuild::scratch_capacity(2_000));
    assert_eq!(begin(&scene, &Options::DEFAULT, all, 0), None);
    let full = BuildError::ScratchFull { needed: all, given: all - 1 };
    assert_eq!(begin(&scene, &Options::DEFAULT, all - 1, 0), Some(full));
    assert_eq!(begin(&scene, &Options::DEFAULT, all, 4), Some(BuildError::Misaligned));
    let too_much = BuildError::TooMuchWork { limit: 2_000 };
    assert_eq!(begin(&scene, &few_steps, all, 0), Some(too_much));
    let beside = BuildError::HoldsTriangles { kind: "wide-bvh" };
    let scene_beside = Scene::new(&good).beside();
    assert_eq!(begin(&scene_beside, &Options::DEFAULT, all, 0), Some(beside));
}

#[test]
fn a_build_needs_no_more_scratch_than_at_once() {
    for count in [0, 1, 9, 1_000, 1 << 20] {
        let whole = Index::<WideBvh>::scratch_capacity(count, &Options::DEFAULT);
        assert!(SlicedBuild::scratch_capacity(count) <= whole, "{count}");
    }
    let size = size_of::<SlicedBuild<'_, '_>>();
    assert!(size <= 13_312, "a build is {size} bytes, its page says 13 KB");
}

/// A build may be given up at any time, and its memory used again.
#[test]
fn memory_of_a_build_that_was_given_up_serves_again() {
    let triangles = scenes::soup(3_000, 2);
    let expected = at_once(&triangles).0;
    let mut arena = blocks(expected.len());
    let mut scratch = blocks(SlicedBuild::scratch_capacity(triangles.len()));
    let scene = Scene::new(&triangles);
    for steps in [0, 1, 5, 30, 60] {
        let (arena, scratch) = (Block::bytes(&mut arena), Block::bytes(&mut scratch));
        let mut build =
            SlicedBuild::new(&scene, &Options::DEFAULT, arena, scratch).expect("memory");
        for _ in 0..steps {
            let _ = build.step(2_000).expect("room for the index");
        }
    }
    let (arena, scratch) = (Block::bytes(&mut arena), Block::bytes(&mut scratch));
    let build = SlicedBuild::new(&scene, &Options::DEFAULT, arena, scratch).expect("memory");
    assert!(build.finish().expect("room for the index").as_bytes() == expected);
}
