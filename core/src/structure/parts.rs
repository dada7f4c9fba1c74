//! What an index is built from, and what it is read from.

use core::ops::ControlFlow;

use super::Sections;
use crate::cluster::{ClusterNode, Clusters};
use crate::geometry::{Aabb, Ray};
use crate::input::Mesh;
use crate::query::{Query, TriangleId};

/// A scene that has been divided into clusters.
pub struct DividedScene<'a> {
    /// All triangles of the scene.
    pub triangles: Mesh<'a>,
    /// Rays such as the index will be asked about, if that is known.
    pub rays: &'a [Ray],
    /// The clusters; one if they are not asked for.
    pub clusters: &'a Clusters<'a>,
    /// The cluster tree, its leaves first; a leaf's links are the structure's affair. Empty in a dry run of a
    /// structure that does not [read](crate::custom::Structure::READS_TREE) it.
    pub nodes: &'a mut [ClusterNode],
}

impl DividedScene<'_> {
    /// Tells the leaves of the cluster tree that all words belong to the first: one index over all clusters.
    pub(crate) fn first_owns(&mut self, word_count: usize) {
        let words = word_count as u32;
        for (at, (leaf, _)) in self.nodes.iter_mut().zip(self.clusters.iter()).enumerate() {
            leaf.links = if at == 0 { [0, words] } else { [words, 0] };
        }
    }
}

/// What a local index is built from.
#[derive(Clone, Copy)]
pub struct Group<'a> {
    /// All triangles of the scene.
    pub triangles: Mesh<'a>,
    /// Rays such as the scene will be asked about, if that is known; they need not come near the group.
    pub rays: &'a [Ray],
    /// Those of the group, ascending; at least one.
    pub ids: &'a [u32],
    /// The smallest box around the group.
    pub bounds: Aabb,
}

/// A local index to be queried.
#[derive(Clone, Copy)]
pub struct Local<'a> {
    /// All triangles of the scene.
    pub triangles: Mesh<'a>,
    /// The smallest box around the group.
    pub bounds: Aabb,
    /// What `build` wrote.
    pub words: &'a [u32],
}

impl<'a> Local<'a> {
    pub(crate) fn of(sections: &Sections<'a>, leaf: &ClusterNode) -> Self {
        Self {
            triangles: sections.triangles(),
            bounds: leaf.bounds,
            words: sections.local_words(leaf),
        }
    }

    /// One word; 0 past the end.
    #[inline]
    pub fn word(&self, at: u32) -> u32 {
        self.words.get(at as usize).copied().unwrap_or(0)
    }

    /// Shows `query` the triangles that `count` words from `first` name.
    #[inline]
    pub fn test<Q: Query>(&self, first: u32, count: u32, query: &mut Q) -> ControlFlow<()> {
        let first = first as usize;
        let ids = self.words.get(first..first.saturating_add(count as usize)).unwrap_or(&[]);
        // Where they lie: copies of all would cost a bounding volume hierarchy 12% more instructions.
        let Mesh::Triangles(triangles) = self.triangles else {
            return self.test_gathered(ids, query);
        };
        for &id in ids {
            if let Some(triangle) = triangles.get(id as usize) {
                query.test(TriangleId(id), triangle)?;
            }
        }
        ControlFlow::Continue(())
    }

    /// Shows triangles whose corners lie here and there.
    #[inline(never)]
    fn test_gathered<Q: Query>(&self, ids: &[u32], query: &mut Q) -> ControlFlow<()> {
        for &id in ids {
            if let Some(triangle) = self.triangles.get(id) {
                query.test(TriangleId(id), &triangle)?;
            }
        }
        ControlFlow::Continue(())
    }

    /// Tells whether `count` words from `first` are all ids of triangles.
    pub fn are_ids(&self, first: u32, count: u32) -> bool {
        let (first, count) = (first as usize, count as usize);
        let ids = self.words.get(first..first.saturating_add(count));
        ids.is_some_and(|ids| ids.iter().all(|&id| (id as usize) < self.triangles.len()))
    }
}
