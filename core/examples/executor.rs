//! A build on several threads: the core asks an `Executor` to run two closures, at once if it can.
//!
//! The bytes are the same for every executor and every number of threads.
//!
//! `cargo run -p arboleda --release --example executor`

use std::sync::atomic::{AtomicUsize, Ordering};

use arboleda::kinds::WideBvh;
use arboleda::{Block, Executor, Index, Options, Scene, Triangle, Vec3};

/// Threads of the standard library: a new one for each second branch, as long as some are left.
///
/// A pool of threads does the same at less cost; with rayon, `join` is `rayon::join(a, b)`.
struct Threads {
    left: AtomicUsize,
}

impl Executor for Threads {
    fn join<A: Send, B: Send>(
        &self,
        a: impl FnOnce() -> A + Send,
        b: impl FnOnce() -> B + Send,
    ) -> (A, B) {
        let one_less = |left: usize| left.checked_sub(1);
        if self.left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, one_less).is_err() {
            return (a(), b());
        }
        std::thread::scope(|scope| {
            let b = scope.spawn(b);
            let a = a();
            // The core does not panic, so no branch does.
            (a, b.join().expect("no branch panics"))
        })
    }
}

/// Builds a wide BVH alone and with the help of up to seven threads, and compares the bytes.
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

    let threads = Threads { left: AtomicUsize::new(7) };
    let mut helped = vec![Block::ZERO; Block::count(bytes)];
    let helped = Block::bytes(&mut helped);
    let helped = Index::<WideBvh>::build_with(&scene, &options, helped, scratch, &threads)?;

    let used = 7 - threads.left.load(Ordering::Relaxed);
    println!("{bytes} bytes, the same with {used} more threads as with none");
    assert!(used > 0);
    assert!(alone.as_bytes() == helped.as_bytes());
    Ok(())
}
