//! The threads that help with a build.

use arboleda::Executor;
use rayon::ThreadPool;

/// Rayon's threads, as an executor of the core.
///
/// # Examples
/// ```
/// use arboleda::{IndexKind, Options};
/// use arboleda_host::{OwnedIndex, Threads};
/// use arboleda_host::scene::builtin::require;
///
/// let model = require("fig2")?;
/// let (scene, options) = (model.scene(), Options::default());
/// let one = OwnedIndex::build(IndexKind::WideBvh, &scene, &options)?;
/// let many = OwnedIndex::build_with(IndexKind::WideBvh, &scene, &options, &Threads::new(None))?;
/// assert_eq!(one.as_bytes(), many.as_bytes());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Default)]
pub struct Threads(Option<ThreadPool>);

impl Threads {
    /// So many threads; `None` for those of the caller's pool, by default one on each processor. If the
    /// system refuses them, the caller's pool does the work.
    pub fn new(count: Option<usize>) -> Self {
        let pool = |count: usize| rayon::ThreadPoolBuilder::new().num_threads(count.max(1)).build();
        Self(count.and_then(|count| pool(count).ok()))
    }
}

impl Executor for Threads {
    fn join<A: Send, B: Send>(
        &self,
        a: impl FnOnce() -> A + Send,
        b: impl FnOnce() -> B + Send,
    ) -> (A, B) {
        match &self.0 {
            Some(pool) => pool.join(a, b),
            None => rayon::join(a, b),
        }
    }
}
