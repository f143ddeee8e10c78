//! The threads that share the force pass ([`crate::contact::kernel`]), passes over the particle store
//! ([`crate::store`]), the neighbour search and the passes of the lattice gas. One thread needs no pool. Results are
//! the same to the last bit for any number of threads.
//!
//! A step is a few passes of 10 to 100 microseconds each, with a little single-threaded work in between. Waking a
//! sleeping thread takes as long as a pass; in a virtual machine it takes 0.1 to 0.5 ms. A helper thread therefore
//! stays awake after a pass, polls for more work, and sleeps after 2 ms without any. A thread that needs results of
//! helpers polls too. Polling threads yield their core to other threads.

use std::cell::Cell;
use std::num::NonZeroUsize;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use bevy_ecs::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder, Yield};

/// How long a thread without work polls before it sleeps. The single-threaded parts of a step take less time, except a
/// rebuilt list of many grains or a row of measurements.
const PATIENCE: Duration = Duration::from_millis(2);

/// The threads of a run.
#[derive(Resource)]
pub struct Threads(Option<Team>);

/// A pool of several threads.
#[derive(Clone)]
struct Team {
    pool: Arc<ThreadPool>,
    /// Whether some threads may be asleep.
    sleeps: Arc<AtomicBool>,
}

impl Threads {
    /// Creates `count` threads.
    ///
    /// # Errors
    /// If the operating system cannot start them.
    pub fn new(count: NonZeroUsize) -> Result<Self, ThreadPoolBuildError> {
        if count.get() == 1 {
            return Ok(Self::one());
        }
        let pool = Arc::new(ThreadPoolBuilder::new().num_threads(count.get()).build()?);
        Ok(Self(Some(Team { pool, sleeps: Arc::new(AtomicBool::new(true)) })))
    }

    /// Creates a single thread.
    #[must_use]
    pub fn one() -> Self {
        Self(None)
    }

    /// Number of threads.
    #[must_use]
    pub fn count(&self) -> usize {
        self.0.as_ref().map_or(1, |team| team.pool.current_num_threads())
    }

    /// Runs all jobs, in parallel if there are several threads. Returns their results in the order of jobs.
    pub(crate) fn share<R: Send>(&self, jobs: impl IntoIterator<Item: FnOnce() -> R + Send>) -> Vec<R> {
        match &self.0 {
            None => jobs.into_iter().map(|job| job()).collect(),
            Some(team) => team.share(jobs.into_iter().collect()),
        }
    }

    /// Runs `work` on a thread of the pool. Passes inside it then share their jobs with the other threads directly,
    /// without waking the whole pool.
    pub(crate) fn run<R: Send>(world: &mut World, work: impl FnOnce(&mut World) -> R + Send) -> R {
        match world.resource::<Self>().0.clone() {
            None => work(world),
            Some(team) => team.pool.install(|| work(world)),
        }
    }
}

impl Team {
    fn share<R: Send, J: FnOnce() -> R + Send>(&self, jobs: Vec<J>) -> Vec<R> {
        self.wake();
        let mut results: Vec<Option<R>> = jobs.iter().map(|_| None).collect();
        let left = AtomicUsize::new(jobs.len());
        self.pool.in_place_scope(|scope| {
            let mut own = None;
            for (job, result) in jobs.into_iter().zip(&mut results) {
                let ended = Ended(&left);
                let work = move || {
                    *result = Some(job());
                    drop(ended);
                };
                match own {
                    None => own = Some(work),
                    Some(_) => scope.spawn(|_| work()),
                }
            }
            if let Some(work) = own {
                work();
            }
            while left.load(Ordering::Acquire) > 0 {
                self.look_for_work();
            }
        });
        results.into_iter().map(|result| result.expect("a job that panics takes the scope with it")).collect()
    }

    /// Runs a pending job, or else yields the core. Returns whether it ran a job.
    fn look_for_work(&self) -> bool {
        let has_worked = self.pool.yield_now() == Some(Yield::Executed);
        if !has_worked {
            thread::yield_now();
        }
        has_worked
    }

    /// Wakes the sleeping threads.
    fn wake(&self) {
        if self.sleeps.swap(false, Ordering::Relaxed) {
            let (leader, team) = (self.pool.current_thread_index(), self.clone());
            self.pool.spawn_broadcast(move |helper| {
                if Some(helper.index()) != leader {
                    team.stay_awake();
                }
            });
        }
    }

    /// Runs jobs until there have been none for a while.
    fn stay_awake(&self) {
        thread_local! {
            static IS_AWAKE: Cell<bool> = const { Cell::new(false) };
        }
        // A thread may receive this request while it is already polling.
        if IS_AWAKE.replace(true) {
            return;
        }
        let mut last = Instant::now();
        while last.elapsed() < PATIENCE {
            if self.look_for_work() {
                last = Instant::now();
            }
        }
        IS_AWAKE.set(false);
        self.sleeps.store(true, Ordering::Relaxed);
    }
}

/// Decrements the count of open jobs when a job ends, even by a panic.
struct Ended<'a>(&'a AtomicUsize);

impl Drop for Ended<'_> {
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
    fn helpers_go_to_sleep_and_wake_again() {
        let threads = threads(2);
        let sleeps = || threads.0.as_ref().unwrap().sleeps.load(Ordering::Relaxed);
        for _ in 0..3 {
            assert!(sleeps());
            assert_eq!(threads.share((0..4).map(|number| move || number)), [0, 1, 2, 3]);
            while !sleeps() {
                thread::yield_now();
            }
        }
    }

    #[test]
    #[should_panic(expected = "not today")]
    fn a_job_that_panics_is_heard() {
        threads(2).share((0..4).map(|number| move || assert!(number != 3, "not today")));
    }
}
