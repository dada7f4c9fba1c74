//! Tests that no ray leaves a closed mesh without a hit.
//!
//! Rays go from inside a sphere of 20,480 triangles to its corners and to points of its edges. There a rounding error
//! in both adjacent triangles would let the ray pass. Copies of the sphere lie far from the origin and have other
//! sizes.

use std::time::Instant;

use arboleda::{IndexKind, Options, Ray, Scene, Triangle, Vec3};
use arboleda_tests::build::Built;
use arboleda_tests::checks::bits;
use arboleda_tests::random::Random;
use arboleda_tests::{parallel, scenes};

const RAYS: usize = if cfg!(debug_assertions) { 20_000 } else { 1_000_000 };
/// Ratio of all rays to those of the linear scan, which is a thousand times slower than the indices.
const SHARE_OF_LINEAR: usize = 2_000;
const CHUNK: usize = 1_000;

/// Draws a ray from well inside the sphere to an edge or a corner.
fn outwards(triangles: &[Triangle], centre: Vec3, radius: f32, random: &mut Random) -> Ray {
    let Triangle { a, b, c } = triangles[random.below(triangles.len())];
    let (p, q) = random.pick(&[(a, b), (b, c), (c, a)]);
    let along = random.pick(&[0.0, 0.5, random.clone().unit()]);
    let target = p + (q - p) * along;
    // The origin is the centre, or a point near it.
    let origin = centre + random.point() * (radius * random.pick(&[0.0, 0.1, 0.5]));
    let direction = target - origin;
    Ray::new(origin, direction).expect("the target is not the origin")
}

fn leaks(name: &str, sphere: &[Triangle], centre: Vec3, radius: f32, ray_count: usize) {
    let scene = Scene::new(sphere);
    let built: Vec<Built> = IndexKind::ALL
        .iter()
        .map(|&kind| Built::new(kind, &scene, &Options::default()).expect("an ordinary scene"))
        .collect();
    let indices: Vec<_> = built.iter().map(Built::index).collect();
    let start = Instant::now();
    let leaks = parallel::map(ray_count / CHUNK, |job| {
        let mut random = Random::new(job as u64);
        let mut leaks = vec![0; indices.len()];
        for place in 0..CHUNK {
            let ray = outwards(sphere, centre, radius, &mut random);
            let mut first = None;
            for (index, leaks) in indices.iter().zip(&mut leaks) {
                let sampled = (job * CHUNK + place).is_multiple_of(SHARE_OF_LINEAR);
                if index.kind() == IndexKind::Linear && !sampled {
                    continue;
                }
                let hit = index.closest_hit(&ray);
                if hit.is_none() || !index.occluded(&ray) {
                    *leaks += 1;
                }
                // All indices that answer this ray agree.
                let found = hit.as_ref().map(bits);
                assert_eq!(*first.get_or_insert(found), found, "{} {ray:?}", index.kind().name());
            }
        }
        leaks
    });
    let seconds = start.elapsed().as_secs_f64();
    println!("{name}: {ray_count} rays, {} indices, {seconds:.1} s", indices.len());
    for (place, index) in indices.iter().enumerate() {
        let leaked: usize = leaks.iter().map(|leaks| leaks[place]).sum();
        assert_eq!(leaked, 0, "{name}: rays leaked through {}", index.kind().name());
    }
}

#[test]
fn none_from_a_sphere() {
    let sphere = scenes::icosphere(5);
    assert_eq!(sphere.len(), 20_480);
    leaks("unit sphere", &sphere, Vec3::ZERO, 1.0, RAYS);
}

#[test]
fn none_from_a_sphere_far_away() {
    let centre = Vec3::new(1e5, -2e5, 3e5);
    let sphere = scenes::moved(&scenes::icosphere(5), 1000.0, centre);
    leaks("sphere of radius 1000 at 3e5", &sphere, centre, 1000.0, RAYS / 4);
}

#[test]
fn none_from_a_sphere_as_coarse_as_its_floats() {
    // Coordinates are multiples of 1/16, so many triangles are slivers and some have no area.
    let centre = Vec3::splat(1e6);
    let sphere = scenes::moved(&scenes::icosphere(5), 4.0, centre);
    leaks("sphere of radius 4 at 1e6", &sphere, centre, 4.0, RAYS / 4);
}
