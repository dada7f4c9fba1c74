//! Tests of indices beside a mesh that the caller keeps: accepted and refused meshes, memory, hostile index bytes.
//!
//! `arboleda_tests::checks` compares their answers with those of other indices, on the scenes of the other tests.

use arboleda::kinds::LeanBvh;
use arboleda::{BuildError, Index, IndexKind, Mesh, MeshError, OpenError, Options, Scene, Vec3};
use arboleda_tests::build::{Built, build_exactly};
use arboleda_tests::checks::hostile::{
    self, is_harmless_beside, small_options, some_rays, two_lattices, with_words_beside,
};
use arboleda_tests::checks::{all_hits, is_the_same};
use arboleda_tests::random::Random;
use arboleda_tests::scenes::welded;
use arboleda_tests::{rays, scenes};

const DEBUG: bool = cfg!(debug_assertions);

/// Lists the kinds that can lie beside a mesh.
fn kinds() -> impl Iterator<Item = IndexKind> {
    IndexKind::ALL.iter().copied().filter(|kind| !kind.holds_triangles())
}

#[test]
fn however_the_mesh_is_kept_the_index_is_the_same() {
    let triangles = [scenes::icosphere(2), scenes::soup(300, 7), two_lattices()].concat();
    let (vertices, corners) = welded(&triangles);
    assert!(vertices.len() < 2 * triangles.len(), "nothing is shared");
    let indexed = Mesh::Indexed { vertices: &vertices, corners: &corners };
    let rays = rays::around(&triangles, if DEBUG { 60 } else { 400 }, 2);
    let expected: Vec<_> = rays.iter().map(|ray| all_hits(&triangles, ray)).collect();
    let options = Options::default();
    for kind in kinds() {
        let own = Built::new(kind, &Scene::of(indexed), &options).expect("an ordinary scene");
        let same = Built::new(kind, &Scene::new(&triangles), &options).expect("the same scene");
        assert!(own.bytes() == same.bytes(), "{} of an indexed mesh", kind.name());

        let beside = build_exactly(kind, &Scene::of(indexed).beside(), &options);
        let beside = beside.expect("the same scene");
        let same = build_exactly(kind, &Scene::new(&triangles).beside(), &options);
        let same = same.expect("the same scene");
        assert!(beside.bytes() == same.bytes(), "{} beside triangles", kind.name());
        let saved = own.bytes().len() - beside.bytes().len();
        assert!(saved.abs_diff(size_of_val(&*triangles)) < 64, "{} saves {saved}", kind.name());

        for mesh in [indexed, Mesh::Triangles(&triangles)] {
            is_the_same(&beside.index_beside(mesh), &own.index(), &rays, &expected);
        }
    }
}

#[test]
fn whole_objects_beside_a_mesh() {
    let triangles = two_lattices();
    let objects: Vec<u32> = (0..triangles.len() as u32).map(|at| at / 3).collect();
    let rays = rays::around(&triangles, 100, 3);
    let expected: Vec<_> = rays.iter().map(|ray| all_hits(&triangles, ray)).collect();
    for kind in kinds() {
        let scene = Scene::with_objects(&triangles, &objects);
        let own = Built::new(kind, &scene, &small_options()).expect("an ordinary scene");
        let beside = Built::new(kind, &scene.beside(), &small_options()).expect("the same");
        let beside = beside.index_beside(scene.triangles());
        is_the_same(&beside, &own.index(), &rays, &expected);
    }
}

#[test]
fn a_lean_bvh_needs_at_most_12_bytes_a_triangle() {
    let triangles = scenes::icosphere(6);
    let (vertices, corners) = welded(&triangles);
    let scene = Scene::of(Mesh::Indexed { vertices: &vertices, corners: &corners }).beside();
    for kind in [IndexKind::LeanBvh, IndexKind::LeanBvhHierarchy] {
        let built = Built::new(kind, &scene, &Options::default()).expect("an ordinary scene");
        let (bytes, count) = (built.bytes().len(), triangles.len());
        assert!(bytes <= 12 * count, "{} takes {bytes} bytes for {count}", kind.name());
    }
}

#[test]
fn what_holds_the_triangles_is_not_built_beside_them() {
    let triangles = scenes::soup(30, 1);
    for &kind in IndexKind::ALL.iter().filter(|kind| kind.holds_triangles()) {
        let refusal = Built::new(kind, &Scene::new(&triangles).beside(), &Options::default());
        assert_eq!(refusal.err(), Some(BuildError::HoldsTriangles { kind: kind.name() }));
        // The bytes are not opened beside a mesh either.
        let own = Built::new(kind, &Scene::new(&triangles), &Options::default()).expect("alone");
        let error = kind.from_bytes_beside(own.bytes(), Mesh::Triangles(&triangles)).err();
        assert_eq!(error, Some(OpenError::HasTriangles), "{}", kind.name());
        // Bit 18 of the fourth word claims that the index lies beside a mesh.
        let mut forged = Built::copied(kind, own.bytes());
        forged.bytes_mut()[12..16]
            .iter_mut()
            .zip((1_u32 << 18).to_ne_bytes())
            .for_each(|(to, bit)| *to |= bit);
        let error = kind.from_bytes_beside(forged.bytes(), Mesh::Triangles(&triangles)).err();
        assert_eq!(error, Some(OpenError::Malformed { part: "header", at: 0 }));
    }
}

#[test]
fn an_index_takes_no_other_mesh_than_its_own() {
    let triangles = two_lattices();
    let (vertices, corners) = welded(&triangles);
    let mesh = Mesh::Indexed { vertices: &vertices, corners: &corners };
    for kind in kinds() {
        let name = kind.name();
        let own = Built::new(kind, &Scene::of(mesh), &small_options()).expect("ordinary");
        let beside = Built::new(kind, &Scene::of(mesh).beside(), &small_options());
        let beside = beside.expect("the same scene");

        // 1. A missing mesh, and a mesh for an index with triangles.
        assert_eq!(kind.from_bytes(beside.bytes()).err(), Some(OpenError::MeshMissing), "{name}");
        let error = kind.from_bytes_beside(own.bytes(), mesh).err();
        assert_eq!(error, Some(OpenError::HasTriangles), "{name}");

        // 2. A mesh of another length.
        let refused = |vertices: &[Vec3], corners: &[[u32; 3]]| {
            let mesh = Mesh::Indexed { vertices, corners };
            kind.from_bytes_beside(beside.bytes(), mesh).err()
        };
        let expected = triangles.len() as u32;
        for found in [0, 1, triangles.len() - 1] {
            let error = refused(&vertices, &corners[..found]);
            assert_eq!(error, Some(OpenError::OtherMeshLength { expected, found }), "{name}");
        }

        // 3. A mesh with a changed bit of a coordinate, with a changed sign, and with two triangles exchanged.
        for change in [1, 1 << 31] {
            for (vertex, axis) in [(0, 0), (5, 1), (vertices.len() - 1, 2)] {
                let mut changed = vertices.clone();
                let number = &mut changed[vertex].as_mut()[axis];
                *number = f32::from_bits(number.to_bits() ^ change);
                assert_eq!(refused(&changed, &corners), Some(OpenError::OtherMesh), "{name}");
            }
        }
        let mut exchanged = corners.clone();
        exchanged.swap(3, 17);
        assert_eq!(refused(&vertices, &exchanged), Some(OpenError::OtherMesh), "{name}");

        // 4. A mesh that is not valid.
        let mut wrong = corners.clone();
        wrong[7][2] = vertices.len() as u32;
        let error = MeshError::CornerOutOfRange {
            triangle: 7,
            corner: vertices.len() as u32,
            vertices: vertices.len(),
        };
        assert_eq!(refused(&vertices, &wrong), Some(OpenError::Mesh(error)), "{name}");
        let scene = Scene::of(Mesh::Indexed { vertices: &vertices, corners: &wrong });
        for scene in [scene, scene.beside()] {
            let refusal = Built::new(kind, &scene, &small_options()).err();
            assert_eq!(refusal, Some(BuildError::Mesh(error)), "{name}");
        }
        let mut infinite = vertices.clone();
        infinite[corners[2][1] as usize].y = f32::INFINITY;
        let first = corners.iter().position(|corners| {
            corners.iter().any(|&corner| !infinite[corner as usize].is_finite())
        });
        let error = MeshError::NonFiniteVertex { triangle: first.expect("the third") as u32 };
        assert_eq!(refused(&infinite, &corners), Some(OpenError::Mesh(error)), "{name}");
    }
}

#[test]
fn misaligned_memory_is_an_error_beside_a_mesh() {
    let triangles = scenes::soup(30, 1);
    let mesh = Mesh::Triangles(&triangles);
    let (scene, options) = (Scene::of(mesh).beside(), Options::default());
    for kind in kinds() {
        let built = Built::new(kind, &scene, &options).expect("an ordinary scene");
        let length = built.bytes().len();
        let mut longer = Built::copied(kind, &vec![0; length + 64]);
        let mut scratch = Built::copied(kind, &vec![0; kind.scratch_capacity(30, &options)]);
        for shift in [1, 4, 32, 63] {
            longer.bytes_mut()[shift..shift + length].copy_from_slice(built.bytes());
            let error = kind.from_bytes_beside(&longer.bytes()[shift..], mesh).err();
            assert_eq!(error, Some(OpenError::Misaligned), "{} at {shift}", kind.name());
            let arena = &mut longer.bytes_mut()[shift..];
            let error = kind.build(&scene, &options, arena, scratch.bytes_mut()).err();
            assert_eq!(error, Some(BuildError::Misaligned), "{} at {shift}", kind.name());
        }
    }
}

/// Builds a small index of each of [`kinds`] beside a mesh.
fn indices(mesh: Mesh<'_>, options: &Options) -> Vec<Built> {
    let built = kinds().map(|kind| Built::new(kind, &Scene::of(mesh).beside(), options));
    built.map(|built| built.expect("an ordinary scene")).collect()
}

#[test]
fn every_truncation_and_every_flipped_bit_is_harmless_beside_a_mesh() {
    let triangles = two_lattices();
    let (vertices, corners) = welded(&triangles);
    let mesh = Mesh::Indexed { vertices: &vertices, corners: &corners };
    let rays = some_rays(&triangles);
    for built in indices(mesh, &small_options()) {
        hostile::every_truncation_is_refused(&built, |cut| {
            built.kind().from_bytes_beside(cut, mesh).err()
        });
        hostile::every_flipped_bit_is_harmless(&built, |damaged| {
            is_harmless_beside(damaged, Some(mesh), &rays)
                + is_harmless_beside(damaged, None, &rays)
        });
    }
}

#[test]
fn random_words_beside_a_mesh_are_harmless() {
    let triangles = scenes::lattice(9, 2, 5);
    let mesh = Mesh::Triangles(&triangles);
    let rays = some_rays(&triangles);
    let one_cluster = Options { proximity: 1e6, size_classes: 1, ..Options::default() };
    for valid in indices(mesh, &one_cluster) {
        let mut random = Random::new(9);
        for _ in 0..if DEBUG { 2_000 } else { 20_000 } {
            let mut words: Vec<u32> = (0..random.below(60))
                .map(|_| {
                    let small = random.below(12) as u32;
                    random.pick(&[small, small, small | 1 << 31, u32::MAX, 7 << 28 | small])
                })
                .collect();
            if random.below(2) == 0 {
                words.extend(END_OF_LEAN);
            }
            is_harmless_beside(&with_words_beside(&valid, mesh, &words), Some(mesh), &rays);
        }
    }
}

/// Zeros at the end of a lean BVH.
const END_OF_LEAN: [u32; 38] = [0; 38];

/// Forged words of a lean BVH are refused. The core's `indices/wide/quantised/ids.rs` describes the format.
#[test]
fn forged_lean_bvhs_are_refused() {
    const LEAF: u32 = 1 << 31;
    let leaf = |place: u32, count: u32| LEAF | (count - 1) << 28 | place;
    let triangles = scenes::lattice(3, 2, 5);
    let mesh = Mesh::Triangles(&triangles);
    let scene = Scene::of(mesh).beside();
    let valid = Built::new(IndexKind::LeanBvh, &scene, &Options::default());
    let valid = valid.expect("an ordinary scene");
    let largest = 4.0_f32.to_bits();
    let read = |words: &[u32]| {
        let words = [words, &END_OF_LEAN].concat();
        let forged = with_words_beside(&valid, mesh, &words);
        Index::<LeanBvh>::from_bytes_beside(forged.bytes(), mesh).err()
    };
    let refused = |what: &str, words: &[u32]| {
        let error = read(words);
        assert!(matches!(error, Some(OpenError::Malformed { .. })), "{what}: {error:?}");
    };
    assert_eq!(read(&[leaf(2, 3), largest, 0, 1, 2]), None);
    refused("nothing", &[]);
    refused("no head", &[leaf(2, 3)]);
    refused("a root that is the head", &[0, largest, 0, 1, 2]);
    refused("a root that is no node", &[2, largest, 0, 1, 2]);
    refused("too few triangles", &[leaf(2, 2), largest, 0, 1]);
    refused("a leaf that is longer than the index", &[leaf(2, 4), largest, 0, 1, 2]);
    refused("a leaf that begins later", &[leaf(3, 2), largest, 0, 1, 2]);
    refused("a triangle that does not exist", &[leaf(2, 3), largest, 0, 1, 3]);
    refused("words left over", &[leaf(2, 3), largest, 0, 1, 2, 0]);
    // A node whose only child is itself, or the head, or does not follow the node; then a node with more children.
    for (root, child) in
        [(2, 2), (2, 0), (2, leaf(12, 3)), (2, leaf(13, 3)), (1 << 28 | 2, leaf(12, 3))]
    {
        let words = [&[root, largest], &[0; 6][..], &[child], &[0; 3], &[0, 1, 2]].concat();
        assert_eq!(
            read(&words).is_none(),
            (root, child) == (2, leaf(12, 3)),
            "{root:#x} {child:#x}"
        );
    }
}

#[test]
fn a_copied_image_may_be_read_beside_any_form_of_its_mesh() {
    let triangles = scenes::icosphere(2);
    let (vertices, corners) = welded(&triangles);
    let mesh = Mesh::Indexed { vertices: &vertices, corners: &corners };
    let built = Built::new(IndexKind::LeanBvh, &Scene::of(mesh).beside(), &Options::default());
    let copy = Built::copied(IndexKind::LeanBvh, built.expect("ordinary").bytes());
    let index = copy.index_beside(Mesh::Triangles(&triangles));
    assert_eq!(index.as_bytes(), copy.bytes());
    assert_eq!(index.sections().triangles().len(), triangles.len());
}
