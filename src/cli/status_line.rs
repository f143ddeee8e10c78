//! A line on a terminal that is written anew each time. WebAssembly has no terminals: there it is never seen.

#[cfg(not(target_family = "wasm"))]
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// The line.
#[cfg(not(target_family = "wasm"))]
pub(super) struct StatusLine(ProgressBar);

#[cfg(not(target_family = "wasm"))]
impl StatusLine {
    /// Begins a line on stderr.
    pub(super) fn new() -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(5));
        if let Ok(style) = ProgressStyle::with_template("{spinner} {wide_msg}") {
            bar.set_style(style);
        }
        Self(bar)
    }

    /// Shows other words.
    pub(super) fn show(&self, words: String) {
        self.0.set_message(words);
        self.0.tick();
    }

    /// Removes the line.
    pub(super) fn clear(&self) {
        self.0.finish_and_clear();
    }
}

#[cfg(target_family = "wasm")]
pub(super) struct StatusLine;

#[cfg(target_family = "wasm")]
#[expect(clippy::unused_self, clippy::needless_pass_by_value, reason = "the signatures of other systems")]
impl StatusLine {
    pub(super) fn new() -> Self {
        Self
    }

    pub(super) fn show(&self, _: String) {}

    pub(super) fn clear(&self) {}
}
