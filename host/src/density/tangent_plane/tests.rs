//! Tests of density estimation on the tangent plane: closed forms, photon maps, and all pairs.

use std::cell::RefCell;
use std::sync::Mutex;

use arboleda::{IndexKind, Vec3};

use super::*;
use crate::density::fixtures::{
    Lit, assert_near, lamp_over_floor, lamp_over_plate, on_floor, turned, uniform_furnace,
};
use crate::density::{Estimate, Facing, Fan, Gather, MapEstimator, Receiver};
use crate::photon::PhotonRandom;
use crate::photon::fixtures::{SegmentCollector, closed_box, sphere};
use crate::scene::{AreaLight, Model};

pub(super) fn disc(radius: f32) -> TangentPlane {
    TangentPlane { radius, beyond: 0.0, kernel: Kernel::Constant, domain: Domain::Disc }
}

pub(super) fn visible(radius: f32) -> TangentPlane {
    TangentPlane { domain: Domain::Visible, ..disc(radius) }
}

/// Estimates with the first photons of a model.
pub(super) fn estimates(
    lit: &Lit,
    options: &TangentPlane,
    receivers: &[Receiver],
    photons: u64,
) -> Vec<Estimate> {
    lit.shoot(photons, |source| {
        let fan = Fan::default();
        let kind = IndexKind::WideBvh;
        let mut discs = Discs::new(receivers, options, kind, source.index, &fan).unwrap();
        let flux = discs.count(source, &|_| {}).photon_flux();
        (0..receivers.len()).map(|at| discs.estimate(at, flux)).collect()
    })
}

pub(super) fn by_map(
    lit: &Lit,
    radius: f32,
    receivers: &[Receiver],
    photons: u64,
) -> Vec<Estimate> {
    let map = lit.map(photons);
    let estimator = MapEstimator {
        gather: Gather::Within { radius },
        facing: Facing::within_degrees(10.0),
        kernel: Kernel::Constant,
    };
    let mut found = Vec::new();
    receivers.iter().map(|receiver| estimator.estimate(&map, receiver, None, &mut found)).collect()
}

#[test]
fn both_estimators_give_the_irradiance_under_a_lamp() {
    let lit = lamp_over_floor();
    let receivers = [0.0, 0.5, 1.0, 2.0].map(|x| on_floor(x, 0.0));
    // Means over discs of radius 0.2, and four standard deviations.
    let expected = [(23.40747, 0.012), (17.77549, 0.014), (8.47258, 0.02), (1.40869, 0.048)];
    let photons = 4_000_000;
    let planes = estimates(&lit, &disc(0.2), &receivers, photons);
    let maps = by_map(&lit, 0.2, &receivers, photons);
    for ((plane, map), (value, tolerance)) in planes.iter().zip(&maps).zip(expected) {
        assert_near(plane.mean().into(), value, tolerance, "tangent plane");
        assert_eq!(plane, map, "the same photons on a flat floor");
        let error = f64::from(plane.standard_error) / value;
        assert_near(error, 1.0 / f64::from(plane.count).sqrt(), 0.05, "standard error");
    }
}

#[test]
fn a_furnace_is_uniform() {
    let mut receivers = Vec::new();
    let steps = [0.2, 0.6, 1.0, 1.4, 1.8];
    for (u, v) in steps.into_iter().flat_map(|u| steps.map(|v| (u, v))) {
        receivers.extend([
            (Vec3::new(u, v, 0.0), Vec3::Z),
            (Vec3::new(u, v, 2.0), Vec3::NEG_Z),
            (Vec3::new(u, 0.0, v), Vec3::Y),
            (Vec3::new(u, 2.0, v), Vec3::NEG_Y),
            (Vec3::new(0.0, u, v), Vec3::X),
            (Vec3::new(2.0, u, v), Vec3::NEG_X),
        ]);
    }
    let receivers: Vec<_> =
        receivers.into_iter().map(|(p, n)| Receiver::new(p, n).unwrap()).collect();
    for (reflectance, expected) in [(0.0, 1.0), (0.5, 2.0), (0.8, 5.0)] {
        let lit = uniform_furnace(reflectance);
        let sum = |estimates: Vec<Estimate>| -> f64 {
            estimates.iter().map(|estimate| f64::from(estimate.mean())).sum::<f64>() / 150.0
        };
        let plane = sum(estimates(&lit, &disc(0.15), &receivers, 1_000_000));
        let map = sum(by_map(&lit, 0.15, &receivers, 1_000_000));
        assert_near(plane, expected, 0.006, "tangent plane");
        assert_near(map, expected, 0.006, "photon map");
    }
}

#[test]
fn an_open_edge_does_not_darken() {
    let lit = lamp_over_plate();
    let receivers = [(0.0, 0.0), (0.9, 0.0), (1.0, 0.0), (1.0, 1.0)].map(|(x, y)| on_floor(x, y));
    let photons = 4_000_000;
    let planes = estimates(&lit, &disc(0.2), &receivers, photons);
    assert_near(planes[2].mean().into(), 17.97109, 0.027, "edge");
    assert_near(planes[3].mean().into(), 13.82579, 0.031, "corner");
    let maps = by_map(&lit, 0.2, &receivers, photons);
    assert_near(maps[2].mean().into(), 9.4098, 0.037, "edge by the map");
    assert_near(maps[3].mean().into(), 3.7670, 0.059, "corner by the map");
    assert_near(planes[0].mean().into(), 23.809_493, 0.025, "centre");
    assert_near(planes[1].mean().into(), 18.945_77, 0.03, "half a radius from the edge");
}

#[test]
fn counts_equal_those_of_a_photon_map_on_a_flat_floor() {
    let lit = lamp_over_floor();
    let mut random = PhotonRandom::new(8, 0);
    let receivers: Vec<_> = (0..10_000)
        .map(|_| on_floor(6.0 * random.uniform() - 3.0, 6.0 * random.uniform() - 3.0))
        .collect();
    for radius in [0.02, 0.1, 0.3] {
        let planes = estimates(&lit, &disc(radius), &receivers, 100_000);
        let maps = by_map(&lit, radius, &receivers, 100_000);
        assert!(planes.iter().map(|estimate| estimate.count).sum::<u32>() > 2_000);
        assert_eq!(planes, maps, "{radius}");
    }
}

#[test]
fn counts_equal_on_a_floor_that_is_not_along_the_axes() {
    // The same lamp and floor, turned and far from the origin: no plane of f32 points.
    let away = Vec3::new(103.7, -41.3, 17.9);
    let flat = lamp_over_floor();
    let mut model = Model::named("turned");
    let floor = flat.model.triangles.iter().map(|triangle| {
        let [a, b, c] = [triangle.a, triangle.b, triangle.c].map(|corner| turned(corner) + away);
        arboleda::Triangle::new(a, b, c)
    });
    model.add_object("floor", floor, 0.0);
    let light = flat.model.lights[0];
    model.lights.push(AreaLight {
        corner: turned(light.corner) + away,
        edge_u: turned(light.edge_u),
        edge_v: turned(light.edge_v),
        flux: light.flux,
    });
    let lit = Lit::new(model);
    let mut random = PhotonRandom::new(8, 0);
    let receivers: Vec<_> = (0..2_000)
        .map(|_| {
            let place = Vec3::new(4.0 * random.uniform() - 2.0, 4.0 * random.uniform() - 2.0, 0.0);
            Receiver::new(turned(place) + away, turned(Vec3::Z)).unwrap()
        })
        .collect();
    let planes = estimates(&lit, &disc(0.2), &receivers, 100_000);
    let maps = by_map(&lit, 0.2, &receivers, 100_000);
    assert!(planes.iter().map(|estimate| estimate.count).sum::<u32>() > 200_000);
    assert_eq!(planes, maps);
}

#[test]
fn irradiance_in_mid_air_needs_no_surface() {
    // A work plane half a metre over the floor, under a lamp at one metre: a square at half the distance.
    let lit = lamp_over_floor();
    let centre = Receiver::new(Vec3::new(0.0, 0.0, 0.5), Vec3::Z).unwrap();
    let planes = estimates(&lit, &disc(0.05), &[centre], 1_000_000);
    // Four rectangles with X = Y = 1: F = 4 (2 / (2 pi)) atan(1 / sqrt 2) / sqrt 2 = 0.554099.
    assert_near(planes[0].mean().into(), 55.4099, 0.04, "mid-air");
    assert_eq!(by_map(&lit, 0.05, &[centre], 1_000)[0].count, 0, "a map has nothing there");
    // The black floor sends nothing up to its lower side, and light from above crosses it from behind.
    let below = Receiver::new(Vec3::new(0.0, 0.0, 0.5), Vec3::NEG_Z).unwrap();
    assert_eq!(estimates(&lit, &disc(0.2), &[below], 100_000)[0].count, 0);
}

#[test]
fn slack_sees_the_inside_of_a_sphere() {
    // The light inside is far from uniform, so all of it is indirect in the far half.
    let mut model = Model::named("sphere");
    let radius = 1.0;
    let triangles = sphere(Vec3::ZERO, radius, 5);
    let area = 12.556_376;
    model.add_object("sphere", triangles.clone(), 0.5);
    model.lights.push(AreaLight::facing_down(Vec3::Z * 0.1, 0.1, 0.1, 10.0));
    let lit = Lit::new(model);
    // Indirect light is uniform: flux rho / (area (1 - rho)).
    let expected = 10.0 * 0.5 / (area * 0.5);
    let receivers: Vec<_> = triangles
        .iter()
        .step_by(97)
        .map(|triangle| {
            let middle = (triangle.a + triangle.b + triangle.c) / 3.0;
            Receiver::new(middle, -middle).unwrap()
        })
        .collect();
    let mean = |beyond: f32| {
        lit.shoot(500_000, |source| {
            let source = crate::density::PhotonSource {
                bounces: crate::density::Bounces::Indirect,
                ..source.clone()
            };
            let options = TangentPlane { beyond, ..disc(0.2) };
            let fan = Fan::default();
            let mut discs =
                Discs::new(&receivers, &options, IndexKind::WideBvh, source.index, &fan).unwrap();
            let flux = discs.count(&source, &|_| {}).photon_flux();
            let sum: f64 =
                (0..receivers.len()).map(|at| f64::from(discs.estimate(at, flux).mean())).sum();
            sum / receivers.len() as f64 / expected
        })
    };
    assert!(mean(0.0) < 0.2, "every segment ends before the plane");
    assert_near(mean(0.15), 0.9633, 0.03, "slack 0.15");
    assert_near(mean(0.3), 0.9710, 0.03, "slack 0.3");
}

#[test]
fn the_index_finds_every_disc_of_all_pairs() {
    let mut model = Model::named("open room");
    let mut walls = closed_box(Vec3::ZERO, Vec3::new(4.0, 3.0, 2.0));
    walls.truncate(10);
    walls.extend(sphere(Vec3::new(1.0, 1.0, 0.7), 0.4, 2));
    model.add_object("room", walls, 0.6);
    model.lights.push(AreaLight::facing_down(Vec3::new(2.0, 1.5, 1.9), 0.5, 0.5, 10.0));
    let lit = Lit::new(model);
    let mut random = PhotonRandom::new(9, 0);
    let mut draw = || random.uniform();
    // Discs on walls, on facets and in mid-air; some rows of neighbours that share a carrier.
    let mut receivers = Vec::new();
    for at in 0..2_000 {
        let receiver = match at % 4 {
            0 => on_floor(4.0 * draw(), 3.0 * draw()),
            1 => on_floor(0.001 * at as f32, 1.5),
            2 => {
                let triangle = &lit.model.triangles[10 + at % 100];
                let middle = (triangle.a + triangle.b + triangle.c) / 3.0;
                Receiver::new(middle, middle - Vec3::new(1.0, 1.0, 0.7)).unwrap()
            }
            _ => Receiver::new(
                Vec3::new(4.0 * draw(), 3.0 * draw(), 2.0 * draw()),
                Vec3::new(draw() - 0.5, draw() - 0.5, draw()),
            )
            .unwrap(),
        };
        receivers.push(receiver);
    }
    receivers.sort_by(|a, b| a.position().y.total_cmp(&b.position().y));
    let segments = RefCell::new(Vec::new());
    lit.shoot(12_000, |source| {
        source.stream(&|_| {}, &SegmentCollector, |some| segments.borrow_mut().extend(some));
    });
    let segments = segments.into_inner();
    assert!(segments.len() > 20_000);
    for (options, kinds) in [
        (disc(0.2), IndexKind::ALL),
        (TangentPlane { beyond: 0.1, ..disc(0.2) }, &[IndexKind::WideBvh]),
        (visible(0.3), &[IndexKind::WideBvh, IndexKind::OctreeHierarchy]),
        (TangentPlane { kernel: Kernel::Epanechnikov, ..disc(0.1) }, &[IndexKind::Bvh]),
    ] {
        lit.shoot(12_000, |source| {
            let fan = Fan::default();
            let make = |kind| Discs::new(&receivers, &options, kind, source.index, &fan).unwrap();
            let mut expected = make(IndexKind::Linear);
            expected.add_to_all(&segments, &lit.model);
            let total: u32 = (0..receivers.len()).map(|at| expected.count_of(at)).sum();
            assert!(total > 20_000, "{total}");
            for &kind in kinds {
                let mut discs = make(kind);
                assert!(discs.carrier_count() < receivers.len());
                discs.count(source, &|_| {});
                for at in 0..receivers.len() {
                    assert_eq!(
                        discs.estimate(at, 1.0),
                        expected.estimate(at, 1.0),
                        "{} {at}",
                        kind.name()
                    );
                }
            }
        });
    }
}

#[test]
fn the_error_halves_with_four_times_the_photons() {
    let lit = lamp_over_floor();
    let receivers: Vec<_> = (0..400)
        .map(|at| on_floor((at % 20) as f32 * 0.05 - 0.5, (at / 20) as f32 * 0.05 - 0.5))
        .collect();
    // The mean of many more photons stands for the expectation, so the proximity bias cancels.
    let expected = estimates(&lit, &disc(0.03), &receivers, 4_000_000);
    let errors = [20_000, 80_000, 320_000].map(|photons| {
        let some = estimates(&lit, &disc(0.03), &receivers, photons);
        let squares = some.iter().zip(&expected).map(|(some, expected)| {
            let error = f64::from(some.mean() / expected.mean()) - 1.0;
            error * error
        });
        (squares.sum::<f64>() / 400.0).sqrt()
    });
    assert_near(errors[0] / errors[1], 2.0, 0.15, "from N to 4 N");
    assert_near(errors[1] / errors[2], 2.0, 0.15, "from 4 N to 16 N");
}

#[test]
fn sums_do_not_depend_on_threads() {
    let mut lit = uniform_furnace(0.5);
    lit.model.colours = vec![[0.9, 0.5, 0.1]; lit.model.triangles.len()].into();
    let receivers: Vec<_> = (1..50).map(|at| on_floor(0.04 * at as f32, 1.0)).collect();
    let options = TangentPlane { kernel: Kernel::Epanechnikov, ..visible(0.2) };
    let expected = Mutex::new(None);
    for threads in [1, 2, 3, 8] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let some = pool.install(|| estimates(&lit, &options, &receivers, 20_000));
        assert!(some.iter().all(|estimate| estimate.irradiance[0] > estimate.irradiance[2]));
        let mut expected = expected.lock().unwrap();
        assert_eq!(&some, expected.get_or_insert_with(|| some.clone()), "{threads}");
    }
}

#[test]
fn chunks_with_many_pairs_count_the_same() {
    // Every segment meets every carrier: 313 of 64 discs each, so a chunk of 1,024 photons has 320,000 pairs.
    let lit = lamp_over_floor();
    let receivers: Vec<_> = (0..20_000)
        .map(|at| on_floor(0.1 * (at % 200) as f32 - 10.0, 0.1 * (at / 200) as f32 - 5.0))
        .collect();
    let planes = estimates(&lit, &disc(40.0), &receivers, 3_000);
    let all = lit.map(3_000).len() as u32;
    for (at, estimate) in planes.iter().enumerate() {
        // Segments that miss the floor cross the plane near it, too.
        assert!(estimate.count >= all && estimate.count <= 3_000, "{at}: {} {all}", estimate.count);
    }
}
