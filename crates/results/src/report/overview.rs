//! The top of a report: what became of each run, in words, and its key figures.

use std::fmt::Write as _;

use crate::report::html::{Section, escape, quantity};
use crate::report::run::Run;
use crate::report::sheet::{Cell, Sheet};

/// How good an end is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The run ended as it should.
    Success,
    /// The run goes on, was killed or was interrupted.
    Incomplete,
    /// The run failed or lost grains.
    Failure,
}

impl Verdict {
    /// The class of an element, and a word for readers.
    #[must_use]
    pub fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::Success => ("success", "Success"),
            Self::Incomplete => ("incomplete", "Incomplete"),
            Self::Failure => ("failure", "No success"),
        }
    }
}

/// Returns how a run ended: a verdict, and a sentence as HTML.
#[must_use]
pub fn fate(run: &Run) -> (Verdict, String) {
    let grains = if run.is_lattice() { "particles" } else { "grains" };
    let status = run.text("/status").unwrap_or_default();
    let failure = || run.text("/failure").map_or_else(|| "no reason is given".to_owned(), escape);
    let stop = |otherwise: &str| run.text("/stop").map_or_else(|| otherwise.to_owned(), escape);
    let (verdict, sentence) = match status {
        "empty" => (Verdict::Success, "The silo is empty.".to_owned()),
        "at_rest" => (Verdict::Success, format!("All {grains} came to rest.")),
        "end_of_flow" | "clogged" | "out_reached" => {
            (Verdict::Success, format!("A stop condition ended the run: {}.", stop(&status.replace('_', " "))))
        }
        "time_reached" => (Verdict::Success, "The run reached its latest time, <code>until</code>.".to_owned()),
        "interrupted" => (
            Verdict::Incomplete,
            "A signal interrupted the run; <code>siloflow run --resume</code> continues it.".to_owned(),
        ),
        "grains_lost" => (Verdict::Failure, "Grains were lost: they left, but not through a door.".to_owned()),
        "failed" => (Verdict::Failure, format!("The run failed: {}.", failure().trim_end_matches('.'))),
        _ if !run.has_summary() => (
            Verdict::Incomplete,
            "There is no summary: the run goes on, or it was killed. This page shows what its files hold so far."
                .to_owned(),
        ),
        other => (Verdict::Incomplete, format!("The run ended with the status {}.", escape(other))),
    };
    (verdict, format!("{sentence} {}", counts(run)))
}

/// Returns the numbers of grains by their fate, in words.
fn counts(run: &Run) -> String {
    let count = |pointer: &str, column: &str, unit: &str| run.last(pointer, column).map(|count| quantity(count, unit));
    let all = if run.is_lattice() {
        [
            count("/particles/entered", "entered", "particles"),
            count("/particles/inside", "inside", ""),
            count("/particles/out", "out", ""),
            None,
        ]
    } else {
        [
            count("/grains/released", "released", "grains"),
            count("/grains/inside", "inside", ""),
            count("/grains/out", "out", ""),
            count("/grains/lost", "lost", ""),
        ]
    };
    let [Some(entered), Some(inside), Some(out), lost] = all else { return String::new() };
    let lost = lost.map_or(String::new(), |lost| format!(", {lost} are lost"));
    format!("Of {entered} that entered, {inside} are inside, {out} left through a door{lost}.")
}

/// The section of key figures.
#[must_use]
pub fn section_of(runs: &[Run], labels: &[String]) -> Option<Section> {
    let mut content = String::new();
    for run in runs {
        let (verdict, sentence) = fate(run);
        let (class, word) = verdict.words();
        let name = if runs.len() > 1 {
            format!("<strong><bdi>{}</bdi></strong> (<bdi>{}</bdi>): ", escape(run.label()), escape(run.title()))
        } else {
            String::new()
        };
        let _ = writeln!(content, "<p class=\"fate {class}\">{name}<strong>{word}.</strong> {sentence}</p>");
    }
    let sheet = key_figures(runs);
    content += &match runs {
        [_] => tiles(&sheet_rows(runs)),
        _ => sheet.html("Key figures of the runs", labels),
    };
    Section::of("overview", "What happened", content)
}

/// A key figure: its name, pointer into the summary, column of `series.csv` without a summary, and unit.
const FIGURES: [(&str, &str, &str, &str); 18] = [
    ("Simulated time", "/time_s", "time_s", "s"),
    ("Steps", "/steps", "step", "steps"),
    ("Grains released", "/grains/released", "released", "grains"),
    ("Grains out", "/grains/out", "out", "grains"),
    ("Mass out", "/grains/out_kg", "out_kg", "kg"),
    ("Grains lost", "/grains/lost", "lost", "grains"),
    ("Particles entered", "/particles/entered", "entered", "particles"),
    ("Particles out", "/particles/out", "out", "particles"),
    ("At rest", "/rest_time_s", "", "s"),
    ("At rest, step", "/rest_step", "", "steps"),
    ("Empty", "/empty_time_s", "", "s"),
    ("Empty, step", "/empty_step", "", "steps"),
    ("Height of the bed at rest", "/bed/fill_height_m", "", "m"),
    ("Packing fraction at rest", "/bed/packing_fraction", "", ""),
    ("Discharge by number", "/discharge/rate_per_s", "", "grains/s"),
    ("Discharge by mass", "/discharge/rate_kg_per_s", "", "kg/s"),
    ("Largest overlap over the radius", "/max_overlap_ratio", "", ""),
    ("Wall-clock time of the steps", "/performance/wall_s", "", "s"),
];

/// Names of key figures, with the cell of each run.
fn sheet_rows(runs: &[Run]) -> Vec<(&'static str, Vec<Cell>)> {
    let is_of = |run: &Run, name: &str, pointer: &str| {
        let is_of_lattice = pointer.starts_with("/particles") || pointer.ends_with("_step");
        // Without a summary a column may have a namesake in the series of the other method.
        run.has_summary()
            || (name != "Simulated time" || !run.is_lattice())
                && (pointer == "/time_s" || pointer == "/steps" || run.is_lattice() == is_of_lattice)
    };
    let cell = |run: &Run, (name, pointer, column, unit): (&str, &str, &str, &'static str)| {
        Cell::of(Some(run).filter(|run| is_of(run, name, pointer)).and_then(|run| run.last(pointer, column)), unit)
    };
    FIGURES.iter().map(|&figure| (figure.0, runs.iter().map(|run| cell(run, figure)).collect())).collect()
}

fn key_figures(runs: &[Run]) -> Sheet {
    let mut sheet = Sheet::default();
    for (name, cells) in sheet_rows(runs) {
        sheet.add(name, cells);
    }
    sheet
}

/// Key figures of a single run, as a list of terms.
fn tiles(rows: &[(&'static str, Vec<Cell>)]) -> String {
    let mut html = "<dl class=\"tiles\">\n".to_owned();
    for (name, cells) in rows {
        if let Some(Cell::Number(value, unit)) = cells.first() {
            let _ = writeln!(html, "<div><dt>{name}</dt><dd>{}</dd></div>", quantity(*value, unit));
        }
    }
    html + "</dl>\n"
}
