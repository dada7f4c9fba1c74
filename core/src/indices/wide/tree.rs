//! Contract between the traversal and the forms in which nodes and leaves are written.

use core::ops::ControlFlow;

use super::rows::{EMPTY, LANES};
use super::simd::{LaneRay, Lanes};
use crate::Vec3;
use crate::geometry::kernel::Verdict;
use crate::geometry::{Aabb, Triangle};
use crate::query::{Query, TriangleId};

/// Tree of nodes of up to eight boxes, and of leaves of up to eight triangles.
pub(crate) trait Tree: Copy {
    /// The node or leaf where a traversal begins.
    fn root(self) -> Step;

    /// The largest absolute value of any triangle's coordinates.
    fn largest(self) -> f32;

    /// Calls `show` with each child of a node and its lane, until it breaks.
    fn for_each_child(
        self,
        link: u32,
        show: impl FnMut(usize, Step, Aabb) -> ControlFlow<()>,
    ) -> ControlFlow<()>;

    /// Shows the query the triangles of a leaf, without a filter, and counts them.
    fn decide_leaf<Q: Query>(self, step: Step, query: &mut Q) -> ControlFlow<()>;
}

/// Tree that can be read by the lanes `L`.
pub(crate) trait InLanes<L: Lanes>: Tree {
    /// Tests the boxes of a node; see [`Lanes::meet_boxes`]. `None` for a link that leads nowhere.
    fn meet_node(self, link: u32, ray: &LaneRay, last: f32) -> Option<L::Keys>;

    /// The child in one lane of a node.
    fn child(self, link: u32, lane: usize) -> Option<Step>;

    /// Tests the triangles of a leaf: counts all, and lets the query judge those that the ray may hit up to `last`.
    fn test_leaf<Q: Query>(
        self,
        step: Step,
        ray: &LaneRay,
        last: f32,
        query: &mut Q,
    ) -> ControlFlow<()>;

    /// Prefetches what a link leads to.
    #[inline(always)]
    fn prefetch(self, _: u32) {}
}

/// Node or leaf to be entered.
#[derive(Clone, Copy)]
pub(crate) struct Step {
    /// The link; to a leaf if [`LEAF_BIT`](super::rows::LEAF) is set.
    pub link: u32,
    /// Leaf metadata kept in the parent (longest edge and first lane; see `rows`), or 0 if the format has none.
    pub edge: u32,
}

impl Step {
    /// The step to nothing.
    pub const NOWHERE: Self = Self { link: EMPTY, edge: 0 };
}

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
