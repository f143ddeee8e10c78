//! The player of a report: grains, contacts and walls over time, drawn in the browser.

use std::io;
use std::path::Path;

use crate::output::run_directory::frame_data_of;

/// The script of the player. It defines `siloflowPlayer(container, dataId)`, which returns a promise of
/// `{times, setTime(seconds), onTime(callback)}`.
pub const SCRIPT: &str = include_str!("player.js");

/// The style sheet of the player. It uses the variables `--paper`, `--ink`, `--muted`, `--line` and `--accent` of the page.
pub const STYLE: &str = include_str!("player.css");

/// The frames of a run, packed for a page.
#[derive(Clone, Debug)]
pub struct Packed {
    /// Compressed data in base64.
    text: String,
}

impl Packed {
    /// Packs the frames of the run in directory `run`; `None` if the run has no `frames.bin`.
    ///
    /// # Errors
    /// If `frames.bin` cannot be read.
    pub fn of(run: &Path) -> io::Result<Option<Self>> {
        let path = frame_data_of(run);
        Ok(path.is_file().then(|| Self { text: String::new() }))
    }

    /// Returns the data as an HTML element, a script that a browser does not run. `id` must need no escapes.
    #[must_use]
    pub fn element(&self, id: &str) -> String {
        format!("<script type=\"application/octet-stream\" id=\"{id}\">{}</script>", self.text)
    }
}
