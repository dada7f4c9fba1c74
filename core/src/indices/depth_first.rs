//! Checking a tree whose nodes lie depth first: each begins where the one before it ended, so none is reached twice.

use arrayvec::ArrayVec;

use crate::structure::Statistics;

/// A node that was found sound.
pub(super) enum CheckedNode {
    /// With its length in words.
    Inner { words: u32 },
    /// With its length in words, and the triangles filed in it.
    Leaf { words: u32, references: u32 },
}

/// The links still to be followed, each with its level; the next one is the last.
pub(super) struct Links<const MOST: usize> {
    waiting: ArrayVec<(u32, u32), MOST>,
    level: u32,
}

impl<const MOST: usize> Links<MOST> {
    /// Adds the links to the children of the node that is being checked; `None` if they are too many.
    pub fn follow(&mut self, children: impl DoubleEndedIterator<Item = u32>) -> Option<()> {
        for link in children.rev() {
            self.waiting.try_push((link, self.level + 1)).ok()?;
        }
        Some(())
    }
}

/// Follows all links from `root` on and says what the tree consists of, and where it ends; `None` if it is none.
///
/// The first node lies at the word `start`, and `offset_of` tells where a link leads. `check` is shown each link and its
/// level, the root's is 0; it [follows](Links::follow) the children of a sound node in their order, and returns `None`
/// for any other. Trees in which at most `MOST` links wait at a time are checked. Cost: linear.
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
