//! The judge of `siloflow validate beverloo`, on made-up runs: a law that it has to find, another one that has to miss, and a clog that must not count.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use serde_json::json;
use siloflow::studies::sweep::Sweep;
use siloflow::studies::sweep::directory::SweepDirectory;
use siloflow::studies::validation::cases;
use siloflow::studies::validation::runs::Studies;
use siloflow::studies::validation::verdict::{FigureRow, Verdict};

/// Mean diameter, m; wide, deep and layers of the slot of the full form, diameters.
const D: f64 = 0.004;
const SIZE: [f64; 3] = [40.0, 5.0, 45.0];

/// C and k of the made-up rates.
const LAW: (f64, f64) = (0.9, 1.3);

/// Writes the runs of the slots: Beverloo's law with an exponent and errors of up to 1 %. The narrowest slot clogs, and so does the first run of the next one,
/// after a rate a hundred times as large.
fn studies(here: &Path, exponent: f64) -> Studies {
    let case = cases::named("beverloo").unwrap();
    for (name, content) in case.files {
        fs::write(here.join(name), content).unwrap();
    }
    let sweep = Sweep::read(&here.join("full-slot.ron")).unwrap();
    let directory = SweepDirectory::prepare(&here.join("full-slot"), &sweep, false).unwrap();
    for (task, number) in sweep.tasks().into_iter().zip(0u32..) {
        let slot: f64 = sweep.points[task.point].values[0].parse().unwrap();
        let unit = SIZE[1] * D.powi(-3) * 9.81f64.sqrt() * D.powf(2.5);
        let error = 0.01 * (f64::from(number) * 2.4).sin();
        let mut rate = LAW.0 * unit * (slot - LAW.1).max(0.0).powf(exponent) * (1.0 + error);
        let is_clogged = task.point == 0 || (task.point == 1 && task.seed == 1);
        if is_clogged {
            rate *= 100.0;
        }
        let status = if is_clogged { "clogged" } else { "out_reached" };
        let mut summary = json!({
            "format": 1, "scene": "slot", "status": status, "steps": 1000, "door_open_time_s": 0.5,
            "parameters": {"slot": slot, "wide": SIZE[0], "deep": SIZE[1], "layers": SIZE[2]},
        });
        if is_clogged {
            summary["clog"] = json!({"grains_above": 1, "avalanche_grains": 17});
        }
        let mut series = "time_s,out\n".to_owned();
        for n in 0..50 {
            let time = 0.02 * f64::from(n);
            // The transient at the opening is twice as fast.
            let out = rate * ((time - 0.5).max(0.0) + (time - 0.5).clamp(0.0, 0.05));
            writeln!(series, "{time},{out}").unwrap();
        }
        let run = directory.run(&sweep, task);
        fs::create_dir_all(&run).unwrap();
        fs::write(run.join("summary.json"), summary.to_string()).unwrap();
        fs::write(run.join("series.csv"), series).unwrap();
        fs::write(run.join("state.csv"), bed()).unwrap();
    }
    let mut studies = Studies::default();
    studies.add("full-slot.ron", &sweep, &directory).unwrap();
    studies
}

/// One grain per cubic diameter.
fn bed() -> String {
    let mut state = "x,y,z\n".to_owned();
    for place in 0..45 * 40 * 5 {
        let [z, x, y] = [place / 200, place / 5 % 40, place % 5].map(|n| D * (f64::from(n) + 0.5));
        writeln!(state, "{},{y},{z}", x - 0.5 * SIZE[0] * D).unwrap();
    }
    state
}

fn row<'a>(rows: &'a [FigureRow], words: &str) -> &'a FigureRow {
    rows.iter().find(|row| row.quantity.contains(words)).unwrap_or_else(|| panic!("{words}: {rows:?}"))
}

#[test]
fn the_law_of_the_rates_is_found_and_clogs_do_not_count() {
    let here = tempfile::tempdir().unwrap();
    let judgement = (cases::named("beverloo").unwrap().judge)(&studies(here.path(), 1.5)).unwrap();
    let rows = &judgement.rows;
    let fixed = row(rows, "exponent of Beverloo's law at k = 1.4");
    assert_eq!(fixed.verdict(), Verdict::Pass, "{fixed:?}");
    let exponent = row(rows, "exponent of Beverloo's law, with C and k free");
    assert!(
        (exponent.found - 1.5).abs() < 3.0 * exponent.error.unwrap() && exponent.error.unwrap() < 0.1,
        "{exponent:?}"
    );
    let [c, k] = ["slot: C at", "slot: k at"].map(|words| row(rows, words));
    // The density is counted in 20 of 19.5 layers: 2.6 %. The errors of the rates are 1 %.
    assert!((c.found / LAW.0 - 1.0).abs() < 0.05 && (k.found - LAW.1).abs() < 3.0 * k.error.unwrap(), "{c:?} {k:?}");
    assert_eq!(row(rows, "share of the runs that clog").verdict(), Verdict::Pass);
    let second = row(rows, "slot of 5 d: rate");
    assert_eq!(second.remark, "runs: 2");
    assert!(!rows.iter().any(|row| row.quantity == "slot of 2 d: rate"));
    let list = judgement.remarks.iter().find(|text| text.contains("that clogged")).unwrap();
    assert!(list.contains("2 d, seed 1: 17") && list.contains("5 d, seed 1: 17"), "{list}");
}

#[test]
fn rates_with_another_exponent_miss() {
    let here = tempfile::tempdir().unwrap();
    let rows = (cases::named("beverloo").unwrap().judge)(&studies(here.path(), 2.0)).unwrap().rows;
    let exponent = row(&rows, "exponent of Beverloo's law at k = 1.4");
    assert_eq!(exponent.verdict(), Verdict::Miss, "{exponent:?}");
}
