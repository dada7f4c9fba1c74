//! Decision about the triangles that lanes have left in doubt.

// Forced, because what a traversal calls must be compiled for the instructions of its lanes, in one function with it.
#![allow(clippy::inline_always)]

use core::ops::ControlFlow;

use super::lanes::{LANES, Lanes};
use crate::Vec3;
use crate::geometry::kernel::Verdict;
use crate::geometry::{LaneRay, Triangle};
use crate::query::{Query, TriangleId};

/// The query's last `t`, as lanes compare with it.
///
/// It is read anew at each node. Kept in the traversal's state, compilers load it together with its neighbours, and the
/// processor waits until all of them are written.
#[inline(always)]
pub(crate) fn last_t<Q: Query>(query: &Q) -> f32 {
    let t = query.last_t();
    if t < f32::MAX { t } else { f32::MAX }
}

/// Lets the query judge the triangles whose bits are set, after the filter [`Lanes::judge`].
#[inline(always)]
pub(crate) fn decide_each<L: Lanes, Q: Query>(
    mut candidates: u32,
    ray: &LaneRay,
    query: &mut Q,
    triangle: impl Fn(usize) -> (TriangleId, Triangle),
) -> ControlFlow<()> {
    while candidates != 0 {
        let lane = candidates.trailing_zeros() as usize % LANES;
        candidates &= candidates - 1;
        let (id, corners) = triangle(lane);
        match L::judge(&corners, ray, query.last_t()) {
            Verdict::Missed => {}
            Verdict::Hit(hit) => query.accept(id, hit)?,
            // The triangle is read once more: kept until here, the corners of every triangle would be written to the
            // stack.
            doubt => {
                let (triangle_again, direction) = (triangle(lane).1, query.ray().direction());
                if triangle_again.is_along(direction) {
                    candidates = without_flat(candidates, direction, &triangle);
                } else {
                    query.judge(id, &triangle_again, doubt)?;
                }
            }
        }
    }
    ControlFlow::Continue(())
}

/// Takes out the triangles that have no extent on an axis on which the direction is 0: the ray hits none of them, see
/// [`Triangle::is_along`]. The filters cannot reject one in whose plane the ray runs, and in a large plane there are
/// many.
///
/// # What lost
/// Taking them out before the filter: a ray in a large plane takes a third of the instructions, but every ray 1% to 2%
/// more.
#[cold]
#[inline(never)]
fn without_flat(
    candidates: u32,
    direction: Vec3,
    triangle: &impl Fn(usize) -> (TriangleId, Triangle),
) -> u32 {
    let is_flat = |lane: &usize| triangle(*lane).1.is_along(direction);
    let lanes = (0..LANES).filter(|lane| candidates >> lane & 1 != 0);
    lanes.filter(is_flat).fold(candidates, |left, lane| left & !(1 << lane))
}
