//! Output of a build: the words it writes, and the steps it counts.

use super::put;
use crate::error::BuildError;

/// Growing run of words that goes on counting where the memory ends.
///
/// Building into too little memory, or none, is therefore a dry run: [`Words::len`] is the number of words needed. A
/// builder must not read back what it wrote.
///
/// A builder [spends](Words::spend) a step for each look at a triangle. So the work of a build is a number that is the
/// same on every machine, and that can be limited.
pub struct Words<'a> {
    slots: &'a mut [u32],
    len: usize,
    steps: u64,
    most_steps: u64,
}

impl<'a> Words<'a> {
    /// An empty run that may fill `slots`, without a limit of steps.
    pub fn new(slots: &'a mut [u32]) -> Self {
        Self::limited(slots, u64::MAX)
    }

    /// An empty run that may fill `slots` in at most `most_steps` steps.
    pub fn limited(slots: &'a mut [u32], most_steps: u64) -> Self {
        Self { slots, len: 0, steps: 0, most_steps }
    }

    /// Counts `steps` steps, one for each look at a triangle. A pass of a sort looks at each once.
    ///
    /// # Errors
    /// [`BuildError::TooMuchWork`] if the sum of all steps exceeds the limit.
    #[inline]
    pub fn spend(&mut self, steps: u64) -> Result<(), BuildError> {
        self.steps = self.steps.saturating_add(steps);
        if self.steps <= self.most_steps {
            Ok(())
        } else {
            Err(BuildError::TooMuchWork { limit: self.most_steps })
        }
    }

    /// The number of steps counted so far.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// The number of steps left below the limit.
    pub fn steps_left(&self) -> u64 {
        self.most_steps.saturating_sub(self.steps)
    }

    /// The number of words written so far, including those that found no memory.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Tells whether nothing was written.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Appends a word and returns its offset.
    pub fn push(&mut self, word: u32) -> usize {
        let offset = self.len;
        self.set(offset, word);
        self.len = offset.saturating_add(1);
        offset
    }

    /// Appends `words`.
    pub fn extend(&mut self, words: &[u32]) {
        let start = self.len;
        let end = start.saturating_add(words.len());
        if let Some(slots) = self.slots.get_mut(start..end)
            && slots.len() == words.len()
        {
            slots.copy_from_slice(words);
        }
        self.len = end;
    }

    /// Appends `count` words, to be [set](Words::set) later, and returns the offset of the first.
    pub fn reserve(&mut self, count: usize) -> usize {
        let offset = self.len;
        self.len = offset.saturating_add(count);
        offset
    }

    /// Appends `count` words and returns them, to be filled now; `None` if the memory does not hold them.
    pub fn append(&mut self, count: usize) -> Option<&mut [u32]> {
        let offset = self.reserve(count);
        self.slots.get_mut(offset..self.len)
    }

    /// Overwrites the word at `offset`.
    pub fn set(&mut self, offset: usize, word: u32) {
        put(self.slots, offset, word);
    }
}
