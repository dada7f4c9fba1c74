//! Threads of parallel builds.

use arboleda::Executor;
use rayon::ThreadPool;

/// Executor of the core that runs on Rayon's threads.
///
/// # Examples
/// ```
/// use arboleda::{IndexKind, Options};
/// use arboleda_host::{TimedIndex, Threads};
/// use arboleda_host::scene::builtin::require;
///
/// let model = require("fig2")?;
/// let (scene, options) = (model.scene(), Options::default());
/// let one = TimedIndex::build(IndexKind::WideBvh, &scene, &options)?;
/// let many = TimedIndex::build_with(IndexKind::WideBvh, &scene, &options, &Threads::new(None))?;
/// assert_eq!(one.as_bytes(), many.as_bytes());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Default)]
pub struct Threads(Option<ThreadPool>);

impl Threads {
    /// Creates a pool of `count` threads. With `None` the caller's pool is used, by default one thread for each
    /// processor. If the system refuses `count` threads, the caller's pool is used too.
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
