//! Values that behaviours register for the summary.

use std::collections::BTreeSet;

use serde_json::Value;

use crate::report::html::{Section, code, escape};
use crate::report::run::Run;
use crate::report::sheet::{Cell, Sheet};

/// The section of values of behaviours; nothing if no run has any.
#[must_use]
pub fn section_of(runs: &[Run], labels: &[String]) -> Option<Section> {
    let mut sheet = Sheet::default();
    for (behaviour, name) in names(runs) {
        let found = |run: &Run| run.value("/behaviours").map(|all| all[&behaviour][&name].clone());
        let text = |value: &Value, key: &str| value[key].as_str().unwrap_or_default().to_owned();
        let label = runs.iter().filter_map(found).map(|value| text(&value, "label")).find(|label| !label.is_empty());
        let cell = |run: &Run| {
            found(run).map_or(Cell::Nothing, |value| Cell::of(value["value"].as_f64(), text(&value, "unit")))
        };
        let label = escape(label.as_ref().unwrap_or(&name));
        sheet.add(format!("{label} ({})", code(&behaviour)), runs.iter().map(cell).collect());
    }
    Section::of("behaviours", "Values of behaviours", sheet.html("Values that behaviours measure", labels))
}

/// Names of behaviours and of their values.
fn names(runs: &[Run]) -> BTreeSet<(String, String)> {
    let objects = runs.iter().filter_map(|run| run.value("/behaviours")?.as_object());
    let values = objects.flatten().filter_map(|(behaviour, values)| Some((behaviour, values.as_object()?)));
    values.flat_map(|(behaviour, values)| values.keys().map(|name| (behaviour.clone(), name.clone()))).collect()
}
