//! A build on a bare thread pool: workers that wait for closures in a queue, as in a program without rayon.
//!
//! `join(a, b)` queues `b`, runs `a`, and takes `b` back if no worker has begun it. So it waits only for a branch that
//! is running, and the pool cannot run into a deadlock, whatever the number of workers.
//!
//! `cargo run -p arboleda --release --example thread_pool`

use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError, mpsc};
use std::thread::JoinHandle;

use arboleda::kinds::WideBvh;
use arboleda::{Block, Executor, Index, Options, Scene, Triangle, Vec3};

type Task = Box<dyn FnOnce() + Send>;

/// Tasks that wait for a worker, each with a number of its own.
#[derive(Default)]
struct Queue {
    tasks: VecDeque<(u64, Task)>,
    next: u64,
    closed: bool,
}

#[derive(Default)]
struct Shared {
    queue: Mutex<Queue>,
    filled: Condvar,
    /// Number of tasks that workers ran.
    helped: AtomicUsize,
}

/// Threads that run tasks until the pool is dropped.
struct Pool {
    shared: Arc<Shared>,
    workers: Vec<JoinHandle<()>>,
}

impl Pool {
    fn new(count: usize) -> Self {
        let shared = Arc::<Shared>::default();
        let worker = |_| {
            let shared = Arc::clone(&shared);
            std::thread::spawn(move || work(&shared))
        };
        Self { workers: (0..count).map(worker).collect(), shared }
    }
}

impl Drop for Pool {
    fn drop(&mut self) {
        self.shared.lock().closed = true;
        self.shared.filled.notify_all();
        for worker in self.workers.drain(..) {
            let _ = worker.join(); // it cannot have panicked
        }
    }
}

impl Shared {
    /// A panic of another thread leaves the queue as it is: each change is one call.
    fn lock(&self) -> std::sync::MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn push(&self, task: Task) -> u64 {
        let mut queue = self.lock();
        let number = queue.next;
        queue.next += 1;
        queue.tasks.push_back((number, task));
        self.filled.notify_one();
        number
    }

    /// Takes a task back, unless a worker has it.
    fn take(&self, number: u64) -> Option<Task> {
        let tasks = &mut self.lock().tasks;
        let at = tasks.iter().position(|task| task.0 == number)?;
        tasks.remove(at).map(|task| task.1)
    }
}

/// Runs tasks, the oldest first, which are the largest.
fn work(shared: &Shared) {
    let mut queue = shared.lock();
    loop {
        if let Some((_, task)) = queue.tasks.pop_front() {
            drop(queue);
            shared.helped.fetch_add(1, Ordering::Relaxed);
            let _ = catch_unwind(AssertUnwindSafe(task)); // its join sees that there is no result
            queue = shared.lock();
        } else if queue.closed {
            return;
        } else {
            queue = shared.filled.wait(queue).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

impl Executor for Pool {
    #[allow(unsafe_code)]
    fn join<A: Send, B: Send>(
        &self,
        a: impl FnOnce() -> A + Send,
        b: impl FnOnce() -> B + Send,
    ) -> (A, B) {
        let (sender, result) = mpsc::sync_channel(1);
        let task: Box<dyn FnOnce() + Send + '_> = Box::new(move || {
            let _ = sender.send(b()); // the join waits for it
        });
        // SAFETY: the task borrows from the caller of this function, which therefore must not return before the task
        // has run or is dropped. It does not: below, the task is taken back, or its end is waited for, also if `a`
        // panics. The sender is dropped with the task, so waiting ends.
        let task: Task =
            unsafe { std::mem::transmute::<Box<dyn FnOnce() + Send + '_>, Task>(task) };
        let number = self.shared.push(task);
        let a = catch_unwind(AssertUnwindSafe(a));
        if let Some(task) = self.shared.take(number) {
            let _ = catch_unwind(AssertUnwindSafe(task));
        }
        let b = result.recv();
        match (a, b) {
            (Ok(a), Ok(b)) => (a, b),
            (Err(panic), _) => resume_unwind(panic),
            (_, Err(_)) => panic!("the other branch panicked"),
        }
    }
}

/// Builds a wide BVH alone and with the help of pools of no, one and three workers, and compares the bytes.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
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

    for count in [0, 1, 3] {
        let pool = Pool::new(count);
        let mut arena = vec![Block::ZERO; Block::count(bytes)];
        let arena = Block::bytes(&mut arena);
        let index = Index::<WideBvh>::build_with(&scene, &options, arena, scratch, &pool)?;
        let helped = pool.shared.helped.load(Ordering::Relaxed);
        println!("{count} workers, which ran {helped} branches: the same {bytes} bytes");
        assert!(alone.as_bytes() == index.as_bytes());
        assert!(helped == 0 || count > 0);
    }
    Ok(())
}
