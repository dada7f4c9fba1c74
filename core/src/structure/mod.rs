//! The contract of an index: its input, its output, how it shows triangles to a query, and what that takes.
//!
//! ```text
//! LocalIndex       one group of triangles        octree, grid, kd-tree, BVH, ...
//! Structure        all clusters                  one index in each, below the cluster tree; or one over all
//! Representation   with clusters, or without     what an `Index` is
//! ```

mod parts;
pub(crate) mod sections;
mod statistics;
mod weights;

use core::ops::ControlFlow;

pub use parts::{DividedScene, Group, Local};
pub use sections::Sections;
pub use statistics::Statistics;
pub use weights::Weights;

use crate::error::BuildError;
use crate::geometry::{RaySpan, Span};
use crate::input::{CostModel, Executor, Options, SimdLevel};
use crate::memory::Words;
use crate::query::{BatchQuery, Hit, Query};
use sections::WORDS_HOLD_TRIANGLES;

/// Description of an index: names, format number, costs and weights.
///
/// It is the single source of them: command lines, tables, [`crate::IndexKind`] and [`crate::select`] read them here.
pub trait Described: 'static {
    /// The name of the simple representation, for command lines and tables.
    const NAME: &'static str;
    /// The name of the clustered representation.
    const HIERARCHY_NAME: &'static str;
    /// The number of the format, below 2^16. It is never used again for another format.
    const FORMAT: u32;
    /// The cost model of builds that estimate: the cost of a node in triangle tests, as measured. [`Options::cost`]
    /// overrides it.
    const COST: CostModel = CostModel::tests_per_node(1.0);
    /// True if `build` uses [`Scene::rays`](crate::Scene::rays) as a tuning sample. Query results never depend on the
    /// rays.
    const USES_RAYS: bool = false;
    /// The weights of a query on a processor with `f64` in hardware, as measured; see [`Weights`].
    const WEIGHTS: Weights = Weights::UNKNOWN;
    /// The weights of a query on a processor that calculates `f64` in software; see [`Weights`].
    const SOFTWARE_WEIGHTS: Weights = Weights::UNKNOWN_IN_SOFTWARE;
}

/// Spatial index over one group of triangles, written as a run of `u32` words.
///
/// It need not decide anything exactly, because it shows triangles to a [`Query`], which decides. It must show every
/// triangle that the ray hits within the span, unless the hit lies beyond [`Query::last_t`] at that time.
pub trait LocalIndex: Described {
    /// Bounds the scratch bytes that the build for a group of `triangle_count` triangles needs.
    fn scratch_bytes(triangle_count: usize, options: &Options) -> usize;

    /// Appends the group's index to `words`, with all links relative to its first word.
    ///
    /// The words must depend on the arguments only, and not on words read back. The work must be bounded by a multiple
    /// of `n log n`, wherever the triangles lie; [`Words::spend`] counts it.
    ///
    /// # Errors
    /// [`BuildError::TooLarge`] if a link does not fit its field, [`BuildError::TooMuchWork`] from [`Words::spend`],
    /// [`BuildError::ScratchFull`] and [`BuildError::Misaligned`] for the scratch.
    fn build(
        group: &Group<'_>,
        options: &Options,
        words: &mut Words<'_>,
        scratch: &mut [u8],
    ) -> Result<(), BuildError>;

    /// Shows `query` the triangles near the part `span` of the ray, which lies in the group's box. Returns `Break` if
    /// the query did.
    fn traverse<Q: Query>(
        local: &Local<'_>,
        ray: &RaySpan,
        span: Span,
        query: &mut Q,
    ) -> ControlFlow<()>;

    /// Checks everything on which `traverse` relies to end and to stay in bounds, for any words. Returns what the index
    /// consists of; `None` if something is wrong. Cost: linear.
    fn check(local: &Local<'_>) -> Option<Statistics>;
}

/// Build of the local index of one cluster; see [`LocalIndex::build`].
pub type ClusterBuild =
    fn(&Group<'_>, &Options, &mut Words<'_>, &mut [u8]) -> Result<(), BuildError>;

/// Spatial index over all clusters of a scene.
///
/// Every [`LocalIndex`] is a structure: one local index for each cluster, below the cluster tree. An index that joins
/// clusters in its own nodes implements this trait instead.
pub trait Structure: Described {
    /// True if the words hold the triangles, so that the index has no section of triangles.
    const HOLDS_TRIANGLES: bool = false;
    /// True if `build` reads the cluster tree. If false, a dry run makes no tree, and [`DividedScene::nodes`] is empty
    /// in it.
    const READS_TREE: bool = true;
    /// Function that writes the words of one cluster, for a [build in pieces](crate::PiecewiseBuild); `None` if the words
    /// are those of all clusters together.
    const BUILD_CLUSTER: Option<ClusterBuild> = None;

    /// Bounds the scratch bytes that the build for `triangle_count` triangles needs, whatever the clusters.
    fn scratch_bytes(triangle_count: usize, options: &Options) -> usize;

    /// Writes the index to `words`, and writes to each leaf of the cluster tree which words are its own.
    ///
    /// The words must depend on the other arguments only, and not on the executor or on words read back.
    ///
    /// # Errors
    /// [`BuildError::TooLarge`] if a link does not fit its field, [`BuildError::TooMuchWork`] from [`Words::spend`].
    fn build(
        division: DividedScene<'_>,
        options: &Options,
        words: &mut Words<'_>,
        scratch: &mut [u8],
        executor: &impl Executor,
    ) -> Result<(), BuildError>;

    /// Shows `query` the triangles near its ray, until the query knows the answer.
    fn traverse<Q: Query>(sections: &Sections<'_>, simd_level: SimdLevel, query: &mut Q);

    /// Answers `count` queries, in any order. `start` makes the query of an index, and `finish` receives its answer.
    /// `scratch` may have any length and alignment, and its contents do not matter.
    #[inline]
    fn traverse_each<Q: BatchQuery>(
        sections: &Sections<'_>,
        simd_level: SimdLevel,
        _scratch: &mut [u8],
        count: usize,
        start: impl Fn(usize) -> Option<Q>,
        mut finish: impl FnMut(usize, Hit),
    ) {
        for index in 0..count {
            let Some(mut query) = start(index) else { return };
            Self::traverse(sections, simd_level, &mut query);
            finish(index, query.answer());
        }
    }

    /// Checks everything on which `traverse` relies to end and to stay in bounds, for any words. Returns what the index
    /// consists of. Cost: linear.
    ///
    /// # Errors
    /// The number of the cluster in which something is wrong.
    fn check(sections: &Sections<'_>) -> Result<Statistics, u32>;
}

/// Representation of a scene: a structure over the whole scene, or over its clusters.
///
/// Implemented for every [`Structure`] (the paper's *simple* representations), and for
/// [`Clustered`](crate::kinds::Clustered) of it (the paper's *composite* representations).
pub trait Representation: 'static {
    /// The structure.
    type Structure: Structure;
    /// True if the scene is divided into clusters.
    const CLUSTERED: bool;
    /// The name used on command lines and in tables.
    const NAME: &'static str;
    /// The number of the format: [`Described::FORMAT`], bit 16 if clustered, bit 17 if the words hold the triangles.
    const FORMAT: u32 = <Self::Structure as Described>::FORMAT
        | (Self::CLUSTERED as u32) << 16
        | if Self::Structure::HOLDS_TRIANGLES { WORDS_HOLD_TRIANGLES } else { 0 };
}

impl<S: Structure> Representation for S {
    type Structure = S;
    const CLUSTERED: bool = false;
    const NAME: &'static str = S::NAME;
}
