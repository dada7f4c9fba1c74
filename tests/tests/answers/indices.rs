//! Tests that every index gives the answers of the linear scan, bit for bit, in exactly the memory that it requires: on
//! random scenes, and on scenes that are likely to reveal defects.

use arboleda::{
    BuildError, Counters, IndexKind, Level, MeshError, Options, Ray, Scene, Triangle, Vec3,
};
use arboleda_tests::build::{Built, build_exactly};
use arboleda_tests::checks::every_index_equals_linear;
use arboleda_tests::pairs::{self, Family};
use arboleda_tests::random::Random;
use arboleda_tests::{parallel, rays, scenes};
use proptest::prelude::*;

const DEBUG: bool = cfg!(debug_assertions);

/// Draws options among all levels and leaf capacities that matter on small scenes.
fn options() -> impl Strategy<Value = Options> {
    let level = prop_oneof![Just(Level::Automatic), (0..=6_u32).prop_map(Level::AtMost)];
    let proximity = prop_oneof![Just(0.0_f32), Just(0.5), 0.0..4.0_f32];
    let least_side = prop_oneof![Just(0.0_f32), Just(1.0), 0.0..1.0_f32];
    (level, 1..=12_u32, proximity, 1..=4_u32, least_side).prop_map(
        |(level, leaf_capacity, proximity, size_classes, least_side)| Options {
            leaf_capacity,
            level,
            least_side,
            proximity,
            size_classes,
            ..Options::default()
        },
    )
}

fn point(coordinate: impl Strategy<Value = f32> + Clone) -> impl Strategy<Value = Vec3> {
    (coordinate.clone(), coordinate.clone(), coordinate).prop_map(|(x, y, z)| Vec3::new(x, y, z))
}

fn triangles(
    coordinate: impl Strategy<Value = f32> + Clone,
    most: usize,
) -> impl Strategy<Value = Vec<Triangle>> {
    let corner = || point(coordinate.clone());
    let triangle = (corner(), corner(), corner()).prop_map(|(a, b, c)| Triangle::new(a, b, c));
    prop::collection::vec(triangle, 0..most)
}

fn rays(coordinate: impl Strategy<Value = f32> + Clone) -> impl Strategy<Value = Vec<Ray>> {
    let interval = prop_oneof![
        Just((0.0, f32::INFINITY)),
        Just((f32::NEG_INFINITY, f32::INFINITY)),
        Just((0.0, 1.0)),
        Just((1.0, 1.0)),
    ];
    let ray = (point(coordinate.clone()), point(coordinate), interval).prop_filter_map(
        "a direction of zero",
        |(origin, direction, (t_min, t_max))| {
            Ray::with_interval(origin, direction, t_min, t_max).ok()
        },
    );
    prop::collection::vec(ray, 1..40)
}

fn whole() -> impl Strategy<Value = f32> + Clone {
    (-5..=5_i32).prop_map(|i| i as f32)
}

/// Draws any finite float, most of ordinary size.
fn float() -> impl Strategy<Value = f32> + Clone {
    let ordinary = -8.0..8.0_f32;
    let any = prop::num::f32::NORMAL | prop::num::f32::SUBNORMAL | prop::num::f32::ZERO;
    prop_oneof![8 => ordinary, 2 => whole(), 1 => any]
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: if DEBUG { 40 } else { 250 },
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn lattice_scenes(
        triangles in triangles(whole(), 60),
        rays in rays(whole()),
        options in options(),
    ) {
        every_index_equals_linear(&triangles, &rays, &options);
    }

    #[test]
    fn float_scenes(
        triangles in triangles(float(), 60),
        rays in rays(float()),
        options in options(),
    ) {
        every_index_equals_linear(&triangles, &rays, &options);
    }
}

/// Lists the scenes of the edge matrix, with their names.
fn edge_scenes() -> Vec<(&'static str, Vec<Triangle>)> {
    let mut mixed = scenes::soup(120, 5);
    mixed.extend(scenes::huge(20, 6));
    mixed.extend(scenes::tiny(60, 7));
    let two_groups = [
        scenes::lattice(150, 4, 8),
        scenes::moved(&scenes::lattice(150, 4, 9), 1.0, Vec3::new(1000.0, 0.0, -500.0)),
    ];
    vec![
        ("none", Vec::new()),
        ("one", scenes::soup(1, 1)),
        ("one without area", vec![Triangle::new(Vec3::ONE, Vec3::ONE, Vec3::ONE)]),
        ("coincident", scenes::coincident(16)),
        ("flat across x", scenes::flat(9, 0)),
        ("flat across y", scenes::flat(9, 1)),
        ("flat across z", scenes::flat(9, 2)),
        ("huge", scenes::huge(200, 2)),
        ("tiny", scenes::tiny(200, 3)),
        ("touching boxes", scenes::touching_boxes(2)),
        ("a sphere", scenes::icosphere(2)),
        ("a sphere far away", scenes::moved(&scenes::icosphere(2), 1.0, Vec3::splat(1e6))),
        ("two groups", two_groups.concat()),
        ("soup", scenes::soup(400, 4)),
        ("all sizes", mixed),
    ]
}

#[test]
fn edge_scenes_with_hard_rays() {
    let scenes = edge_scenes();
    let options: Vec<Options> = [
        (Level::Automatic, 12),
        (Level::Automatic, 1),
        (Level::AtMost(0), 1),
        (Level::AtMost(3), 2),
    ]
    .map(|(level, leaf_capacity)| Options { level, leaf_capacity, ..Options::default() })
    .to_vec();
    let ray_count = if DEBUG { 16 } else { 40 };
    let found = parallel::map(scenes.len() * options.len(), |job| {
        let (name, triangles) = &scenes[job % scenes.len()];
        let rays = rays::around(triangles, ray_count, job as u64);
        every_index_equals_linear(triangles, &rays, &options[job / scenes.len()]);
        let hits = rays
            .iter()
            .filter(|ray| triangles.iter().any(|t| arboleda::intersect(ray, t).is_some()));
        (*name, hits.count())
    });
    // A scene whose rays all miss would show nothing.
    for (name, hits) in found {
        let empty = ["none", "one without area"].contains(&name);
        assert!(empty == (hits == 0), "{name}: {hits} hits");
    }
}

/// Pairs that are hard for the kernel are hard for the boxes and filters before it too, as lines and as half-lines.
#[test]
fn hard_pairs_together() {
    let rounds = if DEBUG { 2 } else { 20 };
    parallel::map(Family::ALL.len() * rounds, |job| {
        let mut random = Random::new(job as u64);
        let family = Family::ALL[job % Family::ALL.len()];
        let pairs = [(); 6].map(|()| family.pair(&mut random));
        let half = |(line, triangle): &(Ray, Triangle)| {
            pairs::half_line(line, arboleda::intersect(line, triangle).map(|hit| hit.t))
        };
        let rays: Vec<Ray> =
            pairs.iter().map(|pair| pair.0).chain(pairs.iter().map(half)).collect();
        every_index_equals_linear(&pairs.map(|pair| pair.1), &rays, &Options::default());
    });
}

#[test]
fn whole_objects_are_indexed_like_triangles() {
    let mut random = Random::new(11);
    for round in 0..if DEBUG { 20 } else { 60 } {
        let triangles = scenes::lattice(80, 5, round);
        let objects: Vec<u32> = triangles.iter().map(|_| random.below(12) as u32).collect();
        let scene = Scene::with_objects(&triangles, &objects);
        for &kind in IndexKind::ALL {
            let built = build_exactly(kind, &scene, &Options::default());
            let built = built.unwrap_or_else(|error| panic!("{}: {error}", kind.name()));
            for ray in rays::around(&triangles, 40, round) {
                let expected = arboleda_tests::checks::all_hits(&triangles, &ray);
                arboleda_tests::checks::answers_equal(&built.index(), &ray, &expected);
            }
        }
    }
}

/// The cells of grids depend on the sample of rays, if enough rays pass the grid. No other index depends on the sample.
#[test]
fn grids_go_by_the_rays_given() {
    let near = scenes::icosphere(3);
    let far = scenes::moved(&near, 1.0, Vec3::new(500.0, 0.0, 0.0));
    let triangles = [near, far].concat();
    // All rays stay around one of the spheres, so a grid over both may be as fine as that sphere needs.
    let some = rays::around(&triangles[..triangles.len() / 2], 300, 1);
    let inside = |rays| {
        let built = |&kind: &IndexKind| {
            build_exactly(kind, &Scene::new(&triangles).rays(rays), &Options::default())
        };
        IndexKind::ALL.iter().map(built).collect::<Result<Vec<_>, _>>().unwrap()
    };
    let (without, few, with) = (inside(&[]), inside(&some[..3]), inside(&some));
    for ((without, few), with) in without.iter().zip(few).zip(with) {
        let name = with.kind().name();
        assert_eq!(without.bytes(), few.bytes(), "{name}");
        assert_eq!(without.bytes() != with.bytes(), with.kind().uses_rays(), "{name}");
        assert_eq!(with.kind().uses_rays(), name.contains("grid"), "{name}");
        let cost = |built: &Built| {
            let mut counters = Counters::default();
            for ray in &some {
                built.index().closest_hit_counted(ray, &mut counters);
            }
            let model = with.kind().cost_model();
            model.traversal * counters.nodes_visited as f64
                + model.intersection * counters.triangle_tests as f64
        };
        assert!(cost(&with) <= cost(without), "{name}: {} {}", cost(&with), cost(without));
    }
}

#[test]
fn a_number_that_is_not_finite_is_refused_by_id() {
    let scratch_free = |kind, triangles: &[Triangle]| {
        Built::new(kind, &Scene::new(triangles), &Options::default())
            .map(|built| built.bytes().len())
    };
    for &kind in IndexKind::ALL {
        for place in [0, 6, 12] {
            for coordinate in 0..9 {
                for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
                    let mut triangles = scenes::soup(13, 1);
                    let triangle = &mut triangles[place];
                    let corners = [&mut triangle.a, &mut triangle.b, &mut triangle.c];
                    for (number, corner) in corners.into_iter().enumerate() {
                        if number == coordinate / 3 {
                            corner[coordinate % 3] = value;
                        }
                    }
                    let expected = MeshError::NonFiniteVertex { triangle: place as u32 }.into();
                    assert_eq!(scratch_free(kind, &triangles), Err(expected), "{}", kind.name());
                }
            }
        }
    }
}

#[test]
fn options_and_objects_out_of_range_are_refused() {
    let triangles = scenes::soup(5, 1);
    let default = Options::default();
    let wrong = [
        ("leaf_capacity", Options { leaf_capacity: 0, ..default }),
        ("level", Options { level: Level::AtMost(21), ..default }),
        ("proximity", Options { proximity: -0.5, ..default }),
        ("proximity", Options { proximity: f32::NAN, ..default }),
        ("proximity", Options { proximity: f32::INFINITY, ..default }),
        ("size_classes", Options { size_classes: 0, ..default }),
        ("size_classes", Options { size_classes: 5, ..default }),
    ];
    for &kind in IndexKind::ALL {
        for (name, options) in wrong {
            let refusal = Built::new(kind, &Scene::new(&triangles), &options).err();
            assert!(
                matches!(refusal, Some(BuildError::InvalidOption { option, .. }) if option == name),
                "{}: {name}: {refusal:?}",
                kind.name()
            );
        }
        let refused = |objects: &[u32]| {
            Built::new(kind, &Scene::with_objects(&triangles, objects), &default).err()
        };
        let mismatch = BuildError::ObjectsMismatch { triangles: 5, objects: 4 };
        assert_eq!(refused(&[0; 4]), Some(mismatch));
        let out_of_range = BuildError::ObjectOutOfRange { triangle: 3 };
        assert_eq!(refused(&[0, 1, 4, 5, 0]), Some(out_of_range));
    }
}

/// A ray in the plane of a flat scene hits nothing, and no index tests a triangle, whether the ray begins inside or
/// outside the scene.
#[test]
fn rays_in_the_plane_of_a_flat_scene_test_nothing() {
    for axis in 0..3 {
        let triangles = scenes::flat(24, axis);
        let height = triangles[0].a[axis];
        let (lo, hi) =
            triangles.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lo, hi), t| {
                (lo.min(t.a).min(t.b).min(t.c), hi.max(t.a).max(t.b).max(t.c))
            });
        assert!(lo[axis] == hi[axis], "not flat");
        let scene = Scene::new(&triangles);
        for &kind in IndexKind::ALL {
            let built = Built::new(kind, &scene, &Options::default()).expect("it is built");
            for (from, towards) in [(lo - 1.0, hi - lo), (lo, Vec3::ONE), (hi, lo - hi * 0.75)] {
                let (mut origin, mut direction) = (from, towards);
                (origin[axis], direction[axis]) = (height, 0.0);
                let ray = Ray::new(origin, direction).expect("a valid ray");
                let mut counters = Counters::default();
                assert_eq!(built.index().closest_hit_counted(&ray, &mut counters), None);
                assert!(!built.index().occluded_counted(&ray, &mut counters));
                assert_eq!(counters, Counters::default(), "{} on axis {axis}", kind.name());
            }
        }
    }
}
