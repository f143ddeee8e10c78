//! `siloflow plot`: figures of one and of several runs, and refusals.

use std::fs;
use std::path::Path;

use crate::command_line::{siloflow, text};

/// Writes a run directory of a silo whose door opens at 2 s, and from which `rate` grains a second leave until 10 s.
fn made_up(run: &Path, rate: f64) {
    fs::create_dir_all(run).unwrap();
    let row = |n: u32| {
        let time = 0.1 * f64::from(n);
        let out = (rate * (time - 2.0)).max(0.0);
        format!("{time},{out},{},{}\n", 0.5 * out, 300.0 + time)
    };
    let rows: String = (0..=100).map(row).collect();
    fs::write(run.join("series.csv"), format!("time_s,out,out_kg,mean_temperature_k\n{rows}")).unwrap();
    fs::write(run.join("summary.json"), r#"{"rest_time_s": 2.0, "door_open_time_s": 2.0}"#).unwrap();
}

fn assert_refused(here: &Path, arguments: &[&str], words: &[&str]) {
    let output = siloflow(here, &[&["plot"], arguments].concat());
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
    for word in words {
        assert!(said.contains(word), "{arguments:?}: {said}");
    }
}

#[test]
fn a_discharge_has_its_rate_by_number_and_mass() {
    let here = tempfile::tempdir().unwrap();
    made_up(&here.path().join("run"), 40.0);
    let output = siloflow(here.path(), &["plot", "run"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    for name in ["discharge", "grains", "mean_temperature_k"] {
        for ending in ["svg", "png"] {
            let file = format!("run/plots/{name}.{ending}");
            assert!(said.contains(&file) && here.path().join(&file).is_file(), "{said}");
        }
    }
    let svg = fs::read_to_string(here.path().join("run/plots/discharge.svg")).unwrap();
    for words in [
        "mean rate 40.000 grains/s",
        "mean rate 20.000 kg/s",
        "at rest, door opens",
        r#"data-clock="run""#,
        r#"data-to="10""#,
    ] {
        assert!(svg.contains(words), "{words}");
    }
    assert_refused(here.path(), &["run"], &["exists", "--force"]);
    assert!(siloflow(here.path(), &["plot", "run", "--force", "--what", "discharge"]).status.success());
}

#[test]
fn figures_of_several_runs_have_a_curve_for_each() {
    let here = tempfile::tempdir().unwrap();
    made_up(&here.path().join("slow"), 20.0);
    made_up(&here.path().join("fast"), 40.0);
    made_up(&here.path().join("other/fast"), 40.0);
    assert_refused(here.path(), &["slow", "fast"], &["--out"]);
    let output = siloflow(here.path(), &["plot", "slow", "fast", "other/fast", "--out", "plots"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let svg = fs::read_to_string(here.path().join("plots/discharge.svg")).unwrap();
    for words in [
        ">slow<",
        ">fast<",
        ">other/fast<",
        "since the door opened",
        "mean rate 20.000 grains/s",
        r#"data-clock="opening""#,
    ] {
        assert!(svg.contains(words), "{words}");
    }
}

#[test]
fn a_figure_takes_a_size_letters_names_and_a_title() {
    let here = tempfile::tempdir().unwrap();
    made_up(&here.path().join("slow"), 20.0);
    made_up(&here.path().join("fast"), 40.0);
    let call = ["plot", "slow", "fast", "--what", "out", "--out", "plots", "--size", "260x200", "--font-size", "6.5"];
    let names = ["--label", "narrow <1>", "--label", "wide", "--title", "Two outlets"];
    let output = siloflow(here.path(), &[&call[..], &names].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let svg = fs::read_to_string(here.path().join("plots/out.svg")).unwrap();
    // Half of the usual size, with 14 px for the title.
    for words in [">narrow &lt;1&gt;<", ">wide<", ">Two outlets<", r#"width="260" height="214""#] {
        assert!(svg.contains(words), "{words}: {svg}");
    }
    assert!(!svg.contains(">fast<"), "{svg}");
}

#[test]
fn a_killed_run_is_drawn_up_to_its_last_whole_row() {
    let here = tempfile::tempdir().unwrap();
    made_up(&here.path().join("run"), 40.0);
    fs::remove_file(here.path().join("run/summary.json")).unwrap();
    let series = here.path().join("run/series.csv");
    let whole = fs::read_to_string(&series).unwrap();
    fs::write(&series, &whole[..whole.len() - 5]).unwrap();
    let output = siloflow(here.path(), &["plot", "run", "--what", "out"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(fs::read_to_string(here.path().join("run/plots/out.svg")).unwrap().contains(r#"data-to="9.9"#));
}

#[test]
fn wrong_calls_are_refused_and_leave_nothing() {
    let here = tempfile::tempdir().unwrap();
    made_up(&here.path().join("run"), 40.0);
    fs::write(here.path().join("file"), "").unwrap();
    assert_refused(here.path(), &[], &["RUNS", "siloflow plot"]);
    assert_refused(here.path(), &["nowhere"], &["there is no run directory nowhere", "siloflow run"]);
    assert_refused(here.path(), &["file"], &["file is not a directory"]);
    assert_refused(here.path(), &["."], &["no series.csv"]);
    assert_refused(here.path(), &["run", "--what", "dischrge"], &["did you mean `discharge`?"]);
    assert_refused(here.path(), &["run", "--what", "walls"], &["nothing to draw"]);
    assert_refused(here.path(), &["run", "--out", "file"], &["file"]);
    assert_refused(here.path(), &["run", "--size", "640"], &["--size", "for example 520x400"]);
    assert_refused(here.path(), &["run", "--size", "nanx400"], &["from 100 to 4000 px"]);
    assert_refused(here.path(), &["run", "--font-size", "0"], &["from 4 to 100 px"]);
    assert_refused(here.path(), &["run", "--size", "200x150"], &["letters of 13 px", "at least 208x169"]);
    assert_refused(here.path(), &["run", "--label", "a"], &["1 of --label", "several"]);
    assert_refused(here.path(), &["run", "run", "--label", "a", "--out", "p"], &["1 of --label for 2"]);
    fs::write(here.path().join("run/profiles.csv"), "profile,to_s\n1\n").unwrap();
    assert_refused(here.path(), &["run"], &["profiles.csv"]);
    assert!(!here.path().join("run/plots").exists());
}
