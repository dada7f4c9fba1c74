//! Tests of the automatic selection of an index: its choice, its limit of memory, its determinism.

use arboleda::select::{Expectation, Selection, select};
use arboleda::{Block, BuildError, Float64, IndexKind, MeshError, Options, Scene, Triangle, Vec3};
use arboleda_tests::build::Built;
use arboleda_tests::{rays, scenes};

const ROOM: usize = 4 << 20;

fn scratch_for(triangles: &[Triangle]) -> Vec<Block> {
    let options = Options::default();
    let bytes = IndexKind::ALL.iter().map(|k| k.scratch_capacity(triangles.len(), &options)).max();
    vec![Block::ZERO; Block::count(bytes.unwrap_or(0))]
}

fn select_within(
    arena_bytes: usize,
    triangles: &[Triangle],
    candidates: &[IndexKind],
    rays: &[arboleda::Ray],
) -> Result<Selection, BuildError> {
    let mut arena = vec![Block::ZERO; Block::count(arena_bytes)];
    let mut scratch = scratch_for(triangles);
    select(
        &Scene::new(triangles).rays(rays).expecting(u64::MAX),
        &Options::default(),
        candidates,
        &mut Block::bytes(&mut arena)[..arena_bytes],
        Block::bytes(&mut scratch),
    )
}

/// Makes two spheres, far apart.
fn two_spheres() -> Vec<Triangle> {
    let mut triangles = scenes::icosphere(3);
    triangles.extend(scenes::moved(&scenes::icosphere(3), 2.0, Vec3::new(300.0, 4.0, -1.0)));
    triangles
}

#[test]
fn a_few_triangles_need_no_tree() {
    let triangles = [Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y)];
    let kind = select_within(ROOM, &triangles, IndexKind::ALL, &[]).unwrap().kind();
    let built = Built::new(kind, &Scene::new(&triangles), &Options::default()).unwrap();
    assert_eq!(built.index().check().unwrap().inner_nodes, 0, "{}", kind.name());
    // A leaf of the wide BVH tests one triangle faster than the linear scan does.
    assert_eq!(kind, IndexKind::WideBvh);
}

#[test]
fn thousands_of_triangles_do() {
    let triangles = two_spheres();
    let selection = select_within(ROOM, &triangles, IndexKind::ALL, &[]).unwrap();
    assert_ne!(selection.kind(), IndexKind::Linear);
    assert_eq!(selection.candidates().len(), IndexKind::ALL.len());
    // The chosen index is the cheapest, or within 3% of it.
    for candidate in selection.candidates() {
        if let Expectation::Fits(cost) = candidate.expectation {
            assert!(
                cost.nanoseconds * 1.03 >= selection.cost().nanoseconds,
                "{}",
                candidate.kind.name()
            );
        }
    }
}

/// With `f64` in software all trees cost about the same, because the hit costs most, and the linear scan is relatively
/// cheap; with `f64` in hardware it is far behind.
///
/// # Measured
/// Instructions a ray on a Cortex-M4, with 200 triangles, of which 6,500 are for the hits of two rays in three:
///
/// - 8,800 in the grid hierarchy
/// - 9,200 in the bounding volume hierarchy
/// - 9,500 in wide BVHs
/// - 9,900 in the octree hierarchy
/// - 11,100 in the kd-tree
/// - 36,400 in the linear scan
#[test]
fn software_floats_are_weighed_as_they_were_counted() {
    let triangles = scenes::soup(200, 1);
    let expected = |float64, kind| {
        let options = Options { float64, ..Options::default() };
        let mut arena = vec![Block::ZERO; Block::count(ROOM)];
        let mut scratch = scratch_for(&triangles);
        let (arena, scratch) = (Block::bytes(&mut arena), Block::bytes(&mut scratch));
        let selection = select(&Scene::new(&triangles), &options, &[kind], arena, scratch);
        selection.unwrap().cost().nanoseconds
    };
    let gain = |float64, kind| expected(float64, IndexKind::Linear) / expected(float64, kind);
    for kind in [IndexKind::OctreeHierarchy, IndexKind::Bvh, IndexKind::KdTree] {
        let (hardware, software) = (gain(Float64::Hardware, kind), gain(Float64::Software, kind));
        assert!(software < 0.6 * hardware, "{}: {hardware}, {software}", kind.name());
        let wide = gain(Float64::Software, IndexKind::WideBvh) / software;
        assert!((0.75..1.25).contains(&wide), "{}: {wide}", kind.name());
    }
}

/// The linear scan is not run; its computed counters are those of a run.
#[test]
fn the_linear_scan_is_reckoned_exactly() {
    let triangles = two_spheres();
    let asked = rays::around(&triangles, 200, 1);
    let selection = select_within(ROOM, &triangles, &[IndexKind::Linear], &asked).unwrap();
    let built = Built::new(IndexKind::Linear, &Scene::new(&triangles), &Options::default());
    let built = built.unwrap();
    let mut counters = arboleda::Counters::default();
    for ray in &asked {
        built.index().closest_hit_counted(ray, &mut counters);
    }
    let rays = asked.len() as f64;
    assert_eq!((selection.cost().nodes * rays).round(), counters.nodes_visited as f64);
    assert_eq!((selection.cost().tests * rays).round(), counters.triangle_tests as f64);
}

#[test]
fn the_choice_is_the_same_each_time_and_everywhere() {
    let triangles = two_spheres();
    let first = select_within(ROOM, &triangles, IndexKind::ALL, &[]).unwrap();
    assert_eq!(Ok(&first), select_within(ROOM, &triangles, IndexKind::ALL, &[]).as_ref());
    // Golden values from x86_64. They depend on the sample of rays, and on the BVH, whose build seldom changes.
    let bvh = select_within(ROOM, &triangles, &[IndexKind::Bvh, IndexKind::Bvh], &[]).unwrap();
    assert_eq!(bvh.candidates().len(), 1);
    assert_eq!((bvh.cost().nodes, bvh.cost().tests), (6.649_414_062_5, 1.853_515_625));
}

#[test]
fn what_does_not_fit_is_left_out_with_the_reason() {
    let triangles = two_spheres();
    let all = select_within(ROOM, &triangles, IndexKind::ALL, &[]).unwrap();
    let sizes: Vec<usize> = all
        .candidates()
        .iter()
        .filter_map(|candidate| match candidate.expectation {
            Expectation::Fits(cost) => Some(cost.bytes),
            Expectation::LeftOut(_) => None,
        })
        .collect();
    assert_eq!(sizes.len(), IndexKind::ALL.len());

    // 1. An arena too small for the best index.
    let tight = all.cost().bytes - 1;
    let other = select_within(tight, &triangles, IndexKind::ALL, &[]).unwrap();
    assert_ne!(other.kind(), all.kind());
    assert!(other.cost().bytes <= tight);
    let left_out = format!("{} left out: the index needs", all.kind().name());
    assert!(other.to_string().contains(&left_out), "{other}");

    // 2. An arena exactly large enough for the smallest index, and one byte less.
    let least = sizes.iter().copied().min().unwrap();
    let smallest = select_within(least, &triangles, IndexKind::ALL, &[]).unwrap();
    assert_eq!(smallest.cost().bytes, least);
    assert_eq!(
        select_within(least - 1, &triangles, IndexKind::ALL, &[]),
        Err(BuildError::ArenaFull { needed: least, given: least - 1 })
    );
}

#[test]
fn nothing_to_index_and_nothing_to_choose_from() {
    let empty = select_within(ROOM, &[], IndexKind::ALL, &[]).unwrap();
    assert_eq!(empty.cost().tests, 0.0);
    assert!(!empty.to_string().is_empty());
    assert!(matches!(
        select_within(ROOM, &two_spheres(), &[], &[]),
        Err(BuildError::InvalidOption { option: "candidates", .. })
    ));
}

/// In these scenes the sample cannot make all of its rays.
#[test]
fn extreme_scenes_are_no_trouble() {
    let far = f32::MAX;
    let huge = Triangle::new(Vec3::splat(-far), Vec3::splat(far), Vec3::new(far, -far, 0.0));
    let tiny = Triangle::new(Vec3::ZERO, Vec3::X * 1e-45, Vec3::Y * 1e-45);
    let point = Triangle::new(Vec3::ONE, Vec3::ONE, Vec3::ONE);
    for triangles in [&[huge][..], &[tiny], &[point], &[huge, tiny, point], &[point; 40]] {
        let selection = select_within(ROOM, triangles, IndexKind::ALL, &[]).unwrap();
        assert!(selection.cost().nanoseconds.is_finite());
    }
    let nan = [Triangle::new(Vec3::NAN, Vec3::X, Vec3::Y)];
    let error = select_within(ROOM, &nan, IndexKind::ALL, &[]).unwrap_err();
    assert_eq!(error, BuildError::Mesh(MeshError::NonFiniteVertex { triangle: 0 }));
}

#[test]
fn the_reason_has_the_numbers() {
    let triangles = two_spheres();
    let selection = select_within(ROOM, &triangles, IndexKind::ALL, &[]).unwrap();
    let (text, cost) = (selection.to_string(), selection.cost());
    assert!(text.starts_with(selection.kind().name()), "{text}");
    for part in [
        format!("{:.1} nodes", cost.nodes),
        format!("{:.1} tests", cost.tests),
        format!("{:.2} us", cost.nanoseconds / 1e3),
        "next: ".to_owned(),
        "times as much".to_owned(),
    ] {
        assert!(text.contains(&part), "{text} lacks {part}");
    }
}

/// Selects among all kinds for a number of rays.
fn select_for(triangles: &[Triangle], rays: u64) -> Selection {
    let mut arena = vec![Block::ZERO; Block::count(64 << 20)];
    let mut scratch = scratch_for(triangles);
    let scene = Scene::new(triangles).expecting(rays);
    let (arena, scratch) = (Block::bytes(&mut arena), Block::bytes(&mut scratch));
    select(&scene, &Options::default(), IndexKind::ALL, arena, scratch).unwrap()
}

/// For one ray no build is worth its cost. For some rays only cheap builds are. For many rays all candidates are tried.
#[test]
fn the_more_rays_the_more_is_tried() {
    let triangles = scenes::icosphere(5);
    let tried = |selection: &Selection| {
        let fits = |candidate: &&arboleda::select::Candidate| {
            matches!(candidate.expectation, Expectation::Fits(_))
        };
        selection.candidates().iter().filter(fits).count()
    };
    let one = select_for(&triangles, 1);
    assert_eq!((one.kind(), tried(&one)), (IndexKind::Linear, 1));
    assert!(one.to_string().contains("; not worth building: octree, octree-hierarchy, "), "{one}");
    let some = select_for(&triangles, 10_000);
    assert_eq!(some.kind(), IndexKind::WideBvh);
    assert!((2..IndexKind::ALL.len()).contains(&tried(&some)), "{some}");
    let many = select_for(&triangles, u64::MAX);
    assert_eq!(tried(&many), IndexKind::ALL.len());
}

/// Trying candidates costs at most a few builds of the chosen index, even on scenes that no plane separates.
#[test]
fn trying_is_bounded_by_the_chosen_build() {
    for (name, crowd) in arboleda_tests::scenes::crowds::ALL {
        let triangles = crowd(2_000);
        let (mut arena, mut scratch) = (vec![Block::ZERO; 1 << 20], scratch_for(&triangles));
        let (arena, scratch) = (Block::bytes(&mut arena), Block::bytes(&mut scratch));
        let scene = Scene::new(&triangles);
        let chosen = select(&scene, &Options::default(), IndexKind::ALL, arena, scratch).unwrap();
        let spent: f64 = chosen
            .candidates()
            .iter()
            .filter_map(|candidate| match candidate.expectation {
                Expectation::Fits(cost) => Some(cost.build_nanoseconds),
                Expectation::LeftOut(_) => None,
            })
            .sum();
        let rays = 16.0 * triangles.len() as f64 * chosen.cost().nanoseconds;
        let few = (4.0 * chosen.cost().build_nanoseconds).max(rays).max(8e6);
        assert!(spent <= few, "{name}: {spent} ns of {few}: {chosen}");
    }
}
