//! Tests of builds in pieces: the bytes of a build at once, in any room; the errors of a build at once.

use arboleda::kinds::{Clustered, Linear};
use arboleda::{
    AnyIndex, Block, BuildError, IndexKind, Mesh, MeshError, Options, PiecewiseBuild, Scene,
    Triangle, Vec3, clusters,
};
use arboleda_tests::build::Built;
use arboleda_tests::parallel::AtOnce;
use arboleda_tests::scenes::{self, crowds};

fn blocks(bytes: usize) -> Vec<Block> {
    vec![Block::ZERO; Block::count(bytes)]
}

/// All kinds that can be built in pieces.
fn kinds() -> impl Iterator<Item = IndexKind> {
    IndexKind::ALL.iter().copied().filter(|kind| kind.can_be_built_in_pieces())
}

/// Builds in pieces, each in a room of `least` bytes or, if it is too small, of exactly what it needs. The pieces are
/// copied to a storage of zeros. Returns it with the number of steps.
fn in_pieces(
    kind: IndexKind,
    scene: &Scene<'_>,
    options: &Options,
    least: usize,
) -> Result<(Vec<u8>, u64), BuildError> {
    let mut scratch = blocks(clusters::scratch_capacity(scene.triangles().len()));
    let found = clusters::find_with(scene, options, Block::bytes(&mut scratch), &AtOnce)?;
    let needed = kind.memory_in_pieces(&found, options);
    let mut memory = blocks(needed);
    let memory = &mut Block::bytes(&mut memory)[..needed];
    // What lies in the memory before does not matter.
    memory.fill(0xa5);
    let mut build = kind.build_in_pieces(scene, options, &found, memory)?;
    let mut storage = Vec::new();
    let mut write = |offset: usize, bytes: &[u8]| {
        storage.resize(storage.len().max(offset + bytes.len()), 0);
        storage[offset..][..bytes.len()].copy_from_slice(bytes);
    };
    if let Mesh::Triangles(triangles) = scene.triangles() {
        write(build.triangles_offset(), bytemuck::cast_slice(triangles));
    }
    let mut room = blocks(least);
    let mut end = build.length();
    loop {
        let given = least.min(room.len() * 64);
        let needed = match build.build_next(&mut Block::bytes(&mut room)[..given]) {
            Ok(Some(piece)) => {
                assert_eq!(piece.offset, end, "pieces follow each other");
                write(piece.offset, piece.bytes);
                end += piece.bytes.len();
                continue;
            }
            Ok(None) => break,
            Err(BuildError::ArenaFull { needed, given: told }) => {
                assert_eq!(told, given);
                needed
            }
            Err(error) => return Err(error),
        };
        let mut exact = blocks(needed);
        let exact = &mut Block::bytes(&mut exact)[..needed];
        let refused = build.build_next(&mut exact[..needed - 1]);
        assert_eq!(refused.err(), Some(BuildError::ArenaFull { needed, given: needed - 1 }));
        exact.fill(0x5a);
        let piece = build.build_next(exact)?.expect("a cluster is left");
        write(piece.offset, piece.bytes);
        end += piece.bytes.len();
    }
    let (count, built) = build.progress();
    assert_eq!((built, count), (found.count(), found.count()));
    let (steps, length) = (build.steps(), build.length());
    assert_eq!(length, end);
    for piece in build.finish()? {
        write(piece.offset, piece.bytes);
    }
    write(length, &[]);
    Ok((storage, steps))
}

/// Builds at once: the bytes and the number of steps.
fn at_once(kind: IndexKind, scene: &Scene<'_>, options: &Options) -> (Vec<u8>, u64) {
    let mut scratch = blocks(kind.scratch_capacity(scene.triangles().len(), options));
    let capacity = kind.capacity(scene, options, Block::bytes(&mut scratch)).expect("a scene");
    let built = Built::new(kind, scene, options).expect("a scene");
    (built.bytes().to_vec(), capacity.steps)
}

/// Scenes of many clusters, of one, of one for each triangle, and of none.
fn all_scenes() -> Vec<Vec<Triangle>> {
    let mut groups = scenes::lattice(300, 5, 1);
    groups.extend(scenes::moved(&scenes::soup(500, 2), 10.0, Vec3::new(100.0, -3.0, 0.1)));
    groups.extend(scenes::moved(&scenes::icosphere(2), 0.37, Vec3::new(-40.0, 7.0, 1e-3)));
    groups.extend(scenes::flat(6, 1));
    let apart = |number: u8| Vec3::X * (9.0 * f32::from(number));
    let singles =
        (0..100).map(apart).map(|at| Triangle::new(at, at + Vec3::Y, at + Vec3::Z)).collect();
    vec![
        groups,
        singles,
        scenes::icosphere(3),
        scenes::coincident(50),
        crowds::large_and_small(9_000),
        scenes::soup(1, 3),
        Vec::new(),
    ]
}

#[test]
fn pieces_are_the_bytes_of_a_build_at_once() {
    let mut counts = Vec::new();
    for triangles in all_scenes() {
        let (scene, options) = (Scene::new(&triangles), Options::DEFAULT);
        for kind in kinds() {
            let expected = at_once(kind, &scene, &options);
            for least in [0, 64, 1 << 20] {
                let found = in_pieces(kind, &scene, &options, least).expect("a scene");
                assert!(found == expected, "{}, {} triangles", kind.name(), triangles.len());
            }
            let opened = Built::copied(kind, &expected.0);
            counts.push(opened.index().cluster_tree().cluster_count());
        }
    }
    assert!(counts.contains(&0) && counts.contains(&1) && counts.contains(&100), "{counts:?}");
    assert!(counts.iter().any(|count| (2..100).contains(count)), "{counts:?}");
}

#[test]
fn objects_stay_whole() {
    let triangles = &all_scenes()[0];
    let objects: Vec<u32> = (0..triangles.len() as u32).map(|id| id / 7 % 40).collect();
    let (scene, options) = (Scene::with_objects(triangles, &objects), Options::DEFAULT);
    for kind in kinds() {
        let expected = at_once(kind, &scene, &options);
        assert!(in_pieces(kind, &scene, &options, 4096) == Ok(expected), "{}", kind.name());
    }
}

#[test]
fn beside_a_mesh_there_are_no_triangles_in_the_pieces() {
    let (vertices, corners) = scenes::welded(&all_scenes()[0]);
    let mesh = Mesh::Indexed { vertices: &vertices, corners: &corners };
    let (scene, options) = (Scene::of(mesh).beside(), Options::DEFAULT);
    for kind in kinds() {
        let (expected, steps) = at_once(kind, &scene, &options);
        let found = in_pieces(kind, &scene, &options, 4096);
        assert!(found == Ok((expected.clone(), steps)), "{}", kind.name());
        Built::copied(kind, &expected).index_beside(mesh);
    }
}

#[test]
fn what_cannot_be_built_in_pieces_is_refused() {
    let triangles = scenes::soup(20, 1);
    let (scene, options) = (Scene::new(&triangles), Options::DEFAULT);
    for &kind in IndexKind::ALL.iter().filter(|kind| !kind.can_be_built_in_pieces()) {
        let error = in_pieces(kind, &scene, &options, 0).err();
        assert_eq!(error, Some(BuildError::NotInPieces { kind: kind.name() }));
    }
    type Kind = Clustered<Linear>;
    let mut scratch = blocks(clusters::scratch_capacity(20));
    let found = clusters::find(&scene, &options, Block::bytes(&mut scratch)).unwrap();
    let needed = PiecewiseBuild::memory_bytes::<Kind>(&found, &options);
    let mut memory = blocks(needed + 64);
    let memory = Block::bytes(&mut memory);

    let few = Scene::new(&triangles[..19]);
    let refused = PiecewiseBuild::new::<Kind>(&few, &options, &found, memory).err();
    assert_eq!(refused, Some(BuildError::OtherClusters { triangles: 19, clustered: 20 }));
    let given = needed - 1;
    let refused = PiecewiseBuild::new::<Kind>(&scene, &options, &found, &mut memory[..given]).err();
    assert_eq!(refused, Some(BuildError::ScratchFull { needed, given }));
    let refused = PiecewiseBuild::new::<Kind>(&scene, &options, &found, &mut memory[4..]).err();
    assert_eq!(refused, Some(BuildError::Misaligned));

    let mut broken = triangles.clone();
    broken[7].b.x = f32::NAN;
    let refused = PiecewiseBuild::new::<Kind>(&Scene::new(&broken), &options, &found, memory).err();
    assert_eq!(refused, Some(BuildError::Mesh(MeshError::NonFiniteVertex { triangle: 7 })));
    let wrong = Options { leaf_capacity: 0, ..options };
    let refused = PiecewiseBuild::new::<Kind>(&scene, &wrong, &found, memory).err();
    assert!(matches!(refused, Some(BuildError::InvalidOption { .. })));

    let mut build = PiecewiseBuild::new::<Kind>(&scene, &options, &found, memory).unwrap();
    let mut room = blocks(4096);
    let refused = build.build_next(&mut Block::bytes(&mut room)[1..]).err();
    assert_eq!(refused, Some(BuildError::Misaligned));
    assert_eq!(build.finish().err(), Some(BuildError::PiecesLeft { left: found.count() }));
}

#[test]
fn the_limit_of_work_is_that_of_the_whole_build() {
    let triangles = &all_scenes()[0];
    let scene = Scene::new(triangles);
    for kind in kinds() {
        let (bytes, steps) = at_once(kind, &scene, &Options::DEFAULT);
        let limited = |limit| Options { work_limit: Some(limit), ..Options::DEFAULT };
        let enough = in_pieces(kind, &scene, &limited(steps), 4096);
        // An automatic grid is planned for the steps that are left.
        if kind != IndexKind::GridHierarchy {
            assert!(enough == Ok((bytes, steps)), "{}", kind.name());
        }
        if let Some(limit) = steps.checked_sub(1) {
            let refused = in_pieces(kind, &scene, &limited(limit), 4096).err();
            let once = Built::new(kind, &scene, &limited(limit)).err();
            assert_eq!(refused, once, "{}", kind.name());
        }
    }
}

#[test]
fn the_bytes_open() {
    let triangles = &all_scenes()[0];
    let (bytes, _) =
        in_pieces(IndexKind::OctreeHierarchy, &Scene::new(triangles), &Options::DEFAULT, 0)
            .unwrap();
    let mut aligned = blocks(bytes.len());
    Block::bytes(&mut aligned)[..bytes.len()].copy_from_slice(&bytes);
    let opened = AnyIndex::from_bytes(Block::bytes(&mut aligned)).unwrap();
    assert_eq!(opened.kind(), IndexKind::OctreeHierarchy);
}
