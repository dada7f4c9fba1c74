//! Runs the examples: each asserts what it prints.

#[path = "../examples/batch.rs"]
mod batch;
#[path = "../examples/beside_a_mesh.rs"]
mod beside_a_mesh;
#[path = "../examples/choose_an_index.rs"]
mod choose_an_index;
#[path = "../examples/custom_index.rs"]
mod custom_index;
#[path = "../examples/executor.rs"]
mod executor;
#[path = "../examples/index_in_rom.rs"]
mod index_in_rom;
#[path = "../examples/job_system.rs"]
mod job_system;
#[cfg(feature = "alloc")]
#[path = "../examples/minimal.rs"]
mod minimal;
#[path = "../examples/save_and_open.rs"]
mod save_and_open;
#[path = "../examples/thread_pool.rs"]
mod thread_pool;

/// Makes a test of the `main` of each example.
macro_rules! run {
    ($($(#[$attribute:meta])? $example:ident)*) => {
        $(
            #[test]
            $(#[$attribute])?
            fn $example() -> Result<(), Box<dyn std::error::Error>> {
                $example::main()
            }
        )*
    };
}
run! { #[cfg(feature = "alloc")] minimal batch save_and_open index_in_rom beside_a_mesh choose_an_index custom_index executor thread_pool job_system }
