//! The report of one run or of several: one HTML file that opens without a network.
//!
//! * [`run`]: a run as far as its files go.
//! * [`document`]: the page. Each section has a file of its own: [`overview`], [`accounting`], [`discharge`], ...
//! * [`estimate`]: the page of an estimate.
//! * [`player`]: the frames of a run, played in the browser.
//! * [`html`]: escapes, and numbers with units. [`sheet`]: tables of quantities by run.
//!
//! Curves come from [`plot`](mod@crate::plot). A run that goes on or was killed is reported as far as its files go.

pub mod accounting;
pub mod behaviours;
pub mod differences;
pub mod discharge;
pub mod document;
pub mod energy;
pub mod estimate;
pub mod html;
pub mod overview;
pub mod player;
pub mod profiles;
pub mod provenance;
pub mod run;
pub mod sheet;
pub mod step;
pub mod table;
pub mod walls;

use std::path::Path;

use crate::plot::{self, Figure};
use crate::report::document::Contents;
use crate::report::player::Packed;
use crate::report::run::Run;
use crate::run_results::RunResults;
use crate::scene_facts::ReadFacts;
use siloflow_files::frames::reader::OF_UNKNOWN_SCENE;
use siloflow_text::fault::Fault;

/// Most runs of one report.
pub const MOST_RUNS: usize = 12;

/// Least number of characters of the data of a player, if there are many.
const LEAST_BUDGET: usize = 2_000_000;

/// Returns the page of these run directories. `read` reads the facts of their scenes.
///
/// # Errors
/// If one of them is no run directory, or its summary or series cannot be read.
pub fn page(directories: &[&Path], read: ReadFacts) -> Result<String, Fault> {
    let mut runs = directories.iter().map(|path| Run::open(path, read)).collect::<Result<Vec<_>, _>>()?;
    Run::distinguish(&mut runs);
    let files: Vec<_> = runs.iter().map(|run| &run.files).collect();
    let figures = figures(&files);
    // Pages with several players stay within the size of a page with one.
    let budget = (player::BUDGET / runs.len()).max(LEAST_BUDGET);
    let frames = runs.iter().map(|run| frames(run, budget)).collect();
    Ok(Contents { runs: &runs, frames, figures }.html())
}

/// All figures, of whichever the files can be read.
fn figures(files: &[&RunResults]) -> Vec<Figure> {
    plot::figures(files)
        .unwrap_or_else(|_| plot::names().filter_map(|name| plot::named(files, name).ok().flatten()).collect())
}

/// The frames of a run, or why there are none, as HTML.
fn frames(run: &Run, budget: usize) -> Result<Packed, String> {
    let most = run.scene.as_ref().map_or(OF_UNKNOWN_SCENE, |scene| scene.most_bytes);
    match Packed::of_frames_within(&run.files.directory, budget, most) {
        Ok(Some(frames)) => Ok(frames),
        Ok(None) if run.is_lattice() => Err(
            "The lattice gas keeps no frames to play, and this run has no pictures: set the key <code>pictures</code>."
                .to_owned(),
        ),
        Ok(None) => Err(
            "The run kept no frames to play: there is no <code>frames.bin</code>. Run the scene again with the key \
                         <code>data_frames: (interval: 0.1)</code> (s), or \
                         <code>--set \"data_frames=(interval: 0.1)\"</code>."
                .to_owned(),
        ),
        Err(error) => Err(format!("The frames cannot be played: {}.", html::escape(&error.to_string()))),
    }
}
