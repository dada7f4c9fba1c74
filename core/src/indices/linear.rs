//! Linear scan: every triangle is tested. The oracle that all indices are compared with.
//!
//! ```text
//! words:  id id id ...
//! ```

use core::ops::ControlFlow;

use crate::error::BuildError;
use crate::geometry::{RaySpan, Span};
use crate::input::Options;
use crate::memory::Words;
use crate::query::Query;
use crate::structure::{Described, Group, Local, LocalIndex, Statistics, Weights};

/// Linear scan: no tree, every triangle is tested.
pub enum Linear {}

/// Bounds the scratch; see [`LocalIndex::scratch_bytes`].
pub(crate) const fn scratch_bytes(_: usize, _: &Options) -> usize {
    0
}

impl Described for Linear {
    const NAME: &'static str = "linear";
    const HIERARCHY_NAME: &'static str = "linear-hierarchy";
    const FORMAT: u32 = 1;
    const WEIGHTS: Weights = Weights { ray: 8.0, node: 9.8, test: 9.2 }; // +-4%
    const SOFTWARE_WEIGHTS: Weights = Weights { ray: 68_967.0, node: 7_602.0, test: 1_942.0 }; // +-1%
}

impl LocalIndex for Linear {
    fn scratch_bytes(triangle_count: usize, options: &Options) -> usize {
        scratch_bytes(triangle_count, options)
    }

    fn build(
        group: &Group<'_>,
        _: &Options,
        words: &mut Words<'_>,
        _: &mut [u8],
    ) -> Result<(), BuildError> {
        words.spend(group.ids.len() as u64)?;
        words.extend(group.ids);
        Ok(())
    }

    fn traverse<Q: Query>(
        local: &Local<'_>,
        _: &RaySpan,
        _: Span,
        query: &mut Q,
    ) -> ControlFlow<()> {
        local.test_singly(query)
    }

    fn check(local: &Local<'_>) -> Option<Statistics> {
        let count = local.words.len() as u32;
        let mut statistics = Statistics::default();
        statistics.add_leaf(count, 0);
        local.are_ids(0, count).then_some(statistics)
    }
}
