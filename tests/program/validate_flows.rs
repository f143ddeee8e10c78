//! `siloflow validate clogging` and `orifice-profiles` in still shorter forms, and with a wrong scene.

use std::fs;
use std::path::Path;

use siloflow::studies::sweep::Sweep;
use siloflow::studies::sweep::directory::SweepDirectory;
use siloflow::studies::validation::cases;
use siloflow::studies::validation::runs::Studies;
use siloflow::studies::validation::verdict::{FigureRow, Verdict};

use crate::command_line::{siloflow, text};

/// Runs the short form of a case after changes of its files, and returns the rows.
fn rows(here: &Path, case: &str, change: impl Fn(&str) -> String) -> Vec<FigureRow> {
    let case = cases::named(case).unwrap();
    for (name, content) in case.files {
        fs::write(here.join(name), change(content)).unwrap();
    }
    let mut studies = Studies::default();
    let output = siloflow(here, &["sweep", "short.ron", "--quiet"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let sweep = Sweep::read(&here.join("short.ron")).unwrap();
    let directory = SweepDirectory::open(&here.join("out/short"), &sweep).unwrap();
    studies.add("short.ron", &sweep, &directory).unwrap();
    (case.judge)(&studies).unwrap().rows
}

/// Returns the verdicts of the rows that have a rule.
fn verdicts(rows: &[FigureRow]) -> Vec<(Verdict, &str, f64)> {
    let all = rows.iter().map(|row| (row.verdict(), row.quantity.as_str(), row.found));
    all.filter(|(verdict, ..)| *verdict != Verdict::Reported).collect()
}

#[test]
#[ignore = "half a minute; the short form of the case, which .ci/full runs, judges 450 avalanches"]
fn sixty_avalanches_of_two_widths_are_exponential_and_grow() {
    let here = tempfile::tempdir().unwrap();
    let change = |text: &str| text.replace("[2.5, 3.0, 3.5]", "[2.5, 3.0]").replace("most: 150", "most: 60");
    let rows = rows(here.path(), "clogging", change);
    let found = verdicts(&rows);
    // Chance and ratio of moments of both widths, and the growth of the mean.
    assert_eq!(found.len(), 5, "{found:?}");
    assert!(found.iter().all(|(verdict, ..)| *verdict == Verdict::Pass), "{found:?}");
}

#[test]
fn the_flux_of_the_profiles_is_the_counted_rate_and_the_middle_of_the_orifice_misses() {
    for (end, expected) in [("hole + d", Verdict::Pass), ("hole / 2", Verdict::Miss)] {
        let here = tempfile::tempdir().unwrap();
        let change = |text: &str| {
            let shorter = text.replace("[8.0, 11.0, 15.0, 20.0]", "[10.0]").replace("Out(1800)", "Out(900)");
            shorter
                .replace("\"= -hole - d\"", &format!("\"= -({end})\""))
                .replace("\"= hole + d\"", &format!("\"= {end}\""))
        };
        let rows = rows(here.path(), "orifice-profiles", change);
        let found = verdicts(&rows);
        assert!(found.len() == 1 && found[0].0 == expected, "{found:?}");
    }
}
