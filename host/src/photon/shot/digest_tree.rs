//! Digests of ranges of photons, which combine to the digest of all.
//!
//! The digest of a shot is the BLAKE3 hash of the digests of its chunks, of 1024 photons each. BLAKE3 hashes a tree. Its
//! leaves have 1024 bytes, which are 32 digests. So a range of photons keeps the values of the largest subtrees that it
//! fills, and what is left at both ends:
//!
//! ```text
//! photons of a chunk that was cut | chunks | subtrees of 32, 64, ... chunks | ... | chunks | photons of a cut chunk
//! ```
//! Two neighbouring ranges are joined by appending the nodes of one to those of the other; whatever becomes complete is
//! combined. Ranges may be cut anywhere. Whatever its length, a range keeps at most 62 digests of chunks, two subtrees a
//! level, and the hits of less than two chunks.
//!
//! # Source
//! J. O'Connor, J. Aumasson, S. Neves, Z. Wilcox-O'Hearn, *BLAKE3*, 2020, section 2.1. It calls a leaf a
//! chunk.

use std::ops::Range;

use blake3::Hasher;
use blake3::hazmat::{HasherExt, Mode, merge_subtrees_non_root, merge_subtrees_root};
use serde::{Deserialize, Serialize};

use super::Digest;
use crate::photon::stream::CHUNK;

/// Chunks whose digests fill a leaf of BLAKE3.
const LEAF_CHUNKS: u64 = 32;
/// Level of a subtree that is one leaf: it has 2^5 chunks.
const LEAF_LEVEL: u32 = LEAF_CHUNKS.trailing_zeros();

/// Hit as it is hashed: photon (two words), bounce, triangle, `t`, `u`, `v`, each little-endian in the hashed bytes.
pub(crate) type Event = [u32; 7];

/// Digests of a range of the photons of a job.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct DigestTree {
    /// Number of photons of the whole job.
    photons: u64,
    /// Nodes in the order of their photons, without gaps.
    nodes: Vec<DigestNode>,
}

/// Node of the tree.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum DigestNode {
    /// Hits of some photons of a chunk, by bounce and photon.
    Cut { photons: Range<u64>, events: Vec<Event> },
    /// Digest of a chunk's hits.
    Chunk { chunk: u64, digest: [u8; 32] },
    /// Value of a subtree of 2^level chunks, not the whole tree. `first` is its first chunk, a multiple of 2^level.
    Subtree { first: u64, level: u32, value: [u8; 32] },
}

impl DigestNode {
    /// The photons below the node, of a job of `all` photons; `None` if there are no such photons.
    fn photons(&self, all: u64) -> Option<Range<u64>> {
        let of_chunks = |first: u64, count: u64| {
            let range = first.checked_mul(CHUNK)?..first.checked_add(count)?.checked_mul(CHUNK)?;
            (range.start < all).then_some(range.start..range.end.min(all))
        };
        match self {
            Self::Cut { photons, .. } => Some(photons.clone()),
            Self::Chunk { chunk, .. } => of_chunks(*chunk, 1),
            Self::Subtree { first, level, .. } => of_chunks(*first, 1_u64.checked_shl(*level)?),
        }
    }
}

impl DigestTree {
    /// The tree of no photons yet, of a job.
    pub fn new(photons: u64) -> Self {
        Self { photons, nodes: Vec::new() }
    }

    /// Tells whether there are no photons.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Number of chunks of the whole job.
    fn chunks(&self) -> u64 {
        self.photons.div_ceil(CHUNK)
    }

    /// Appends the node of the photons that follow, and combines what is complete.
    pub fn push(&mut self, node: DigestNode) {
        self.nodes.push(node);
        while let Some((count, combined)) = self.combined() {
            self.nodes.truncate(self.nodes.len() - count);
            self.nodes.push(combined);
        }
    }

    /// Appends the nodes of the range that follows.
    pub fn join(&mut self, next: Self) {
        for node in next.nodes {
            self.push(node);
        }
    }

    /// Combines the last nodes, if they are parts of one. Returns how many they are.
    fn combined(&self) -> Option<(usize, DigestNode)> {
        use DigestNode::{Chunk, Cut, Subtree};
        match &self.nodes[..] {
            [.., Cut { photons: a, events: first }, Cut { photons: b, events: second }]
                if a.start / CHUNK == b.start / CHUNK =>
            {
                // 1. Parts of a chunk are a larger part, or the chunk.
                let photons = a.start..b.end;
                let mut events = [&first[..], &second[..]].concat();
                events.sort_by_key(|&[photon, photon_high, bounce, ..]| {
                    (bounce, photon_high, photon)
                });
                let chunk = Chunk { chunk: a.start / CHUNK, digest: hash_of(&events) };
                let is_whole = chunk.photons(self.photons).as_ref() == Some(&photons);
                Some((2, if is_whole { chunk } else { Cut { photons, events } }))
            }
            [.., Chunk { chunk, .. }]
                if chunk % LEAF_CHUNKS == LEAF_CHUNKS - 1 && self.chunks() > LEAF_CHUNKS =>
            {
                // 2. The chunks of a leaf are a subtree.
                let first = chunk - (LEAF_CHUNKS - 1);
                let leaf = &self.nodes[self.nodes.len().checked_sub(LEAF_CHUNKS as usize)?..];
                let begins = matches!(leaf[0], Chunk { chunk, .. } if chunk == first);
                let value = value_of(first, leaf);
                begins.then_some((leaf.len(), Subtree { first, level: LEAF_LEVEL, value }))
            }
            [
                ..,
                Subtree { first, level, value: left },
                Subtree { level: other, value: right, .. },
            ] if level == other && first >> level & 1 == 0 && 2 << level < self.chunks() => {
                // 3. Two subtrees are one. The whole tree is hashed in another way; see `digest`.
                let value = merge_subtrees_non_root(left, right, Mode::Hash);
                Some((2, Subtree { first: *first, level: level + 1, value }))
            }
            _ => None,
        }
    }

    /// Tells whether the nodes may be those of a range of the photons of a job, as [`push`](Self::push) leaves them.
    pub fn is_of(&self, range: &Range<u64>, all: u64) -> bool {
        let mut end = range.start;
        let follows = self.nodes.iter().all(|node| {
            let is_sound = match node {
                DigestNode::Cut { photons, events } => {
                    let number = |event: &Event| u64::from(event[1]) << 32 | u64::from(event[0]);
                    let chunk = photons.start / CHUNK;
                    let whole = DigestNode::Chunk { chunk, digest: [0; 32] }.photons(all);
                    photons.start < photons.end
                        && chunk == (photons.end - 1) / CHUNK
                        && whole.as_ref() != Some(photons)
                        && events.iter().all(|event| photons.contains(&number(event)))
                }
                DigestNode::Chunk { .. } => true,
                DigestNode::Subtree { first, level, .. } => {
                    let length = 1_u64.checked_shl(*level).unwrap_or(0);
                    let is_within =
                        first.checked_add(length).is_some_and(|end| end <= self.chunks());
                    *level >= LEAF_LEVEL && first.checked_rem(length) == Some(0) && is_within
                }
            };
            let photons = node.photons(all).filter(|photons| is_sound && photons.start == end);
            photons.is_some_and(|photons| {
                end = photons.end;
                true
            })
        });
        self.photons == all && follows && end == range.end && {
            let mut again = Self::new(all);
            self.nodes.iter().cloned().for_each(|node| again.push(node));
            again == *self
        }
    }

    /// Combines the nodes of all photons. Without photons, the digest of nothing.
    pub fn digest(&self) -> Digest {
        // 1. What does not fill a leaf is hashed as it is.
        let is_subtree = |node: &DigestNode| matches!(node, DigestNode::Subtree { .. });
        let (subtrees, chunks) = self.nodes.split_at(self.nodes.partition_point(is_subtree));
        let values = subtrees.iter().filter_map(|node| match node {
            DigestNode::Subtree { value, .. } => Some(*value),
            _ => None,
        });
        let mut values: Vec<[u8; 32]> = values.collect();
        if values.is_empty() {
            return Digest(*hasher_of(chunks).finalize().as_bytes());
        }
        if let Some(DigestNode::Chunk { chunk, .. }) = chunks.first() {
            values.push(value_of(*chunk, chunks));
        }
        // 2. The smallest subtrees are joined first; they are last.
        while let (Some(right), Some(left)) = (values.pop(), values.pop()) {
            if values.is_empty() {
                return Digest(*merge_subtrees_root(&left, &right, Mode::Hash).as_bytes());
            }
            values.push(merge_subtrees_non_root(&left, &right, Mode::Hash));
        }
        // A single subtree is never the whole tree.
        Digest([0; 32])
    }
}

/// Hashes the hits of a chunk, as a shot hashes them.
fn hash_of(events: &[Event]) -> [u8; 32] {
    let bytes: Vec<Event> = events.iter().map(|event| event.map(u32::to_le)).collect();
    *blake3::hash(bytemuck::cast_slice(&bytes)).as_bytes()
}

/// Hashes the digests of chunks.
fn hasher_of(chunks: &[DigestNode]) -> Hasher {
    let mut hasher = Hasher::new();
    hash_into(&mut hasher, chunks);
    hasher
}

/// The value of chunks that begin a leaf; they may not fill it.
fn value_of(first: u64, chunks: &[DigestNode]) -> [u8; 32] {
    let mut hasher = Hasher::new();
    hasher.set_input_offset(first * 32);
    hash_into(&mut hasher, chunks);
    hasher.finalize_non_root()
}

fn hash_into(hasher: &mut Hasher, chunks: &[DigestNode]) {
    for node in chunks {
        if let DigestNode::Chunk { digest, .. } = node {
            hasher.update(digest);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chunk(chunk: u64) -> DigestNode {
        DigestNode::Chunk { chunk, digest: *blake3::hash(&chunk.to_le_bytes()).as_bytes() }
    }

    fn tree_of(chunks: Range<u64>, all: u64) -> DigestTree {
        let mut tree = DigestTree::new(all * CHUNK);
        chunks.for_each(|one| tree.push(chunk(one)));
        tree
    }

    #[test]
    fn the_digest_is_that_of_all_chunks_in_one_hash() {
        for all in (0..140).chain([255, 256, 257, 1_000, 1_024, 1_025]) {
            let mut whole = Hasher::new();
            hash_into(&mut whole, &(0..all).map(chunk).collect::<Vec<_>>());
            let expected = Digest(*whole.finalize().as_bytes());
            let tree = tree_of(0..all, all);
            assert_eq!(tree.digest(), expected, "{all}");
            assert!(tree.is_of(&(0..all * CHUNK), all * CHUNK));
            assert!(tree.nodes.len() < 64, "{all}: {} nodes", tree.nodes.len());
            // Cut anywhere into three.
            for cut in [0, 1, 31, 32, 33, all / 3, all / 2] {
                let (a, b) = (cut.min(all), (2 * cut + 5).min(all));
                let mut joined = tree_of(0..a, all);
                let mut rest = tree_of(a..b, all);
                rest.join(tree_of(b..all, all));
                joined.join(rest);
                assert_eq!(joined, tree, "{all} cut at {a} and {b}");
            }
        }
    }

    #[test]
    fn what_is_not_of_a_range_is_found() {
        let all = 100 * CHUNK;
        let tree = tree_of(40..90, 100);
        assert!(tree.is_of(&(40 * CHUNK..90 * CHUNK), all));
        assert!(!tree.is_of(&(40 * CHUNK..91 * CHUNK), all));
        assert!(!tree.is_of(&(39 * CHUNK..90 * CHUNK), all));
        let mut gap = tree.clone();
        gap.nodes.remove(3);
        assert!(!gap.is_of(&(40 * CHUNK..90 * CHUNK), all));
        for node in [
            DigestNode::Subtree { first: 40, level: 5, value: [0; 32] },
            DigestNode::Subtree { first: 64, level: 200, value: [0; 32] },
            DigestNode::Chunk { chunk: u64::MAX, digest: [0; 32] },
            DigestNode::Cut { photons: 5..5, events: Vec::new() },
            DigestNode::Cut { photons: 0..10, events: vec![[10, 0, 0, 0, 0, 0, 0]] },
            DigestNode::Cut { photons: 0..CHUNK, events: Vec::new() },
        ] {
            let forged = DigestTree { photons: all, nodes: vec![node] };
            assert!(!forged.is_of(&(0..all), all), "{forged:?}");
        }
        // Chunks of a leaf that were not combined.
        let forged = DigestTree { photons: all, nodes: (0..100).map(chunk).collect() };
        assert!(!forged.is_of(&(0..all), all));
    }
}
