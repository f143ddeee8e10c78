//! `siloflow verify`: checks the files of runs against the hashes that the runs have recorded.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use crate::cli::exit_status::ExitStatus;
use crate::cli::say;
use crate::output::verification::{self, Verification};
use siloflow_text::fault::Fault;

/// Arguments of `verify`.
#[derive(Args, Debug)]
#[command(after_help = "\
Every file that a run has written is held against its hash: input, rows, frames, pictures, checkpoints, state, summary. A file that \
is missing, cut, or has other bytes is named. Files that were added later are not examined. Nothing is changed.

  siloflow run scenes/silo1.ron --until 1
  siloflow verify out/silo1

Exit status: 0 all sound; 1 damage found; 2 a path is no run.")]
pub(super) struct VerifyArgs {
    /// The run directories.
    #[arg(required = true, value_name = "RUN")]
    runs: Vec<PathBuf>,
    /// Print the findings as JSON instead of in words.
    #[arg(long)]
    json: bool,
}

/// A run and what was found.
#[derive(Serialize)]
struct Verified {
    run: String,
    is_sound: bool,
    #[serde(flatten)]
    found: Verification,
}

pub(super) fn verify(args: &VerifyArgs, quiet: bool) -> Result<ExitStatus, Fault> {
    // A wrong path is found before the work begins.
    args.runs.iter().try_for_each(|run| verification::check(run))?;
    let mut all = Vec::new();
    for run in &args.runs {
        let found = verification::verify(run)?;
        let verified = Verified { run: run.display().to_string(), is_sound: found.damage.is_empty(), found };
        let is_silent = args.json || quiet && verified.is_sound;
        if !is_silent {
            say(&words(&verified));
        }
        all.push(verified);
    }
    if args.json {
        say(&(serde_json::to_string_pretty(&all).unwrap_or_default() + "\n"));
    }
    Ok(if all.iter().all(|verified| verified.is_sound) { ExitStatus::Done } else { ExitStatus::Different })
}

fn words(Verified { run, is_sound, found }: &Verified) -> String {
    let verdict = if *is_sound { "sound" } else { "damaged" };
    let mut text =
        format!("{run}: {verdict} ({}; {} files, {} bytes checked)\n", found.status, found.files, found.bytes);
    // Writing to a string cannot fail.
    for finding in &found.damage {
        let _ = writeln!(text, "  damaged: {} {}", finding.file, finding.what);
    }
    for note in &found.notes {
        let _ = writeln!(text, "  note: {note}");
    }
    text
}
