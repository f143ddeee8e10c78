//! Progress of a run on stderr: one line that is updated on a terminal, plain lines every few seconds elsewhere.

use std::io::IsTerminal as _;
use std::time::{Duration, Instant};

use crate::cli::say_aside;
use crate::cli::status_line::StatusLine;

/// Steps between two readings of the wall clock.
const CHUNK: u32 = 64;

pub(super) struct Progress {
    bar: Option<StatusLine>,
    plain: bool,
    stride: u32,
    before_s: f64,
    start: Instant,
    next: Instant,
    last: (Instant, u64),
}

/// The speed of a run.
#[derive(Clone, Copy)]
pub(super) struct Pace {
    /// Millions of updates a second since the last line.
    pub millions_per_s: f64,
    /// Wall clock since the start of the run, s.
    pub elapsed: f64,
}

impl Pace {
    /// Estimated remaining wall-clock time, s, when `done` of the way is done and `ahead` of it remains.
    pub(super) fn left(self, done: f64, ahead: f64) -> f64 {
        self.elapsed * ahead / done.max(1e-9)
    }
}

impl Progress {
    /// Starts to show the progress of a run that has taken `before_s` seconds and made `updates` updates.
    pub(super) fn new(quiet: bool, before_s: f64, updates: u64) -> Self {
        let on_terminal = std::io::stderr().is_terminal();
        let bar = (on_terminal && !quiet).then(StatusLine::new);
        let now = Instant::now();
        let patience = if on_terminal { Duration::from_millis(300) } else { Duration::from_secs(1) };
        Self {
            bar,
            plain: !on_terminal && !quiet,
            stride: 0,
            before_s,
            start: now,
            next: now + patience,
            last: (now, updates),
        }
    }

    /// Shows the line that `describe` makes, if enough time has passed. `updates` is the number of updates so far.
    pub(super) fn look(&mut self, updates: u64, describe: impl FnOnce(Pace) -> String) {
        self.stride += 1;
        if self.stride < CHUNK {
            return;
        }
        self.stride = 0;
        self.show(updates, describe);
    }

    /// As [`Progress::look`], and reads the wall clock at each call.
    pub(super) fn show(&mut self, updates: u64, describe: impl FnOnce(Pace) -> String) {
        let now = Instant::now();
        if now < self.next {
            return;
        }
        let pace = self.pace(updates, now);
        if let Some(bar) = &self.bar {
            bar.show(describe(pace));
            self.next = now + Duration::from_millis(200);
        } else if self.plain {
            say_aside(&describe(pace));
            self.next = now + Duration::from_secs(5);
        } else {
            self.next = now + Duration::from_hours(1);
        }
        self.last = (now, updates);
    }

    #[expect(clippy::cast_precision_loss, reason = "figures for people")]
    fn pace(&self, updates: u64, now: Instant) -> Pace {
        let seconds = now.duration_since(self.last.0).as_secs_f64().max(1e-9);
        Pace {
            millions_per_s: (updates - self.last.1) as f64 / seconds / 1e6,
            elapsed: self.before_s + now.duration_since(self.start).as_secs_f64(),
        }
    }

    pub(super) fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.clear();
        }
    }
}
