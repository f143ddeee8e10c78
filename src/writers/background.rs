//! Work that goes on beside a run, job after job, on a thread of its own. The queue is short, so that memory is bounded: if it is full, the
//! run waits. Where the system has no threads (WebAssembly), each job is done at once.

use std::io;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::{Builder, JoinHandle};

use siloflow_dem::outcome::Failure;

/// Does a job.
type Work<S, J> = fn(&mut S, J) -> Result<(), Failure>;

/// Does jobs with a state `S`.
pub(crate) enum Background<S, J> {
    Thread { queue: SyncSender<J>, thread: JoinHandle<(S, Result<(), Failure>)> },
    Here { state: S, work: Work<S, J>, result: Result<(), Failure> },
}

impl<S: Send + 'static, J: Send + 'static> Background<S, J> {
    /// Begins with a state. At most `waiting` jobs wait in the queue.
    ///
    /// # Errors
    /// If the system has threads, and cannot start one.
    pub(crate) fn start(name: &str, waiting: usize, mut state: S, work: Work<S, J>) -> io::Result<Self> {
        if cfg!(target_family = "wasm") {
            return Ok(Self::Here { state, work, result: Ok(()) });
        }
        let (queue, jobs) = sync_channel(waiting);
        let all = move || {
            let result = jobs.iter().try_for_each(|job| work(&mut state, job));
            (state, result)
        };
        let thread = Builder::new().name(name.to_owned()).spawn(all)?;
        Ok(Self::Thread { queue, thread })
    }

    /// Adds a job. Returns false if an earlier one has failed, and [`Background::close`] tells why.
    pub(crate) fn add(&mut self, job: J) -> bool {
        match self {
            Self::Thread { queue, .. } => queue.send(job).is_ok(),
            Self::Here { state, work, result } => {
                if result.is_ok() {
                    *result = work(state, job);
                }
                result.is_ok()
            }
        }
    }

    /// Waits until all jobs are done. Returns the state, and the first failure.
    pub(crate) fn close(self) -> (S, Result<(), Failure>) {
        match self {
            Self::Thread { queue, thread } => {
                drop(queue);
                thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
            }
            Self::Here { state, result, .. } => (state, result),
        }
    }

    /// Waits until all jobs are done; their failures, and a panic, are ignored.
    pub(crate) fn wait(self) {
        if let Self::Thread { queue, thread } = self {
            drop(queue);
            let _ = thread.join();
        }
    }
}
