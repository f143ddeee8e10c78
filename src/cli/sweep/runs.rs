//! The runs of a sweep, each a process of its own: `siloflow run` on one thread. A run that fails or is killed does not touch the others.
//!
//! A signal to the sweep is passed on to its runs, which end after their step with a checkpoint, and the sweep waits for them. Runs are not in
//! the process group of the sweep, so that a key such as Ctrl-C reaches each of them once.

use std::collections::VecDeque;
use std::io::{self, Write as _};
use std::num::NonZeroUsize;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use crate::cli::program;
use crate::cli::progress::Progress;
use crate::cli::signals::Signals;
use crate::studies::sweep::directory::{Log, State, SweepDirectory};
use crate::studies::sweep::{Sweep, Task};
use siloflow_text::fault::Fault;

/// Time between two looks at the processes.
const PAUSE: Duration = Duration::from_millis(10);

/// Time after which a run that another process does is examined again.
const PATIENCE: Duration = Duration::from_millis(500);

/// The runs of a sweep in a directory.
pub(in crate::cli) struct Runs<'a> {
    pub sweep: &'a Sweep,
    pub directory: &'a SweepDirectory,
    /// Most processes at a time.
    pub cores: NonZeroUsize,
    pub signals: &'a Signals,
    pub quiet: bool,
    /// Whether runs of another scene are replaced.
    pub force: bool,
    /// Whether failed runs are replaced.
    pub retry: bool,
}

/// A run without a result, and the reason.
pub(in crate::cli) struct Failure {
    pub task: Task,
    pub reason: String,
}

/// The way in which a run starts.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Start {
    New,
    Resume,
    Replace,
}

/// A process.
struct Running {
    task: Task,
    start: Start,
    child: Child,
    /// Holds the lock.
    log: Log,
}

/// The runs that are not over.
struct Queue {
    waiting: VecDeque<(Task, Option<Start>)>,
    /// Runs that other processes do.
    elsewhere: VecDeque<(Task, Option<Start>)>,
    looked: Instant,
    running: Vec<Running>,
    failures: Vec<Failure>,
}

impl Runs<'_> {
    /// Does all runs of `todo`, out of `all`, and returns those that have no result. After a signal no run is started.
    pub(in crate::cli) fn run(&self, all: usize, todo: &[Task]) -> Result<Vec<Failure>, Fault> {
        let program = program()?;
        let mut queue = Queue {
            waiting: todo.iter().map(|&task| (task, None)).collect(),
            elsewhere: VecDeque::new(),
            looked: Instant::now(),
            running: Vec::new(),
            failures: Vec::new(),
        };
        let mut progress = Progress::new(self.quiet, 0.0, 0);
        let mut is_told = false;
        loop {
            let is_stopped = self.signals.received().is_some();
            if is_stopped && !is_told {
                queue.running.iter().for_each(|running| terminate(&running.child));
                is_told = true;
            }
            if !is_stopped {
                self.fill(&mut queue, &program);
            }
            self.collect(&mut queue);
            let ahead = queue.waiting.len() + queue.elsewhere.len();
            if queue.running.is_empty() && (ahead == 0 || is_stopped) {
                break;
            }
            let left = ahead + queue.running.len();
            #[expect(clippy::cast_precision_loss, reason = "figures for people")]
            progress.show(0, |pace| {
                let done = todo.len() - left;
                let over = all - left;
                let time = pace.left(done as f64, left as f64);
                let time = if done > 0 { format!(", about {time:.0} s left") } else { String::new() };
                format!("{over} of {all} runs are over, {} run now{time}", queue.running.len() + queue.elsewhere.len())
            });
            std::thread::sleep(PAUSE);
        }
        progress.finish();
        Ok(queue.failures)
    }

    /// Starts runs while there are cores for them.
    fn fill(&self, queue: &mut Queue, program: &Path) {
        if queue.looked.elapsed() > PATIENCE {
            queue.waiting.append(&mut queue.elsewhere);
            queue.looked = Instant::now();
        }
        while queue.running.len() < self.cores.get() {
            let Some((task, forced)) = queue.waiting.pop_front() else { return };
            match self.begin(task, forced, program) {
                Ok(Begun::Running(running)) => queue.running.push(*running),
                Ok(Begun::Elsewhere) => queue.elsewhere.push_back((task, forced)),
                Ok(Begun::Over) => {}
                Err(reason) => queue.failures.push(Failure { task, reason }),
            }
        }
    }

    /// Starts a run, unless another process has done it or does it.
    fn begin(&self, task: Task, forced: Option<Start>, program: &Path) -> Result<Begun, String> {
        let log =
            self.directory.claim(self.sweep, task).map_err(|error| format!("its log cannot be written: {error}"))?;
        let Some(log) = log else { return Ok(Begun::Elsewhere) };
        let state = self.directory.state(self.sweep, task).map_err(|fault| fault.to_string())?;
        let start = match state {
            State::Foreign(key) if !self.force => {
                return Err(format!("its directory is of another scene: `{key}` differs"));
            }
            State::Over(_) if !(self.retry && state.is_failure()) => return Ok(Begun::Over),
            State::Foreign(_) | State::Unfinished(false) | State::Over(_) => Start::Replace,
            State::Unfinished(true) => forced.unwrap_or(Start::Resume),
            State::Missing => Start::New,
        };
        let spawn = || {
            let mut messages = log.file()?;
            messages.set_len(0)?;
            messages.flush()?;
            self.command(task, start, program).stderr(messages).spawn()
        };
        let child = spawn().map_err(|error| format!("its process could not be started: {error}"))?;
        Ok(Begun::Running(Box::new(Running { task, start, child, log })))
    }

    fn command(&self, task: Task, start: Start, program: &Path) -> Command {
        let run = self.directory.run(self.sweep, task);
        let mut command = Command::new(program);
        command.args(["--quiet", "run", "--threads", "1"]);
        if start == Start::Resume {
            command.arg("--resume").arg(run);
        } else {
            command.arg("--out").arg(run);
            for (key, value) in self.sweep.settings(task) {
                command.arg("--set").arg(format!("{key}={value}"));
            }
            if start == Start::Replace {
                command.arg("--force");
            }
            command.arg("--").arg(&self.sweep.scene);
        }
        command.stdin(Stdio::null()).stdout(Stdio::null());
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        command
    }

    /// Takes the processes that have ended out of the queue.
    fn collect(&self, queue: &mut Queue) {
        let mut number = 0;
        while number < queue.running.len() {
            let status = match queue.running[number].child.try_wait() {
                Ok(None) => {
                    number += 1;
                    continue;
                }
                Ok(Some(status)) => Ok(status),
                Err(error) => Err(error),
            };
            let running = queue.running.swap_remove(number);
            let task = running.task;
            match self.end(&running, status) {
                Ended::Over => {}
                Ended::Again => queue.waiting.push_front((task, Some(Start::Replace))),
                Ended::Without(reason) => queue.failures.push(Failure { task, reason }),
            }
            drop(running.log);
        }
    }

    /// Judges a process that has ended by the directory of its run.
    fn end(&self, running: &Running, status: io::Result<ExitStatus>) -> Ended {
        let task = running.task;
        if matches!(self.directory.state(self.sweep, task), Ok(State::Over(_))) {
            return Ended::Over;
        }
        let code = status.as_ref().ok().and_then(ExitStatus::code);
        // The checkpoint is of another version of the program.
        if running.start == Start::Resume && code == Some(2) {
            return Ended::Again;
        }
        let ended = status.map_or_else(|error| error.to_string(), |status| status.to_string());
        let log = self.directory.log_path(self.sweep, task);
        Ended::Without(format!("its process ended with {ended}; its messages are in {}", log.display()))
    }
}

/// The result of an attempt to start a run.
enum Begun {
    Running(Box<Running>),
    Elsewhere,
    Over,
}

/// The end of a process.
enum Ended {
    Over,
    Again,
    Without(String),
}

/// Asks a run to end after its step.
#[cfg(unix)]
fn terminate(child: &Child) {
    use rustix::process::{Pid, Signal, kill_process};
    // A process that has just ended needs no signal.
    let _ = i32::try_from(child.id()).ok().and_then(Pid::from_raw).map(|id| kill_process(id, Signal::TERM));
}

/// Other systems have no such signals, and the sweep receives none.
#[cfg(not(unix))]
fn terminate(_: &Child) {}
