//! The words that a local index writes, and the steps that its build takes.

use crate::error::BuildError;

/// A growing run of words that goes on counting where the memory ends.
///
/// Building into too little memory, or none, is therefore a dry run: `len` says how much was needed.
/// A builder must not read back what it wrote.
///
/// A builder also [spends](Words::spend) a step for each triangle that it looks at, so that the work of a build is
/// a number that is the same on every machine, and can be limited.
pub struct Words<'a> {
    slots: &'a mut [u32],
    len: usize,
    steps: u64,
    most_steps: u64,
}

impl<'a> Words<'a> {
    /// An empty run that may fill `slots`, in any number of steps.
    pub fn new(slots: &'a mut [u32]) -> Self {
        Self::limited(slots, u64::MAX)
    }

    /// An empty run that may fill `slots` in at most `most_steps` steps.
    pub fn limited(slots: &'a mut [u32], most_steps: u64) -> Self {
        Self { slots, len: 0, steps: 0, most_steps }
    }

    /// Counts steps: one for each look at a triangle.
    ///
    /// # Errors
    /// [`BuildError::TooMuchWork`] if the sum of all steps is more than allowed.
    #[inline]
    pub fn spend(&mut self, steps: u64) -> Result<(), BuildError> {
        self.steps = self.steps.saturating_add(steps);
        if self.steps <= self.most_steps {
            Ok(())
        } else {
            Err(BuildError::TooMuchWork { limit: self.most_steps })
        }
    }

    /// Steps counted so far.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Steps that are left.
    pub fn steps_left(&self) -> u64 {
        self.most_steps.saturating_sub(self.steps)
    }

    /// Words written so far, or that would have been.
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

    /// Appends several words.
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

    /// Appends `count` words, to be set later, and returns the offset of the first.
    pub fn reserve(&mut self, count: usize) -> usize {
        let offset = self.len;
        self.len = offset.saturating_add(count);
        offset
    }

    /// Appends `count` words and returns them, to be set now, if the memory holds them.
    pub fn append(&mut self, count: usize) -> Option<&mut [u32]> {
        let offset = self.reserve(count);
        self.slots.get_mut(offset..self.len)
    }

    /// Overwrites the word at `offset`.
    pub fn set(&mut self, offset: usize, word: u32) {
        if let Some(slot) = self.slots.get_mut(offset) {
            *slot = word;
        }
    }
}
