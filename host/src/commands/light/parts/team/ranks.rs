//! Ranks: the processes that `mpirun` started, on one machine or on many.
//!
//! ```text
//! rank 0         hands out ranges and takes what they leave behind; a thread of it shoots as the others do
//! other ranks    ask -> range -> shoot -> ask with what is left of it -> range -> ... -> the round ends
//! all            add the counts of the round, in a tree
//! ```
//! Counts of triangles and receivers may be many. Each rank keeps them until the round ends. The rest is small, or has to
//! be in the order of photons: it goes to rank 0 with each range.
//!
//! If a rank fails, it ends all of them; what the checkpoint has is not lost.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::time::{Duration, Instant};

use anyhow::{Context, bail, ensure};
use mpi::Threading;
use mpi::environment::Universe;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, Destination, MatchedReceiveVec, Source};

use super::pace::Pace;
use super::{Team, add_counts, keep_counts, processors};
use crate::commands::light::parts::work::PartWork;
use crate::commands::output::duration;
use crate::density::CountsOf;
use crate::parts::{Job, JobPart, PartSums};

/// Message that asks for work: the length of the result before it.
const ASK: i32 = 1;
/// Answer: a kind of work and two numbers.
const WORK: i32 = 2;
/// Bytes of a result, or counts.
const CONTENTS: i32 = 3;

/// Kinds of work: shoot a range; add the counts of the passes from the first to the last number; nothing more.
const SHOOT: u64 = 0;
const ADD: u64 = 1;
const END: u64 = 2;

/// Most numbers of one message. A message may have 2^31.
const AT_ONCE: usize = 1 << 27;
/// Pause of rank 0 while nobody asks.
const PAUSE: Duration = Duration::from_micros(500);

type Counts = BTreeMap<CountsOf, Vec<u64>>;

/// Joins the processes that `mpirun` or `srun` started, if they did. The ranks go on until the universe is dropped.
///
/// # Errors
/// If the library of MPI cannot be used from one thread after the other.
pub fn join_ranks() -> anyhow::Result<Option<(Universe, Team)>> {
    // As Open MPI, MPICH and its kin, and Slurm's PMIx name a process. A process of its own is no rank.
    let names = ["OMPI_COMM_WORLD_RANK", "PMI_RANK", "PMIX_RANK"];
    if names.iter().all(|name| std::env::var_os(name).is_none()) {
        return Ok(None);
    }
    let (universe, threading) = mpi::initialize_with_threading(Threading::Serialized)
        .context("MPI was there before the program")?;
    ensure!(threading >= Threading::Serialized, "this MPI allows no threads");
    let team = if universe.world().rank() == 0 { Team::First } else { Team::Other };
    let threads = processors::threads(&universe.world());
    rayon::ThreadPoolBuilder::new().num_threads(threads).build_global()?;
    Ok(Some((universe, team)))
}

/// Checks that all ranks have the same job: a machine may have another scene at the same path, or another program. All
/// ranks call it.
pub fn agree(work: &PartWork<'_>) -> anyhow::Result<()> {
    let world = SimpleCommunicator::world();
    if world.rank() != 0 {
        let job = postcard::to_stdvec(&work.job)?;
        world.process_at_rank(0).send_with_tag(&job[..], CONTENTS);
        return Ok(());
    }
    for rank in 1..world.size() {
        let (bytes, _) = world.process_at_rank(rank).receive_vec_with_tag::<u8>(CONTENTS);
        let job: Job = postcard::from_bytes(&bytes)
            .with_context(|| format!("rank {rank} is another version of the program"))?;
        if let Some(difference) = work.job.difference(&job) {
            bail!("rank {rank} has another job than rank 0: it has {difference}");
        }
    }
    Ok(())
}

/// Ends all ranks because this one failed.
pub fn abort() -> ! {
    SimpleCommunicator::world().abort(1)
}

/// Times of rank 0 beside shooting, in all rounds. `growth.py` computes from them how many ranks are worth while.
#[derive(Default)]
pub struct Exchange {
    /// Number of ranges that were handed out.
    ranges: u64,
    /// Time of receiving results of ranks and handing out ranges.
    speaking: Duration,
    /// Time of adding counts over all ranks.
    adding: Duration,
}

impl Exchange {
    /// Logs the times.
    pub fn log(&self) {
        let (ranks, ranges) = (SimpleCommunicator::world().size(), self.ranges);
        let [speaking, adding] =
            [self.speaking, self.adding].map(|time| duration(time.as_secs_f64()));
        log::info!(
            "{ranks} ranks; {ranges} ranges handed out in {speaking}, counts added in {adding}"
        );
    }
}

/// Shoots a round with all ranks, as rank 0: photons from the first of those that are left. Returns where it ended, and
/// what all its photons leave behind.
pub fn round(
    work: &PartWork<'_>,
    left: &Range<u64>,
    pace: &mut Pace,
    exchange: &mut Exchange,
    progress: &(dyn Fn(u64) + Sync),
) -> anyhow::Result<(u64, PartSums)> {
    // 1. This thread shoots, so that it is the pool of the command that does; another one speaks with the ranks.
    let (ask, asked) = channel();
    let (answer, answered) = channel();
    let per_pass = work.per_pass();
    let speaking = &mut *exchange;
    let (shot, handed) = std::thread::scope(|scope| {
        let coordinator = scope
            .spawn(move || hand_out((left, per_pass), pace, speaking, progress, &asked, &answer));
        let shot = shoot_own(work, progress, &ask, &answered);
        drop(ask);
        (shot, coordinator.join())
    });
    let mut counts = shot?;
    let Ok(handed) = handed else { bail!("the thread that speaks with the ranks failed") };
    let Handed { end, rests } = handed?;

    // 2. The counts of all ranks, and what is left in the order of photons.
    let world = SimpleCommunicator::world();
    let mut all: Option<JobPart> = None;
    for (photons, sums) in rests.into_values() {
        let part = JobPart { photons, sums };
        match &mut all {
            None => all = Some(part),
            Some(all) => {
                let (own, next) = (all.photons.clone(), part.photons.clone());
                ensure!(all.join(part), "photons {next:?} do not follow {own:?}");
            }
        }
    }
    let JobPart { photons, mut sums } = all.context("a round without photons")?;
    ensure!(photons == (left.start..end), "photons of the round were not shot");
    let begun = Instant::now();
    for of in counts_of(&passes_of(&photons, per_pass)) {
        let added = add_over_ranks(&world, counts.remove(&of).unwrap_or_default())?;
        sums.put_counts(of, &added);
    }
    exchange.adding += begun.elapsed();
    Ok((end, sums))
}

/// What was handed out in a round: where it ended, and what is left of each range, by its first photon.
struct Handed {
    end: u64,
    rests: BTreeMap<u64, (Range<u64>, PartSums)>,
}

/// A range that a thread of rank 0 shot.
type OwnRange = Option<(Range<u64>, PartSums)>;

/// Shoots ranges for rank 0 itself. Returns their counts.
fn shoot_own(
    work: &PartWork<'_>,
    progress: &(dyn Fn(u64) + Sync),
    ask: &Sender<OwnRange>,
    answered: &Receiver<Option<Range<u64>>>,
) -> anyhow::Result<Counts> {
    let (mut counts, mut shot) = (Counts::new(), None);
    // The other thread is gone only if it failed, and says so itself.
    while ask.send(shot.take()).is_ok()
        && let Ok(Some(photons)) = answered.recv()
    {
        let sums = (work.shoot)(photons.clone(), progress)?;
        shot = Some((photons, keep_counts(&mut counts, sums)));
    }
    Ok(counts)
}

/// Hands out ranges to all ranks until the round is over, and all that was handed out is back.
fn hand_out(
    (left, per_pass): (&Range<u64>, u64),
    pace: &mut Pace,
    exchange: &mut Exchange,
    progress: &(dyn Fn(u64) + Sync),
    asked: &Receiver<OwnRange>,
    answer: &Sender<Option<Range<u64>>>,
) -> anyhow::Result<Handed> {
    let world = SimpleCommunicator::world();
    let ranks = world.size() as usize;
    pace.of(ranks);
    let mut handed = Handed { end: left.start, rests: BTreeMap::new() };
    // Ranks that have work, or have not asked yet, and whether rank 0 itself is one of them.
    let (mut working, mut works_itself) = (ranks, true);
    while working > 0 {
        // 1. Somebody asks, with what is left of the range before.
        let begun = Instant::now();
        let (rank, back) = match asked.try_recv() {
            Ok(back) => (0, back),
            Err(TryRecvError::Disconnected) if works_itself => bail!("rank 0 has failed"),
            Err(_) => {
                let Some((rank, back)) = receive_ask(&world)? else {
                    std::thread::sleep(PAUSE);
                    continue;
                };
                if let Some((photons, _)) = &back {
                    progress(photons.end - photons.start);
                }
                (rank, back)
            }
        };
        if let Some((photons, sums)) = back {
            pace.done(rank as usize);
            handed.rests.insert(photons.start, (photons, sums));
        }
        // 2. The next range, or none.
        let is_over = handed.end == left.end || (pace.is_over() && handed.end > left.start);
        let next = (!is_over).then(|| pace.next(rank as usize, &(handed.end..left.end), per_pass));
        match &next {
            Some(photons) => {
                handed.end = photons.end;
                exchange.ranges += 1;
            }
            None => working -= 1,
        }
        if rank == 0 {
            works_itself = next.is_some();
            answer.send(next)?;
        } else if let Some(photons) = next {
            let words = [SHOOT, photons.start, photons.end];
            world.process_at_rank(rank).send_with_tag(&words[..], WORK);
        }
        exchange.speaking += begun.elapsed();
    }
    // 3. All ranks add at the same time: one that was done earlier would ask for work of the next round in this one.
    let passes = passes_of(&(left.start..handed.end), per_pass);
    for rank in 1..world.size() {
        let words = [ADD, passes.start.into(), passes.end.into()];
        world.process_at_rank(rank).send_with_tag(&words[..], WORK);
    }
    Ok(handed)
}

/// Takes the question of a rank, if one asks.
fn receive_ask(world: &SimpleCommunicator) -> anyhow::Result<Option<(i32, OwnRange)>> {
    let Some(asking) = world.any_process().immediate_matched_probe_with_tag(ASK) else {
        return Ok(None);
    };
    let (words, status) = asking.matched_receive_vec::<u64>();
    let rank = status.source_rank();
    let length = words.first().copied().unwrap_or(0);
    if length == 0 {
        return Ok(Some((rank, None)));
    }
    let bytes: Vec<u8> = receive_all(world, rank, length)?;
    let (photons, sums) = postcard::from_bytes(&bytes)
        .with_context(|| format!("rank {rank} is another version of the program"))?;
    Ok(Some((rank, Some((photons, sums)))))
}

/// Shoots what rank 0 hands out, until it ends the work.
pub fn serve(work: &PartWork<'_>) -> anyhow::Result<()> {
    let world = SimpleCommunicator::world();
    let first = world.process_at_rank(0);
    let (mut counts, mut result) = (Counts::new(), Vec::new());
    loop {
        first.send_with_tag(&[result.len() as u64][..], ASK);
        send_all(&world, 0, &result);
        result.clear();
        let (words, _) = first.receive_vec_with_tag::<u64>(WORK);
        match words[..] {
            [SHOOT, start, end] => {
                let sums = (work.shoot)(start..end, &|_| {})?;
                result = postcard::to_stdvec(&(start..end, keep_counts(&mut counts, sums)))?;
            }
            [ADD, start, end] => {
                for of in counts_of(&(start as u32..end as u32)) {
                    add_over_ranks(&world, counts.remove(&of).unwrap_or_default())?;
                }
            }
            [END, ..] => return Ok(()),
            _ => bail!("rank 0 is another version of the program"),
        }
    }
}

/// Ends the work of the other ranks, as rank 0.
pub fn dismiss() {
    let world = SimpleCommunicator::world();
    for rank in 1..world.size() {
        let process = world.process_at_rank(rank);
        process.receive_vec_with_tag::<u64>(ASK);
        process.send_with_tag(&[END, 0, 0][..], WORK);
    }
}

/// The passes of a range of photons.
fn passes_of(photons: &Range<u64>, per_pass: u64) -> Range<u32> {
    let per_pass = per_pass.max(1);
    (photons.start / per_pass) as u32..photons.end.div_ceil(per_pass) as u32
}

/// The lists of counts of passes, in the order in which all ranks add them.
fn counts_of(passes: &Range<u32>) -> impl Iterator<Item = CountsOf> + use<> {
    passes.clone().flat_map(|pass| [(pass, 0), (pass, 1)])
}

/// Adds counts over all ranks, in a binomial tree; rank 0 has the sums. A rank without counts has an empty list.
fn add_over_ranks(world: &SimpleCommunicator, own: Vec<u64>) -> anyhow::Result<Vec<u64>> {
    let (rank, size, mut sums, mut step) = (world.rank(), world.size(), own, 1);
    while step < size {
        if rank & step != 0 {
            let parent = rank - step;
            world.process_at_rank(parent).send_with_tag(&[sums.len() as u64][..], CONTENTS);
            send_all(world, parent, &sums);
            return Ok(Vec::new());
        }
        let child = rank + step;
        if child < size {
            let (length, _) = world.process_at_rank(child).receive_vec_with_tag::<u64>(CONTENTS);
            let length = length.first().copied().unwrap_or(0);
            let others = receive_all(world, child, length)?;
            ensure!(
                sums.is_empty() || others.is_empty() || sums.len() == others.len(),
                "ranks {rank} and {child} count at different points"
            );
            if !others.is_empty() {
                add_counts(&mut sums, others);
            }
        }
        step <<= 1;
    }
    Ok(sums)
}

/// Sends numbers to a rank, in messages that are not too long.
fn send_all<T: mpi::traits::Equivalence>(world: &SimpleCommunicator, rank: i32, numbers: &[T])
where
    [T]: mpi::traits::Buffer,
{
    for some in numbers.chunks(AT_ONCE) {
        world.process_at_rank(rank).send_with_tag(some, CONTENTS);
    }
}

/// Receives as many numbers from a rank as it said.
fn receive_all<T: mpi::traits::Equivalence>(
    world: &SimpleCommunicator,
    rank: i32,
    length: u64,
) -> anyhow::Result<Vec<T>> {
    let mut all: Vec<T> = Vec::new();
    while (all.len() as u64) < length {
        let (some, _) = world.process_at_rank(rank).receive_vec_with_tag::<T>(CONTENTS);
        ensure!(!some.is_empty(), "rank {rank} sent less than it said");
        if all.is_empty() { all = some } else { all.extend(some) }
    }
    Ok(all)
}
