//! Pages and tables of a validation.
//!
//! | file | content |
//! |---|---|
//! | `CASE.csv` | the rows of a case |
//! | `CASE.svg`, `CASE-NAME.svg`, and `.png` | its figures |
//! | `CASE.md` | its section |
//! | `README.md` | all cases that have a section in the directory, and the number of their verdicts |

use std::fmt::Write as _;
use std::path::Path;

use crate::studies::validation::cases::CASES;
use crate::studies::validation::verdict::{Judgement, Picture, Verdict};
use crate::studies::validation::{Case, Form, unreadable};
use siloflow_figures::statistics::digits::short;
use siloflow_files::own_files;
use siloflow_files::table::Table;
use siloflow_text::fault::Fault;
use siloflow_text::file;

/// A case with its verdict.
#[derive(Debug)]
pub struct Section<'a> {
    /// The case.
    pub case: &'a Case,
    /// The form that was run.
    pub form: Form,
    /// Number of runs.
    pub runs: usize,
    /// Particle-steps of all runs.
    pub particle_steps: f64,
    /// Time of the runs on their cores, s.
    pub seconds: f64,
    /// The day on which the section is written, as in 2026-11-30.
    pub day: String,
    /// The verdict.
    pub judgement: Judgement,
}

impl Section<'_> {
    /// Returns the name of a figure, without its ending.
    #[must_use]
    pub fn picture_name(&self, picture: &Picture) -> String {
        if picture.name.is_empty() { self.case.name.to_owned() } else { format!("{}-{}", self.case.name, picture.name) }
    }

    /// Returns `CASE.csv`.
    #[must_use]
    pub fn table(&self) -> String {
        let number = |x: Option<f64>| x.filter(|x| x.is_finite()).map_or_else(String::new, |x| x.to_string());
        let mut writer = csv::Writer::from_writer(Vec::new());
        let header =
            ["form", "quantity", "unit", "siloflow", "standard_error", "published", "rule", "verdict", "remark"];
        // Writing to memory cannot fail, and all rows have the same length.
        let _ = writer.write_record(header);
        for row in &self.judgement.rows {
            let _ = writer.write_record([
                self.form.name(),
                &row.quantity,
                row.unit,
                &number(Some(row.found)),
                &number(row.error),
                &number(row.published),
                &row.rule_in_words(),
                row.verdict().word(),
                &row.remark,
            ]);
        }
        String::from_utf8(writer.into_inner().unwrap_or_default()).unwrap_or_default()
    }

    /// Returns `CASE.md`. Writing to a string cannot fail.
    #[must_use]
    pub fn markdown(&self) -> String {
        let Self { case, form, runs, particle_steps, day, judgement, .. } = self;
        let flag = if *form == Form::Full { " --full" } else { "" };
        let mut text = format!(
            "## {}\n\n{}\n\nThe {} form: {runs} runs, {} particle-steps, written by siloflow {} on {day}. `siloflow validate {}{flag}`\n\n",
            case.title,
            case.sources,
            form.name(),
            short(*particle_steps),
            env!("CARGO_PKG_VERSION"),
            case.name
        );
        text += "| quantity | siloflow | published | rule | verdict |\n|---|---|---|---|---|\n";
        for row in &judgement.rows {
            let unit = if row.unit.is_empty() { String::new() } else { format!(", {}", row.unit) };
            let published = row.published.map_or_else(String::new, short);
            let remark = if row.remark.is_empty() { String::new() } else { format!(". {}", row.remark) };
            let verdict = row.verdict();
            let word = if verdict == Verdict::Miss { "**miss**" } else { verdict.word() };
            let _ = writeln!(
                text,
                "| {}{unit} | {} | {published} | {} | {word}{remark} |",
                row.quantity,
                row.found_in_words(),
                row.rule_in_words()
            );
        }
        for picture in &judgement.pictures {
            let _ = write!(text, "\n![{}]({}.svg)\n\n{}\n", case.title, self.picture_name(picture), picture.caption);
        }
        for remark in &judgement.remarks {
            let _ = write!(text, "\n{remark}\n");
        }
        text
    }
}

/// Returns `README.md` of a directory with sections; cases without a section are listed as not run.
///
/// # Errors
/// If a section or table in the directory cannot be read.
pub fn overview(directory: &Path) -> Result<String, Fault> {
    let mut text = "# Validation against published silos\n\nEach case is a set of scenes that the program carries. \
                    `siloflow validate CASE` runs its short form, which takes minutes of a core, and `--full` its full form; it writes the case's section, \
                    table and figures, and this page. A rule comes from the publication or from theory, and a figure that breaks its rule is shown as a miss. \
                    Figures whose source could not be read are reported without a verdict.\n\n\
                    | case | form | pass | miss | reported |\n|---|---|---|---|---|\n"
        .to_owned();
    let mut sections = String::new();
    for case in CASES {
        let table = directory.join(format!("{}.csv", case.name));
        if !own_files::is_file(&table) {
            let _ = writeln!(text, "| {} | not run | | | |", case.title);
            continue;
        }
        let table = Table::read(&table, "run the case again")?;
        let verdicts = table.texts("verdict").unwrap_or_default();
        let count = |verdict: Verdict| verdicts.iter().filter(|word| **word == verdict.word()).count();
        let form = table.texts("form").and_then(|forms| forms.first().copied()).unwrap_or_default();
        let [pass, miss, reported] = [Verdict::Pass, Verdict::Miss, Verdict::Reported].map(count);
        let _ = writeln!(text, "| [{}](#{}) | {form} | {pass} | {miss} | {reported} |", case.title, anchor(case.title));
        let section = directory.join(format!("{}.md", case.name));
        let read = own_files::read_text(&section, file::RESULT_BYTES);
        sections += "\n";
        sections += &read.map_err(|error| unreadable(&section, &error))?;
    }
    Ok(text + &sections)
}

/// Returns the anchor of a heading.
fn anchor(title: &str) -> String {
    let kept =
        title.to_lowercase().chars().filter(|c| c.is_alphanumeric() || [' ', '-', '_'].contains(c)).collect::<String>();
    kept.replace(' ', "-")
}
