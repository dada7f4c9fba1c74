//! A build on a job system, such as that of a game engine: C functions that take a callback and a pointer.
//!
//! `join(a, b)` submits `b` as a job, runs `a`, and waits. In these systems, a thread that waits runs other jobs in the
//! meantime; so the build may be called from a job too.
//!
//! `cargo run -p arboleda --release --example job_system`

#![allow(unsafe_code)] // the job system takes pointers

use std::ffi::c_void;
use std::mem::ManuallyDrop;
use std::ptr::from_mut;

use arboleda::kinds::WideBvh;
use arboleda::{Block, Executor, Index, Options, Scene, Triangle, Vec3};

/// Executor on the engine's jobs.
struct Jobs;

/// A branch on the stack of its `join`, and then its result.
enum Branch<F, R> {
    Waiting(ManuallyDrop<F>),
    Done(R),
}

/// Runs the branch that a pointer leads to.
///
/// # Safety
/// `branch` leads to a waiting `Branch<F, R>` that nobody else uses until the job is done.
unsafe extern "C" fn run<F: FnOnce() -> R, R>(branch: *mut c_void) {
    // SAFETY: the caller's promise.
    let branch = unsafe { &mut *branch.cast::<Branch<F, R>>() };
    if let Branch::Waiting(closure) = branch {
        // SAFETY: the closure is taken once, because the branch is done then. If it panicked, the program would end,
        // since this function is C.
        let closure = unsafe { ManuallyDrop::take(closure) };
        *branch = Branch::Done(closure());
    }
}

/// Submits a branch as a job.
fn submit<F: FnOnce() -> R + Send, R: Send>(branch: &mut Branch<F, R>) -> engine::Job {
    // SAFETY: `join` neither touches nor leaves the branch before it has waited for the job.
    unsafe { engine::submit(run::<F, R>, from_mut(branch).cast()) }
}

impl Executor for Jobs {
    fn join<A: Send, B: Send>(
        &self,
        a: impl FnOnce() -> A + Send,
        b: impl FnOnce() -> B + Send,
    ) -> (A, B) {
        let mut branch = Branch::Waiting(ManuallyDrop::new(b));
        let job = submit(&mut branch);
        // Waits also if `a` panics. (The core does not.)
        let wait = WaitFor(job);
        let a = a();
        drop(wait);
        match branch {
            Branch::Done(b) => (a, b),
            Branch::Waiting(_) => {
                unreachable!("the engine runs each job before a wait for it ends")
            }
        }
    }
}

/// Waits for a job when dropped.
struct WaitFor(engine::Job);

impl Drop for WaitFor {
    fn drop(&mut self) {
        engine::wait(self.0);
    }
}

/// Stands for the engine: jobs in a stack, and threads that run them.
mod engine {
    use std::collections::HashSet;
    use std::ffi::c_void;
    use std::sync::{Mutex, PoisonError};
    use std::thread;

    pub type Callback = unsafe extern "C" fn(*mut c_void);

    /// Handle of a submitted job.
    #[derive(Clone, Copy, PartialEq, Eq, Hash)]
    pub struct Job(u64);

    struct Entry {
        job: Job,
        callback: Callback,
        argument: *mut c_void,
    }

    // SAFETY: the promise of `submit`.
    unsafe impl Send for Entry {}

    #[derive(Default)]
    struct State {
        waiting: Vec<Entry>,
        running: HashSet<Job>,
        count: u64,
    }

    static STATE: Mutex<Option<State>> = Mutex::new(None);

    fn with_state<R>(use_it: impl FnOnce(&mut State) -> R) -> R {
        let mut state = STATE.lock().unwrap_or_else(PoisonError::into_inner);
        use_it(state.get_or_insert_default())
    }

    /// Hands in a job.
    ///
    /// # Safety
    /// `callback(argument)` may be called on any thread, once, until a wait for the job ends.
    pub unsafe fn submit(callback: Callback, argument: *mut c_void) -> Job {
        with_state(|state| {
            let job = Job(state.count);
            state.count += 1;
            state.waiting.push(Entry { job, callback, argument });
            job
        })
    }

    /// Waits until a job is done, and runs jobs in the meantime.
    pub fn wait(job: Job) {
        let is_done = |state: &mut State| {
            !state.running.contains(&job) && state.waiting.iter().all(|entry| entry.job != job)
        };
        while !with_state(is_done) {
            if !run_one() {
                thread::yield_now();
            }
        }
    }

    /// Runs the youngest job, if there is one.
    pub fn run_one() -> bool {
        let taken = with_state(|state| {
            let entry = state.waiting.pop()?;
            state.running.insert(entry.job);
            Some(entry)
        });
        let Some(entry) = taken else {
            return false;
        };
        // SAFETY: the promise of `submit`.
        unsafe { (entry.callback)(entry.argument) };
        with_state(|state| state.running.remove(&entry.job));
        true
    }
}

/// Builds a wide BVH alone and on the job system with two threads, and compares the bytes.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    use std::sync::atomic::{AtomicBool, Ordering};

    let triangle = |number: u32| {
        let a = Vec3::new((number % 256) as f32, (number / 256) as f32, (number % 7) as f32);
        Triangle::new(a, a + Vec3::X, a + Vec3::Y)
    };
    let triangles: Vec<Triangle> = (0..50_000).map(triangle).collect();
    let (scene, options) = (Scene::new(&triangles), Options::DEFAULT);
    let scratch_bytes = Index::<WideBvh>::scratch_capacity(triangles.len(), &options);
    let mut scratch = vec![Block::ZERO; Block::count(scratch_bytes)];
    let scratch = Block::bytes(&mut scratch);
    let bytes = Index::<WideBvh>::capacity(&scene, &options, scratch)?.index;
    let mut alone = vec![Block::ZERO; Block::count(bytes)];
    let alone = Index::<WideBvh>::build(&scene, &options, Block::bytes(&mut alone), scratch)?;

    let mut arena = vec![Block::ZERO; Block::count(bytes)];
    let arena = Block::bytes(&mut arena);
    let is_over = AtomicBool::new(false);
    let index = std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while !is_over.load(Ordering::Relaxed) {
                    if !engine::run_one() {
                        std::thread::yield_now();
                    }
                }
            });
        }
        let index = Index::<WideBvh>::build_with(&scene, &options, arena, scratch, &Jobs);
        is_over.store(true, Ordering::Relaxed);
        index
    })?;
    println!("{bytes} bytes, the same by jobs as without");
    assert!(alone.as_bytes() == index.as_bytes());
    Ok(())
}
