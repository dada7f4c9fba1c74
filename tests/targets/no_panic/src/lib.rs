//! Proof by linking: no panic is reachable in the core, and nothing allocates.
//!
//! The public functions that do work are called from exported ones, errors' messages included, on
//! values about which the compiler knows nothing. The panic handler calls a function that nobody
//! defines, so a program made of this library links only if the optimiser has removed every path to
//! it. No allocator is defined either, and the `alloc` crate is not linked.
//!
//! The optimiser has to see that a check cannot fail, so the proof covers this compiler at this
//! optimisation level, without overflow checks; that the values are right is the other tests' affair.
//! With the feature `control` one function can panic, and linking must fail: a proof that cannot fail
//! proves nothing.
#![no_std]
// Linked, but called by nobody.
#![allow(improper_ctypes_definitions)]

use core::fmt::{self, Write};
use core::panic::PanicInfo;
use core::slice;

use arboleda::custom::{RaySpan, kernel, may_overlap};
use arboleda::kinds::{Clustered, Octree};
use arboleda::{
    Aabb, AllHits, AnyIndex, Block, Counters, Hit, IndexKind, Mesh, OpenError, Options, Ray,
    RayError, Scene, Stored, Triangle, Vec3, clusters as cluster, intersect, select,
};

unsafe extern "C" {
    /// Defined nowhere.
    fn a_panic_is_reachable() -> !;
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    // SAFETY: never linked, so never called.
    unsafe { a_panic_is_reachable() }
}

/// Counts the bytes of messages.
struct Sink(usize);

impl Write for Sink {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0 ^= text.len();
        Ok(())
    }
}

/// The length of an error's message, more or less.
fn message(error: impl fmt::Display) -> usize {
    let mut sink = Sink(0);
    write!(sink, "{error}").map_or(0, |()| sink.0)
}

/// A slice from outside.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Slice<T> {
    first: *mut T,
    count: usize,
}

impl<T> Slice<T> {
    /// # Safety
    /// `count` values lie at `first`, and nobody else uses them during `'a`.
    unsafe fn get<'a>(self) -> &'a mut [T] {
        // SAFETY: the caller's promise.
        unsafe { slice::from_raw_parts_mut(self.first, self.count) }
    }
}

/// Numbers that become a ray.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct RayNumbers {
    origin: Vec3,
    direction: Vec3,
    t_min: f32,
    t_max: f32,
}

impl RayNumbers {
    fn ray(self) -> Result<Ray, RayError> {
        Ray::with_interval(self.origin, self.direction, self.t_min, self.t_max)
    }
}

/// A mesh in either form, or none.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct MeshParts {
    /// 0 for none, 1 for triangles, else by vertices and corners.
    form: u32,
    triangles: Slice<Triangle>,
    vertices: Slice<Vec3>,
    corners: Slice<[u32; 3]>,
}

impl MeshParts {
    /// # Safety
    /// As [`Slice::get`], for all.
    unsafe fn get<'a>(self) -> Option<Mesh<'a>> {
        // SAFETY: the caller's promise.
        let (triangles, vertices, corners) =
            unsafe { (self.triangles.get(), self.vertices.get(), self.corners.get()) };
        match self.form {
            0 => None,
            1 => Some(Mesh::Triangles(triangles)),
            _ => Some(Mesh::Indexed { vertices, corners }),
        }
    }
}

/// Everything that a build takes.
#[repr(C)]
pub struct Build {
    kind: usize,
    mesh: MeshParts,
    is_beside: u32,
    objects: Slice<u32>,
    has_objects: u32,
    rays: Slice<Ray>,
    options: Options,
    arena: Slice<u8>,
    scratch: Slice<u8>,
}

fn kind(number: usize) -> Option<IndexKind> {
    IndexKind::ALL.get(number).copied()
}

/// Opens the bytes of an index of a kind, beside a mesh if there is one.
fn read<'a>(
    number: usize,
    index_bytes: &'a [u8],
    mesh: Option<Mesh<'a>>,
) -> Option<Result<AnyIndex<'a>, OpenError>> {
    let kind = kind(number)?;
    Some(match mesh {
        Some(mesh) => kind.from_bytes_beside(index_bytes, mesh),
        None => kind.from_bytes(index_bytes),
    })
}

/// The scene of a build.
///
/// # Safety
/// As [`Slice::get`], for all.
unsafe fn scene<'a>(input: &Build) -> Scene<'a> {
    // SAFETY: the caller's promise.
    let (mesh, objects, rays) =
        unsafe { (input.mesh.get(), input.objects.get(), input.rays.get()) };
    let scene = Scene::of(mesh.unwrap_or(Mesh::EMPTY)).rays(rays);
    let scene = if input.has_objects == 0 { scene } else { scene.objects(objects) };
    if input.is_beside == 0 { scene } else { scene.beside() }
}

/// Computes the capacity of an index, and builds it. What is returned depends on everything.
///
/// # Safety
/// As [`Slice::get`], for every slice.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn prove_build(input: Build) -> usize {
    let Some(kind) = kind(input.kind) else {
        return 0;
    };
    let options = input.options;
    // SAFETY: the caller's promise.
    let (scene, arena, scratch) = unsafe {
        let scene = scene(&input);
        (scene, input.arena.get(), input.scratch.get())
    };
    let needed = kind.scratch_capacity(scene.triangles().len(), &options);
    let capacity = kind.capacity(&scene, &options, scratch);
    match (capacity, kind.build(&scene, &options, arena, scratch)) {
        (Ok(capacity), Ok(index)) => index.as_bytes().len() + capacity.index + needed,
        (Err(error), _) | (_, Err(error)) => message(error),
    }
}

/// Chooses an index, and prints why.
///
/// # Safety
/// As [`Slice::get`], for every slice.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn prove_select(input: Build, kinds: Slice<IndexKind>) -> usize {
    let options = input.options;
    // SAFETY: the caller's promise.
    let (scene, arena, scratch, kinds) = unsafe {
        let scene = scene(&input);
        (scene, input.arena.get(), input.scratch.get(), kinds.get())
    };
    match select::select(&scene, &options, kinds, arena, scratch) {
        Ok(selection) => message(&selection) + selection.candidates().len(),
        Err(error) => message(error),
    }
}

/// Finds clusters.
///
/// # Safety
/// As [`Slice::get`], for every slice.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn prove_clusters(input: Build) -> usize {
    let options = input.options;
    // SAFETY: the caller's promise.
    let (scene, scratch) = unsafe {
        let scene = scene(&input);
        (scene, input.scratch.get())
    };
    let clusters = match cluster::find(&scene, &options, scratch) {
        Ok(clusters) => clusters,
        Err(error) => return message(error),
    };
    let members: usize = clusters.iter().map(<[u32]>::len).sum();
    let classes = clusters.classes().iter().fold(0, |sum, class| sum ^ class);
    let needed = cluster::scratch_capacity(members);
    needed + clusters.count() + (classes ^ clusters.class_count()) as usize
}

/// Validates the bytes of an index and counts what is in it.
///
/// # Safety
/// As [`Slice::get`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn prove_index_bytes(number: usize, index_bytes: Slice<u8>, mesh: MeshParts) -> u64 {
    // SAFETY: the caller's promise.
    let (bytes, mesh) = unsafe { (index_bytes.get(), mesh.get()) };
    let index = match read(number, bytes, mesh) {
        Some(Ok(index)) => index,
        Some(Err(error)) => return message(error) as u64,
        None => return 0,
    };
    let sections = index.sections();
    let nodes = sections.nodes().iter().map(|leaf| sections.local_words(leaf).len() as u64);
    let statistics = index.check().unwrap_or_default();
    nodes.sum::<u64>()
        + u64::from(sections.cluster_count())
        + u64::from(index.kind().is_clustered())
        + index.kind().name().len() as u64
        + u64::from(sections.triangle_count())
        + statistics.joined(statistics).references
}

/// Opens the bytes of any kind of index by its header, and a stored one.
///
/// # Safety
/// Every slice must fulfil the conditions of [`Slice::get`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn prove_open(
    index_bytes: Slice<u8>,
    mesh: MeshParts,
    blocks: Slice<Block>,
    ray: RayNumbers,
) -> usize {
    // SAFETY: the caller's promise.
    let (bytes, mesh, blocks) = unsafe { (index_bytes.get(), mesh.get(), blocks.get()) };
    let opened = match mesh {
        Some(mesh) => AnyIndex::from_bytes_beside(bytes, mesh),
        None => AnyIndex::from_bytes(bytes),
    };
    let number = match opened {
        Ok(index) => index.kind() as usize + index.kind().family().len(),
        Err(error) => message(error),
    };
    let stored = match Stored::<_, Clustered<Octree>>::open(blocks) {
        Ok(stored) => stored,
        Err(error) => return message(error),
    };
    let Ok(ray) = ray.ray() else { return 0 };
    number + usize::from(stored.index().occluded(&ray)) + stored.into_storage().len()
}

/// Asks everything about one ray, of index bytes as they come from outside. Writes the closest hit.
///
/// # Safety
/// As [`Slice::get`], for every slice; `closest` and `counters` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn prove_queries(
    number: usize,
    index_bytes: Slice<u8>,
    mesh: MeshParts,
    ray: RayNumbers,
    hits: Slice<Hit>,
    closest: &mut Hit,
    counters: &mut Counters,
) -> usize {
    // SAFETY: the caller's promise.
    let (index_bytes, mesh, hits) = unsafe { (index_bytes.get(), mesh.get(), hits.get()) };
    let (Some(Ok(index)), Ok(ray)) = (read(number, index_bytes, mesh), ray.ray()) else {
        return 0;
    };
    let plain = index.closest_hit(&ray);
    let counted = index.closest_hit_counted(&ray, counters);
    *closest = plain.or(counted).unwrap_or(Hit::NONE);
    let occluded = index.occluded(&ray) || index.occluded_counted(&ray, counters);
    let AllHits { hits, truncated } = index.all_hits(&ray, hits);
    hits.len() + usize::from(occluded) + usize::from(truncated)
}

/// Asks about many rays of index bytes as they come from outside.
///
/// # Safety
/// As [`Slice::get`], for every slice.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn prove_many(
    number: usize,
    index_bytes: Slice<u8>,
    mesh: MeshParts,
    rays: Slice<Ray>,
    hits: Slice<Hit>,
    occluded: Slice<bool>,
) -> usize {
    // SAFETY: the caller's promise.
    let (index_bytes, mesh, rays, hits, occluded) =
        unsafe { (index_bytes.get(), mesh.get(), rays.get(), hits.get(), occluded.get()) };
    let Some(Ok(index)) = read(number, index_bytes, mesh) else {
        return 0;
    };
    index.closest_hits(rays, hits);
    index.occluded_each(rays, occluded);
    hits.len() + occluded.len()
}

/// Intersects one ray with one triangle.
///
/// # Safety
/// As the language's.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn prove_intersect(ray: RayNumbers, triangle: &Triangle) -> f32 {
    let ray = match ray.ray() {
        Ok(ray) => ray,
        Err(error) => return message(error) as f32,
    };
    let unfiltered = kernel::meet(&ray, triangle, ray.t_min(), ray.t_max());
    let t = unfiltered.map_or(0.0, |meeting| meeting.t());
    intersect(&ray, triangle).map_or(t, |hit| hit.t + hit.u + hit.v)
}

/// The rest of the geometry.
///
/// # Safety
/// As [`Slice::get`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn prove_geometry(
    ray: RayNumbers,
    triangle: &Triangle,
    bounds: &Aabb,
    axis: usize,
    blocks: Slice<Block>,
) -> f64 {
    let Ok(ray) = ray.ray() else {
        return 0.0;
    };
    let along = RaySpan::new(&ray);
    let span = along.clip(bounds, along.whole());
    let span = along.between(axis, span.from, span.to, span);
    let crossing = along.crossing(axis, f64::from(ray.at(1.0).x));
    let own = triangle.bounds();
    let near = own.gap_squared(bounds) + own.diagonal_squared() + f64::from(own.centre().x);
    let wide = |corner: Vec3| corner.to_array().map(f64::from);
    let overlap = may_overlap(triangle, wide(bounds.lo), wide(bounds.hi));
    let inside = bounds.contains(&own.with_point(triangle.at(0.25, 0.25) + triangle.normal()));
    // SAFETY: the caller's promise.
    let bytes = Block::bytes(unsafe { blocks.get() }).len() + Block::count(axis);
    let flags = f64::from(u8::from(overlap) + u8::from(inside));
    span.from + crossing.earliest + crossing.latest + near + flags + bytes as f64
}

/// One place of a slice, which may not be there.
///
/// # Safety
/// As [`Slice::get`].
#[cfg(feature = "control")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn prove_control(places: Slice<u8>, place: usize) -> u8 {
    // SAFETY: the caller's promise.
    let places = unsafe { places.get() };
    places[place]
}
