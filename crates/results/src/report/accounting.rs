//! Grain accounting: released = inside + out + lost, and removed where behaviours remove grains. Feeds, delayed releases, avalanches, clogs and lost grains.

use serde_json::Value;

use crate::report::html::{Section, escape, list, quantity};
use crate::report::run::Run;
use crate::report::sheet::{Cell, Sheet};

/// Most lost grains that are listed.
const MOST_LOSSES: usize = 20;

/// Rows: name, pointer into the summary, column of `series.csv` without a summary, unit, and whether it belongs to the lattice gas.
const ROWS: [(&str, &str, &str, &str, bool); 13] = [
    ("Grains released", "/grains/released", "released", "grains", false),
    ("Grains inside at the end", "/grains/inside", "inside", "grains", false),
    ("Mass inside at the end", "/grains/inside_kg", "", "kg", false),
    ("Grains out through a door", "/grains/out", "out", "grains", false),
    ("Mass out through a door", "/grains/out_kg", "out_kg", "kg", false),
    ("Grains lost in any other way", "/grains/lost", "lost", "grains", false),
    ("Grains removed by behaviours", "/grains/removed", "", "grains", false),
    ("Releases that had to wait", "/releases/delayed_releases", "", "grains", false),
    ("Longest wait of a release", "/releases/longest_delay_s", "", "s", false),
    ("Contacts per grain at the end", "/coordination", "coordination", "", false),
    ("Particles entered", "/particles/entered", "entered", "particles", true),
    ("Particles inside at the end", "/particles/inside", "inside", "particles", true),
    ("Particles out through the door", "/particles/out", "out", "particles", true),
];

/// The section of the grain accounting.
#[must_use]
pub fn section_of(runs: &[Run], labels: &[String]) -> Option<Section> {
    let mut sheet = Sheet::default();
    for (name, pointer, column, unit, is_lattice) in ROWS {
        let cell = |run: &Run| {
            Cell::of(
                Some(run).filter(|run| run.is_lattice() == is_lattice).and_then(|run| run.last(pointer, column)),
                unit,
            )
        };
        sheet.add(name, runs.iter().map(cell).collect());
    }
    add_feeds(&mut sheet, runs);
    let removes = runs.iter().any(|run| run.value("/grains/removed").is_some());
    let title = format!("Grain accounting: released = inside + out + lost{}", if removes { " + removed" } else { "" });
    let mut content = sheet.html(&title, labels);
    for run in runs {
        content += &events(run, runs.len() > 1);
    }
    Section::of("accounting", "Grain accounting", content)
}

fn add_feeds(sheet: &mut Sheet, runs: &[Run]) {
    let count = |run: &Run| run.value("/feed").and_then(Value::as_array).map_or(0, Vec::len);
    for number in 0..runs.iter().map(count).max().unwrap_or(0) {
        for (name, key, unit) in [
            ("grains released", "grains", "grains"),
            ("mass released", "mass_kg", "kg"),
            ("share of the amount due that is missing", "shortfall", ""),
            ("longest wait", "longest_wait_s", "s"),
        ] {
            let cell = |run: &Run| Cell::of(run.number(&format!("/feed/{number}/{key}")), unit);
            sheet.add(format!("Feed {}: {name}", number + 1), runs.iter().map(cell).collect());
        }
    }
}

/// Avalanches, clogs and losses of a run, in words.
fn events(run: &Run, has_name: bool) -> String {
    let mut items = Vec::new();
    if let (Some(above), Some(left)) = (run.number("/clog/grains_above"), run.number("/clog/avalanche_grains")) {
        items.push(format!(
            "The outlet clogged: {} left after the door had opened, and {} were above it.",
            quantity(left, "grains"),
            quantity(above, "grains")
        ));
    }
    if let Some(avalanches) = run.value("/avalanches").and_then(Value::as_array) {
        let sizes: Vec<f64> = avalanches.iter().filter_map(|avalanche| avalanche["grains"].as_f64()).collect();
        #[expect(clippy::cast_precision_loss, reason = "a number of avalanches")]
        let count = sizes.len() as f64;
        let mean = if sizes.is_empty() { 0.0 } else { sizes.iter().sum::<f64>() / count };
        items.push(format!(
            "A kick ended {}; their mean size is {}.",
            quantity(count, "clogs"),
            quantity(mean, "grains")
        ));
    }
    let losses = run.value("/losses").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    for loss in losses.iter().take(MOST_LOSSES) {
        let place: Vec<_> = loss["position_m"].as_array().into_iter().flatten().filter_map(Value::as_f64).collect();
        let place: Vec<_> = place.iter().map(|x| quantity(*x, "m")).collect();
        items.push(format!(
            "Grain {} was lost at {}, at ({}): {}.",
            loss["grain"],
            quantity(loss["time_s"].as_f64().unwrap_or(f64::NAN), "s"),
            place.join(", "),
            escape(loss["way"].as_str().unwrap_or_default())
        ));
    }
    let all = run.number("/grains/lost").unwrap_or_default();
    if losses.len() > MOST_LOSSES {
        items.push(format!("These are the first of {}.", quantity(all, "lost grains")));
    }
    match (items.is_empty(), has_name) {
        (true, _) => String::new(),
        (false, true) => format!("<h3><bdi>{}</bdi></h3>\n{}", escape(run.label()), list(&items)),
        (false, false) => list(&items),
    }
}
