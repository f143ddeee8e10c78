//! Summaries in words.

use std::fmt::{Display, Write as _};

/// A summary in words: lines of a name and a value.
#[derive(Default)]
pub(in crate::cli) struct SummaryWords(String);

impl SummaryWords {
    pub(in crate::cli) fn line(&mut self, name: &str, value: impl Display) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.0, "{name:<12} {value}");
    }

    /// Adds a line for each event that happened, with its moment in words.
    pub(in crate::cli) fn moments<T: Copy>(&mut self, moments: [(&str, Option<T>); 3], in_words: impl Fn(T) -> String) {
        for (name, moment) in moments {
            if let Some(moment) = moment {
                self.line(name, in_words(moment));
            }
        }
    }

    /// Returns the lines.
    pub(super) fn text(self) -> String {
        self.0
    }
}
