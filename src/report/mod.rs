//! The report of one run or of several: one HTML file that opens without a network.
//!
//! * [`run`]: a run as far as its files go.
//! * [`document`]: the page. Each section has a file of its own: [`overview`], [`accounting`], [`discharge`], ...
//! * [`player`]: the frames of a run, played in the browser.
//! * [`html`]: escapes, and numbers with units. [`sheet`]: tables of quantities by run.
//!
//! Curves come from [`charts`]. A run that goes on or was killed is reported as far as its files go.

pub mod accounting;
pub mod behaviours;
pub mod differences;
pub mod discharge;
pub mod document;
pub mod energy;
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

use crate::charts;
use crate::charts::run_files::RunFiles;
use crate::fault::Fault;
use crate::report::document::Contents;
use crate::report::player::Packed;
use crate::report::run::Run;

/// Most runs of one report.
pub const MOST_RUNS: usize = 12;

/// Returns the page of these run directories.
///
/// # Errors
/// If one of them is no run directory, or a file of it cannot be read.
pub fn page(directories: &[&Path]) -> Result<String, Fault> {
    let mut runs = directories.iter().map(|path| Run::open(path)).collect::<Result<Vec<_>, _>>()?;
    Run::distinguish(&mut runs);
    let files = runs
        .iter()
        .map(|run| RunFiles::open(&run.path).map(|files| RunFiles { name: run.label.clone(), ..files }))
        .collect::<Result<Vec<_>, _>>()?;
    let figures = charts::figures(&files)?;
    let frames = runs.iter().map(frames).collect();
    Ok(Contents { runs: &runs, frames, figures }.html())
}

/// The frames of a run, or why there are none, as HTML.
fn frames(run: &Run) -> Result<Packed, String> {
    match Packed::of(&run.path) {
        Ok(Some(frames)) => Ok(frames),
        Ok(None) if run.is_lattice() => Err(
            "The lattice gas keeps no frames to play. Its pictures are in <code>frames/</code> of the run directory."
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
