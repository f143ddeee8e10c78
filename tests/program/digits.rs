//! Numbers in tables read back to the same bits: times of short steps, places of small cells, and figures of summaries.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::command_line::{siloflow, text};

/// Step of the scene, s.
const DT: f64 = 2e-11;

/// A powder of discs of half a micrometre, with every table of times and places.
const POWDER: &str = "(
    gravity: (0.0, -9.81), contact: Linear(k: 1.0e4, damping: Restitution(0.5)), mass: Disc(1.0e-3), step: Fixed(2.0e-11), until: 2.0e-8,
    fill: [(low: (0.0, 1.0e-6), high: (1.0e-5, 1.0e-5), spacing: 2.0e-6, radius: Fixed(5.0e-7))],
    walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0)), Segment(from: (-5.0e-7, 0.0), to: (-5.0e-7, 1.0e-5), name: \"side\")],
    series: (interval: 2.0e-10), pictures: None, checkpoint: None,
    profiles: [(axis: Y, low: 0.0, high: 1.0e-5, bins: 7, sample: 1.0e-10, average: 2.0e-9, section: 1.0e-5)],
    fields: [(grid: XY(low: (0.0, 0.0), high: (1.0e-5, 1.0e-5), cells: (7, 3)), sample: 1.0e-10, average: 2.0e-9)],
    wall_bands: [(walls: \"side\", low: 0.0, high: 1.0e-5, bins: 7, sample: 1.0e-10, average: 2.0e-9)],
)";

/// The column of a table.
fn column(path: &Path, name: &str) -> Vec<f64> {
    let mut rows = csv::Reader::from_path(path).unwrap();
    let place = rows.headers().unwrap().iter().position(|own| own == name).unwrap();
    rows.records().map(|row| row.unwrap()[place].parse().unwrap()).collect()
}

#[test]
fn times_and_places_of_small_scenes_read_back_to_the_same_bits() {
    let here = tempfile::tempdir().unwrap();
    fs::write(here.path().join("powder.ron"), POWDER).unwrap();
    let output = siloflow(here.path(), &["run", "powder.ron", "--quiet", "--out", "out"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let times = [
        ("series", "time_s", 101),
        ("walls", "time_s", 101),
        ("wall_groups", "time_s", 101),
        ("centres", "time_s", 101),
        ("profiles", "from_s", 10),
        ("profiles", "to_s", 10),
        ("fields", "from_s", 10),
        ("fields", "to_s", 10),
        ("wall_bands", "from_s", 10),
        ("wall_bands", "to_s", 10),
    ];
    for (table, name, distinct) in times {
        let found = column(&here.path().join(format!("out/{table}.csv")), name);
        // A time is a number of steps, times the step.
        assert!(found.iter().all(|time| ((time / DT).round() * DT).to_bits() == time.to_bits()), "{table} {name}");
        let found: BTreeSet<u64> = found.into_iter().map(f64::to_bits).collect();
        assert!(found.len() >= distinct, "{table} {name}: {} distinct times", found.len());
    }
    // Middles and borders of cells, to the rounding of a product and a sum.
    for (table, name, cells, shift) in [
        ("profiles", "place_m", 7.0, 0.5),
        ("fields", "x1_m", 7.0, 0.5),
        ("fields", "x2_m", 3.0, 0.5),
        ("wall_bands", "low_m", 7.0, 0.0),
    ] {
        for place in column(&here.path().join(format!("out/{table}.csv")), name) {
            let cell = place / 1e-5 * cells - shift;
            assert!((cell - cell.round()).abs() < 1e-12, "{table} {name}: {place:e}");
        }
    }
}

#[test]
fn figures_of_a_sweep_have_the_digits_of_the_summaries() {
    let here = tempfile::tempdir().unwrap();
    fs::write(here.path().join("powder.ron"), POWDER).unwrap();
    let sweep = "(scene: \"powder.ron\", axes: [Values(key: \"contact.k\", values: [1.0e4, 2.0e4, 3.0e4])], seeds: 1,
        figures: [\"energy.dissipated\", \"time_s\"])";
    fs::write(here.path().join("sweep.ron"), sweep).unwrap();
    let output = siloflow(here.path(), &["sweep", "sweep.ron", "--out", "swept", "--quiet"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let results = here.path().join("swept/results.csv");
    let runs =
        csv::Reader::from_path(&results).unwrap().records().map(|row| row.unwrap()[0].to_owned()).collect::<Vec<_>>();
    let [energies, times] = ["energy.dissipated", "time_s"].map(|name| column(&results, name));
    assert_eq!(runs.len(), 3);
    for ((run, energy), time) in runs.iter().zip(energies).zip(times) {
        let summary = here.path().join("swept/runs").join(run).join("summary.json");
        let summary: Value = serde_json::from_str(&fs::read_to_string(summary).unwrap()).unwrap();
        assert_eq!(summary["energy"]["dissipated"].as_f64().map(f64::to_bits), Some(energy.to_bits()), "{run}");
        assert_eq!(summary["time_s"].as_f64().map(f64::to_bits), Some(time.to_bits()), "{run}");
    }
}
