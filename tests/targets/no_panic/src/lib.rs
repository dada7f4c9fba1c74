//! Proof by linking: no panic is reachable in the core, and nothing allocates.
//!
//! - Exported functions call the core's public functions that compute, and write the messages of errors, on values
//!   unknown to the compiler.
//! - The panic handler calls a function that is not defined. So a program links only if the optimiser has removed every
//!   path to the panic handler.
//! - No allocator is defined, and the `alloc` crate is not linked.
//! - The functions of the C interface are exported already, and are linked like those here.
//!
//! The optimiser must find out that a check cannot fail. So the proof is for this compiler, at this optimisation level,
//! without overflow checks. It says nothing about the values, which other tests check.
//!
//! With the feature `control` one function can panic, and linking must fail. That shows that the proof can fail.
#![no_std]
// The functions are linked but never called from C.
#![allow(improper_ctypes_definitions)]

mod input;

use core::fmt::{self, Write};
use core::panic::PanicInfo;

// The exported functions of the C interface and of WebAssembly are linked as they are.
use arboleda_ffi as _;
use arboleda_wasm as _;

use arboleda::custom::{RaySpan, kernel, may_overlap};
use arboleda::kinds::{Clustered, Octree};
use arboleda::{
    Aabb, AllHits, AnyIndex, Block, Counters, Hit, IndexKind, PiecewiseBuild, Ray, SlicedBuild,
    Stored, Triangle, Vec3, clusters as cluster, intersect, select,
};

use input::{Build, MeshParts, RayNumbers, Slice, kind, read, scene};

unsafe extern "C" {
    /// Function without a definition, so that calling it is an error of the linker.
    fn a_panic_is_reachable() -> !;
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    // SAFETY: the program does not link if this call remains, so it is never executed.
    unsafe { a_panic_is_reachable() }
}

/// Output that keeps the lengths of messages only.
struct Sink(usize);

impl Write for Sink {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0 ^= text.len();
        Ok(())
    }
}

/// Writes an error's message; returns a number that depends on its length.
fn message(error: impl fmt::Display) -> usize {
    let mut sink = Sink(0);
    write!(sink, "{error}").map_or(0, |()| sink.0)
}

/// Computes the capacity of an index, and builds it. The result depends on all outputs, so none is optimised away.
///
/// # Safety
/// Each slice must fulfil the conditions of [`Slice::get`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn prove_build(input: Build) -> usize {
    let Some(kind) = kind(input.kind) else {
        return 0;
    };
    let options = input.options;
    // SAFETY: the caller fulfils the conditions of `Slice::get`.
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

/// Builds a wide BVH in slices.
///
/// # Safety
/// Each slice must fulfil the conditions of [`Slice::get`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn prove_build_in_slices(input: Build, looks: usize) -> usize {
    let options = input.options;
    // SAFETY: the caller fulfils the conditions of `Slice::get`.
    let (scene, arena, scratch) = unsafe {
        let scene = scene(&input);
        (scene, input.arena.get(), input.scratch.get())
    };
    let needed = SlicedBuild::scratch_capacity(scene.triangles().len());
    let mut build = match SlicedBuild::new(&scene, &options, arena, scratch) {
        Ok(build) => build,
        Err(error) => return message(error),
    };
    if let Err(error) = build.step(looks) {
        return message(error);
    }
    match build.finish() {
        Ok(index) => index.as_bytes().len() + needed,
        Err(error) => message(error),
    }
}

/// Finds clusters, and builds a hierarchy over them in pieces.
///
/// # Safety
/// Each slice must fulfil the conditions of [`Slice::get`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn prove_build_in_pieces(input: Build, room: Slice<u8>) -> usize {
    let Some(kind) = kind(input.kind) else {
        return 0;
    };
    let options = input.options;
    // SAFETY: the caller fulfils the conditions of `Slice::get`.
    let (scene, memory, scratch, room) = unsafe {
        let scene = scene(&input);
        (scene, input.arena.get(), input.scratch.get(), room.get())
    };
    let clusters = match cluster::find(&scene, &options, scratch) {
        Ok(clusters) => clusters,
        Err(error) => return message(error),
    };
    let needed = kind.memory_in_pieces(&clusters, &options);
    let build = match kind.build_in_pieces(&scene, &options, &clusters, memory) {
        Ok(build) => build,
        Err(error) => return message(error),
    };
    all_pieces(build, room) + needed
}

fn all_pieces(mut build: PiecewiseBuild<'_, '_>, room: &mut [u8]) -> usize {
    let mut sum = build.triangles_offset();
    loop {
        match build.build_next(room) {
            Ok(Some(piece)) => sum ^= piece.offset ^ piece.bytes.len(),
            Ok(None) => break,
            Err(error) => return message(error),
        }
    }
    sum ^= build.length() ^ build.progress().1 ^ build.steps() as usize;
    match build.finish() {
        Ok(pieces) => pieces.iter().fold(sum, |sum, piece| sum ^ piece.offset ^ piece.bytes.len()),
        Err(error) => message(error),
    }
}

/// Selects an index, and writes the reasons.
///
/// # Safety
/// Each slice must fulfil the conditions of [`Slice::get`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn prove_select(input: Build, kinds: Slice<IndexKind>) -> usize {
    let options = input.options;
    // SAFETY: the caller fulfils the conditions of `Slice::get`.
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
/// Each slice must fulfil the conditions of [`Slice::get`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn prove_clusters(input: Build) -> usize {
    let options = input.options;
    // SAFETY: the caller fulfils the conditions of `Slice::get`.
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

/// Opens index bytes as a kind of index, and computes their statistics.
///
/// # Safety
/// Each slice must fulfil the conditions of [`Slice::get`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn prove_opening(number: usize, bytes: Slice<u8>, mesh: MeshParts) -> u64 {
    // SAFETY: the caller fulfils the conditions of `Slice::get`.
    let (bytes, mesh) = unsafe { (bytes.get(), mesh.get()) };
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

/// Opens index bytes by their header, and a stored index.
///
/// # Safety
/// Each slice must fulfil the conditions of [`Slice::get`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn prove_open(
    bytes: Slice<u8>,
    mesh: MeshParts,
    blocks: Slice<Block>,
    ray: RayNumbers,
) -> usize {
    // SAFETY: the caller fulfils the conditions of `Slice::get`.
    let (bytes, mesh, blocks) = unsafe { (bytes.get(), mesh.get(), blocks.get()) };
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

/// Answers all queries of one ray from index bytes of the caller. Writes the closest hit.
///
/// # Safety
/// Each slice must fulfil the conditions of [`Slice::get`]; `closest` and `counters` must be writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn prove_queries(
    number: usize,
    bytes: Slice<u8>,
    mesh: MeshParts,
    ray: RayNumbers,
    hits: Slice<Hit>,
    closest: &mut Hit,
    counters: &mut Counters,
) -> usize {
    // SAFETY: the caller fulfils the conditions of `Slice::get`.
    let (bytes, mesh, hits) = unsafe { (bytes.get(), mesh.get(), hits.get()) };
    let (Some(Ok(index)), Ok(ray)) = (read(number, bytes, mesh), ray.ray()) else {
        return 0;
    };
    let plain = index.closest_hit(&ray);
    let counted = index.closest_hit_counted(&ray, counters);
    *closest = plain.or(counted).unwrap_or(Hit::NONE);
    let occluded = index.occluded(&ray) || index.occluded_counted(&ray, counters);
    let AllHits { hits, truncated } = index.all_hits(&ray, hits);
    hits.len() + usize::from(occluded) + usize::from(truncated)
}

/// Answers batch queries from index bytes of the caller.
///
/// # Safety
/// Each slice must fulfil the conditions of [`Slice::get`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn prove_many(
    number: usize,
    bytes: Slice<u8>,
    mesh: MeshParts,
    rays: Slice<Ray>,
    hits: Slice<Hit>,
    occluded: Slice<bool>,
    scratch: Slice<u8>,
) -> usize {
    // SAFETY: the caller fulfils the conditions of `Slice::get`.
    let (bytes, mesh, rays, hits, occluded, scratch) =
        unsafe { (bytes.get(), mesh.get(), rays.get(), hits.get(), occluded.get(), scratch.get()) };
    let Some(Ok(index)) = read(number, bytes, mesh) else {
        return 0;
    };
    index.closest_hits(rays, hits);
    index.occluded_each(rays, occluded);
    index.closest_hits_in(rays, hits, scratch);
    index.occluded_each_in(rays, occluded, scratch);
    hits.len() + occluded.len()
}

/// Intersects one ray with one triangle.
///
/// # Safety
/// References must be valid, as the language requires.
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

/// Calls the other public functions of the geometry.
///
/// # Safety
/// Each slice must fulfil the conditions of [`Slice::get`].
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
    let along = RaySpan::new(&ray, bounds);
    let span = along.clip(bounds, along.whole());
    let span = along.between(axis, span.from, span.to, span);
    let crossing = along.crossing(axis, ray.at(1.0).x);
    let own = triangle.bounds();
    let near = own.gap_squared(bounds) + own.diagonal_squared() + f64::from(own.centre().x);
    let wide = |corner: Vec3| corner.to_array().map(f64::from);
    let overlap = may_overlap(triangle, wide(bounds.lo), wide(bounds.hi));
    let inside = bounds.contains(&own.with_point(triangle.at(0.25, 0.25) + triangle.normal()));
    // SAFETY: the caller fulfils the conditions of `Slice::get`.
    let bytes = Block::bytes(unsafe { blocks.get() }).len() + Block::count(axis);
    let flags = f64::from(u8::from(overlap) + u8::from(inside));
    let bounds = span.from + crossing.earliest + crossing.latest;
    f64::from(bounds) + near + flags + bytes as f64
}

/// Reads an element of a slice, which panics if the slice is shorter.
///
/// # Safety
/// Each slice must fulfil the conditions of [`Slice::get`].
#[cfg(feature = "control")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn prove_control(places: Slice<u8>, place: usize) -> u8 {
    // SAFETY: the caller fulfils the conditions of `Slice::get`.
    let places = unsafe { places.get() };
    places[place]
}
