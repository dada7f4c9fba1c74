//! Check of a tree whose nodes lie in depth-first order: each node begins where the one before it ended, so no node is
//! reached twice.

use arrayvec::ArrayVec;

use crate::structure::{Local, Statistics};

/// Node that passed its check.
pub(super) enum CheckedNode {
    /// Inner node of this length.
    Inner { words: u32 },
    /// Leaf of this length, and the number of triangles filed in it.
    Leaf { words: u32, references: u32 },
}

/// Stack of the links still to be followed, each with its level; the next one is the last.
pub(super) struct Links<const MOST: usize> {
    waiting: ArrayVec<(u32, u32), MOST>,
    level: u32,
}

impl<const MOST: usize> Links<MOST> {
    /// Pushes the links to the children of the node that is being checked; `None` if more than `MOST` links wait.
    pub fn follow(&mut self, children: impl DoubleEndedIterator<Item = u32>) -> Option<()> {
        for link in children.rev() {
            self.waiting.try_push((link, self.level + 1)).ok()?;
        }
        Some(())
    }
}

/// Follows all links from `root` on. Returns what the tree consists of, and the offset where it ends; `None` if a check
/// fails.
///
/// - The first node lies at the offset `start`. `offset_of` gives the offset that a link leads to.
/// - `check` receives each link and its level; the root's is 0. For a sound node it pushes the children in their order
///   with [`Links::follow`]; for any other it returns `None`.
/// - At most `MOST` links may wait at a time.
///
/// Cost: linear.
pub(super) fn check_depth_first<const MOST: usize>(
    root: u32,
    start: u32,
    offset_of: impl Fn(u32) -> u32,
    mut check: impl FnMut(u32, u32, &mut Links<MOST>) -> Option<CheckedNode>,
) -> Option<(Statistics, u32)> {
    let mut statistics = Statistics::default();
    let mut links = Links { waiting: ArrayVec::new(), level: 0 };
    links.waiting.try_push((root, 0)).ok()?;
    let mut end = start;
    while let Some((link, level)) = links.waiting.pop() {
        if offset_of(link) != end {
            return None;
        }
        links.level = level;
        let words = match check(link, level, &mut links)? {
            CheckedNode::Inner { words } => {
                statistics.inner_nodes += 1;
                words
            }
            CheckedNode::Leaf { words, references } => {
                statistics.add_leaf(references, level);
                words
            }
        };
        end = end.checked_add(words)?;
    }
    Some((statistics, end))
}

/// Checks a leaf that consists of a number of triangles, at least 1, and of their ids.
pub(super) fn check_leaf(local: &Local<'_>, offset: u32) -> Option<CheckedNode> {
    let references = local.word(offset);
    let words = references.checked_add(1)?;
    let sound = references != 0 && local.are_ids(offset + 1, references);
    sound.then_some(CheckedNode::Leaf { words, references })
}
