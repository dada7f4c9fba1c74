//! Checks of indices against tests of every triangle, bit for bit, also beside a mesh.

pub mod hostile;
pub mod work;

use arboleda::{
    AllHits, AnyIndex, BATCH_SCRATCH, Counters, Hit, IndexKind, Mesh, Options, Ray, RayIndex,
    Scene, Triangle, TriangleId, intersect,
};

use crate::build::{Built, build_exactly};
use crate::scenes::welded;

/// Compares every kind of index with tests of all triangles, as [`index_equals_linear`] does.
///
/// # Panics
/// If an answer differs by a bit, a size is not exact, or a build is refused.
pub fn every_index_equals_linear(triangles: &[Triangle], rays: &[Ray], options: &Options) {
    for &kind in IndexKind::ALL {
        index_equals_linear(kind, triangles, rays, options);
    }
}

/// Builds an index in exactly enough memory and compares its answers with tests of all triangles. The built index, a
/// copy of its bytes, and an index beside a mesh are checked.
///
/// # Panics
/// If an answer differs by a bit, a size is not exact, or a build is refused.
pub fn index_equals_linear(
    kind: IndexKind,
    triangles: &[Triangle],
    rays: &[Ray],
    options: &Options,
) {
    let scene = Scene::new(triangles);
    let expected: Vec<Vec<Hit>> = rays.iter().map(|ray| all_hits(triangles, ray)).collect();
    let build = |scene| match build_exactly(kind, &scene, options) {
        Ok(built) => built,
        Err(error) => panic!("{} is not built: {error}", kind.name()),
    };
    let built = build(scene);
    // 1. An index tuned by a sample of rays may be divided differently.
    let for_rays = build(scene.rays(rays));
    if for_rays.bytes() != built.bytes() {
        for (ray, expected) in rays.iter().zip(&expected) {
            answers_equal(&for_rays.index(), ray, expected);
        }
    }

    // 2. The index, and one opened from a copy of its bytes.
    let copy = Built::copied(kind, built.bytes());
    let (built, copied) = (built.index(), copy.index());
    assert_eq!(built.check(), copied.check());
    for (ray, expected) in rays.iter().zip(&expected) {
        answers_equal(&built, ray, expected);
        answers_equal(&copied, ray, expected);
        assert_eq!(counts(&built, ray), counts(&copied, ray), "{} {ray:?}", kind.name());
    }
    many_equal_one_by_one(&built, rays, &expected);
    rays_in_flight_equal(&built, rays, &expected);

    // 3. An index beside a mesh of the same triangles, with the same traversal.
    if kind.holds_triangles() {
        return;
    }
    let (vertices, corners) = welded(triangles);
    let mesh = Mesh::Indexed { vertices: &vertices, corners: &corners };
    let beside = Built::new(kind, &Scene::of(mesh).beside(), options);
    let beside = beside.unwrap_or_else(|error| panic!("{} beside: {error}", kind.name()));
    is_the_same(&beside.index_beside(mesh), &built, rays, &expected);
}

/// Compares an index beside a mesh with an index that has a copy of the triangles.
///
/// # Panics
/// If an answer, a counter or the structure differs.
pub fn is_the_same(beside: &AnyIndex<'_>, own: &AnyIndex<'_>, rays: &[Ray], expected: &[Vec<Hit>]) {
    let name = own.kind().name();
    assert_eq!(beside.check(), own.check(), "{name}");
    let (sections, own_sections) = (beside.sections(), own.sections());
    assert_eq!(sections.words(), own_sections.words(), "{name}");
    assert_eq!(sections.nodes(), own_sections.nodes(), "{name}");
    for (ray, expected) in rays.iter().zip(expected) {
        answers_equal(beside, ray, expected);
        assert_eq!(counts(beside, ray), counts(own, ray), "{name} {ray:?}");
    }
    many_equal_one_by_one(beside, rays, expected);
    rays_in_flight_equal(beside, rays, expected);
}

/// Finds all hits of a ray by testing every triangle, sorted by `(t, id)`.
pub fn all_hits(triangles: &[Triangle], ray: &Ray) -> Vec<Hit> {
    let hit = |(id, triangle): (u32, &Triangle)| {
        let at = intersect(ray, triangle)?;
        Some(Hit { triangle: TriangleId(id), t: at.t, u: at.u, v: at.v })
    };
    let mut hits: Vec<Hit> = (0..).zip(triangles).filter_map(hit).collect();
    // The sort is stable, so ties stay in the order of ids.
    hits.sort_by(|a, b| a.t.total_cmp(&b.t));
    hits
}

/// Returns the bits of a hit, for comparison: with `==` on floats, -0.0 would equal 0.0.
pub fn bits(hit: &Hit) -> [u32; 4] {
    [hit.triangle.0, hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits()]
}

/// Compares the answers of all three queries of a ray with all its hits.
///
/// # Panics
/// If an answer differs by a bit.
pub fn answers_equal(index: &dyn RayIndex, ray: &Ray, expected: &[Hit]) {
    let about = || format!("index of {} bytes, {ray:?}", index.as_bytes().len());
    let closest = index.closest_hit(ray);
    assert_eq!(closest.as_ref().map(bits), expected.first().map(bits), "closest: {}", about());
    assert_eq!(index.occluded(ray), !expected.is_empty(), "occluded: {}", about());

    // Buffers of no room, too little, exactly enough and too much.
    let count = expected.len();
    for room in [0, 1, 2, count / 2, count.saturating_sub(1), count, count + 3] {
        let mut buffer = vec![Hit::NONE; room];
        let AllHits { hits, truncated } = index.all_hits(ray, &mut buffer);
        let expected = &expected[..room.min(count)];
        assert!(
            hits.iter().map(bits).eq(expected.iter().map(bits)),
            "all hits in {room}: {}\n found {hits:?}\n exact {expected:?}",
            about()
        );
        assert_eq!(truncated, count > room, "truncated, {room} of {count}: {}", about());
    }

    // Counting changes no answer, and a hit implies a triangle test.
    let (counters, counted) = counts(index, ray);
    assert_eq!(counted.as_ref().map(bits), closest.as_ref().map(bits), "counted: {}", about());
    assert!(counted.is_none() || counters[0].triangle_tests > 0, "{}", about());
    assert!(counters[0].triangle_tests >= u64::from(count > 0), "{}", about());
}

/// Compares batch queries with the expected hits, for all rays, half of them, and a buffer of one.
///
/// # Panics
/// If an answer differs by a bit, or an entry beyond the shorter slice is written.
pub fn many_equal_one_by_one(index: &dyn RayIndex, rays: &[Ray], expected: &[Vec<Hit>]) {
    let untouched = Hit { u: -7.0, ..Hit::NONE };
    for (asked, room) in [(rays.len(), rays.len()), (rays.len() / 2, rays.len()), (rays.len(), 1)] {
        let mut hits = vec![untouched; room];
        let mut occluded = vec![true; room];
        index.closest_hits(&rays[..asked], &mut hits);
        index.occluded_each(&rays[..asked], &mut occluded);
        let answered = asked.min(room);
        for (at, (hit, expected)) in hits.iter().zip(expected).enumerate().take(answered) {
            let closest = expected.first().unwrap_or(&Hit::NONE);
            assert_eq!(bits(hit), bits(closest), "ray {at} of {asked}: {:?}", rays[at]);
            assert_eq!(occluded[at], !expected.is_empty(), "ray {at}: {:?}", rays[at]);
        }
        assert!(hits[answered..].iter().all(|hit| bits(hit) == bits(&untouched)));
        assert!(occluded[answered..].iter().all(|&occluded| occluded));
    }
}

/// Compares a batch that is long enough to have many rays in flight with the expected hits: the rays, over and over, in
/// a scratch. Other kinds than those of the wide family use no scratch, and are left out.
///
/// # Panics
/// If an answer differs by a bit.
pub fn rays_in_flight_equal(index: &AnyIndex<'_>, rays: &[Ray], expected: &[Vec<Hit>]) {
    let (hits, occluded) = answers_in_flight(index, rays);
    for (at, (hit, expected)) in hits.iter().zip(expected.iter().cycle()).enumerate() {
        let closest = expected.first().unwrap_or(&Hit::NONE);
        let ray = &rays[at % rays.len()];
        assert_eq!(bits(hit), bits(closest), "{}, ray {at}: {ray:?}", index.kind().name());
        assert_eq!(occluded[at], !expected.is_empty(), "{}, ray {at}", index.kind().name());
    }
}

/// Asks an index of the wide family for the answers of a batch with many rays in flight: the rays, over and over. None
/// of other kinds, or without rays.
fn answers_in_flight(index: &AnyIndex<'_>, rays: &[Ray]) -> (Vec<Hit>, Vec<bool>) {
    /// More than the 128 from which on a batch has rays in flight, so that some begin where others ended.
    const MANY: usize = 160;
    let kinds = [
        IndexKind::WideBvh,
        IndexKind::WideBvhHierarchy,
        IndexKind::CompactBvh,
        IndexKind::CompactBvhHierarchy,
        IndexKind::LeanBvh,
        IndexKind::LeanBvhHierarchy,
    ];
    if !kinds.contains(&index.kind()) {
        return Default::default();
    }
    let rays: Vec<Ray> = rays.iter().copied().cycle().take(MANY).collect();
    let (mut hits, mut occluded) = (vec![Hit::NONE; rays.len()], vec![false; rays.len()]);
    let mut scratch = vec![0xa5; BATCH_SCRATCH];
    index.closest_hits_in(&rays, &mut hits, &mut scratch);
    index.occluded_each_in(&rays, &mut occluded, &mut scratch);
    (hits, occluded)
}

fn counts(index: &dyn RayIndex, ray: &Ray) -> ([Counters; 2], Option<Hit>) {
    let mut counters = [Counters::default(); 2];
    let hit = index.closest_hit_counted(ray, &mut counters[0]);
    let occluded = index.occluded_counted(ray, &mut counters[1]);
    assert_eq!(occluded, hit.is_some());
    (counters, hit)
}
