//! Signals that end a run: SIGINT, SIGTERM and SIGHUP, and those of batch systems before they kill a job: SIGXCPU at the limit of
//! processor time, SIGUSR1 and SIGUSR2. While the input is read and checked, the first one ends the process at once, because nothing
//! has been changed yet. Then the first one lets the run finish its step and write its results; one that comes a second or more
//! after it ends the process at once. The exit status is 128 + the number of the signal.
//!
//! SIGXCPU comes again in every further second of processor time, so it never ends the process at once. The system does, at its hard limit.
//!
//! SIGXFSZ says that a file would become longer than its limit (`ulimit -f`). It ends no command: the write fails, and is reported as on a
//! full disk.
//!
//! A signal often comes twice at once: `timeout` and batch systems send it to the process and to its group. Both mean one
//! request.
//!
//! A signal that the process was started to ignore (`nohup`, jobs in the background of a script) stays ignored. Systems
//! other than Unix have no such signals.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
#[cfg(unix)]
use std::time::Duration;

/// Time after the first signal in which further ones count as the same request.
#[cfg(unix)]
const GRACE_PERIOD: Duration = Duration::from_secs(1);

/// The flags that signals set and obey.
#[derive(Clone, Debug, Default)]
pub(super) struct Signals {
    /// The number of the first signal.
    first: Arc<AtomicUsize>,
    /// Whether the next signal ends the process at once.
    ends_at_once: Arc<AtomicBool>,
}

impl Signals {
    /// Catches the signals from now on. Until [`Self::defer`] is called, a signal ends the process at once.
    pub(super) fn catch() -> Self {
        let signals = Self::default();
        signals.ends_at_once.store(true, Ordering::Relaxed);
        if let Err(error) = signals.register() {
            tracing::warn!(
                "could not catch all signals: {error}; a signal may end the run without a summary, and a later one may not end it \
                 at once"
            );
        }
        signals
    }

    /// From now on the first signal only sets the flag. To be called before anything is changed.
    pub(super) fn defer(&self) {
        self.ends_at_once.store(false, Ordering::Relaxed);
    }

    /// Returns the number of the signal, if one has come.
    pub(super) fn received(&self) -> Option<u8> {
        u8::try_from(self.first.load(Ordering::Relaxed)).ok().filter(|&signal| signal != 0)
    }

    /// Returns the flag, which is zero until a signal comes.
    pub(super) fn flag(&self) -> Arc<AtomicUsize> {
        self.first.clone()
    }

    #[cfg(unix)]
    fn register(&self) -> std::io::Result<()> {
        use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGUSR1, SIGUSR2, SIGXCPU};
        use signal_hook::flag;
        use signal_hook::iterator;
        use std::thread;

        let ignored = ignored_signals();
        let mut caught = vec![SIGINT, SIGTERM, SIGHUP, SIGXCPU, SIGUSR1, SIGUSR2];
        caught.retain(|signal| ignored >> (signal - 1) & 1 == 0);
        let ends_at_once = self.ends_at_once.clone();
        for &signal in &caught {
            if signal != SIGXCPU {
                flag::register_conditional_shutdown(signal, 128 + signal, ends_at_once.clone())?;
            }
            flag::register_usize(signal, self.flag(), usize::try_from(signal).unwrap_or(1))?;
        }
        // A handler cannot wait, so a thread does.
        let mut signals = iterator::Signals::new(caught)?;
        thread::Builder::new().name("signals".to_owned()).spawn(move || {
            if signals.forever().next().is_some() {
                thread::sleep(GRACE_PERIOD);
                ends_at_once.store(true, Ordering::Relaxed);
            }
        })?;
        Ok(())
    }

    #[cfg(not(unix))]
    #[expect(clippy::unused_self, clippy::unnecessary_wraps, reason = "the signature of Unix")]
    fn register(&self) -> std::io::Result<()> {
        Ok(())
    }
}

/// Lets a write beyond the limit of file sizes fail, from now on. Without it the process would end there.
pub(super) fn survive_file_limits() {
    #[cfg(unix)]
    {
        use signal_hook::{consts::SIGXFSZ, flag};
        // A handler, whatever it does, lets the write return its error. Programs that are started do not inherit it.
        if let Err(error) = flag::register(SIGXFSZ, Arc::default()) {
            tracing::warn!(
                "could not catch SIGXFSZ: {error}; a limit of file sizes may end the command without a message"
            );
        }
    }
}

/// Returns the signals that this process ignores as a bit set, signal 1 in bit 0. Only Linux reports it; elsewhere the set is
/// empty.
#[cfg(unix)]
fn ignored_signals() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let set = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    set.and_then(|set| u64::from_str_radix(set.trim(), 16).ok()).unwrap_or(0)
}
