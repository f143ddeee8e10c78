//! Signals that end a run: SIGINT, SIGTERM and SIGHUP. The first one lets the run finish its step and write its results;
//! the second one ends the process at once. The exit status is 128 + the number of the signal.
//!
//! A signal that the process was started to ignore (`nohup`, jobs in the background of a script) stays ignored. Systems
//! other than Unix have no such signals.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The flag that the first signal sets to its number.
#[derive(Clone, Debug, Default)]
pub(super) struct Signals(Arc<AtomicUsize>);

impl Signals {
    /// Catches the signals from now on.
    pub(super) fn catch() -> Self {
        let signals = Self::default();
        if let Err(error) = signals.register() {
            tracing::warn!("could not catch signals: {error}; a signal will stop the run without a summary");
        }
        signals
    }

    /// Returns the number of the signal, if one has come.
    pub(super) fn received(&self) -> Option<u8> {
        u8::try_from(self.0.load(Ordering::Relaxed)).ok().filter(|&signal| signal != 0)
    }

    /// Returns the flag, which is zero until a signal comes.
    pub(super) fn flag(&self) -> Arc<AtomicUsize> {
        self.0.clone()
    }

    #[cfg(unix)]
    fn register(&self) -> std::io::Result<()> {
        use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
        use signal_hook::flag;
        use std::sync::atomic::AtomicBool;

        let ignored = ignored_signals();
        let is_second = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|signal| ignored >> (signal - 1) & 1 == 0) {
            // Actions run in the order of registration, so the first signal finds `is_second` still unset.
            flag::register_conditional_shutdown(signal, 128 + signal, is_second.clone())?;
            flag::register(signal, is_second.clone())?;
            flag::register_usize(signal, self.flag(), usize::try_from(signal).unwrap_or(1))?;
        }
        Ok(())
    }

    #[cfg(not(unix))]
    #[expect(clippy::unused_self, clippy::unnecessary_wraps, reason = "the signature of Unix")]
    fn register(&self) -> std::io::Result<()> {
        Ok(())
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
