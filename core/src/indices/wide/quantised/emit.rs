//! The second pass of the quantised indices: subtrees are written as nodes and leaves, depth first.

use core::marker::PhantomData;

use arrayvec::ArrayVec;

use super::{Form, HEAD_WORDS, QuantisedNode, most_words};
use crate::error::BuildError;
use crate::geometry::{Aabb, Box4};
use crate::indices::wide::build::collapse::Subtree;
use crate::indices::wide::build::primitive::Primitive;
use crate::indices::wide::build::sort;
use crate::indices::wide::rows::LANES;
use crate::input::{Executor, Mesh};
use crate::memory::Words;
use crate::structure::DividedScene;

/// Builds a quantised index: both passes.
pub(super) fn build<F: Form>(
    mut division: DividedScene<'_>,
    words: &mut Words<'_>,
    scratch: &mut [u8],
    executor: &impl Executor,
) -> Result<(), BuildError> {
    let triangles = division.triangles;
    if triangles.is_empty() {
        return Ok(());
    }
    let sorted = sort(&division, words, scratch, executor)?;
    let head = words.len();
    words.extend(&[0; HEAD_WORDS]);
    let (link, _) =
        Encoder::<F> { triangles, words: &mut *words, leaves: PhantomData }.subtree(sorted.root);
    words.set(head, link);
    words.set(head + 1, sorted.largest.to_bits());
    for _ in 0..F::ZEROS {
        words.push(0);
    }
    if words.len() > most_words::<F>() {
        return Err(BuildError::TooLarge);
    }
    division.first_owns(words.len());
    Ok(())
}

/// Second pass.
struct Encoder<'e, 'w, F> {
    triangles: Mesh<'e>,
    words: &'e mut Words<'w>,
    leaves: PhantomData<F>,
}

impl<F: Form> Encoder<'_, '_, F> {
    /// Appends a subtree, and returns the link to it and its box. The recursion is as deep as the tree.
    fn subtree(&mut self, subtree: Subtree<'_>) -> (u32, Box4) {
        let children = subtree.children();
        if children.is_empty() {
            let primitives = subtree.primitives;
            let link = F::write(self.triangles, primitives.iter().map(Primitive::id), self.words);
            return (link, Primitive::bounds_of(primitives));
        }
        // 1. Reserve the node's words before those of its children.
        let offset = self.words.reserve(F::node_words(children.len()));
        // 2. Append the children.
        let mut bounds = Box4::EMPTY;
        let mut links = ArrayVec::<u32, LANES>::new();
        let mut boxes = ArrayVec::<Aabb, LANES>::new();
        for child in &children {
            let (link, child) = self.subtree(*child);
            bounds = bounds.union(child);
            let pushed = links.try_push(link).is_ok() && boxes.try_push(child.aabb()).is_ok();
            debug_assert!(pushed, "a node has eight lanes");
        }
        // 3. Encode the node: now its children's boxes are known.
        let mut node = QuantisedNode::of(&boxes);
        for (slot, &link) in node.links.iter_mut().zip(&links) {
            *slot = link;
        }
        (F::write_node(&node, children.len(), offset, self.words), bounds)
    }
}
