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

/// The section that says what became of each run.
#[must_use]
pub fn section_of(runs: &[Run]) -> Option<Section> {
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
    Section::of("overview", "What happened", content)
}

/// The section of key figures.
#[must_use]
pub fn figures_of(runs: &[Run], labels: &[String]) -> Option<Section> {
    let content = match runs {
        [_] => tiles(&sheet_rows(runs)),
        _ => key_figures(runs).html("Key figures of the runs", labels),
    };
    Section::of("figures", "Key figures", content)
}

/// Largest overlap over the radius that the contact laws are meant for. They take overlaps to be small; a tenth is beyond that.
const DEEP: f64 = 0.1;

/// A key figure.
struct KeyFigure {
    name: &'static str,
    /// Pointer into the summary.
    pointer: &'static str,
    /// Column of `series.csv` that has it in a run without a summary; empty if there is none.
    column: &'static str,
    unit: &'static str,
    /// Number above which something is wrong, and what; `None` if any number is right.
    trouble: Option<(f64, &'static str)>,
}

impl KeyFigure {
    /// Returns what is wrong with a number, in words.
    fn trouble(&self, number: f64) -> Option<&'static str> {
        self.trouble.filter(|(most, _)| number > *most).map(|(_, words)| words)
    }

    const fn wrong_above(self, most: f64, words: &'static str) -> Self {
        Self { trouble: Some((most, words)), ..self }
    }
}

const fn figure(name: &'static str, pointer: &'static str, column: &'static str, unit: &'static str) -> KeyFigure {
    KeyFigure { name, pointer, column, unit, trouble: None }
}

const FIGURES: &[KeyFigure] = &[
    figure("Simulated time", "/time_s", "time_s", "s"),
    figure("Steps", "/steps", "step", "steps"),
    figure("Grains released", "/grains/released", "released", "grains"),
    figure("Grains out", "/grains/out", "out", "grains"),
    figure("Mass out", "/grains/out_kg", "out_kg", "kg"),
    figure("Grains lost", "/grains/lost", "lost", "grains").wrong_above(0.0, "they left, but not through a door"),
    figure("Particles entered", "/particles/entered", "entered", "particles"),
    figure("Particles out", "/particles/out", "out", "particles"),
    figure("At rest", "/rest_time_s", "", "s"),
    figure("At rest, step", "/rest_step", "", "steps"),
    figure("Empty", "/empty_time_s", "", "s"),
    figure("Empty, step", "/empty_step", "", "steps"),
    figure("Height of the bed at rest", "/bed/fill_height_m", "", "m"),
    figure("Packing fraction at rest", "/bed/packing_fraction", "", ""),
    figure("Discharge by number", "/discharge/rate_per_s", "", "grains/s"),
    figure("Discharge by mass", "/discharge/rate_kg_per_s", "", "kg/s"),
    figure("Largest overlap over the radius", "/max_overlap_ratio", "", "")
        .wrong_above(DEEP, "deep: stiffer contacts or slower impacts would be nearer to hard grains"),
    figure("Wall-clock time of the steps", "/performance/wall_s", "", "s"),
];

/// The key figures, with the cell of each run.
fn sheet_rows(runs: &[Run]) -> Vec<(&'static KeyFigure, Vec<Cell>)> {
    // Without a summary a column of `series.csv` has the figure. Both methods have columns of some names, so a run shows only the figures of
    // its own method then.
    let is_of_method = |run: &Run, figure: &KeyFigure| {
        let is_of_lattice = figure.pointer.starts_with("/particles") || figure.pointer.ends_with("_step");
        let is_of_both = ["/time_s", "/steps"].contains(&figure.pointer);
        let is_time_of_lattice = figure.pointer == "/time_s" && run.is_lattice();
        run.has_summary() || !is_time_of_lattice && (is_of_both || run.is_lattice() == is_of_lattice)
    };
    let cell = |run: &Run, figure: &KeyFigure| {
        let number = is_of_method(run, figure).then(|| run.last(figure.pointer, figure.column)).flatten();
        Cell::of(number, figure.unit)
    };
    FIGURES.iter().map(|figure| (figure, runs.iter().map(|run| cell(run, figure)).collect())).collect()
}

fn key_figures(runs: &[Run]) -> Sheet {
    let mut sheet = Sheet::default();
    for (figure, cells) in sheet_rows(runs) {
        sheet.add(figure.name, cells);
    }
    sheet
}

/// Key figures of a single run, as a list of terms.
fn tiles(rows: &[(&'static KeyFigure, Vec<Cell>)]) -> String {
    let mut html = "<dl class=\"tiles\">\n".to_owned();
    for (figure, cells) in rows {
        if let Some(Cell::Number(value, unit)) = cells.first() {
            let trouble = figure.trouble(*value);
            let (class, note) =
                trouble.map_or_else(Default::default, |why| (" class=\"trouble\"", format!("<p>{why}</p>")));
            let name = figure.name;
            let _ = writeln!(html, "<div{class}><dt>{name}</dt><dd>{}{note}</dd></div>", quantity(*value, unit));
        }
    }
    html + "</dl>\n"
}
