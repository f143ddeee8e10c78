//! Energies at the end, energy flows of the whole run, and the error of the balance.

use crate::report::html::Section;
use crate::report::run::Run;
use crate::report::sheet::{Cell, Sheet};

/// Rows: name, key in `energy` of the summary, and column of `series.csv` without a summary.
const ROWS: [(&str, &str, &str); 13] = [
    ("Kinetic energy of translation at the end", "kinetic", "kinetic_j"),
    ("Kinetic energy of rotation at the end", "rotational", "rotational_j"),
    ("Potential energy at the end", "potential", "potential_j"),
    ("Elastic energy of contacts at the end", "elastic", "elastic_j"),
    ("Energy of grains that entered", "released", "released_j"),
    ("Work of moving walls", "wall_work", "wall_work_j"),
    ("Potential energy gained at periodic sides", "lifted", "lifted_j"),
    ("Work of forces of behaviours", "added_work", "added_work_j"),
    ("Dissipated by damping and friction", "dissipated", "dissipated_j"),
    ("\u{2013} of which by friction", "channels/tangential", ""),
    ("\u{2013} of which by rolling resistance", "channels/rolling", ""),
    ("Energy of grains that were removed", "removed", "removed_j"),
    ("Error of the balance", "balance_error", "balance_error_j"),
];

/// The section of energies; nothing if no run has any.
#[must_use]
pub fn section_of(runs: &[Run], labels: &[String]) -> Option<Section> {
    let energy = |run: &Run, key: &str, column: &str| {
        Some(run).filter(|run| !run.is_lattice()).and_then(|run| run.last(&format!("/energy/{key}"), column))
    };
    let mut sheet = Sheet::default();
    for (name, key, column) in ROWS {
        // Most scenes have no such flow.
        let is_usual = !["rotational", "wall_work", "lifted", "added_work"].contains(&key);
        if !is_usual && runs.iter().all(|run| energy(run, key, column).unwrap_or(0.0) == 0.0) {
            continue;
        }
        sheet.add(name, runs.iter().map(|run| Cell::of(energy(run, key, column), "J")).collect());
    }
    let share = |run: &Run| {
        let flow = |key: &str| energy(run, key, &format!("{key}_j"));
        let error = flow("balance_error")?;
        // The energies that went in and out, of whichever sign.
        let turned = ["released", "wall_work", "lifted", "added_work", "dissipated", "removed"]
            .map(|key| flow(key).unwrap_or(0.0).abs());
        let largest = turned.into_iter().fold(0.0, f64::max);
        (largest > 0.0).then(|| 100.0 * error.abs() / largest)
    };
    sheet.add("Error over the largest flow", runs.iter().map(|run| Cell::of(share(run), "%")).collect());
    let table = sheet.html("Energy balance", labels);
    if table.is_empty() {
        return None;
    }
    let note = "<p class=\"note\">kinetic + rotational + potential + elastic = entered + work of walls + gained at periodic sides + \
                work of behaviours \u{2212} dissipated \u{2212} removed + error. The potential energy is 0 at the origin.</p>\n";
    Section::of("energy", "Energy", table + note)
}
