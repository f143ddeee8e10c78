//! Results of the accuracy study as a table, Markdown, CSV and JSON.

use std::fmt::Write as _;

use serde::Serialize;

use super::SCHEMES;
use super::ladder::Climb;
use super::work_precision::{Needed, needed, pareto};
use siloflow_figures::statistics::mean::geometric_mean;

/// Target errors whose cost is reported.
pub const TARGETS: [f64; 3] = [1e-2, 1e-3, 1e-4];
/// Cases and target error of the summary number of a scheme.
pub const SUMMARY: ([&str; 3], f64) = (["bounce-0.9", "bounce-0.5", "bounce-0.2"], 1e-3);

/// Result of one case with one scheme and one step.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Name of the case.
    pub case: &'static str,
    /// Name of the scheme.
    pub scheme: String,
    /// t_c/dt.
    pub steps_per_contact: f64,
    /// Force evaluations per contact duration.
    pub evaluations_per_contact: f64,
    /// Rms error; `null` if it is not finite or if the step was refused.
    pub error: Option<f64>,
    /// Order of convergence between the next coarser step and this one.
    pub order: Option<f64>,
    /// Whether the row is Pareto-optimal in evaluations and error.
    pub pareto: bool,
    /// `refused: ...` or `broke down`.
    pub note: Option<String>,
}

impl Row {
    /// Returns the text that a table shows instead of the error.
    fn short_note(&self) -> String {
        let is_broken = self.note.as_deref() == Some("broke down");
        (if is_broken { "broke down" } else { "refused" }).to_owned()
    }
}

/// The cost of one target error.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Price {
    /// The target error.
    pub error: f64,
    /// The t_c/dt that the target error needs.
    pub steps_per_contact: Needed,
    /// Computing time per grain and contact duration, ns.
    pub ns_per_grain_and_contact: Option<f64>,
}

/// Results of one case with one scheme.
#[derive(Clone, Debug, Serialize)]
pub struct Entry {
    /// Name of the case.
    pub case: &'static str,
    /// Title in tables and figures.
    pub title: &'static str,
    /// Name of the scheme.
    pub scheme: String,
    /// Reason why the scheme cannot run this case.
    pub not_for_this_case: Option<String>,
    /// Order of convergence over the steps finer than t_c/20.
    pub order: Option<f64>,
    /// Difference between the reference and the reference at twice its step; 0 for closed forms.
    pub reference_error: f64,
    /// Costs of the target errors.
    pub prices: Vec<Price>,
    /// Results by step, coarse to fine.
    pub rows: Vec<Row>,
}

/// Summary of one scheme.
#[derive(Clone, Debug, Serialize)]
pub struct SchemeFigures {
    /// Name of the scheme.
    pub scheme: String,
    /// Computing time per particle-step, ns, measured in the bed on this machine.
    pub ns_per_particle_step: Option<f64>,
    /// Step for an error of 1e-3 in restitution, divided by the step that plain Verlet needs.
    ///
    /// It is the geometric mean over e = 0.9, 0.5, 0.2.
    pub step_over_plain_at_1e_3: Option<f64>,
}

/// The full results.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Version of the JSON format.
    pub format: u32,
    /// Summaries by scheme.
    pub schemes: Vec<SchemeFigures>,
    /// Results by case and scheme.
    pub entries: Vec<Entry>,
}

impl Report {
    /// Builds the report.
    ///
    /// `climbs` must be sorted by case and scheme. `cost` has nanoseconds per particle-step of each scheme.
    #[must_use]
    pub fn new(climbs: &[Climb], cost: &[Option<f64>]) -> Self {
        let mut entries: Vec<_> = climbs.iter().map(|climb| entry(climb, cost[climb.scheme])).collect();
        mark_front(&mut entries);
        let schemes = SCHEMES.iter().enumerate().map(|(number, scheme)| SchemeFigures {
            scheme: scheme.name(),
            ns_per_particle_step: cost[number],
            step_over_plain_at_1e_3: step_over_plain(climbs, number),
        });
        Self { format: 1, schemes: schemes.collect(), entries }
    }

    /// Returns the report as CSV, with a row per case, scheme and step.
    #[must_use]
    pub fn csv(&self) -> String {
        let mut text =
            "case,scheme,steps_per_contact,evaluations_per_contact,error,order,pareto,reference_error,note\n"
                .to_owned();
        let number = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:e}"));
        for (entry, row) in self.entries.iter().flat_map(|entry| entry.rows.iter().map(move |row| (entry, row))) {
            let Row { case, scheme, steps_per_contact: n, evaluations_per_contact: cost, pareto, note, .. } = row;
            let error = number(row.error);
            let order = number(row.order);
            let note = note.as_deref().unwrap_or_default().replace([',', '\n', '"'], ";");
            let reference = entry.reference_error;
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{case},{scheme},{n},{cost},{error},{order},{pareto},{reference:e},{note}");
        }
        text
    }

    /// Returns the report as Markdown: a table of the cases and a table of the schemes' costs.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut text = "| case | scheme | order | error at t_c/10 | /20 | /50 | /100 | t_c/dt for 1e-2 | 1e-3 | 1e-4 |\n|---|---|---|---|---|---|---|---|---|---|\n"
            .to_owned();
        for entry in &self.entries {
            let title = entry.title;
            let scheme = &entry.scheme;
            // Writing to a string cannot fail.
            if let Some(why) = &entry.not_for_this_case {
                let _ = writeln!(text, "| {title} | `{scheme}` | not for this case: {why} | | | | | | | |");
                continue;
            }
            let error = |whole: f64| {
                let row = entry.rows.iter().find(|row| (whole..whole + 1.0).contains(&row.steps_per_contact));
                row.map_or_else(String::new, |row| row.error.map_or(row.short_note(), |error| format!("{error:.1e}")))
            };
            let errors = [10.0, 20.0, 50.0, 100.0].map(error).join(" | ");
            let steps: Vec<_> = entry.prices.iter().map(|price| price.steps_per_contact.to_string()).collect();
            let order = entry.order.map_or("-".to_owned(), |order| format!("{order:.2}"));
            let _ = writeln!(text, "| {title} | `{scheme}` | {order} | {errors} | {} |", steps.join(" | "));
        }
        text += "\n| scheme | ns per particle-step in the bed | step for 1e-3 over plain Verlet's, mean of e = 0.9, 0.5, 0.2 |\n|---|---|---|\n";
        for figures in &self.schemes {
            let cost = figures.ns_per_particle_step.map_or("refused".to_owned(), |ns| format!("{ns:.1}"));
            let ratio = figures.step_over_plain_at_1e_3.map_or("not reached".to_owned(), |ratio| format!("{ratio:.2}"));
            let _ = writeln!(text, "| `{}` | {cost} | {ratio} |", figures.scheme);
        }
        text
    }

    /// Returns the report as a plain-text table.
    #[must_use]
    pub fn table(&self) -> String {
        let mut text = String::new();
        for entry in &self.entries {
            if self
                .entries
                .iter()
                .find(|other| other.case == entry.case)
                .is_some_and(|first| std::ptr::eq(first, entry))
            {
                let _ = writeln!(text, "\n{}: {}", entry.case, entry.title);
                let _ = writeln!(
                    text,
                    "  {:<16} {:>7}  {:<54} {:>7} {:>7} {:>7}   {:>9} {:>9} {:>9}",
                    "scheme", "order", "error at t_c/dt", "1e-2", "1e-3", "1e-4", "1e-2", "1e-3", "1e-4"
                );
            }
            text += &line(entry);
        }
        text += "\nfor each target error: the t_c/dt that it needs, and nanoseconds per grain and contact duration; -: not reached\n\n";
        for scheme in &self.schemes {
            let cost =
                scheme.ns_per_particle_step.map_or("refused".to_owned(), |ns| format!("{ns:.1} ns per particle-step"));
            let ratio = scheme.step_over_plain_at_1e_3;
            let ratio = ratio
                .map_or("1e-3 not reached or not run".to_owned(), |ratio| format!("{ratio:.2} times plain Verlet's"));
            let _ = writeln!(
                text,
                "{:<16} {cost} in the bed; step for 1e-3, mean of e = 0.9, 0.5, 0.2: {ratio}",
                scheme.scheme
            );
        }
        text
    }
}

fn entry(climb: &Climb, cost: Option<f64>) -> Entry {
    let scheme = &SCHEMES[climb.scheme];
    let points = climb.points();
    let price = |error: f64| {
        let steps = needed(&points, error);
        Price {
            error,
            steps_per_contact: steps,
            ns_per_grain_and_contact: steps.steps().zip(cost).map(|(n, ns)| n * ns),
        }
    };
    let rows = climb.rungs.iter().map(|rung| Row {
        case: climb.case,
        scheme: scheme.name(),
        steps_per_contact: rung.steps,
        evaluations_per_contact: rung.steps * scheme.evaluations,
        error: rung.error.filter(|error| error.is_finite()),
        order: rung.order,
        pareto: false,
        note: match (&rung.refusal, rung.error) {
            (Some(refusal), _) => Some(format!("refused: {refusal}")),
            (None, Some(error)) if !error.is_finite() => Some("broke down".to_owned()),
            _ => None,
        },
    });
    Entry {
        case: climb.case,
        title: climb.title,
        scheme: scheme.name(),
        not_for_this_case: climb.refusal.clone(),
        order: climb.order,
        reference_error: climb.reference_error,
        prices: if climb.refusal.is_none() { TARGETS.map(price).to_vec() } else { Vec::new() },
        rows: rows.collect(),
    }
}

/// Marks the Pareto-optimal rows of each case.
fn mark_front(entries: &mut [Entry]) {
    for group in entries.chunk_by_mut(|a, b| a.case == b.case) {
        let mut rows: Vec<&mut Row> = group.iter_mut().flat_map(|entry| &mut entry.rows).collect();
        let points: Vec<_> =
            rows.iter().map(|row| (row.evaluations_per_contact, row.error.unwrap_or(f64::INFINITY))).collect();
        rows.iter_mut().zip(pareto(&points)).for_each(|(row, is_on_it)| row.pareto = is_on_it);
    }
}

/// Returns [`SchemeFigures::step_over_plain_at_1e_3`]; `None` unless both schemes reach the target error in all cases
/// of [`SUMMARY`].
fn step_over_plain(climbs: &[Climb], scheme: usize) -> Option<f64> {
    let (cases, target) = SUMMARY;
    let steps = |scheme: usize, case: &str| {
        let climb = climbs.iter().find(|climb| climb.scheme == scheme && climb.case == case)?;
        needed(&climb.points(), target).steps()
    };
    let ratios: Option<Vec<f64>> = cases.iter().map(|case| Some(steps(0, case)? / steps(scheme, case)?)).collect();
    geometric_mean(&ratios?)
}

fn line(entry: &Entry) -> String {
    if let Some(why) = &entry.not_for_this_case {
        return format!("  {:<16} not for this case: {why}\n", entry.scheme);
    }
    let errors: Vec<_> = entry
        .rows
        .iter()
        .map(|row| {
            let error = row.error.map_or(row.short_note(), |error| format!("{error:.1e}"));
            format!("{:.0}: {error}", row.steps_per_contact)
        })
        .collect();
    let order = entry.order.map_or("-".to_owned(), |order| format!("{order:.2}"));
    let steps = entry.prices.iter().map(|price| format!("{:>7}", price.steps_per_contact.to_string()));
    let times = entry
        .prices
        .iter()
        .map(|price| price.ns_per_grain_and_contact.map_or_else(|| format!("{:>9}", "-"), |ns| format!("{ns:>9.0}")));
    let (steps, times): (Vec<_>, Vec<_>) = (steps.collect(), times.collect());
    let steps = steps.join(" ");
    let times = times.join(" ");
    let mut text = String::new();
    for (number, errors) in errors.chunks(4).enumerate() {
        let errors = errors.join("  ");
        let _ = if number == 0 {
            writeln!(text, "  {:<16} {order:>7}  {errors:<54} {steps}   {times}", entry.scheme)
        } else {
            writeln!(text, "  {:<16} {:>7}  {errors}", "", "")
        };
    }
    text
}
