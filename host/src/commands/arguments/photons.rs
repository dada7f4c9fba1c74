//! Options of the photons that light a scene: number, seed, threads.

use clap::Args;

use super::values::{MOST_PHOTONS, threads, whole};

/// Photons, and the threads that shoot them.
#[derive(Args, Clone, Debug)]
// The help writes numbers as people do, not as code.
#[allow(clippy::doc_markdown)]
pub struct PhotonArguments {
    /// Number of photons: 1000000, 1_000_000, 1e6 or 1M; 0 leaves the scene dark
    #[arg(long, value_name = "N", default_value_t = 1_000_000, value_parser = whole::<u64>(0..=MOST_PHOTONS))]
    pub photons: u64,
    /// Another seed gives other photons
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Number of threads: 1 to 256, or to the number of processors if that is larger [default: one on each processor]
    #[arg(long, value_name = "K", value_parser = threads())]
    pub threads: Option<usize>,
}

impl PhotonArguments {
    /// Runs work in a pool of `threads` threads; without a number, in the caller's pool.
    ///
    /// # Errors
    /// The errors of the work. Fails if the system refuses the threads.
    pub fn run<T: Send>(
        &self,
        work: impl FnOnce() -> anyhow::Result<T> + Send,
    ) -> anyhow::Result<T> {
        match self.threads {
            None => work(),
            Some(threads) => {
                rayon::ThreadPoolBuilder::new().num_threads(threads).build()?.install(work)
            }
        }
    }
}
