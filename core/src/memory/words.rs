//! Where a local index writes itself: a run of `u32` words.

/// A growing run of words that goes on counting where the memory ends.
///
/// Building into too little memory, or none, is therefore a dry run: `len` says how much was needed.
/// A builder must not read back what it wrote.
pub struct Words<'a> {
    slots: &'a mut [u32],
    len: usize,
}

impl<'a> Words<'a> {
    /// An empty run that may fill `slots`.
    pub fn new(slots: &'a mut [u32]) -> Self {
        Self { slots, len: 0 }
    }

    /// Words written so far, or that would have been.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Tells whether nothing was written.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Appends a word and returns its place.
    pub fn push(&mut self, word: u32) -> usize {
        let place = self.len;
        self.set(place, word);
        self.len = place.saturating_add(1);
        place
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

    /// Appends `count` words, to be set later, and returns the place of the first.
    pub fn reserve(&mut self, count: usize) -> usize {
        let place = self.len;
        self.len = place.saturating_add(count);
        place
    }

    /// Appends `count` words and returns them, to be set now, if the memory holds them.
    pub fn append(&mut self, count: usize) -> Option<&mut [u32]> {
        let place = self.reserve(count);
        self.slots.get_mut(place..self.len)
    }

    /// Overwrites the word at `place`.
    pub fn set(&mut self, place: usize, word: u32) {
        if let Some(slot) = self.slots.get_mut(place) {
            *slot = word;
        }
    }
}
