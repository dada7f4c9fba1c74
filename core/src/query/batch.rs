//! Queries of a batch, of which many are under way at once.

use super::{Closest, Count, Hit, Occluded, Query, TriangleId};

/// Query of a batch: it can be put aside during a traversal, because its ray and its answer are all that it knows.
pub trait BatchQuery: Query {
    /// The hit found so far, or [`Hit::NONE`].
    fn answer(&self) -> Hit;
    /// Goes on from an answer of a query about the same ray.
    fn resume(&mut self, answer: Hit);
}

impl<C: Count> BatchQuery for Closest<'_, C> {
    #[inline]
    fn answer(&self) -> Hit {
        self.finish().unwrap_or(Hit::NONE)
    }

    #[inline]
    fn resume(&mut self, answer: Hit) {
        if !answer.is_none() {
            self.hit = answer;
        }
    }
}

impl<C: Count> BatchQuery for Occluded<'_, C> {
    /// If something is hit, a hit of some triangle.
    #[inline]
    fn answer(&self) -> Hit {
        let triangle = if self.found { TriangleId(0) } else { Hit::NONE.triangle };
        Hit { triangle, ..Hit::NONE }
    }

    #[inline]
    fn resume(&mut self, answer: Hit) {
        self.found = !answer.is_none();
    }
}
