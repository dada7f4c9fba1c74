//! Parallel execution of a build's branches.

/// Fork-join scheduler: runs two closures, possibly in parallel.
///
/// The bytes that a build writes depend neither on the executor nor on its number of threads.
///
/// # Examples
/// ```
/// use arboleda::Executor;
///
/// /// A thread of its own for each second branch; a thread pool does the same at less cost.
/// struct Threads;
///
/// impl Executor for Threads {
///     fn join<A: Send, B: Send>(
///         &self,
///         a: impl FnOnce() -> A + Send,
///         b: impl FnOnce() -> B + Send,
///     ) -> (A, B) {
///         std::thread::scope(|scope| {
///             let b = scope.spawn(b);
///             (a(), b.join().expect("no branch panics"))
///         })
///     }
/// }
/// assert_eq!(Threads.join(|| 1, || "two"), (1, "two"));
/// ```
pub trait Executor: Sync {
    /// Runs `a` and `b`, in any order or in parallel, and returns both results.
    fn join<A: Send, B: Send>(
        &self,
        a: impl FnOnce() -> A + Send,
        b: impl FnOnce() -> B + Send,
    ) -> (A, B);
}

/// Executor without parallelism: runs one closure after the other, in the caller's thread.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sequential;

impl Executor for Sequential {
    #[inline]
    fn join<A: Send, B: Send>(
        &self,
        a: impl FnOnce() -> A + Send,
        b: impl FnOnce() -> B + Send,
    ) -> (A, B) {
        (a(), b())
    }
}
