//! Tests of light transport with known answers: whole shots through real indices.

use std::sync::atomic::{AtomicU64, Ordering};

use arboleda::{IndexKind, TriangleId, Vec3};

use super::fixtures::{BuiltIndex, closed_box, lamp, model, quad, sphere};
use super::{Counting, PathEnd, ShootOptions, Shot, Tracer, shoot};
use crate::scene::Model;

fn options(photons: u64) -> ShootOptions {
    ShootOptions { photons, ..ShootOptions::default() }
}

fn shot(model: &Model, options: &ShootOptions) -> Shot {
    let mut built = BuiltIndex::new(model, IndexKind::Octree);
    let shot = shoot(model, &built.index(), options, &|_| {});
    assert_eq!(shot.balance.emitted, options.photons);
    assert_eq!(shot.balance.ended(), shot.balance.emitted);
    assert_eq!(shot.balance.hits, shot.hit_counts.iter().sum::<u64>());
    assert!(shot.front_hit_counts.iter().zip(&shot.hit_counts).all(|(front, both)| front <= both));
    assert_eq!(shot.balance.rays, shot.balance.hits + shot.balance.escaped);
    shot
}

/// Makes an open room with a block in it, in which photons are absorbed, escape, and are cut off.
fn open_room(photons: u64) -> (Model, ShootOptions) {
    let mut triangles = closed_box(Vec3::ZERO, Vec3::new(4.0, 3.0, 2.0));
    triangles.retain(|triangle| triangle.a.z.min(triangle.b.z).min(triangle.c.z) < 2.0);
    triangles.extend(closed_box(Vec3::new(1.0, 1.0, 0.0), Vec3::new(1.5, 1.7, 0.9)));
    triangles.extend(sphere(Vec3::new(3.0, 1.5, 1.0), 0.3, 2));
    let model = model(triangles, 0.7, lamp(Vec3::new(2.0, 1.5, 1.9), 0.5, 40.0));
    (model, ShootOptions { max_bounces: 6, counting: Counting::On, ..options(photons) })
}

#[test]
fn photons_are_conserved() {
    let (model, options) = open_room(20_000);
    let shot = shot(&model, &options);
    assert!(shot.balance.absorbed > 0 && shot.balance.escaped > 0 && shot.balance.cut_off > 0);
    assert_eq!(shot.balance.refused, 0);
    // A photon bounces after each hit but its last, unless it escapes after a bounce.
    assert_eq!(shot.bounce_count, shot.balance.rays - shot.balance.emitted);
    assert_eq!(shot.balance.total_flux, 40.0);
    let flux: f64 = (0..model.triangles.len()).map(|id| shot.flux(TriangleId(id as u32))).sum();
    assert!((flux - 40.0 * shot.balance.hits as f64 / 20_000.0).abs() < 1e-9);
}

#[test]
fn the_result_depends_neither_on_threads_nor_on_the_index() {
    // Three chunks, the last one not full.
    let (model, mut options) = open_room(10_000);
    let expected = shot(&model, &options);
    for &kind in IndexKind::ALL {
        let mut built = BuiltIndex::new(&model, kind);
        let index = built.index();
        let mut counters = None;
        for threads in [1, 2, 3] {
            options.threads = Some(threads);
            let done = AtomicU64::new(0);
            let progress = |photons| {
                done.fetch_add(photons, Ordering::Relaxed);
            };
            let shot = shoot(&model, index.as_ray_index(), &options, &progress);
            assert_eq!(done.into_inner(), 10_000);
            assert_eq!(shot.digest, expected.digest, "{} with {threads} threads", kind.name());
            assert_eq!(shot.hit_counts, expected.hit_counts);
            assert_eq!(shot.front_hit_counts, expected.front_hit_counts);
            assert_eq!(shot.thread_count, threads);
            assert!(shot.counters.is_some());
            assert_eq!(shot.counters, *counters.get_or_insert(shot.counters));
        }
    }
    options.seed += 1;
    assert_ne!(shot(&model, &options).digest, expected.digest);
}

#[test]
fn nothing_escapes_from_a_closed_box() {
    for (lo, hi) in [
        (Vec3::ZERO, Vec3::ONE),
        (Vec3::new(-0.3, 0.1, 0.7), Vec3::new(1.1, 0.9, 2.3)),
        (Vec3::new(1000.1, -500.7, 20.3), Vec3::new(1003.3, -498.9, 23.1)),
        (Vec3::splat(-1e-20), Vec3::splat(3e-20)),
        (Vec3::splat(-2e25), Vec3::splat(1e25)),
    ] {
        // The light fills the ceiling, so photons begin in the room's corners and at its edges too.
        let size = hi - lo;
        let light = crate::scene::AreaLight {
            corner: lo + Vec3::Z * size,
            edge_u: Vec3::Y * size,
            edge_v: Vec3::X * size,
            flux: 1.0,
        };
        let model = model(closed_box(lo, hi), 0.9, light);
        let shot = shot(&model, &options(50_000));
        assert_eq!((shot.balance.escaped, shot.balance.refused), (0, 0), "{lo} {hi}");
    }
}

#[test]
fn nothing_escapes_from_a_closed_sphere() {
    // The third sphere is 1e4 radii from the origin, where corners are rounded to a thousandth of the radius.
    for (centre, radius, level) in [
        (Vec3::ZERO, 1.0, 4),
        (Vec3::new(10.3, -20.7, 3.1), 1.0, 3),
        (Vec3::new(1e4, 1e4, -1e4), 1.0, 3),
        (Vec3::ZERO, 1e-25, 3),
        (Vec3::ZERO, 1e25, 3),
    ] {
        let light = lamp(centre, radius, 1.0);
        let model = model(sphere(centre, radius, level), 0.8, light);
        let shot = shot(&model, &options(100_000));
        assert!(shot.balance.hits > 450_000);
        assert_eq!((shot.balance.escaped, shot.balance.refused), (0, 0), "{centre} {radius}");
    }
}

#[test]
fn furnace() {
    // In a closed sphere a photon has 1 / (1 - rho) hits on average, with the variance rho / (1 - rho)^2 of the
    // geometric distribution.
    for rho in [0.0_f32, 0.25, 0.5, 0.8] {
        let model = model(sphere(Vec3::ZERO, 2.0, 2), rho, lamp(Vec3::ZERO, 1.0, 1.0));
        let photons = 50_000;
        let shot = shot(&model, &options(photons));
        let rho = f64::from(rho);
        let mean = shot.balance.hits as f64 / photons as f64;
        let sigma = rho.sqrt() / (1.0 - rho) / (photons as f64).sqrt();
        assert!((mean - 1.0 / (1.0 - rho)).abs() <= 4.0 * sigma, "{rho}: {mean}");
    }
}

/// Computes the share of a unit square's light that reaches an opposite unit square at distance 1 (J. R. Howell, *A
/// Catalog of Radiation Heat Transfer Configuration Factors*, C-11).
fn form_factor_of_opposite_squares() -> f64 {
    let root = 2.0_f64.sqrt();
    let logarithm = 0.5 * libm::log(4.0 / 3.0);
    let arcs = 2.0 * root * libm::atan(1.0 / root) - 2.0 * libm::atan(1.0);
    2.0 / core::f64::consts::PI * (logarithm + arcs)
}

#[test]
fn irradiance_of_a_floor_under_a_square_light() {
    let floor = quad(Vec3::new(-0.5, -0.5, 0.0), Vec3::X, Vec3::Y);
    let model = model(floor.to_vec(), 0.0, lamp(Vec3::Z, 1.0, 60.0));
    let photons = 400_000;
    let shot = shot(&model, &options(photons));
    assert_eq!(shot.front_hit_counts, shot.hit_counts, "all light comes from above");
    let share = form_factor_of_opposite_squares();
    assert!((share - 0.1998).abs() < 1e-4, "the value in tables");
    // By symmetry, each half of the floor receives half of the flux, on half a square metre.
    let expected = 60.0 * share;
    let half = share / 2.0;
    let sigma = 2.0 * 60.0 * (half * (1.0 - half) / photons as f64).sqrt();
    for (id, triangle) in (0..).zip(&model.triangles) {
        let irradiance = shot.irradiance(TriangleId(id), triangle);
        assert!((irradiance - expected).abs() < 4.0 * sigma, "{irradiance} {expected}");
    }
}

#[test]
fn the_rays_are_those_of_the_shot() {
    let (model, options) = open_room(5_000);
    let mut built = BuiltIndex::new(&model, IndexKind::Octree);
    let index = built.index();
    let tracer = Tracer::new(&model, options.seed, options.max_bounces);
    let mut rays = Vec::new();
    tracer.rays(&index, 0..5_000, |ray| rays.push(*ray));
    let shot = shoot(&model, &index, &options, &|_| {});
    assert_eq!(rays.len() as u64, shot.balance.rays);
    let hit_count = rays.iter().filter(|ray| index.closest_hit(ray).is_some()).count();
    assert_eq!(hit_count as u64, shot.balance.hits);
}

#[test]
fn paths_that_cannot_go_on_end() {
    // An index of another model, then a model without reflectances, then without lights.
    let (mut model, options) = open_room(1000);
    let mut built = BuiltIndex::new(&model, IndexKind::Octree);
    let index = built.index();
    let triangles = std::mem::take(&mut model.triangles);
    let lost = shoot(&model, &index, &options, &|_| {});
    assert!(lost.balance.refused > 0);
    assert_eq!(lost.balance.absorbed + lost.balance.escaped + lost.balance.refused, 1000);
    model.triangles = triangles;
    model.reflectance.to_mut().clear();
    let black = shoot(&model, &index, &options, &|_| {});
    assert_eq!((black.balance.absorbed, black.bounce_count), (black.balance.hits, 0));
    model.lights.clear();
    let dark = shoot(&model, &index, &options, &|_| {});
    assert_eq!((dark.balance.emitted, dark.balance.rays, dark.balance.photon_flux()), (0, 0, 0.0));
    assert_eq!(Tracer::new(&model, 1, 6).follow(0, |_| None, |_| {}), None);

    // A light at the end of the range of f32, where the origin may overflow when it is lifted.
    model.lights.push(lamp(Vec3::new(0.0, 0.0, -f32::MAX), 1.0, 1.0));
    model.lights[0].edge_u.z = -f32::MAX;
    let end = Tracer::new(&model, 1, 6).follow(0, |_| None, |_| {});
    assert!(matches!(end, Some(PathEnd::Refused | PathEnd::Escaped)));
}
