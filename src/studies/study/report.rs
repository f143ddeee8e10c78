//! The output of a study: `claims.md`, `figures.csv`, sheets of pictures for each silo, and the paper's first four
//! figures.

use std::fmt::Write as _;

use crate::lattice_silo::observables::QUANTITIES;
use crate::studies::study::claims::{CLAIMS, ClaimVerdict, quantity, shown};
use crate::studies::study::figures::{self, Flights, Panel, SheetRow, sheet};
use crate::studies::study::plan::{StudyPlan, Variant};
use crate::studies::study::results::Results;
use siloflow_figures::statistics::mean::Mean;

/// Returns the tables: (file name, content).
#[must_use]
pub fn tables(plan: &StudyPlan, results: &Results, flights: &Flights) -> [(&'static str, String); 2] {
    [("claims.md", claims(plan, results, flights)), ("figures.csv", values(results))]
}

/// Largest number of rows of a sheet: the base case and the paper's twelve variants.
const ROWS: usize = 13;

/// Returns the pictures: (name without extension, SVG document).
#[must_use]
pub fn pictures(plan: &StudyPlan, results: &Results, flights: &Flights) -> Vec<(String, String)> {
    let mut all = vec![
        ("vectors".to_owned(), figures::vectors()),
        ("resultants".to_owned(), figures::resultants()),
        ("collisions".to_owned(), figures::collisions()),
        ("thrown".to_owned(), figures::thrown(flights)),
    ];
    let columns: Vec<_> = plan.pictures.iter().map(|step| format!("t = {step}")).collect();
    for silo in plan.silos.keys() {
        for (number, rows) in (1..).zip(rows(plan, results, silo).chunks(ROWS)) {
            all.push((format!("sheet-{}-{number}", silo.replace(' ', "-")), sheet(rows, &columns)));
        }
    }
    all
}

/// Returns a row of pictures for each variant, from its first seed.
fn rows(plan: &StudyPlan, results: &Results, silo: &str) -> Vec<SheetRow> {
    let of = |variant: &Variant| results.0.iter().find(|one| one.case.silo == silo && one.case.variant == *variant);
    let row = |variant: &Variant| {
        let one = of(variant)?;
        let shown = |step: &u64| one.pictures.iter().find(|(when, _)| when == step).map(|(_, cells)| cells.clone());
        // The panel is empty if the run ended before this step.
        let panel = |step: &u64| Panel { cells: shown(step).unwrap_or_default(), lines: one.lines.clone() };
        Some(SheetRow { name: variant.to_string(), panels: plan.pictures.iter().map(panel).collect() })
    };
    plan.variants.iter().filter_map(row).collect()
}

/// Returns the content of `figures.csv`: all observables of all replicas.
#[must_use]
pub fn values(results: &Results) -> String {
    let symbols: Vec<_> = QUANTITIES.iter().map(|quantity| quantity.symbol).collect();
    let mut text = format!("silo,variant,seed,{}\n", symbols.join(","));
    // Writing to a string cannot fail.
    for replica in &results.0 {
        let _ = write!(text, "{},\"{}\",{}", replica.case.silo, replica.case.variant, replica.case.seed);
        for quantity in &QUANTITIES {
            let value = (quantity.value)(&replica.observables).map_or_else(String::new, |value| format!("{value:?}"));
            let _ = write!(text, ",{value}");
        }
        text.push('\n');
    }
    text
}

/// Returns the content of `claims.md`: the findings for all claims, in Markdown.
// Writing to a string cannot fail.
#[must_use]
pub fn claims(plan: &StudyPlan, results: &Results, flights: &Flights) -> String {
    let silos: Vec<&String> = plan.silos.keys().collect();
    let mut text = format!(
        "# Claims of the paper, tested\n\nEach value is the mean ± standard error over {} seeds. The base case has the \
         parameters of the scene. A variant is named by the parameters that differ from the base case. A statement holds \
         or fails if the difference is at least two combined standard errors. The symbols are explained at the end.\n",
        plan.seeds.len()
    );
    for claim in CLAIMS {
        let _ = writeln!(text, "\n## {}\n\n| statement | {} |", claim.text, silo_headers(&silos));
        let _ = writeln!(text, "|---|{}", "---|---|".repeat(silos.len()));
        for statement in claim.statements {
            let found: Vec<_> = silos.iter().map(|silo| statement.judge(results, silo)).collect();
            let cells: Vec<_> = found.iter().map(|one| format!("{} | {}", one.figures, one.verdict.word())).collect();
            let _ = writeln!(text, "| {} | {} |", found[0].statement, cells.join(" | "));
        }
    }
    zone_shapes(plan, &silos, results, &mut text);
    thrown_particles(flights, &mut text);
    quantities(&mut text);
    text
}

/// Returns the header cells of the silos: two columns each, the first with the silo's name.
fn silo_headers(silos: &[&String]) -> String {
    silos.iter().map(|silo| format!("{silo} | ")).collect::<Vec<_>>().join(" | ")
}

/// Appends the shapes of the zones in all silos. The paper calls them similar.
fn zone_shapes(plan: &StudyPlan, silos: &[&String], results: &Results, text: &mut String) {
    let names: Vec<&str> = silos.iter().map(|silo| silo.as_str()).collect();
    text.push_str("\n## Dilatant zones have similar shapes in both silos (no verdict)\n\n");
    let _ = writeln!(text, "| variant | {} |\n|---|{}", names.join(" | "), "---|".repeat(silos.len()));
    for variant in plan.variants.iter().filter(|variant| variant.settings().len() < 2) {
        let cell = |silo: &&String| {
            let mean = |symbol: &str| {
                quantity(symbol).and_then(|q| results.mean(silo, variant, q)).map_or("-".to_owned(), shown)
            };
            format!("hz {}, za {}", mean("hz"), mean("za"))
        };
        let cells: Vec<_> = silos.iter().map(cell).collect();
        let _ = writeln!(text, "| {variant} | {} |", cells.join(" | "));
    }
}

/// Appends the mean height of thrown particles and the exact mean of the Markov chain that the rules define.
fn thrown_particles(flights: &Flights, text: &mut String) {
    let _ = writeln!(
        text,
        "\n## A thrown particle falls along a parabola\n\n{} particles are thrown with velocity v7 at g = {}, h = 0. The heights \
         are in spacings. The exact mean follows from the rules. The parabola is exact up to the first step at which a \
         particle can reach the largest fall velocity.\n\n\
         | step | mean | exact mean | parabola 1.5 t - g t (t + 1)/2 | verdict |\n|---|---|---|---|---|",
        flights.len(),
        flights.g
    );
    for step in [1, 5, 10, 20, 30, 40] {
        let Some(mean) = Mean::of(&flights.heights(step)) else { continue };
        let (exact, parabola) = flights.expected_heights(step);
        let verdict = match flights.len() {
            // A single particle has no standard error.
            ..2 => ClaimVerdict::Unclear,
            // If all particles have the same height, it is the exact mean, to round-off.
            _ if (mean.value - exact).abs() < (2.0 * mean.error).max(1e-9) => ClaimVerdict::NoDifference,
            _ => ClaimVerdict::Fails,
        };
        let _ = writeln!(text, "| {step} | {} | {exact:.3} | {parabola:.3} | {} |", shown(mean), verdict.word());
    }
}

/// Appends the meaning of the symbols.
fn quantities(text: &mut String) {
    text.push_str("\n## Symbols\n\n| symbol | quantity | unit |\n|---|---|---|\n");
    for quantity in &QUANTITIES {
        let _ = writeln!(text, "| {} | {} | {} |", quantity.symbol, quantity.name, quantity.unit);
    }
}
