//! Test of the triangles that a leaf names: four or eight at once, in lanes of `f32`, and the survivors one by one,
//! exactly.
//!
//! Targets without vector registers test one triangle at a time.

use core::ops::ControlFlow;

use glam::{Mat4, Vec4};

use super::candidates::decide_each;
use super::portable::Portable;
use crate::geometry::{
    Candidates, LaneRay, Points, RaySpan, Triangle, longest_edges, meet_triangles,
};
use crate::input::{Mesh, SimdLevel};
use crate::query::{Query, TriangleId};

/// True if `glam` uses vector registers of four `f32` on this target: SSE2, NEON, simd128.
pub(crate) const HAS_VECTORS: bool =
    cfg!(any(target_feature = "sse2", target_feature = "neon", target_feature = "simd128"));

/// Shows a query the triangles of a mesh that `ids` names.
#[inline]
pub(crate) fn test_triangles<Q: Query>(
    mesh: Mesh<'_>,
    ids: &[u32],
    ray: &RaySpan,
    level: SimdLevel,
    query: &mut Q,
) -> ControlFlow<()> {
    // All of them at first: how many are tested at once must not show where a test ends an any-hit query.
    query.count_tests(ids.len() as u32);
    let (Some(lanes), true) = (ray.lanes(), HAS_VECTORS) else {
        return test_singly(mesh, ids, query);
    };
    #[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
    if let Some(flow) = super::avx2_leaf::test(level, mesh, ids, lanes, query) {
        return flow;
    }
    let _ = level;
    test_in_lanes(mesh, ids, lanes, query)
}

/// Shows a query the triangles of a mesh that `ids` names, one at a time.
#[inline(never)]
pub(crate) fn test_each<Q: Query>(mesh: Mesh<'_>, ids: &[u32], query: &mut Q) -> ControlFlow<()> {
    for_each_triangle(mesh, ids, |id, triangle| query.test(id, triangle))
}

/// Tests one triangle at a time, without counting.
#[inline(never)]
fn test_singly<Q: Query>(mesh: Mesh<'_>, ids: &[u32], query: &mut Q) -> ControlFlow<()> {
    for_each_triangle(mesh, ids, |id, triangle| query.test_counted(id, triangle))
}

/// Calls `test` with each triangle of a mesh that `ids` names.
#[inline]
fn for_each_triangle(
    mesh: Mesh<'_>,
    ids: &[u32],
    mut test: impl FnMut(TriangleId, &Triangle) -> ControlFlow<()>,
) -> ControlFlow<()> {
    for &id in ids {
        // A list by reference: copying every triangle would double the time of a linear scan.
        if let Mesh::Triangles(triangles) = mesh {
            let Some(triangle) = triangles.get(id as usize) else { continue };
            test(TriangleId(id), triangle)?;
        } else if let Some(triangle) = mesh.get(id) {
            test(TriangleId(id), &triangle)?;
        }
    }
    ControlFlow::Continue(())
}

/// Tests four triangles at a time.
#[inline(never)]
fn test_in_lanes<Q: Query>(
    mesh: Mesh<'_>,
    ids: &[u32],
    ray: &LaneRay,
    query: &mut Q,
) -> ControlFlow<()> {
    for ids in ids.chunks(4) {
        // A list by reference: copying every triangle would cost a BVH 12% more instructions.
        if let Mesh::Triangles(triangles) = mesh {
            let four = four_of(|id| triangles.get(id as usize), ids);
            if let Some(four) = four {
                test_four(four, ids, ray, query)?;
            }
        } else if let Some(four) = four_of(|id| mesh.get(id), ids) {
            test_four(four.each_ref(), ids, ray, query)?;
        }
    }
    ControlFlow::Continue(())
}

/// The triangles of one to four ids. Lanes that are left over have the first triangle again, and are not looked at.
#[inline]
pub(super) fn four_of<T>(get: impl Fn(u32) -> Option<T>, ids: &[u32]) -> Option<[T; 4]> {
    let first = *ids.first()?;
    let id = |lane: usize| ids.get(lane).copied().unwrap_or(first);
    Some([get(first)?, get(id(1))?, get(id(2))?, get(id(3))?])
}

#[inline]
fn test_four<Q: Query>(
    four: [&Triangle; 4],
    ids: &[u32],
    ray: &LaneRay,
    query: &mut Q,
) -> ControlFlow<()> {
    let met = meet_four::<Q>(four, ray, query.last_t());
    decide_each::<Portable, Q>(met.within((1 << ids.len()) - 1).of(query)?, ray, query, |lane| {
        let id = ids.get(lane).copied().unwrap_or(u32::MAX);
        (TriangleId(id), *four[lane % 4])
    })
}

/// Filters four triangles.
// Forced: `avx2_leaf` compiles this for AVX2.
#[allow(clippy::inline_always)]
#[inline(always)]
pub(super) fn meet_four<Q: Query>(four: [&Triangle; 4], ray: &LaneRay, last: f32) -> Candidates {
    let corners = corners_of(four);
    meet_triangles(corners, ray, longest_edges(corners), last, Q::ANY)
}

/// Transposes four triangles: their corners, one triangle in each lane.
// Forced: see `meet_four`.
#[allow(clippy::inline_always)]
#[inline(always)]
fn corners_of(triangles: [&Triangle; 4]) -> [Points<Vec4>; 3] {
    let [p, q, r, s]: [&[f32; 9]; 4] = triangles.map(bytemuck::must_cast_ref);
    // Four numbers of four triangles at once: a row is read with one load, and becomes a column.
    let columns = |at: usize| {
        let row = |numbers: &[f32; 9]| {
            Vec4::new(numbers[at], numbers[at + 1], numbers[at + 2], numbers[at + 3])
        };
        Mat4::from_cols(row(p), row(q), row(r), row(s)).transpose()
    };
    let (first, second) = (columns(0), columns(4));
    let last = Vec4::new(p[8], q[8], r[8], s[8]);
    [
        [first.x_axis, first.y_axis, first.z_axis],
        [first.w_axis, second.x_axis, second.y_axis],
        [second.z_axis, second.w_axis, last],
    ]
}
