//! `siloflow validate chung-ooi`: its two cheapest sweeps, and a wrong material.

use std::fs;
use std::path::Path;

use siloflow::studies::sweep::Sweep;
use siloflow::studies::sweep::directory::SweepDirectory;
use siloflow::studies::validation::cases;
use siloflow::studies::validation::runs::Studies;
use siloflow::studies::validation::verdict::{FigureRow, Verdict};

use crate::command_line::{siloflow, text};

/// Runs the sweeps of tests 1 and 2, with a change of the scenes, and returns the rows.
fn rows(here: &Path, change: impl Fn(&str) -> String) -> Vec<FigureRow> {
    let case = cases::named("chung-ooi").unwrap();
    for (name, content) in case.files {
        fs::write(here.join(name), change(content)).unwrap();
    }
    let mut studies = Studies::default();
    for name in ["test-1.ron", "test-2.ron"] {
        let output = siloflow(here, &["sweep", name, "--quiet"]);
        assert!(output.status.success(), "{}", text(&output.stderr));
        let sweep = Sweep::read(&here.join(name)).unwrap();
        let directory = SweepDirectory::open(&here.join("out").join(name.trim_end_matches(".ron")), &sweep).unwrap();
        studies.add(name, &sweep, &directory).unwrap();
    }
    let rows = (case.judge)(&studies).unwrap().rows;
    rows.into_iter().filter(|row| row.quantity.starts_with("test 1") || row.quantity.starts_with("test 2")).collect()
}

#[test]
fn elastic_impacts_pass_and_a_stiffer_material_misses() {
    let here = tempfile::tempdir().unwrap();
    let right = rows(here.path(), str::to_owned);
    assert_eq!(right.len(), 14);
    for row in &right {
        assert_eq!(row.verdict(), Verdict::Pass, "{}: {}", row.quantity, row.found);
    }
    let here = tempfile::tempdir().unwrap();
    // Glass with one and a half of its modulus: the force grows by 1.5^0.4 = 1.18.
    let wrong = rows(here.path(), |text| text.replace("= 4.8e10 + material", "= 7.2e10 + material"));
    let glass: Vec<_> = wrong.iter().filter(|row| row.quantity.contains("glass")).collect();
    assert!(!glass.is_empty() && glass.iter().all(|row| row.verdict() == Verdict::Miss), "{glass:?}");
}
