//! The summary of a run of grains in words.

use crate::cli::run_path::words::SummaryWords;
use crate::output::summary::Summary;
use crate::output::summary::grains::{Energy, GrainResults};

pub(super) fn describe(summary: &Summary<GrainResults>, words: &mut SummaryWords) {
    let head = &summary.head;
    let results = &summary.results;
    let grains = &results.grains;
    let performance = &results.performance;
    words.line(&head.scene, format!("{}, {} steps, {:.3} s simulated", head.status, head.steps, results.time_s));
    words.line(
        "grains",
        format!(
            "{} released, {} inside, {} out, {} lost{}",
            grains.released,
            grains.inside,
            grains.out,
            grains.lost,
            grains.removed.map_or(String::new(), |removed| format!(", {removed} removed"))
        ),
    );
    if let Some(stop) = &results.stop {
        words.line("stopped", format!("{stop}; {} grains inside, {:.4} kg", grains.inside, grains.inside_kg));
    }
    for feed in results.feed.iter().flat_map(|feeds| &feeds.0) {
        let value = format!(
            "{} grains, {:.4} kg, {:.1} % short of the rate",
            feed.grains,
            feed.mass_kg,
            100.0 * feed.shortfall
        );
        words.line("feed", value);
    }
    let moments =
        [("at rest", results.rest_time_s), ("door opened", results.door_open_time_s), ("empty", results.empty_time_s)];
    words.moments(moments, |time| format!("{time:.3} s"));
    if let Some(bed) = results.bed {
        words.line("bed", format!("height {:.3} m, packing fraction {:.4}", bed.fill_height_m, bed.packing_fraction));
    }
    if let Some(flow) = results.discharge {
        words.line(
            "discharge",
            format!("{:.2} s, {:.1} grains/s from 10 to 90 % out", flow.duration_s, flow.rate_per_s),
        );
    }
    if let Some(outflow) = &results.outflow
        && let (Some(number), Some(mass)) = (outflow.rate_per_s, outflow.rate_kg_per_s)
    {
        let from = outflow.from_s;
        let to = outflow.to_s;
        let value = format!("{:.1} grains/s, {:.4} kg/s from {from:.2} to {to:.2} s", number.mean, mass.mean);
        words.line("outflow", value);
    }
    words.line("overlap", format!("largest {:.4} of the radius", results.max_overlap_ratio));
    if let Energy { flows: Some(flows), balance_error: Some(error), .. } = &results.energy {
        words.line("energy", format!("{:.3e} J dissipated, balance error {error:.3e} J", flows.dissipated));
    }
    words.line("contacts", format!("{:.3} a grain at the end", results.coordination));
    let nanoseconds = 1e9 / performance.particle_steps_per_s;
    words.line(
        "wall clock",
        format!("{:.2} s, {nanoseconds:.1} ns a particle-step, threads: {}", performance.wall_s, performance.threads),
    );
    words.line("state hash", &results.state_hash);
}
