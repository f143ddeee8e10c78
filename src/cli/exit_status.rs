//! Exit statuses of all commands.

/// Every exit status with its meaning, as `--help` and the documentation state them. The numbers of signals are those of Linux.
pub const EXIT_STATUSES: [(&str, &str); 9] = [
    ("0", "done"),
    (
        "1",
        "the simulation failed (unstable, grains lost, release blocked), a file could not be written after the start, \
         `diff` found a difference, `verify` damage, or `validate` a figure that misses its rule",
    ),
    ("2", "the input or the call was wrong, and nothing was changed"),
    ("129", "interrupted by SIGHUP"),
    ("130", "interrupted by SIGINT (Ctrl-C)"),
    ("138", "interrupted by SIGUSR1"),
    ("140", "interrupted by SIGUSR2"),
    ("143", "interrupted by SIGTERM"),
    ("152", "interrupted by SIGXCPU, at the limit of processor time"),
];

/// The exit status of a command whose input and call were right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ExitStatus {
    Done,
    /// The simulation failed, or a file could not be written after the start.
    Failed,
    /// `diff` found a difference, `verify` damage, or `validate` a figure that misses its rule.
    Different,
    /// A signal of this number came.
    Interrupted(u8),
}

/// The number for a wrong input or call.
pub(super) const REFUSED: u8 = 2;

impl ExitStatus {
    /// Returns the number that the process returns.
    pub(super) fn number(self) -> u8 {
        match self {
            Self::Done => 0,
            Self::Failed | Self::Different => 1,
            Self::Interrupted(signal) => 128u8.saturating_add(signal),
        }
    }
}

/// Returns the table for `--help`.
pub(super) fn help() -> String {
    let rows = EXIT_STATUSES.map(|(status, meaning)| format!("{status} {meaning}"));
    format!("Exit status: {}.", rows.join("; "))
}
