//! How many threads share the force pass ([`crate::contact::kernel`]), those over the rows of many grains
//! ([`crate::columns`]), the search for neighbours and the lattice's passes. One needs no pool; on several the bits are the same.
//!
//! A step is a few passes of some ten or a hundred microseconds each, with a little in between that one thread does. To wake
//! a thread that sleeps takes as long as a pass, and 0.1 to 0.5 ms in a virtual machine. So whoever has helped stays awake, looks
//! for more to do, and goes to sleep after 2 ms without; whoever waits for helpers stays awake too. Meanwhile each lets others
//! have its core if they want it.

use std::cell::Cell;
use std::num::NonZeroUsize;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use bevy_ecs::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder, Yield};

/// For how long a thread that has nothing to do looks for something. The parts of a step that one thread does take less, but
/// for a renewed list of many grains, or a row of measurements.
const PATIENCE: Duration = Duration::from_millis(2);

/// The threads of a run.
#[derive(Resource)]
pub struct Threads(Option<Team>);

/// Several of them.
#[derive(Clone)]
struct Team {
    pool: Arc<ThreadPool>,
    /// Whether some of them may be asleep.
    sleeps: Arc<AtomicBool>,
}

impl Threads {
    /// `count` threads.
    ///
    /// # Errors
    /// If the system refuses to start them.
    pub fn new(count: NonZeroUsize) -> Result<Self, ThreadPoolBuildError> {
        if count.get() == 1 {
            return Ok(Self::one());
        }
        let pool = Arc::new(ThreadPoolBuilder::new().num_threads(count.get()).build()?);
        Ok(Self(Some(Team { pool, sleeps: Arc::new(AtomicBool::new(true)) })))
    }

    /// One thread.
    #[must_use]
    pub fn one() -> Self {
        Self(None)
    }

    /// How many threads there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.0.as_ref().map_or(1, |team| team.pool.current_num_threads())
    }

    /// Does all jobs, side by side if there are several threads; gives what came of them, in order.
    pub(crate) fn share<R: Send>(&self, jobs: impl IntoIterator<Item: FnOnce() -> R + Send>) -> Vec<R> {
        match &self.0 {
            None => jobs.into_iter().map(|job| job()).collect(),
            Some(team) => team.share(jobs.into_iter().collect()),
        }
    }

    /// Runs `work` on one of them, so that passes within it share with the others what they do, instead of waking all and waiting.
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

    /// Does something that waits to be done, or lets others have the core. Tells which.
    fn look_for_work(&self) -> bool {
        let has_worked = self.pool.yield_now() == Some(Yield::Executed);
        if !has_worked {
            thread::yield_now();
        }
        has_worked
    }

    /// Wakes those who sleep.
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

    /// Helps until there has been nothing to do for a while.
    fn stay_awake(&self) {
        thread_local! {
            static IS_AWAKE: Cell<bool> = const { Cell::new(false) };
        }
        // Who is asked while it helps has no need to be asked.
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

/// Says at the end of a job, however it ends, that there is one less.
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
