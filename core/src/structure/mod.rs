//! The contract of an index: what it is built from, what it writes, and how it shows triangles to a query.
//!
//! ```text
//! LocalIndex       one group of triangles        octree, grid, kd-tree, BVH, ...
//! Structure        all clusters                  one index in each, below the cluster tree; or one over all
//! Representation   with clusters, or without     what an `Index` is
//! ```

mod parts;
pub(crate) mod sections;
mod statistics;

use core::ops::ControlFlow;

pub use parts::{DividedScene, Group, Local};
pub use sections::Sections;
pub use statistics::Statistics;

use crate::cost::Weights;
use crate::error::BuildError;
use crate::geometry::{RaySpan, Span};
use crate::input::{CostModel, Executor, Options, SimdLevel};
use crate::memory::Words;
use crate::query::Query;
use sections::WORDS_HOLD_TRIANGLES;

/// What an index is, beside what it does: its names, its format and its costs.
///
/// The single source of these: command lines, tables, [`crate::IndexKind`] and [`crate::select`] read them here.
pub trait Described: 'static {
    /// The name of the simple representation, for command lines and tables.
    const NAME: &'static str;
    /// The name of the clustered representation.
    const HIERARCHY_NAME: &'static str;
    /// The number that tells formats apart, below 2^16, never used again for another format.
    const FORMAT: u32;
    /// What a node costs in triangle tests, for deciding how far to divide, as it was measured;
    /// [`Options::cost`] overrides it.
    const COST: CostModel = CostModel::tests_per_node(1.0);
    /// Whether what is built goes by [`Scene::rays`](crate::Scene::rays). No answer does.
    const USES_RAYS: bool = false;
    /// What a query takes on a processor with `f64` in hardware, as it was measured; see [`Weights`].
    const WEIGHTS: Weights = Weights::UNKNOWN;
    /// As `WEIGHTS`, on a processor that calculates `f64` in software.
    const SOFTWARE_WEIGHTS: Weights = Weights::UNKNOWN;
}

/// A spatial index over one group of triangles, written as a run of `u32` words.
///
/// It need not decide anything exactly: it shows triangles to a [`Query`], which does. It must show
/// every triangle that the ray hits in the span, unless the hit lies beyond [`Query::last`] at the time.
pub trait LocalIndex: Described {
    /// A bound on the scratch bytes that a group of `triangle_count` needs.
    fn scratch_bytes(triangle_count: usize, options: &Options) -> usize;

    /// Appends the group's index to `words`, with all links relative to its first word. What is
    /// written must depend on the arguments only, and not on words read back. The work must be bounded by a multiple
    /// of `n log n` wherever the triangles lie; [`Words::spend`] counts it.
    ///
    /// # Errors
    /// [`BuildError::TooLarge`] if links outgrow their field, [`BuildError::TooMuchWork`] from [`Words::spend`].
    fn build(
        group: &Group<'_>,
        options: &Options,
        words: &mut Words<'_>,
        scratch: &mut [u8],
    ) -> Result<(), BuildError>;

    /// Shows `query` the triangles near the part `span` of the ray, which lies in the group's box.
    fn traverse<Q: Query>(
        local: &Local<'_>,
        ray: &RaySpan,
        span: Span,
        query: &mut Q,
    ) -> ControlFlow<()>;

    /// Checks everything on which `traverse` relies to end and to stay inside, for any words, and says
    /// what the index consists of. `None` if something is wrong. Cost: linear.
    fn check(local: &Local<'_>) -> Option<Statistics>;
}

/// What lies over all clusters and answers queries.
///
/// Every [`LocalIndex`] is one: an index for each cluster, below the cluster tree. An index that mixes
/// both in its own nodes implements this instead.
pub trait Structure: Described {
    /// Whether the words hold the triangles, so that the image need not.
    const HOLDS_TRIANGLES: bool = false;
    /// True if `build` reads the cluster tree. If false, a dry run makes no tree, and [`DividedScene::nodes`] is empty.
    const READS_TREE: bool = true;

    /// A bound on the scratch bytes that `triangle_count` triangles need, however they are divided.
    fn scratch_bytes(triangle_count: usize, options: &Options) -> usize;

    /// Writes the index to `words`, and tells the leaves of the cluster tree which words are theirs. What
    /// is written must depend on the other arguments only, and not on the executor or on words read back.
    ///
    /// # Errors
    /// [`BuildError::TooLarge`] if links outgrow their field.
    fn build(
        division: DividedScene<'_>,
        options: &Options,
        words: &mut Words<'_>,
        scratch: &mut [u8],
        executor: &impl Executor,
    ) -> Result<(), BuildError>;

    /// Shows `query` the triangles near its ray, until it knows the answer.
    fn traverse<Q: Query>(sections: &Sections<'_>, simd_level: SimdLevel, query: &mut Q);

    /// Answers `count` queries, in any order: `start` makes the one of a number, `finish` sees it answered.
    #[inline]
    fn traverse_each<Q: Query>(
        sections: &Sections<'_>,
        simd_level: SimdLevel,
        count: usize,
        start: impl Fn(usize) -> Option<Q>,
        mut finish: impl FnMut(usize, &Q),
    ) {
        for index in 0..count {
            let Some(mut query) = start(index) else { return };
            Self::traverse(sections, simd_level, &mut query);
            finish(index, &query);
        }
    }

    /// Checks everything on which `traverse` relies to end and to stay inside, for any words, and says
    /// what the index consists of. Cost: linear.
    ///
    /// # Errors
    /// The number of the cluster in which something is wrong.
    fn check(sections: &Sections<'_>) -> Result<Statistics, u32>;
}

/// What an index consists of: a structure over the whole scene, or over its clusters.
///
/// Implemented for every [`Structure`] (the *simple* representations) and for [`Clustered`](crate::kinds::Clustered) of it
/// (the *composite* ones).
pub trait Representation: 'static {
    /// The structure.
    type Structure: Structure;
    /// Whether the scene is divided into clusters.
    const CLUSTERED: bool;
    /// The name used on command lines and in tables.
    const NAME: &'static str;
    /// The number that tells formats apart.
    const FORMAT: u32 = <Self::Structure as Described>::FORMAT
        | (Self::CLUSTERED as u32) << 16
        | if Self::Structure::HOLDS_TRIANGLES { WORDS_HOLD_TRIANGLES } else { 0 };
}

impl<S: Structure> Representation for S {
    type Structure = S;
    const CLUSTERED: bool = false;
    const NAME: &'static str = S::NAME;
}
