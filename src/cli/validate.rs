//! `siloflow validate`: runs validation cases and writes their verdicts.

use std::fmt::Write as _;
use std::fs;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use clap::Args;

use crate::behaviour::Registry;
use crate::cli::exit_status::ExitStatus;
use crate::cli::signals::Signals;
use crate::cli::sweep::{Effort, available_cores, complete};
use crate::cli::{picture_files, refused, say, show, unwritable};
use crate::studies::sweep::Sweep;
use crate::studies::validation::cases::{self, CASES};
use crate::studies::validation::page::{self, Section};
use crate::studies::validation::runs::{Studies, sweep_directory};
use crate::studies::validation::verdict::Verdict;
use crate::studies::validation::{Case, Form};
use crate::writers::provenance::Provenance;
use siloflow_figures::statistics::digits::short;
use siloflow_files::marked::foreign_entry;
use siloflow_files::own_files;
use siloflow_files::run_directory::write_results;
use siloflow_files::whole_file;
use siloflow_text::fault::Fault;
use siloflow_text::file;

/// File that marks a directory of validations.
const MARKER: &str = ".siloflow-validate";

/// Arguments of `validate`.
#[derive(Args, Debug)]
#[command(after_help = "\
  siloflow validate --list           # the cases, and what they are held against
  siloflow validate anand-hopper     # its short form: minutes
  siloflow validate --full           # all cases in full: hours; an interrupted validation continues

The directory gets a section (CASE.md), a table (CASE.csv) and figures for each case, and README.md with all of them. Scenes, sweep files and runs
are in CASE/. A rule comes from the publication or from theory. A figure that breaks it is a miss, and the exit status is 1 unless the page gives the reason.")]
pub(super) struct ValidateArgs {
    /// Names of the cases. Default: all.
    #[arg(value_name = "CASE")]
    cases: Vec<String>,
    /// Run the full form: the published size, or as close as about an hour of one core comes.
    #[arg(long)]
    full: bool,
    /// The directory of the results and runs.
    #[arg(long, value_name = "DIR", default_value = "out/validate")]
    out: PathBuf,
    /// Number of runs at a time, each on one core. Default: the number of cores.
    #[arg(long, value_name = "N")]
    cores: Option<NonZeroUsize>,
    /// List the cases. Nothing is run or written.
    #[arg(long)]
    list: bool,
    /// Replace runs of another version of a scene.
    #[arg(long, conflicts_with = "list")]
    force: bool,
}

pub(super) fn validate(args: &ValidateArgs, registry: &Registry, quiet: bool) -> Result<ExitStatus, Fault> {
    let mut cases = args.cases.iter().map(|name| cases::named(name)).collect::<Result<Vec<_>, _>>()?;
    if cases.is_empty() {
        cases = CASES.to_vec();
    }
    if args.list {
        return Ok(list(&cases));
    }
    refuse_content(&args.out)?;
    let form = if args.full { Form::Full } else { Form::Short };
    let signals = Signals::catch();
    let mut status = ExitStatus::Done;
    for (number, case) in cases.into_iter().enumerate() {
        let directory = args.out.join(case.name);
        if let Err(error) = write_inputs(&args.out, &directory, case) {
            return refused(unwritable(&directory, &error), number > 0);
        }
        // From here on the call has changed something, so a fault is a failure.
        let studies = run(case, &directory, form, args, &signals, registry, quiet).unwrap_or_else(|fault| {
            show(fault);
            None
        });
        let Some(studies) = studies else {
            if let Some(signal) = signals.received() {
                tracing::error!("interrupted: the same command continues the validation in {}", args.out.display());
                return Ok(ExitStatus::Interrupted(signal));
            }
            status = ExitStatus::Failed;
            continue;
        };
        let judgement = match (case.judge)(&studies) {
            Ok(judgement) => judgement,
            Err(fault) => {
                show(fault);
                status = ExitStatus::Failed;
                continue;
            }
        };
        let runs = studies.all().count();
        let particle_steps = studies.particle_steps();
        let seconds = studies.seconds();
        let day = Provenance::now().day().to_owned();
        let section = Section { case, form, runs, particle_steps, seconds, day, judgement };
        if !quiet {
            say(&in_words(&section));
        }
        if section.judgement.has_new_miss() && status == ExitStatus::Done {
            status = ExitStatus::Different;
        }
        if let Err(fault) = write(&args.out, &section) {
            show(fault);
            return Ok(ExitStatus::Failed);
        }
    }
    if !quiet && status != ExitStatus::Failed {
        say(&format!("written to   {}\n", args.out.display()));
    }
    Ok(status)
}

fn list(cases: &[&Case]) -> ExitStatus {
    for case in cases {
        say(&format!("{:<18} {}\n{:<18} {}\n", case.name, case.title, "", case.sources));
    }
    ExitStatus::Done
}

/// Refuses a directory with content that is no validation.
fn refuse_content(directory: &Path) -> Result<(), Fault> {
    let why = match foreign_entry(directory, &[MARKER]) {
        Ok(None) => return Ok(()),
        Ok(Some(name)) => format!("it holds {}", name.display()),
        Err(error) => error.to_string(),
    };
    Err(Fault::new("validate::directory", format!("{} cannot hold a validation: {why}", directory.display()))
        .help("give another directory with --out"))
}

/// Does the runs of a case. `None` if runs have no result, or after a signal.
fn run(
    case: &Case,
    directory: &Path,
    form: Form,
    args: &ValidateArgs,
    signals: &Signals,
    registry: &Registry,
    quiet: bool,
) -> Result<Option<Studies>, Fault> {
    let effort = Effort { cores: args.cores.unwrap_or_else(available_cores), force: args.force, retry: false };
    let mut studies = Studies::default();
    let mut is_whole = true;
    for name in case.sweeps(form) {
        if !quiet {
            tracing::info!("{}: {name}", case.name);
        }
        let sweep = Sweep::read(&directory.join(name))?;
        let path = sweep_directory(directory, name);
        let (done, failures) = complete(&sweep, &path, &sweep.tasks(), effort, signals, registry, quiet)?;
        if signals.received().is_some() {
            return Ok(None);
        }
        for failure in &failures {
            tracing::error!(
                "{}, {name}: run {} has no result: {}",
                case.name,
                sweep.in_words(failure.task),
                failure.reason
            );
        }
        is_whole &= failures.is_empty();
        if !is_whole {
            continue;
        }
        // A mean over the other runs would hide a run that failed.
        for task in studies.add(name, &sweep, &done)? {
            tracing::error!("{}, {name}: run {} failed; its summary.json tells why", case.name, sweep.in_words(task));
            is_whole = false;
        }
    }
    Ok(is_whole.then_some(studies))
}

/// Writes the scenes and sweep files of a case, if they are not there.
fn write_inputs(out: &Path, directory: &Path, case: &Case) -> std::io::Result<()> {
    fs::create_dir_all(out)?;
    own_files::append(&out.join(MARKER))?;
    fs::create_dir_all(directory)?;
    for (name, content) in case.files {
        let path = directory.join(name);
        if own_files::read_text(&path, file::RESULT_BYTES).ok().as_deref() != Some(content) {
            whole_file::write(&path, content.as_bytes())?;
        }
    }
    Ok(())
}

/// Writes the section, the table and the figures of a case, and the page of all cases.
fn write(out: &Path, section: &Section) -> Result<(), Fault> {
    let name = section.case.name;
    let mut files = vec![(format!("{name}.csv"), section.table().into_bytes())];
    files.push((format!("{name}.md"), section.markdown().into_bytes()));
    for picture in &section.judgement.pictures {
        files.extend(picture_files(&section.picture_name(picture), picture.svg.clone())?);
    }
    let unwritable = |error: std::io::Error| {
        Fault::new("results::write", format!("could not write to {}: {error}", out.display()))
            .help("the runs are kept: the same command writes the results when there is space")
    };
    write_results(out, &files).map_err(unwritable)?;
    write_results(out, &[("README.md".to_owned(), page::overview(out)?.into_bytes())]).map_err(unwritable)
}

/// Returns the verdicts in words.
fn in_words(section: &Section) -> String {
    let mut text = format!("{}\n", section.case.title);
    for row in &section.judgement.rows {
        let published = row.published.map_or_else(String::new, |value| format!(", published {value}"));
        let rule = row.rule_in_words();
        let rule = if rule.is_empty() { rule } else { format!(" ({rule})") };
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "  {:<9}{}: {} {}{published}{rule}",
            row.verdict().word(),
            row.quantity,
            row.found_in_words(),
            row.unit
        );
    }
    let [pass, miss] = [Verdict::Pass, Verdict::Miss].map(|verdict| section.judgement.count(verdict));
    text + &format!(
        "  {pass} pass, {miss} miss; {} runs, {} particle-steps, {:.1} s on one core\n",
        section.runs,
        short(section.particle_steps),
        section.seconds
    )
}
