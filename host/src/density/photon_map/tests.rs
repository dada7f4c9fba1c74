//! Tests of photon maps: searches against a linear scan, and estimates against closed forms.

use arboleda::{IndexKind, Vec3};

use super::*;
use crate::density::fixtures::{Lit, assert_near, lamp_over_floor, on_floor, uniform_furnace};
use crate::density::receiver::distance_squared;
use crate::density::{Bounces, Kernel, PhotonSource, Receiver};
use crate::photon::PhotonRandom;

const ANY: Facing = Facing::ANY;

fn around(receiver: &Receiver, facing: Facing, radius: f64) -> Neighbourhood<'_> {
    Neighbourhood { receiver, facing: Some(facing), radius }
}

/// Makes a map of photons at given places, all on the front of one triangle.
fn map_of(places: &[Vec3]) -> PhotonMap {
    let mut photons: Vec<Photon> =
        places.iter().map(|&place| Photon::new(place, 0, Side::Front)).collect();
    for (rank, photon) in (0..).zip(&mut photons) {
        photon.rank = rank;
    }
    build::order(&mut photons);
    let normals = Normals::Table(vec![Vector64::new(0.0, 0.0, 1.0)]);
    PhotonMap { photons, tints: Vec::new(), normals, balance: Balance::default() }
}

/// Random points, and a lattice on which thousands of points are equally far from each other.
fn places(count: usize) -> Vec<Vec3> {
    let mut random = PhotonRandom::new(5, 0);
    let mut place = |at: usize| {
        let mut draw = || random.uniform();
        match at % 4 {
            0 => Vec3::new(draw(), draw(), draw()),
            // A flat floor.
            1 => Vec3::new(draw(), draw(), 0.0),
            _ => Vec3::new(draw(), draw(), draw() * 0.4).map(|x| (x * 16.0).floor() / 16.0),
        }
    };
    (0..count).map(&mut place).collect()
}

#[test]
fn searches_find_what_a_linear_scan_finds_in_the_same_order() {
    let places = places(100_000);
    let map = map_of(&places);
    let mut random = PhotonRandom::new(6, 0);
    let mut found = Vec::new();
    for query in 0..60 {
        let mut draw = || random.uniform() * 1.1 - 0.05;
        // Half of the points are on the lattice.
        let place = Vec3::new(draw(), draw(), draw() * 0.5);
        let place = if query % 2 == 0 { place } else { place.map(|x| (x * 16.0).floor() / 16.0) };
        let receiver = Receiver::new(place, Vec3::Z).unwrap();
        let mut all: Vec<(u64, u32)> = (0..)
            .zip(&places)
            .map(|(rank, &other)| (distance_squared(other.into(), place.into()).to_bits(), rank))
            .collect();
        all.sort_unstable();
        let same = |found: &[Found], expected: &[(u64, u32)]| {
            let found =
                found.iter().map(|photon| (photon.distance_squared().to_bits(), photon.rank));
            found.eq(expected.iter().copied())
        };
        for k in 1..=200 {
            map.nearest(&around(&receiver, ANY, 9.0), k, &mut found);
            assert!(same(&found, &all[..k]), "{query}: {k} nearest");
        }
        for radius in [0.0, 1.0 / 16.0, 0.1, 0.25] {
            let count =
                all.iter().filter(|(bits, _)| f64::from_bits(*bits) <= radius * radius).count();
            assert!(
                same(&map.within(&around(&receiver, ANY, radius)), &all[..count]),
                "{query}: {radius}"
            );
            map.nearest(&around(&receiver, ANY, radius), 150, &mut found);
            assert!(same(&found, &all[..count.min(150)]), "{query}: 150 nearest in {radius}");
        }
    }
}

#[test]
fn a_photon_takes_20_bytes_and_keeps_its_fields() {
    assert_eq!(size_of::<Photon>(), 20);
    let mut photon = Photon::new(Vec3::ONE, (1 << 30) - 1, Side::Back);
    photon.rank = MOST_PHOTONS as u32;
    for axis in 0..3 {
        photon.set_axis(axis);
        assert_eq!((photon.axis(), photon.triangle()), (axis, (1 << 30) - 1));
        assert_eq!((photon.side(), photon.rank()), (Side::Back, MOST_PHOTONS as u32));
    }
}

#[test]
fn small_maps_are_searched_whole() {
    let mut found = Vec::new();
    for count in 0..40 {
        let map = map_of(&places(count));
        map.nearest(&around(&on_floor(0.5, 0.5), ANY, 9.0), 100, &mut found);
        assert_eq!(found.len(), count, "k above the number of photons");
        map.nearest(&around(&on_floor(0.5, 0.5), ANY, 9.0), 0, &mut found);
        assert!(found.is_empty());
    }
}

#[test]
fn the_bytes_do_not_depend_on_threads_nor_on_the_index() {
    let expected = lamp_over_floor().map(30_000);
    assert!(expected.len() > 29_000);
    for kind in [IndexKind::Linear, IndexKind::Octree, IndexKind::CompactBvh] {
        let lit = Lit::with(lamp_over_floor().model, kind);
        for threads in [1, 2, 3, 8] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let map = pool.install(|| lit.map(30_000));
            assert_eq!(map.photons, expected.photons, "{} with {threads} threads", kind.name());
            assert_eq!(map.balance(), expected.balance());
        }
    }
}

#[test]
fn a_map_is_read_as_it_was_written_and_refused_for_another_scene() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("photons.map");
    let mut lit = uniform_furnace(0.5);
    lit.model.colours = vec![[0.9, 0.5, 0.1]; lit.model.triangles.len()].into();
    let map = lit.map(5_000);
    map.save(&path, &lit.model).unwrap();
    let read = PhotonMap::load(&path, &lit.model).unwrap();
    assert_eq!((&read.photons, &read.tints), (&map.photons, &map.tints));
    assert_eq!(read.balance(), map.balance());
    assert_eq!(read.tints.len(), read.photons.len());

    let message = |bytes: &[u8], model: &Model| {
        let path = folder.path().join("other.map");
        std::fs::write(&path, bytes).unwrap();
        PhotonMap::load(&path, model).unwrap_err().to_string()
    };
    let bytes = std::fs::read(&path).unwrap();
    let other = lamp_over_floor().model;
    assert!(message(&bytes, &other).ends_with("those of another scene, or of other materials"));
    assert!(message(&bytes[..bytes.len() - 1], &lit.model).contains("bytes, but its header says"));
    assert!(message(b"solid", &lit.model).contains("not a photon map"));
    // Any damage is an error or another map, never a panic.
    for at in 0..160 {
        let mut forged = bytes.clone();
        forged[at] ^= 0xff;
        let path = folder.path().join("forged.map");
        std::fs::write(&path, &forged).unwrap();
        if let Ok(map) = PhotonMap::load(&path, &lit.model) {
            map.within(&around(&on_floor(1.0, 1.0), ANY, 3.0));
        }
    }
}

/// The mean over many receivers of the estimate, and of the estimate with k in place of k - 1.
fn mean_of_nearest(map: &PhotonMap, receivers: &[Receiver], k: usize) -> (f64, f64) {
    let estimator = MapEstimator {
        gather: Gather::Nearest { k, max_radius: 0.1 },
        facing: Facing::within_degrees(10.0),
        kernel: Kernel::Constant,
    };
    let mut found = Vec::new();
    let mut sum = 0.0;
    for receiver in receivers {
        let estimate = estimator.estimate(map, receiver, None, &mut found);
        assert_eq!(estimate.count, k as u32);
        sum += f64::from(estimate.mean());
    }
    let mean = sum / receivers.len() as f64;
    (mean, mean * k as f64 / (k - 1) as f64)
}

#[test]
fn the_k_nearest_are_unbiased() {
    let map = uniform_furnace(0.0).map(1_000_000);
    let at = |step: u32| 0.04 + 0.08 * step as f32;
    let mut receivers = Vec::new();
    for (i, j) in (0..25).flat_map(|i| (0..25).map(move |j| (at(i), at(j)))) {
        receivers.extend([
            on_floor(i, j),
            Receiver::new(Vec3::new(i, j, 2.0), Vec3::NEG_Z).unwrap(),
            Receiver::new(Vec3::new(0.0, i, j), Vec3::X).unwrap(),
            Receiver::new(Vec3::new(i, 2.0, j), Vec3::NEG_Y).unwrap(),
        ]);
    }
    let (unbiased, biased) = mean_of_nearest(&map, &receivers, 8);
    // 2,500 receivers at a relative deviation of 0.408.
    assert_near(unbiased, 1.0, 0.033, "(k - 1) rule");
    assert_near(biased, 8.0 / 7.0, 0.033, "k rule");
}

#[test]
fn kernels_agree_and_have_their_variance() {
    let map = uniform_furnace(0.5).map(1_000_000);
    for kernel in [Kernel::Constant, Kernel::Epanechnikov] {
        let estimator = MapEstimator {
            gather: Gather::Within { radius: 0.1 },
            facing: Facing::within_degrees(10.0),
            kernel,
        };
        let (mut sum, mut squares, mut errors, mut count) = (0.0, 0.0, 0.0, 0.0);
        for i in 0..17 {
            for j in 0..17 {
                let at = |step: i32| 0.2 + 0.1 * step as f32;
                let receiver = on_floor(at(i), at(j));
                let estimate = estimator.estimate(&map, &receiver, None, &mut Vec::new());
                let mean = f64::from(estimate.mean());
                sum += mean;
                squares += (mean - 2.0) * (mean - 2.0);
                errors += f64::from(estimate.standard_error);
                count += 1.0;
            }
        }
        // 2,618 photons are expected in each of some 80 discs that do not overlap.
        let sigma = (kernel.variance_factor() / 2618.0).sqrt();
        assert_near(sum / count, 2.0, 4.0 * sigma / 80.0_f64.sqrt(), "mean");
        assert_near((squares / count).sqrt(), 2.0 * sigma, 0.25, "deviation");
        assert_near(errors / count, 2.0 * sigma, 0.05, "standard error");
    }
}

#[test]
fn photons_of_other_sides_and_of_turned_surfaces_do_not_count() {
    let lit = uniform_furnace(0.5);
    let map = lit.map(200_000);
    let count = |receiver: Receiver, degrees: f32| {
        let facing = Facing::within_degrees(degrees);
        map.within(&around(&receiver, facing, 0.25)).len() as f64
    };
    // At the foot of a wall, half of the disc is on the floor; with walls, a uniform field counts whole.
    let expected = 16_362.0 / 5.0;
    let foot = on_floor(0.0, 1.0);
    assert_near(count(foot, 10.0), expected / 2.0, 0.07, "floor");
    assert_near(count(foot, 90.0), expected, 0.05, "floor and wall");
    // From outside, the floor is dark.
    let below = Receiver::new(Vec3::new(1.0, 1.0, 0.0), Vec3::NEG_Z).unwrap();
    assert!(map.within(&around(&below, Facing::within_degrees(90.0), 0.25)).is_empty());
    // A step of 0.05 below is another surface.
    let above = Receiver::new(Vec3::new(1.0, 1.0, 0.05), Vec3::Z).unwrap();
    assert!(
        map.within(&around(&above, Facing::within_degrees(10.0), 0.2)).len()
            < count(foot, 10.0) as usize
    );
}

#[test]
fn the_largest_flux_gives_finite_estimates() {
    let mut map = map_of(&places(100));
    map.balance = Balance { emitted: 1, total_flux: f64::MAX, ..Balance::default() };
    let receiver = Receiver::new(Vec3::splat(0.5), Vec3::Z).unwrap();
    for gather in [Gather::Nearest { k: 9, max_radius: 9.0 }, Gather::Within { radius: 9.0 }] {
        let estimator = MapEstimator { gather, facing: ANY, kernel: Kernel::Epanechnikov };
        let estimate = estimator.estimate(&map, &receiver, None, &mut Vec::new());
        assert_eq!((estimate.mean(), estimate.standard_error), (f32::MAX, f32::MAX));
    }
}

#[test]
fn photons_count_on_the_side_on_which_they_fell() {
    let mut map = map_of(&places(1_000));
    for photon in &mut map.photons {
        let side = if photon.rank() % 3 == 0 { Side::Back } else { Side::Front };
        photon.surface |= Photon::new(Vec3::ZERO, 0, side).surface;
    }
    for (normal, count) in [(Vec3::Z, 666), (Vec3::NEG_Z, 334)] {
        let receiver = Receiver::new(Vec3::splat(0.5), normal).unwrap();
        let found = map.within(&around(&receiver, ANY, 9.0));
        assert_eq!(found.len(), count, "{normal}");
        assert!(found.iter().all(|photon| (photon.rank % 3 == 0) == (normal == Vec3::NEG_Z)));
    }
}

#[test]
fn direct_and_indirect_light_make_up_all() {
    let lit = uniform_furnace(0.5);
    let maps = [Bounces::All, Bounces::Direct, Bounces::Indirect].map(|bounces| {
        lit.shoot(20_000, |source| {
            PhotonMap::shoot(&PhotonSource { bounces, ..source.clone() }, &|_| {}).unwrap()
        })
    });
    assert_eq!(maps[0].len(), maps[1].len() + maps[2].len());
    assert_eq!(maps[1].len(), 20_000);
    assert_eq!(maps[0].len() as u64, maps[0].balance().hits);
}

#[test]
fn colours_multiply_along_the_path() {
    // In a furnace of white light each colour sees the furnace of its own reflectance.
    let mut lit = uniform_furnace(0.5);
    lit.model.colours = vec![[0.8, 0.5, 0.2]; lit.model.triangles.len()].into();
    let map = lit.map(1_000_000);
    let estimator = MapEstimator {
        gather: Gather::Within { radius: 0.5 },
        facing: Facing::within_degrees(10.0),
        kernel: Kernel::Constant,
    };
    let estimate = estimator.estimate(&map, &on_floor(1.0, 1.0), None, &mut Vec::new());
    for (value, (share, tolerance)) in
        estimate.irradiance.into_iter().zip([(0.8, 0.04), (0.5, 0.02), (0.2, 0.02)])
    {
        assert_near(value.into(), 1.0 / (1.0 - share), tolerance, "colour");
    }
    let grey = uniform_furnace(0.5).map(10_000);
    assert_eq!(lit.map(10_000).photons, grey.photons, "paths do not depend on colours of one mean");
}
