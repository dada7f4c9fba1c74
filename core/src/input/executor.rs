//! Who runs the branches of a build.

/// Runs two pieces of work, at once if it likes.
///
/// What a build writes does not depend on it, nor on the number of threads behind it.
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
    /// Runs both, in any order or at once, and returns what they return.
    fn join<A: Send, B: Send>(
        &self,
        a: impl FnOnce() -> A + Send,
        b: impl FnOnce() -> B + Send,
    ) -> (A, B);
}

/// One after the other, in the caller's thread.
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
