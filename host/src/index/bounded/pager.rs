//! Pager: keeps the resident memory of the process below a limit, while it works in mapped files.
//!
//! A page of a mapped file counts as resident memory until it is given back. The system takes pages back only where
//! memory is short, so a process may grow far beyond what it needs. A timer interrupts the threads that work, after
//! each millisecond of processor time or at the next tick of the system. Where the resident memory comes near the limit,
//! the pages of all maps are given back: they stay in the system's cache of files, and are mapped again where they are
//! touched, at about a microsecond each.
//!
//! This needs Linux. On other systems, mapped pages are the system's to take back. It is not a hard limit, because the
//! process may touch any number of pages between two looks: a margin is kept for them. A control group has a hard limit, to
//! which the system gives pages back itself.
//!
//! # What lost
//! - A thread that looks each millisecond: as good while processors are idle, but it waits for its turn where they are
//!   busy. A signal interrupts the very thread that touches pages.
//! - No huge pages: 220 MB instead of 310 MB were mapped between two looks, and the system took four times as long.

use std::io;
use std::ops::Deref;

use memmap2::MmapRaw;

/// Least part of the memory that is kept free, for what is touched between two looks.
///
/// # Measured
/// - Where a page is touched, Linux also maps those around it, 64 KiB in all. So random reads map several GB/s: on two
///   busy processors, up to 310 MB were mapped between two looks.
pub(super) const LEAST_MARGIN: u64 = 400_000_000;

/// Watch over the resident memory. There is one for a process: another one replaces its limit. Dropping it ends it.
pub struct Pager(());

impl Pager {
    /// Starts to keep the resident memory below `memory` bytes.
    pub fn start(memory: u64) -> Self {
        watch::start(memory - (memory / 4).max(LEAST_MARGIN).min(memory));
        Self(())
    }

    /// Adds a map of a file, shared with others, to those whose pages are given back.
    ///
    /// # Errors
    /// If there are too many maps.
    #[allow(clippy::unused_self, reason = "a map needs a pager")]
    pub fn watch(&self, map: MmapRaw) -> io::Result<Watched> {
        let slot = watch::add(map.as_ptr() as usize, map.len())
            .ok_or_else(|| io::Error::other("too many files are mapped"))?;
        Ok(Watched { slot, map })
    }

    /// Gives the pages of all maps back.
    #[cfg(test)]
    pub fn release() {
        watch::release();
    }

    /// Returns the number of times that pages were given back because the memory was full.
    #[cfg(all(test, target_os = "linux"))]
    pub fn times_full() -> u64 {
        watch::times_full()
    }
}

impl Drop for Pager {
    fn drop(&mut self) {
        watch::stop();
    }
}

/// Map whose pages are given back.
pub struct Watched {
    /// Its place among those that are watched.
    slot: usize,
    map: MmapRaw,
}

impl Deref for Watched {
    type Target = MmapRaw;

    fn deref(&self) -> &MmapRaw {
        &self.map
    }
}

impl Drop for Watched {
    // The map is unmapped after this, so what lies at its address later is never given back.
    fn drop(&mut self) {
        watch::remove(self.slot);
    }
}

#[cfg(target_os = "linux")]
#[allow(unsafe_code)] // timers, signals and advice are functions of the system
mod watch {
    use std::os::fd::IntoRawFd;
    use std::sync::atomic::{AtomicBool, AtomicI32, AtomicU64, AtomicUsize, Ordering};

    /// Most maps at once: a pack has at most eleven.
    const MOST_MAPS: usize = 64;

    /// Address and length of each map; 0 where there is none.
    static MAPS: [[AtomicUsize; 2]; MOST_MAPS] =
        [const { [AtomicUsize::new(0), AtomicUsize::new(0)] }; MOST_MAPS];
    /// True while maps are given back or removed. A signal that finds it true does nothing.
    static IS_LOCKED: AtomicBool = AtomicBool::new(false);
    /// Resident bytes above which pages are given back.
    static MOST: AtomicU64 = AtomicU64::new(u64::MAX);
    /// File in which the system tells the resident memory; negative until it is open.
    static METER: AtomicI32 = AtomicI32::new(-1);
    static PAGE: AtomicU64 = AtomicU64::new(4096);
    /// Number of times that pages were given back because the memory was full.
    static TIMES_FULL: AtomicU64 = AtomicU64::new(0);

    /// Returns the number of times that pages were given back because the memory was full.
    #[cfg(test)]
    pub fn times_full() -> u64 {
        TIMES_FULL.load(Ordering::Relaxed)
    }

    /// Locks, calls `work` and unlocks. Not for signals: they could wait for their own thread.
    fn locked(work: impl FnOnce()) {
        while IS_LOCKED.compare_exchange(false, true, Ordering::Acquire, Ordering::Relaxed).is_err()
        {
            std::thread::yield_now();
        }
        work();
        IS_LOCKED.store(false, Ordering::Release);
    }

    pub fn add(address: usize, length: usize) -> Option<usize> {
        let mut found = None;
        locked(|| {
            found = MAPS.iter().position(|map| map[1].load(Ordering::Relaxed) == 0);
            if let Some(slot) = found {
                MAPS[slot][0].store(address, Ordering::Relaxed);
                MAPS[slot][1].store(length, Ordering::Relaxed);
            }
        });
        found
    }

    pub fn remove(slot: usize) {
        locked(|| MAPS[slot][1].store(0, Ordering::Relaxed));
    }

    #[cfg(test)]
    pub fn release() {
        locked(give_back);
    }

    pub fn start(most: u64) {
        MOST.store(most, Ordering::Relaxed);
        PAGE.store(rustix::param::page_size() as u64, Ordering::Relaxed);
        if METER.load(Ordering::Relaxed) < 0 {
            let Ok(file) = std::fs::File::open("/proc/self/statm") else {
                log::warn!("/proc is not there, so mapped pages are left to the system");
                return;
            };
            // Open until the process ends.
            METER.store(file.into_raw_fd(), Ordering::Relaxed);
        }
        // SAFETY: `on_tick` is a function of the type that a handler has without SA_SIGINFO, and calls only what a handler
        // may: atomics, pread and madvise. All fields of the action are set, or zero, which is their default.
        unsafe {
            let mut action: libc::sigaction = std::mem::zeroed();
            action.sa_sigaction = on_tick as extern "C" fn(libc::c_int) as usize;
            action.sa_flags = libc::SA_RESTART;
            libc::sigemptyset(&raw mut action.sa_mask);
            libc::sigaction(libc::SIGPROF, &raw const action, std::ptr::null_mut());
        }
        set_timer(1000);
    }

    pub fn stop() {
        // The handler stays: a signal may be on its way.
        set_timer(0);
        MOST.store(u64::MAX, Ordering::Relaxed);
    }

    /// Sends the signal after each `microseconds` of processor time; 0 for never.
    fn set_timer(microseconds: libc::suseconds_t) {
        let interval = libc::timeval { tv_sec: 0, tv_usec: microseconds };
        let timer = libc::itimerval { it_interval: interval, it_value: interval };
        // SAFETY: the timer is a valid value, and the old one is not asked for.
        unsafe { libc::setitimer(libc::ITIMER_PROF, &raw const timer, std::ptr::null_mut()) };
    }

    /// Handler of the signal: gives pages back if there are too many. It runs in a thread that works.
    extern "C" fn on_tick(_: libc::c_int) {
        // SAFETY: the address is that of this thread's error number.
        let error = unsafe { libc::__errno_location() };
        // SAFETY: as above. The interrupted code may be about to read it.
        let before = unsafe { *error };
        let is_full = resident().is_some_and(|bytes| bytes > MOST.load(Ordering::Relaxed));
        if is_full
            && IS_LOCKED.compare_exchange(false, true, Ordering::Acquire, Ordering::Relaxed).is_ok()
        {
            give_back();
            TIMES_FULL.fetch_add(1, Ordering::Relaxed);
            IS_LOCKED.store(false, Ordering::Release);
        }
        // SAFETY: as above.
        unsafe { *error = before };
    }

    /// Gives the pages of all maps back; under the lock.
    fn give_back() {
        for [address, length] in &MAPS {
            let length = length.load(Ordering::Relaxed);
            if length > 0 {
                let address = address.load(Ordering::Relaxed) as *mut libc::c_void;
                // SAFETY: the lock is held, so the range is still mapped. It is a shared map of a file, so its pages keep what
                // they hold: "repopulating the memory contents from the up-to-date contents of the underlying mapped file",
                // madvise(2). Where it is refused, the system takes pages back in its own time.
                unsafe { libc::madvise(address, length, libc::MADV_DONTNEED) };
            }
        }
    }

    /// Reads the bytes that are resident: the second number in the file, in pages.
    fn resident() -> Option<u64> {
        let mut text = [0_u8; 64];
        let meter = METER.load(Ordering::Relaxed);
        // SAFETY: the buffer has as many bytes.
        let length = unsafe { libc::pread(meter, text.as_mut_ptr().cast(), text.len(), 0) };
        let text = text.get(..usize::try_from(length).ok()?)?;
        let digits = text.split(|&byte| byte == b' ').nth(1)?;
        let pages = digits.iter().fold(0_u64, |sum, digit| {
            sum.wrapping_mul(10).wrapping_add(u64::from(digit.wrapping_sub(b'0')))
        });
        Some(pages.saturating_mul(PAGE.load(Ordering::Relaxed)))
    }
}

#[cfg(not(target_os = "linux"))]
mod watch {
    pub fn add(_: usize, _: usize) -> Option<usize> {
        Some(0)
    }

    pub fn remove(_: usize) {}

    #[cfg(test)]
    pub fn release() {}

    pub fn start(_: u64) {}

    pub fn stop() {}
}

#[cfg(test)]
pub(super) mod tests {
    use std::sync::{Mutex, MutexGuard, PoisonError};

    /// The process has one watch, so tests that start it take turns.
    pub fn alone() -> MutexGuard<'static, ()> {
        static ALONE: Mutex<()> = Mutex::new(());
        ALONE.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Reads the resident bytes of the map at an address, in kB.
    #[cfg(target_os = "linux")]
    fn resident_at(address: usize) -> u64 {
        let maps = std::fs::read_to_string("/proc/self/smaps").unwrap();
        let start = format!("{address:x}-");
        let mut lines = maps.lines().skip_while(|line| !line.starts_with(&start));
        let line = lines.find_map(|line| line.strip_prefix("Rss:")).unwrap();
        line.trim().trim_end_matches(" kB").parse().unwrap()
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn pages_are_given_back_beyond_the_limit_and_keep_what_they_hold() {
        use super::super::{Pager, Scratch};
        use std::time::{Duration, Instant};
        let _alone = alone();
        let folder = tempfile::tempdir().unwrap();
        let pager = Pager::start(u64::MAX);
        let mut scratch = Scratch::new(folder.path(), 32 << 20, &pager).unwrap();
        scratch.bytes().fill(3);
        let address = scratch.bytes().as_ptr() as usize;
        let is_resident = || resident_at(address) > 16 << 10;
        assert!(is_resident(), "nothing is given back below the limit");
        drop(pager);
        let _pager = Pager::start(0);
        let start = Instant::now();
        while is_resident() {
            assert!(start.elapsed() < Duration::from_secs(60), "nothing is given back");
        }
        assert!(scratch.bytes().iter().all(|&byte| byte == 3));
    }
}
