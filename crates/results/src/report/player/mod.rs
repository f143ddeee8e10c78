//! The player of a report: grains, contacts and walls over time, drawn in the browser.
//!
//! [`Packed`] makes a compact copy of `frames.bin`, in which positions and other numbers are rounded, and the script draws it.
//!
//! | part | content |
//! |---|---|
//! | `packing.rs` | the two readings of `frames.bin`, and the format of the data |
//! | `facts.rs`, `plan.rs`, `thinning.rs` | what the frames contain, and how and which of them are packed |
//! | `grid.rs`, `scale.rs` | rounding of places and of other numbers |
//! | `frame_packer.rs`, `links.rs`, `wall_shapes.rs`, `bytes.rs` | a frame as bytes |
//! | `live.rs` | single frames of a run that goes on |
//! | `pictures.rs` | pictures of the lattice gas in place of frames |
//! | `script/` | the script: decoding, drawing with WebGL, controls |

mod bytes;
mod description;
mod facts;
mod frame_packer;
mod grains;
mod grid;
mod links;
pub mod live;
mod packing;
mod pictures;
mod plan;
mod scale;
#[cfg(test)]
#[expect(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    clippy::cast_sign_loss,
    reason = "small numbers"
)]
mod tests;
mod thinning;
#[cfg(test)]
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "levels are bytes")]
mod unpack;
mod wall_shapes;

use std::io;
use std::path::Path;

use siloflow_files::frames::reader::OF_UNKNOWN_SCENE;
use siloflow_files::own_files;
use siloflow_files::run_directory::frame_data_of;

/// Most characters of the data of a run, unless the caller gives another number.
pub const BUDGET: usize = 12_000_000;

/// The script of the player. It defines `siloflowPlayer(container, dataId)`, which returns a promise of
/// `{times, setTime(seconds), onTime(callback), play(), pause()}` (`script/player.js`).
///
/// The function shows a message in the container if the data are damaged or the browser cannot draw them.
pub const SCRIPT: &str = concat!(
    "var siloflowPlayer = (() => {\n\"use strict\";\n",
    include_str!("script/decode.js"),
    include_str!("script/colours.js"),
    include_str!("script/camera.js"),
    include_str!("script/shaders.js"),
    include_str!("script/walls.js"),
    include_str!("script/occlusion.js"),
    include_str!("script/renderer.js"),
    include_str!("script/flat_renderer.js"),
    include_str!("script/view.js"),
    include_str!("script/pictures.js"),
    include_str!("script/form.js"),
    include_str!("script/moments.js"),
    include_str!("script/pick.js"),
    include_str!("script/pointer.js"),
    include_str!("script/player.js"),
    "return siloflowPlayer;\n})();\n",
);

/// The style sheet of the player. It uses the variables `--paper`, `--ink`, `--muted`, `--line` and `--accent` of the page.
pub const STYLE: &str = include_str!("player.css");

/// The frames of a run, packed for a page.
#[derive(Clone, Debug)]
pub struct Packed {
    /// Compressed data in base64.
    text: String,
}

impl Packed {
    /// Packs the frames of the run in directory `run` into at most [`BUDGET`] characters; `None` if the run has nothing to play:
    /// no `frames.bin`, and no pictures of the lattice gas.
    ///
    /// # Errors
    /// If `frames.bin` or a picture cannot be read.
    pub fn of(run: &Path) -> io::Result<Option<Self>> {
        Self::within(run, BUDGET)
    }

    /// Packs the frames of the run in directory `run` into about `characters`. A run that needs more is shown with fewer frames,
    /// evenly spaced by number, but at least two. `None` as for [`Packed::of`].
    ///
    /// # Errors
    /// As [`Packed::of`].
    pub fn within(run: &Path, characters: usize) -> io::Result<Option<Self>> {
        Self::of_frames_within(run, characters, OF_UNKNOWN_SCENE)
    }

    /// As [`Packed::within`], for a run whose frames take at most `most` bytes each.
    ///
    /// # Errors
    /// As [`Packed::of`].
    pub fn of_frames_within(run: &Path, characters: usize, most: u64) -> io::Result<Option<Self>> {
        let path = frame_data_of(run);
        let text = if own_files::is_file(&path) {
            packing::pack((&path, most), characters).map(Some)
        } else {
            pictures::pack(run, characters)
        };
        Ok(text?.map(|text| Self { text }))
    }

    /// Returns the data as an HTML element, a script that a browser does not run. `id` must need no escapes.
    #[must_use]
    pub fn element(&self, id: &str) -> String {
        format!("<script type=\"application/octet-stream\" id=\"{id}\">{}</script>", self.text)
    }
}
