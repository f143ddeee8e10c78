//! The estimates of `siloflow check` for the scene of a run: the step, its limits, the expected error of
//! an impact, and warnings.

use std::fmt::Write as _;

use crate::report::html::{Section, code, escape, list, message};
use crate::report::run::Run;
use crate::report::sheet::{Cell, Sheet};
use crate::scene_facts::{SceneFacts, StepEstimates};
use siloflow_text::fault::Warning;

/// The section of the step and its error.
#[must_use]
pub fn section_of(runs: &[Run], labels: &[String]) -> Option<Section> {
    let estimates: Vec<Option<&StepEstimates>> = runs.iter().map(|run| grains(run)?.step.as_ref()).collect();
    let mut sheet = Sheet::default();
    let mut row = |name: &str, unit: &'static str, of: &dyn Fn(&StepEstimates) -> f64| {
        let cell = |e: Option<&StepEstimates>| Cell::of(e.map(of).filter(|x| x.is_finite()), unit);
        sheet.add(name, estimates.iter().copied().map(cell).collect());
    };
    row("Step", "s", &|e| e.dt);
    row("Shortest contact", "s", &|e| e.contact_duration);
    row("Steps in the shortest contact", "steps", &|e| e.contact_duration / e.dt);
    row("Largest stable step of one contact", "s", &|e| e.pair_limit);
    row("Largest stable step in a dense bed", "s", &|e| e.bed_limit);
    row("Expected rms error of an impact, of its speed", "%", &|e| 100.0 * e.expected_error.unwrap_or(f64::NAN));
    row("Restitution of an impact", "", &|e| e.restitution);
    row("Fastest impact", "m/s", &|e| e.impact_speed);
    row("Overlap expected from that impact, over the radius", "", &|e| e.impact_overlap);
    row("Overlap expected from the weight of the bed, over the radius", "", &|e| e.static_overlap);
    let largest = |run: &Run| Cell::of(run.number("/max_overlap_ratio"), "");
    sheet.add("Largest overlap of the run, over the radius", runs.iter().map(largest).collect());
    let scheme = |e: Option<&StepEstimates>| e.map_or(Cell::Nothing, |e| Cell::Html(code(&e.scheme)));
    sheet.add("Scheme", estimates.iter().copied().map(scheme).collect());
    let reason = |e: Option<&StepEstimates>| match e.map(|e| &e.reason) {
        Some(Some(reason)) => Cell::Html(escape(reason)),
        Some(None) => Cell::Html("The scene gives the step.".to_owned()),
        None => Cell::Nothing,
    };
    sheet.add("Why this step", estimates.iter().copied().map(reason).collect());
    let mut content = sheet.html("Step and expected error, as siloflow check estimates them", labels);
    for run in runs {
        content += &remarks(run, runs.len() > 1);
    }
    let scenes: Vec<_> = runs.iter().filter(|run| grains(run).is_some()).collect();
    if let Some(run) = scenes.first() {
        let _ = writeln!(
            content,
            "<p class=\"note\">The error is that of a single impact, as a root mean square over the phases of a step. \
             <code>siloflow accuracy {}</code> measures the effect of the step on the observables of the scene.</p>",
            escape(&run.files.directory.join("scene.ron").display().to_string())
        );
    }
    Section::of("step", "Step and expected error", content)
}

/// The facts of a scene of grains.
fn grains(run: &Run) -> Option<&SceneFacts> {
    run.scene.as_ref().ok().filter(|scene| !scene.is_lattice)
}

/// Warnings about the scene of a run, or why it cannot be examined.
fn remarks(run: &Run, has_name: bool) -> String {
    let name = if has_name { format!("<strong><bdi>{}</bdi></strong>: ", escape(run.label())) } else { String::new() };
    let warnings = match &run.scene {
        Ok(scene) => &scene.warnings,
        Err(error) => return format!("<p>{name}the scene of the run cannot be examined: {}</p>\n", escape(error)),
    };
    let item = |warning: &Warning| {
        let Warning { code: name, message: text, help } = warning;
        format!("{}: {}; {}.", code(name), message(text), message(help))
    };
    if warnings.is_empty() {
        return format!("<p>{name}<code>siloflow check</code> has no warnings.</p>\n");
    }
    format!("<p>{name}<code>siloflow check</code> warns:</p>\n{}", list(&warnings.iter().map(item).collect::<Vec<_>>()))
}
