//! The end of a run: its state, its summary and its report are written.

use std::path::PathBuf;

use super::runnable::{RunOptions, RunResult, RunnableScene};
use super::words::SummaryWords;
use crate::cli::exit_status::ExitStatus;
use crate::cli::show;
use crate::output::checkpoint;
use crate::output::summary::{Cost, FileRecord};
use crate::simulation::Simulation;
use crate::writers::provenance::Provenance;
use siloflow_dem::outcome::End;
use siloflow_files::hashes;
use siloflow_files::run_directory::RunDirectory;
use siloflow_text::fault::Fault;

/// Ends a run: writes its state and its summary. The state is that of the end of the last step.
pub(in crate::cli) fn finish<S: RunnableScene>(
    scene: &S,
    simulation: &mut Simulation,
    directory: &RunDirectory,
    end: &End,
    cost: Cost,
    options: &RunOptions,
) -> RunResult {
    let world = simulation.own_world();
    let mut summary = scene.summary(world, end, cost, Provenance::now());
    if let Err(error) = directory.write_state(|file| scene.write_state(world, file)) {
        summary.fail(format!("could not write state.csv: {error}"));
    }
    if let Err(failure) = checkpoint::close_writers(world) {
        summary.fail(failure.to_string());
    }
    match directory.write_hashes() {
        Ok(files) => summary.written = FileRecord { damaged: directory.files().damage(), files: Some(files) },
        Err(error) => summary.fail(format!("could not write hashes.txt: {error}")),
    }
    if let Err(error) = directory.write_summary(&summary) {
        summary.fail(format!("could not write summary.json: {error}"));
        // The error may be a passing one. If it is not, the error message is all that remains.
        let _ = directory.write_summary(&summary);
    }
    match &summary.head.failure {
        Some(failure) => tracing::error!("{failure}"),
        // A run that is killed before this checkpoint is complete can be resumed from an earlier one.
        None => checkpoint::at_end(world),
    }
    let status = match (&summary.head.failure, end, options.signals.received()) {
        (None, End::Interrupted, Some(signal)) => ExitStatus::Interrupted(signal),
        _ if summary.is_done() => ExitStatus::Done,
        _ => ExitStatus::Failed,
    };
    let mut words = SummaryWords::default();
    scene.describe(&summary, &mut words);
    words.line("written to", directory.path().display());
    let exit_status = match options.report.then(|| write_report(directory)) {
        None => status,
        Some(Ok(path)) => {
            words.line("report", path.display());
            status
        }
        Some(Err(fault)) => {
            show(fault);
            if status == ExitStatus::Done { ExitStatus::Failed } else { status }
        }
    };
    let json = hashes::sealed(serde_json::to_string_pretty(&summary).unwrap_or_default() + "\n");
    RunResult { words: words.text(), json, exit_status }
}

/// Writes the report of a run that is over, and returns its path.
#[cfg(feature = "report")]
fn write_report(directory: &RunDirectory) -> Result<PathBuf, Fault> {
    use siloflow_files::whole_file;
    let path = siloflow_files::run_directory::report_of(directory.path());
    let page = siloflow_results::report::page(&[directory.path()], &crate::scene::facts::read)?;
    let written =
        directory.guard()().and_then(|()| whole_file::write_synced(&path, |file| file.write_all(page.as_bytes())));
    written.map(|()| path.clone()).map_err(|error| {
        Fault::new("report::write", format!("could not write {}: {error}", path.display()))
            .help("the run itself is complete; `siloflow report` writes the report later")
    })
}

/// A program without the feature `report` writes none.
#[cfg(not(feature = "report"))]
fn write_report(_: &RunDirectory) -> Result<PathBuf, Fault> {
    Err(Fault::new("report::absent", "this program was built without reports")
        .help("build it with the feature `report`"))
}
