//! The threads that share the force pass ([`crate::contact::force_pass`]), passes over the particle store
//! ([`crate::store`]), the neighbour search and the passes of the lattice gas. One thread needs no pool. Results are
//! the same to the last bit for any number of threads. WebAssembly has one thread, whatever number is wanted.
//!
//! A step is a few passes of 10 to 100 microseconds each, with a little single-threaded work in between. Waking a
//! sleeping thread takes as long as a pass; in a virtual machine it takes 0.1 to 0.5 ms. A helper thread therefore
//! stays awake after a pass, polls for more work, and sleeps after 2 ms without any. A thread that needs results of
//! helpers polls too. Polling threads yield their core to other threads.

pub mod trace;

use std::cell::Cell;
use std::num::NonZeroUsize;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use bevy_ecs::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder, Yield};

use self::trace::{PassClock, Passes, Trace};

/// How long a thread without work polls before it sleeps. The single-threaded parts of a step take less time, except a
/// rebuilt list of many grains or a row of measurements.
const POLL_TIME: Duration = Duration::from_millis(2);

thread_local! {
    /// Whether this thread polls for jobs.
    static IS_POLLING: Cell<bool> = const { Cell::new(false) };
    /// Whether this thread waits in a job for another one.
    static IS_WAITING: Cell<bool> = const { Cell::new(false) };
}

/// The threads of a run.
#[derive(Resource)]
pub struct Threads(Option<Pool>);

/// A pool of several threads.
#[derive(Clone)]
struct Pool {
    threads: Arc<ThreadPool>,
    /// Whether some threads may be asleep.
    may_sleep: Arc<AtomicBool>,
    /// The times of passes, if a benchmark wants them.
    trace: Option<Arc<Trace>>,
}

impl Threads {
    /// Creates `count` threads.
    ///
    /// # Errors
    /// If the operating system cannot start them.
    pub fn new(count: NonZeroUsize) -> Result<Self, ThreadPoolBuildError> {
        if count.get() == 1 || cfg!(target_family = "wasm") {
            return Ok(Self::one());
        }
        let threads = Arc::new(ThreadPoolBuilder::new().num_threads(count.get()).build()?);
        Ok(Self(Some(Pool { threads, may_sleep: Arc::new(AtomicBool::new(true)), trace: None })))
    }

    /// Creates a single thread.
    #[must_use]
    pub fn one() -> Self {
        Self(None)
    }

    /// Returns these threads with a trace of their passes. A single thread has no passes.
    #[must_use]
    pub fn traced(self) -> Self {
        Self(self.0.map(|pool| Pool { trace: Some(Arc::default()), ..pool }))
    }

    /// Returns the passes so far; none without a trace.
    #[must_use]
    pub fn passes(&self) -> Passes {
        self.0.as_ref().and_then(|pool| pool.trace.as_ref()).map(|trace| trace.passes()).unwrap_or_default()
    }

    /// Number of threads.
    #[must_use]
    pub fn count(&self) -> usize {
        self.0.as_ref().map_or(1, |shared_pool| shared_pool.threads.current_num_threads())
    }

    /// Runs all jobs, in parallel if there are several threads. Returns their results in the order of jobs.
    ///
    /// # Panics
    /// If a job panics.
    pub fn share<R: Send>(&self, jobs: impl IntoIterator<Item: FnOnce() -> R + Send>) -> Vec<R> {
        let Some(shared_pool) = &self.0 else { return jobs.into_iter().map(|job| job()).collect() };
        let mut jobs: Vec<_> = jobs.into_iter().map(|job| Job { work: Some(job), result: None }).collect();
        shared_pool.share(jobs.iter_mut().map(|job| job as &mut dyn Run).collect());
        jobs.into_iter().map(|job| job.result.expect("the pool propagates a panic of a job")).collect()
    }

    /// Divides `rows` into consecutive parts of at least `least` rows, the last one excepted, and runs `work` with each part, in parallel if there
    /// are several threads. Returns the results in the order of rows.
    pub(crate) fn share_rows<R: Send>(
        &self,
        rows: Range<usize>,
        least: usize,
        work: impl Fn(Range<usize>) -> R + Sync,
    ) -> Vec<R> {
        let each = rows.len().div_ceil(self.count()).max(least);
        let work = &work;
        let parts = rows.clone().step_by(each).map(|first| first..rows.end.min(first + each));
        self.share(parts.map(|part| move || work(part)))
    }

    /// Waits until `is_done`, and begins further jobs of a pass meanwhile. For a job that needs the result of another job of its pass. That job
    /// must not need what this thread still has to do.
    pub(crate) fn wait_until(&self, is_done: impl Fn() -> bool) {
        if is_done() {
            return;
        }
        trace::waiting(|| {
            while !is_done() {
                match &self.0 {
                    Some(pool) => pool.wait_a_moment(),
                    None => thread::yield_now(),
                }
            }
        });
    }

    /// Runs `work` on a thread of the pool. Passes inside it then share their jobs with the other threads directly,
    /// without waking the whole pool.
    pub fn run<R: Send>(world: &mut World, work: impl FnOnce(&mut World) -> R + Send) -> R {
        match world.resource::<Self>().0.clone() {
            None => work(world),
            Some(shared_pool) => shared_pool.install(|| {
                shared_pool.begin_run();
                work(world)
            }),
        }
    }
}

impl Pool {
    /// Runs `work` on a thread of the pool, and waits for it.
    ///
    /// A thread of another pool of Rayon takes further work of its own pool while it waits in `ThreadPool::install`. A caller that runs many simulations in parallel
    /// would so begin one within another on the same stack. In that case a thread that belongs to no pool waits.
    fn install<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        if rayon::current_thread_index().is_none() || self.threads.current_thread_index().is_some() {
            return self.threads.install(work);
        }
        thread::scope(|scope| match scope.spawn(|| self.threads.install(work)).join() {
            Ok(result) => result,
            Err(panic) => std::panic::resume_unwind(panic),
        })
    }

    /// Notes that this thread begins a run. If it still polled for jobs of the former run, it polls no more, and other threads may be asleep.
    fn begin_run(&self) {
        if IS_POLLING.get() {
            self.may_sleep.store(true, Ordering::Relaxed);
        }
    }

    /// Runs all jobs. Not generic, so that it is compiled once.
    fn share(&self, jobs: Vec<&mut dyn Run>) {
        let clock = self.trace.as_ref().map(|_| Trace::begin(self.threads.current_num_threads()));
        self.wake();
        let open_jobs = AtomicUsize::new(jobs.len());
        self.threads.in_place_scope(|scope| {
            let mut jobs = jobs.into_iter();
            let own = jobs.next();
            for job in jobs {
                let job_end = JobEnd(&open_jobs);
                let clock = clock.as_ref();
                scope.spawn(move |_| {
                    self.run_job(job, clock);
                    drop(job_end);
                });
            }
            if let Some(job) = own {
                let job_end = JobEnd(&open_jobs);
                self.run_job(job, clock.as_ref());
                drop(job_end);
            }
            while open_jobs.load(Ordering::Acquire) > 0 {
                self.run_pending_job();
            }
        });
        if let Some((trace, clock)) = self.trace.as_ref().zip(clock) {
            trace.end(clock);
        }
    }

    /// Runs a job, timed if there is a clock.
    fn run_job(&self, job: &mut dyn Run, clock: Option<&PassClock>) {
        match clock {
            None => job.run(),
            Some(clock) => clock.time(self.threads.current_thread_index().unwrap_or(0), || job.run()),
        }
    }

    /// Runs a pending job, or else yields the core. Returns whether it ran a job.
    fn run_pending_job(&self) -> bool {
        let has_worked = self.threads.yield_now() == Some(Yield::Executed);
        if !has_worked {
            thread::yield_now();
        }
        has_worked
    }

    /// Runs a pending job, or else yields the core, in a job that waits. A request to poll that this thread gets meanwhile is put off: it would
    /// keep the thread from the end of its wait.
    fn wait_a_moment(&self) {
        let before = IS_WAITING.replace(true);
        self.run_pending_job();
        IS_WAITING.set(before);
    }

    /// Wakes the sleeping threads.
    fn wake(&self) {
        if self.may_sleep.swap(false, Ordering::Relaxed) {
            let own_index = self.threads.current_thread_index();
            let shared_pool = self.clone();
            self.threads.spawn_broadcast(move |helper| {
                if Some(helper.index()) != own_index {
                    shared_pool.poll_for_jobs();
                }
            });
        }
    }

    /// Runs jobs until there have been none for a while.
    fn poll_for_jobs(&self) {
        // A thread may receive this request while it is already polling.
        if IS_POLLING.get() {
            return;
        }
        if IS_WAITING.get() {
            self.may_sleep.store(true, Ordering::Relaxed);
            return;
        }
        IS_POLLING.set(true);
        let mut last = Instant::now();
        while last.elapsed() < POLL_TIME {
            if self.run_pending_job() {
                last = Instant::now();
            }
        }
        IS_POLLING.set(false);
        self.may_sleep.store(true, Ordering::Relaxed);
    }
}

/// A job and its result.
struct Job<W, R> {
    work: Option<W>,
    result: Option<R>,
}

/// A job of any type.
trait Run: Send {
    /// Does the work and stores the result.
    fn run(&mut self);
}

impl<R: Send, W: FnOnce() -> R + Send> Run for Job<W, R> {
    fn run(&mut self) {
        self.result = self.work.take().map(|work| work());
    }
}

/// Decrements the count of open jobs when a job ends, even by a panic.
struct JobEnd<'a>(&'a AtomicUsize);

impl Drop for JobEnd<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Release);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn threads(count: usize) -> Threads {
        Threads::new(NonZeroUsize::new(count).unwrap()).unwrap()
    }

    #[test]
    fn results_are_in_the_order_of_jobs_however_many_share_them() {
        let expected: Vec<u64> = (0..100).map(|number| number * number).collect();
        for count in [1, 2, 3, 7] {
            let threads = threads(count);
            let squares = || threads.share((0..100u64).map(|number| move || number * number));
            assert_eq!(squares(), expected, "from outside");
            let mut world = World::new();
            world.insert_resource(self::threads(count));
            assert_eq!(
                Threads::run(&mut world, |world| {
                    world.resource::<Threads>().share((0..100u64).map(|number| move || number * number))
                }),
                expected
            );
            assert!(threads.share(Vec::<fn() -> u8>::new()).is_empty());
        }
    }

    #[test]
    fn rows_are_shared_in_parts_of_a_least_size() {
        let parts = |count, rows, least| threads(count).share_rows(rows, least, |part| part);
        assert_eq!(parts(1, 3..10, 2).as_slice(), std::slice::from_ref(&(3..10)));
        assert_eq!(parts(2, 3..10, 2), [3..7, 7..10]);
        assert_eq!(parts(4, 3..10, 3), [3..6, 6..9, 9..10]);
        assert!(parts(2, 5..5, 3).is_empty());
    }

    #[test]
    fn a_thread_of_another_pool_begins_nothing_else_while_it_waits() {
        use rayon::prelude::*;
        thread_local!(static DEPTH: Cell<u32> = const { Cell::new(0) });
        let other = ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let depth = |number: u32| {
            DEPTH.set(DEPTH.get() + 1);
            let mut world = World::new();
            world.insert_resource(threads(2));
            let double = Threads::run(&mut world, |_| {
                thread::sleep(Duration::from_millis(5));
                2 * number
            });
            let depth = DEPTH.get();
            DEPTH.set(depth - 1);
            (double, depth)
        };
        let found: Vec<_> = other.install(|| (0..8u32).into_par_iter().with_max_len(1).map(depth).collect());
        assert_eq!(found, (0..8).map(|number| (2 * number, 1)).collect::<Vec<_>>());
    }

    #[test]
    fn a_job_waits_for_a_later_one_also_if_jobs_are_more_than_threads() {
        for count in [2, 3] {
            let ended: Vec<_> = (0..6).map(|_| AtomicBool::new(false)).collect();
            let threads = threads(count);
            let jobs = (0..6).map(|number| {
                let (ended, threads) = (&ended, &threads);
                move || {
                    if number < 5 {
                        threads.wait_until(|| ended[number + 1].load(Ordering::Relaxed));
                    }
                    ended[number].store(true, Ordering::Relaxed);
                    ended.iter().filter(|ended| ended.load(Ordering::Relaxed)).count() >= 6 - number
                }
            });
            assert_eq!(threads.share(jobs), [true; 6]);
        }
    }

    #[test]
    fn helpers_go_to_sleep_and_wake_again() {
        let threads = threads(2);
        let may_sleep = || threads.0.as_ref().unwrap().may_sleep.load(Ordering::Relaxed);
        for _ in 0..3 {
            assert!(may_sleep());
            assert_eq!(threads.share((0..4).map(|number| move || number)), [0, 1, 2, 3]);
            while !may_sleep() {
                thread::yield_now();
            }
        }
    }

    #[test]
    fn a_run_that_begins_on_a_polling_thread_wakes_the_others() {
        let threads = threads(2);
        let pool = threads.0.clone().unwrap();
        let mut world = World::new();
        world.insert_resource(threads);
        for polls in [false, true] {
            pool.threads.broadcast(|_| IS_POLLING.set(polls));
            pool.may_sleep.store(false, Ordering::Relaxed);
            let will_wake = Threads::run(&mut world, |_| pool.may_sleep.load(Ordering::Relaxed));
            assert_eq!(will_wake, polls);
        }
    }

    #[test]
    fn a_trace_has_the_work_of_all_threads() {
        let mut world = World::new();
        world.insert_resource(threads(2).traced());
        let busy = || {
            let begin = Instant::now();
            while begin.elapsed() < Duration::from_millis(2) {}
        };
        // As in a run: on a thread of the pool. Work from outside counts as that of the first thread.
        Threads::run(&mut world, |world| world.resource::<Threads>().share([busy, busy, busy]));
        let passes = world.resource::<Threads>().passes();
        assert_eq!(passes.count, 1);
        assert!(passes.work >= Duration::from_millis(6), "{passes:?}");
        // One of two threads has at least half of the work, and no thread more than the pass lasts.
        assert!(2 * passes.longest >= passes.work && passes.longest <= passes.wall, "{passes:?}");
        assert_eq!(self::threads(2).passes(), Passes::default());
    }

    #[test]
    #[should_panic(expected = "job failed")]
    fn a_panic_in_a_job_propagates() {
        threads(2).share((0..4).map(|number| move || assert!(number != 3, "job failed")));
    }
}
