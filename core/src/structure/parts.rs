//! Input of a build, and of a traversal.

use core::ops::ControlFlow;

use super::Sections;
use crate::cluster::{ClusterNode, Clusters};
use crate::geometry::{Aabb, Ray, RaySpan};
use crate::input::{Mesh, SimdLevel};
use crate::query::Query;
use crate::simd::{test_each, test_triangles};

/// Scene that has been divided into clusters: the input of a [`Structure`](crate::custom::Structure)'s build.
pub struct DividedScene<'a> {
    /// All triangles of the scene.
    pub triangles: Mesh<'a>,
    /// Rays like those that the index will be asked about; empty if unknown.
    pub rays: &'a [Ray],
    /// The clusters. A representation without clusters has one cluster.
    pub clusters: &'a Clusters<'a>,
    /// The cluster tree, its leaves first. The build sets the links of leaves. Empty in a dry run of a structure that
    /// does not [read](crate::custom::Structure::READS_TREE) the tree.
    pub nodes: &'a mut [ClusterNode],
}

impl DividedScene<'_> {
    /// Gives all `word_count` words to the first leaf of the cluster tree: one index over all clusters.
    pub(crate) fn first_owns(&mut self, word_count: usize) {
        let words = word_count as u32;
        for (at, (leaf, _)) in self.nodes.iter_mut().zip(self.clusters.iter()).enumerate() {
            leaf.links = if at == 0 { [0, words] } else { [words, 0] };
        }
    }
}

/// Group of triangles: the input of a [`LocalIndex`](crate::custom::LocalIndex)'s build.
#[derive(Clone, Copy)]
pub struct Group<'a> {
    /// All triangles of the scene.
    pub triangles: Mesh<'a>,
    /// Rays like those that the scene will be asked about; empty if unknown. They need not come near the group.
    pub rays: &'a [Ray],
    /// The ids of the group's triangles, ascending; at least one.
    pub ids: &'a [u32],
    /// The smallest box around the group.
    pub bounds: Aabb,
}

/// Local index of a group, ready for a traversal.
#[derive(Clone, Copy)]
pub struct Local<'a> {
    /// All triangles of the scene.
    pub triangles: Mesh<'a>,
    /// The smallest box around the group.
    pub bounds: Aabb,
    /// The words that `build` wrote.
    pub words: &'a [u32],
    /// The vector instructions that [`Local::test`] may use.
    pub simd_level: SimdLevel,
}

impl<'a> Local<'a> {
    #[inline]
    pub(crate) fn of(sections: &Sections<'a>, leaf: &ClusterNode, simd_level: SimdLevel) -> Self {
        Self {
            triangles: sections.triangles(),
            bounds: leaf.bounds,
            words: sections.local_words(leaf),
            simd_level,
        }
    }

    /// The word at offset `at`; 0 past the end.
    #[inline]
    pub fn word(&self, at: u32) -> u32 {
        self.words.get(at as usize).copied().unwrap_or(0)
    }

    /// The `N` words from offset `at`; zeros if some lie past the end.
    #[inline]
    pub fn words_at<const N: usize>(&self, at: u32) -> [u32; N] {
        let words = self.words.get(at as usize..).and_then(|rest| rest.first_chunk());
        words.copied().unwrap_or([0; N])
    }

    /// Shows `query` the triangles that the `count` words from offset `first` name, several at once.
    #[inline]
    pub fn test<Q: Query>(
        &self,
        first: u32,
        count: u32,
        ray: &RaySpan,
        query: &mut Q,
    ) -> ControlFlow<()> {
        let first = first as usize;
        let ids = self.words.get(first..first.saturating_add(count as usize)).unwrap_or(&[]);
        test_triangles(self.triangles, ids, ray, self.simd_level, query)
    }

    /// Shows `query` the triangles that all words name, one at a time: the filter of several triangles takes no part.
    pub(crate) fn test_singly<Q: Query>(&self, query: &mut Q) -> ControlFlow<()> {
        test_each(self.triangles, self.words, query)
    }

    /// Tells whether the `count` words from offset `first` exist and are ids of triangles.
    pub fn are_ids(&self, first: u32, count: u32) -> bool {
        let (first, count) = (first as usize, count as usize);
        let ids = self.words.get(first..first.saturating_add(count));
        ids.is_some_and(|ids| ids.iter().all(|&id| (id as usize) < self.triangles.len()))
    }
}
