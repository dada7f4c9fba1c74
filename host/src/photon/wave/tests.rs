//! Tests that waves give the photons of [`Tracer::follow`], which traces them one by one.

use arboleda::{AnyIndex, IndexKind, SimdLevel, Triangle, Vec3};

use super::Wave;
use crate::photon::fixtures::{
    BuiltIndex, SegmentCollector, closed_box, lamp, model, quad, sphere,
};
use crate::photon::shot::Counting;
use crate::photon::stream::{CHUNK, Tally, stream};
use crate::photon::trace::{Segment, Tracer};
use crate::scene::{FaceLight, LitSides, Model};

/// Traces photons one by one. Segments are in the order of photon and bounce.
fn one_by_one(
    tracer: &Tracer<'_>,
    index: &AnyIndex<'_>,
    photons: std::ops::Range<u64>,
) -> (Vec<Segment>, Tally) {
    let (mut segments, mut tally) = (Vec::new(), Tally::default());
    for photon in photons {
        let before = segments.len();
        let end = tracer
            .follow(photon, |ray| index.closest_hit(ray), |segment| segments.push(*segment))
            .unwrap();
        let own = &segments[before..];
        tally.balance.emitted += 1;
        tally.balance.rays += own.len() as u64;
        tally.balance.hits += own.iter().filter(|segment| segment.hit.is_some()).count() as u64;
        tally.bounce_count += own.last().map_or(0, |last| u64::from(last.bounce));
        tally.balance.end(end);
    }
    (segments, tally)
}

/// Traces photons in one wave.
fn in_a_wave(
    tracer: &Tracer<'_>,
    index: &AnyIndex<'_>,
    photons: std::ops::Range<u64>,
    level: SimdLevel,
) -> (Vec<Segment>, Tally) {
    let (mut segments, mut tally) = (Vec::new(), Tally::default());
    let mut wave = Wave::new(tracer, level);
    wave.emit(photons, &mut tally);
    while wave.len() > 0 {
        wave.trace(index, Counting::Off, &mut tally.counters);
        wave.play_roulette(&mut tally);
        let part = wave.part(0..wave.len());
        segments.extend(part.segments());
        let hits = part.segments().filter_map(|segment| Some((segment, segment.hit?)));
        assert!(hits.eq(part.hits(0..part.hit_count())));
        wave.bounce(&mut tally);
    }
    segments.sort_by_key(|segment: &Segment| (segment.photon, segment.bounce));
    (segments, tally)
}

fn check(model: &Model, photons: std::ops::Range<u64>, max_bounces: u32) -> Tally {
    let mut built = BuiltIndex::new(model, IndexKind::WideBvh);
    let index = built.index();
    let tracer = Tracer::new(model, 0xfedc_ba98_7654_3210, max_bounces);
    let (expected, expected_tally) = one_by_one(&tracer, &index, photons.clone());
    let levels = [SimdLevel::COMPILED, SimdLevel::detect().without_avx512(), SimdLevel::detect()];
    for level in levels {
        let (segments, tally) = in_a_wave(&tracer, &index, photons.clone(), level);
        assert_eq!(tally, expected_tally, "{level:?}");
        let differing =
            segments.iter().zip(&expected).find(|(segment, expected)| segment != expected);
        assert_eq!(differing, None, "{level:?}");
        assert_eq!(segments.len(), expected.len());
    }
    expected_tally
}

fn room() -> Model {
    let mut triangles = closed_box(Vec3::ZERO, Vec3::new(4.0, 3.0, 2.0));
    triangles.remove(0);
    triangles.extend(sphere(Vec3::new(3.0, 1.5, 1.0), 0.3, 3));
    model(triangles, 0.7, lamp(Vec3::new(2.0, 1.5, 1.9), 0.5, 40.0))
}

#[test]
fn a_wave_has_the_photons_that_are_traced_one_by_one() {
    // Numbers beyond 32 bits, and a last group that is not full.
    let first = (7 << 32) - 500;
    let tally = check(&room(), first..first + 5003, 6);
    assert!(tally.balance.absorbed > 0 && tally.balance.escaped > 0 && tally.balance.cut_off > 0);
    check(&room(), 0..1, 64);
    check(&room(), 5..5, 64);
}

#[test]
fn photons_of_many_lights_and_colours() {
    let mut model = room();
    model.colours =
        (0..model.triangles.len()).map(|id| [0.3, 0.7, 0.1 * (id % 9) as f32]).collect();
    // One, two, and more lights than lanes take; then triangles too.
    for light in 1..6 {
        let centre = Vec3::new(0.5 * light as f32, 1.0, 1.0 + 0.1 * light as f32);
        model.lights.push(lamp(centre, 0.2, 3.0 * light as f32));
        check(&model, 0..2000, 8);
    }
    let radiance = [30.0, 20.0, 1.0];
    model.emitters.push(FaceLight { triangle: 3, radiance, sides: LitSides::Both });
    check(&model, 0..2000, 8);
    model.lights.clear();
    check(&model, 0..2000, 8);
}

#[test]
fn unusual_photons() {
    // Slivers and a mesh of a few ulps: the photon departs near edges, or its side is in doubt.
    let mut slivers = room();
    let far = Vec3::new(1.0, 1.0, 1.0);
    for step in 0..200 {
        let corner = far + Vec3::new(0.01 * step as f32, 0.001, 0.0);
        let thin = corner + Vec3::new(1.0, 1e-6, 0.1);
        slivers.add_object("sliver", [Triangle::new(corner, thin, corner + Vec3::X * 0.5)], 0.9);
    }
    slivers.add_object("mesh", sphere(Vec3::splat(0.7), 3e-6, 4), 0.9);
    slivers.lights.push(lamp(Vec3::new(0.7, 0.7, 0.70001), 1e-5, 40.0));
    check(&slivers, 0..10_000, 64);

    // A lit floor at the end of the range of f32: rays overflow, and are refused.
    let size = 3e38;
    let floor = quad(Vec3::new(-size, -size, -size), Vec3::X * size, Vec3::Y * size);
    let mut edge = model(floor.to_vec(), 1.0, lamp(Vec3::splat(-0.5 * size), 0.5 * size, 1.0));
    check(&edge, 0..2000, 64);
    edge.lights[0].corner = Vec3::splat(-f32::MAX);
    check(&edge, 0..2000, 64);
}

#[test]
fn chunks_come_in_their_order_and_hold_their_photons_in_the_order_of_waves() {
    let model = room();
    let mut built = BuiltIndex::new(&model, IndexKind::Octree);
    let index = built.index();
    let tracer = Tracer::new(&model, 3, 6);
    // Several runs of chunks, the last chunk not full.
    let photons = 77..77 + 20 * CHUNK + 5;
    let mut chunks = Vec::new();
    let tally = stream(
        &tracer,
        photons.clone(),
        &index,
        Counting::Off,
        &|_| {},
        &SegmentCollector,
        |chunk| {
            chunks.push(chunk);
        },
    );
    let (mut expected, mut expected_tally) = one_by_one(&tracer, &index, photons);
    expected_tally.balance.total_flux = tracer.emitter().total_flux();
    assert_eq!(tally, expected_tally);
    assert_eq!(chunks.len(), 21);
    let chunk_of = |segment: &Segment| (segment.photon - 77) / CHUNK;
    expected.sort_by_key(|segment| (chunk_of(segment), segment.bounce, segment.photon));
    assert!(chunks.concat() == expected);
    for (number, chunk) in (0..).zip(&chunks) {
        assert!(chunk.iter().all(|segment| chunk_of(segment) == number));
    }
}
