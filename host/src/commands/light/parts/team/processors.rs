//! Processors of a rank: how many threads it starts.
//!
//! ```text
//! mpirun -n 2     each rank is bound to one core     -> lifted: both have all processors that mpirun has
//!   --bind-to ..  each rank is bound as was asked    -> stays
//! srun            the ranks are bound, or not        -> stays
//!                                                       threads = processors / ranks of this machine that have them too
//! ```
//! Without options Open MPI 4 binds two ranks to a core each, and more ranks to a socket, because it takes ranks for
//! processes of one thread. A rank of this program has a thread for each of its processors. So it lifts a binding that
//! nobody asked for, and says so. It never takes a processor that the process which started it does not have. A rank
//! that a wrapper bound (`mpirun numactl ..`) looks the same: `--bind-to none` keeps what the wrapper did.
//!
//! A limit of processor time, as containers have, counts as fewer processors.

use std::env;

use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, CommunicatorCollectives};

/// Processors by number, 64 in a word. Machines of today have fewer than 1,024.
type Mask = [u64; 16];

/// Chooses the number of threads of this rank. All ranks call it.
pub fn threads(world: &SimpleCommunicator) -> usize {
    if is_bound_unasked(|name| env::var(name).ok()) {
        system::take_those_of_parent();
        log::debug!("a binding that Open MPI chose is lifted; --bind-to keeps one");
    }
    // Ranks of this machine.
    let near = world.split_shared(world.rank());
    let own = system::own();
    let mut all = vec![0; own.len() * near.size() as usize];
    near.all_gather_into(&own[..], &mut all[..]);
    let (masks, _) = all.as_chunks();
    let available = std::thread::available_parallelism().map_or(1, usize::from);
    share(&own, masks, available)
}

/// Tells whether Open MPI bound this rank although nobody asked for it.
fn is_bound_unasked(variable: impl Fn(&str) -> Option<String>) -> bool {
    let mapping = variable("OMPI_MCA_rmaps_base_mapping_policy").unwrap_or_default();
    variable("OMPI_MCA_orte_bound_at_launch").is_some()
        && variable("OMPI_MCA_hwloc_base_binding_policy").is_none()
        // Processors for each rank, as in `--map-by slot:PE=4`.
        && !mapping.to_ascii_lowercase().contains("pe=")
}

/// Divides the processors of a rank, of which it may use as many as are available, by the ranks that have some of them
/// too, itself included. A rank that does not know its processors shares what is available with all.
fn share(own: &Mask, masks: &[Mask], available: usize) -> usize {
    let processors = own.iter().map(|word| word.count_ones()).sum::<u32>() as usize;
    if processors == 0 {
        return (available / masks.len().max(1)).max(1);
    }
    let meets = |mask: &&Mask| own.iter().zip(*mask).any(|(own, other)| own & other != 0);
    let ranks = masks.iter().filter(meets).count().max(1);
    (processors.min(available) / ranks).max(1)
}

#[cfg(target_os = "linux")]
mod system {
    use rustix::process::getppid;
    use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};

    use super::Mask;

    /// The processors that this thread may use, and the threads that it starts.
    pub fn own() -> Mask {
        let set = sched_getaffinity(None).unwrap_or_default();
        let mut mask = Mask::default();
        for processor in (0..64 * mask.len()).filter(|&at| at < CpuSet::MAX_CPU && set.is_set(at)) {
            mask[processor / 64] |= 1 << (processor % 64);
        }
        mask
    }

    /// Lets this thread use the processors of the process that started it. If the system refuses, nothing changes.
    pub fn take_those_of_parent() {
        if let Ok(set) = sched_getaffinity(getppid()) {
            let _ = sched_setaffinity(None, &set);
        }
    }
}

/// Other systems do not tell, and MPI does not bind there: nothing is known of the processors.
#[cfg(not(target_os = "linux"))]
mod system {
    use super::Mask;

    pub fn own() -> Mask {
        Mask::default()
    }

    pub fn take_those_of_parent() {}
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mask(processors: std::ops::Range<usize>) -> Mask {
        let mut mask = Mask::default();
        processors.for_each(|at| mask[at / 64] |= 1 << (at % 64));
        mask
    }

    #[test]
    fn ranks_divide_only_what_they_share() {
        let (left, right) = (mask(0..32), mask(32..64));
        assert_eq!(share(&left, &[left, right], 64), 32, "each its own");
        assert_eq!(share(&left, &[left, left, right, right], 64), 16, "two on each socket");
        assert_eq!(share(&mask(0..128), &[mask(0..128); 3], 128), 42, "not bound");
        assert_eq!(share(&mask(0..128), &[mask(0..128); 2], 4), 2, "a limit of processor time");
        assert_eq!(share(&mask(3..4), &[mask(3..4), mask(4..5)], 1), 1, "bound to cores");
        assert_eq!(share(&mask(0..2), &[mask(0..2); 5], 2), 1, "more ranks than processors");
        assert_eq!(share(&mask(0..8), &[mask(0..8), mask(0..2), mask(8..16)], 8), 4);
        assert_eq!(share(&Mask::default(), &[Mask::default(); 3], 12), 4, "unknown");
    }

    #[test]
    fn a_binding_that_was_asked_for_stays() {
        let bound = ("OMPI_MCA_orte_bound_at_launch", "1");
        let of = |all: &[(&str, &str)]| {
            is_bound_unasked(|name| {
                let found = all.iter().find(|(own, _)| *own == name);
                found.map(|(_, value)| (*value).to_owned())
            })
        };
        assert!(of(&[bound]));
        assert!(of(&[bound, ("OMPI_MCA_rmaps_base_mapping_policy", "ppr:1:node")]));
        assert!(!of(&[bound, ("OMPI_MCA_hwloc_base_binding_policy", "core")]));
        assert!(!of(&[bound, ("OMPI_MCA_rmaps_base_mapping_policy", "slot:PE=4")]));
        assert!(!of(&[]), "not bound, or another MPI");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn the_processors_of_this_process_are_counted() {
        let own = system::own();
        let processors = std::thread::available_parallelism().unwrap().get();
        assert_eq!(share(&own, &[own], processors), processors);
        system::take_those_of_parent();
        let all = system::own();
        assert!(own.iter().zip(all).all(|(own, all)| own & !all == 0), "none is lost");
    }
}
