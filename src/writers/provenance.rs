//! The origin of a summary: version of siloflow, command line, date, and machine.
//!
//! The processor is `model name` of `/proc/cpuinfo` (Linux on x86), and `null` where there is none. Cores are the threads that the
//! system lets the process run at once.

use std::ffi::OsString;
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use serde::Serialize;

/// Origin of a summary. Of a resumed run it is that of the last part.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Provenance {
    /// Version of siloflow.
    pub version: &'static str,
    /// The command line, quoted for a shell, with the program's name without its directory.
    pub command: String,
    /// Date and time at which the summary was written, UTC, as in ISO 8601.
    pub ended: String,
    /// Name of the processor.
    pub processor: Option<String>,
    /// Number of threads that the system runs at once.
    pub cores: Option<usize>,
}

impl Provenance {
    /// Returns the origin of a summary that is written now by this process.
    #[must_use]
    pub fn now() -> Self {
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        Self {
            version: env!("CARGO_PKG_VERSION"),
            command: command_line(std::env::args_os()),
            ended: date(since.as_secs()),
            processor: std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| parse_processor(&text)),
            cores: std::thread::available_parallelism().ok().map(usize::from),
        }
    }
}

impl Provenance {
    /// Returns the day, as in 2026-11-30.
    #[must_use]
    pub fn day(&self) -> &str {
        self.ended.split('T').next().unwrap_or_default()
    }
}

/// Returns the name of the processor from the text of `/proc/cpuinfo`.
fn parse_processor(text: &str) -> Option<String> {
    let line = text.lines().find_map(|line| line.strip_prefix("model name"))?;
    let name = line.trim_start().strip_prefix(':')?.trim();
    (!name.is_empty()).then(|| name.to_owned())
}

/// Returns a command line that a shell would read as these arguments.
fn command_line(arguments: impl IntoIterator<Item = OsString>) -> String {
    let mut arguments = arguments.into_iter();
    let program = arguments.next().unwrap_or_default();
    let program = Path::new(&program).file_name().unwrap_or_default().to_string_lossy().into_owned();
    let words = std::iter::once(program).chain(arguments.map(|word| word.to_string_lossy().into_owned()));
    words.map(|word| quoted(&word)).collect::<Vec<_>>().join(" ")
}

/// Returns a word as a shell reads it.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_./:=,+@%-".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

/// Returns the date and time of a number of seconds since the start of 1970, UTC. Days are counted in 400-year eras that begin on
/// 1 March (H. Hinnant, chrono-compatible low-level date algorithms).
fn date(seconds: u64) -> String {
    let days = seconds / 86_400 + 719_468;
    let second = seconds % 86_400;
    let era = days / 146_097;
    let day = days % 146_097;
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let month = if month < 10 { month + 3 } else { month - 9 };
    let year = year + 400 * era + u64::from(month <= 2);
    format!("{year:04}-{month:02}-{day:02}T{:02}:{:02}:{:02}Z", second / 3600, second / 60 % 60, second % 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_those_of_the_calendar() {
        // From `date -u -d @N +%FT%TZ`.
        for (seconds, expected) in [
            (0, "1970-01-01T00:00:00Z"),
            (951_782_399, "2000-02-28T23:59:59Z"),
            (951_782_400, "2000-02-29T00:00:00Z"),
            (1_735_689_599, "2024-12-31T23:59:59Z"),
            (4_107_542_400, "2100-03-01T00:00:00Z"),
        ] {
            assert_eq!(date(seconds), expected);
        }
    }

    #[test]
    fn a_shell_reads_the_command_line_as_the_arguments() {
        let words = ["target/debug/siloflow", "run", "a.ron", "--set", "title=\"it's\"", ""].map(OsString::from);
        assert_eq!(command_line(words), r#"siloflow run a.ron --set 'title="it'\''s"' ''"#);
    }

    #[test]
    fn the_processor_has_a_name_where_the_system_gives_one() {
        assert_eq!(parse_processor("processor\t: 0\nmodel name\t: Fast (R) 9\n").as_deref(), Some("Fast (R) 9"));
        assert_eq!(parse_processor("processor: 0\n"), None);
    }
}
