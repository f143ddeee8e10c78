//! Where the results come from: version, scene, seed, hashes, machine, command, cost; and the scene's whole text.

use std::fmt::Write as _;

use crate::report::html::{Section, code, escape};
use crate::report::run::Run;
use crate::report::sheet::{Cell, Sheet};
use siloflow_files::run_directory::hash_of_input;

/// The section of the origin of each run.
#[must_use]
pub fn section_of(runs: &[Run], labels: &[String]) -> Option<Section> {
    let mut sheet = Sheet::of_words();
    let mut row = |name: &str, of: &dyn Fn(&Run) -> Cell| sheet.add(name, runs.iter().map(of).collect());
    let coded = |text: Option<&str>| text.map_or(Cell::Nothing, |text| Cell::Html(code(text)));
    row("Run directory", &|run| coded(Some(&run.files.directory.display().to_string())));
    row("Scene", &|run| Cell::text(run.text("/scene")));
    row("Command", &|run| coded(run.text("/provenance/command")));
    row("Version of siloflow", &|run| Cell::text(run.text("/provenance/version")));
    row("Ended (UTC)", &|run| Cell::text(run.text("/provenance/ended")));
    row("Processor", &|run| Cell::text(run.text("/provenance/processor")));
    row("Cores", &|run| Cell::of(run.number("/provenance/cores"), "threads"));
    row("Threads of the run", &|run| Cell::of(run.number("/performance/threads"), "threads"));
    row("Seed", &seed);
    row("Scheme", &|run| coded(run.text("/performance/integrator")));
    row("Steps", &|run| Cell::of(run.number("/steps"), "steps"));
    row("Wall-clock time of the steps", &|run| Cell::of(run.number("/performance/wall_s"), "s"));
    row("Sum of movable grains over all steps", &|run| Cell::of(run.number("/performance/particle_steps"), ""));
    row("Steps of single grains in a second", &|run| Cell::of(run.number("/performance/particle_steps_per_s"), "1/s"));
    row("Sites", &|run| Cell::of(run.number("/sites"), "sites"));
    row("Updates of sites in a second", &|run| Cell::of(run.number("/performance/site_updates_per_s"), "1/s"));
    row("Largest memory", &|run| Cell::of(run.number("/performance/peak_memory_bytes").map(|bytes| bytes / 1e6), "MB"));
    row("Started from", &|run| coded(run.text("/parent/run")));
    row("Hash of the grains at the start", &|run| coded(run.text("/parent/state_hash")));
    row("Hash of the state at the end", &|run| coded(run.text("/state_hash")));
    row("Hash of the scene and its files", &|run| {
        hash_of_input(&run.files.directory).map_or(Cell::Nothing, |hash| Cell::Html(code(&format!("{hash:016x}"))))
    });
    let mut content = sheet.html("Origin of the results", labels);
    for run in runs {
        let name = if runs.len() > 1 { format!(" of {}", run.label()) } else { String::new() };
        let _ = writeln!(
            content,
            "<details>\n<summary>The scene{}</summary>\n<pre tabindex=\"0\"><code>{}</code></pre>\n</details>",
            escape(&name),
            escape(&run.scene_text)
        );
    }
    let _ = writeln!(
        content,
        "<p class=\"note\">siloflow {} made this page. The same scene, seed and version give the same hash of the state, \
         with any number of threads.</p>",
        env!("CARGO_PKG_VERSION")
    );
    Section::of("provenance", "Provenance", content)
}

/// The seed as text: a number may have more digits than a float holds.
fn seed(run: &Run) -> Cell {
    run.scene.as_ref().map_or(Cell::Nothing, |scene| Cell::Html(code(&scene.seed.to_string())))
}
