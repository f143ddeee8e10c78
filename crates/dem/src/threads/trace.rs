//! Where the time of shared passes goes: the work of each thread, and waiting. A run has no trace unless a benchmark asks for it.

use std::cell::Cell;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Sums over passes, each a call of [`Threads::share`](super::Threads::share).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Passes {
    /// Number of passes.
    pub count: u64,
    /// Time from the beginning of a pass to its end.
    pub wall: Duration,
    /// Work of all threads.
    pub work: Duration,
    /// Work of the thread that had most in its pass. The rest of `wall` is spent on waking, handing out and joining.
    pub longest: Duration,
}

impl Passes {
    /// Returns the passes since an earlier moment.
    #[must_use]
    pub fn since(self, earlier: Self) -> Self {
        Self {
            count: self.count - earlier.count,
            wall: self.wall.saturating_sub(earlier.wall),
            work: self.work.saturating_sub(earlier.work),
            longest: self.longest.saturating_sub(earlier.longest),
        }
    }
}

/// The passes so far.
#[derive(Debug, Default)]
pub(super) struct Trace(Mutex<Passes>);

impl Trace {
    /// Begins a pass of so many threads.
    pub(super) fn begin(threads: usize) -> PassClock {
        PassClock { begin: Instant::now(), work: (0..threads).map(|_| AtomicU64::new(0)).collect() }
    }

    /// Ends a pass.
    pub(super) fn end(&self, clock: PassClock) {
        let wall = clock.begin.elapsed();
        let work = || clock.work.iter().map(|nanoseconds| Duration::from_nanos(nanoseconds.load(Ordering::Relaxed)));
        let mut passes = self.lock();
        passes.count += 1;
        passes.wall += wall;
        passes.work += work().sum::<Duration>();
        passes.longest += work().max().unwrap_or_default();
    }

    /// Returns all passes so far.
    pub(super) fn passes(&self) -> Passes {
        *self.lock()
    }

    fn lock(&self) -> MutexGuard<'_, Passes> {
        // Sums of a benchmark stay sums after a panic elsewhere.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

thread_local! {
    /// Time for which jobs of this thread have waited for other jobs.
    static WAITED: Cell<Duration> = const { Cell::new(Duration::ZERO) };
}

/// Waits, and notes for how long. Jobs that this thread does meanwhile have clocks of their own, so their waiting does not count again.
pub(super) fn waiting(wait: impl FnOnce()) {
    let before = WAITED.get();
    let begin = Instant::now();
    wait();
    WAITED.set(before + begin.elapsed());
}

/// The clock of one pass.
#[derive(Debug)]
pub(super) struct PassClock {
    begin: Instant,
    /// Work of each thread, ns.
    work: Vec<AtomicU64>,
}

impl PassClock {
    /// Does a job on the thread with this index, and adds its time without that of waiting.
    pub(super) fn time(&self, thread: usize, job: impl FnOnce()) {
        let waited = WAITED.get();
        let begin = Instant::now();
        job();
        let spent = begin.elapsed().saturating_sub(WAITED.get().saturating_sub(waited));
        let spent = u64::try_from(spent.as_nanos()).unwrap_or(u64::MAX);
        if let Some(sum) = self.work.get(thread) {
            sum.fetch_add(spent, Ordering::Relaxed);
        }
    }
}
