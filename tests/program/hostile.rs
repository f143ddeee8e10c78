//! Hostile input: scenes and files that once took gigabytes, seconds or the process. Each is refused at once with a message that
//! names the key to change, within an address space of 1 GB. Text of a scene reaches terminals and pictures only as text.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use crate::command_line::{siloflow, text};

const BASE: &str =
    "gravity: (0.0, -9.81), contact: Linear(k: 1.0e5, damping: B(0.0)), mass: Disc(100.0), step: Fixed(1.0e-4)";

const GRAIN: &str = "spawner: (point: (0.0, 0.0), velocity: (0.0, 0.0), interval: 1.0, count: 1, radius: Fixed(0.1))";

/// Runs a scene with these keys within an address space of 1 GB and asserts that it takes less than two seconds.
fn run_bounded(directory: &Path, keys: &str) -> Output {
    fs::write(directory.join("a.ron"), format!("({BASE}, {keys})")).unwrap();
    let start = Instant::now();
    let script = "ulimit -v 1000000; exec \"$0\" run a.ron --out run";
    let program = env!("CARGO_BIN_EXE_siloflow");
    let output = Command::new("sh").args(["-c", script, program]).current_dir(directory).output().unwrap();
    assert!(start.elapsed() < Duration::from_secs(2), "{:?}", start.elapsed());
    output
}

/// Asserts that a scene with these keys is refused with a message that has each of the words.
fn assert_refused(keys: &str, words: &[&str]) {
    let here = tempfile::tempdir().unwrap();
    let output = run_bounded(here.path(), keys);
    // The renderer breaks lines.
    let message = text(&output.stderr).replace("\n  │", "");
    let start = message.chars().take(3000).collect::<String>();
    assert_eq!(output.status.code(), Some(2), "{start}");
    assert!(words.iter().all(|word| message.contains(word)) && !message.contains("panicked"), "{words:?}: {start}");
    assert!(message.len() < 20_000, "{}", message.len());
    assert!(!here.path().join("run").exists());
}

#[test]
fn scenes_that_need_too_much_are_refused_at_once_with_the_key_to_change() {
    let fill = "(low: (0.0, 0.0), high: (1800.0, 1800.0), spacing: 1.0, radius: Fixed(0.3), count: 3000000)";
    let block = |high: &str, radius: &str| {
        format!("until: 1.0, fill: [(low: (0.0, 0.0), high: {high}, spacing: 1.0, radius: {radius})]")
    };
    for (keys, words) in [
        (format!("until: 1.0, fill: [{}]", [fill; 10].join(", ")), ["fill[3].count", "10000000"]),
        (block("(1.0e10, 1.0)", "Fixed(0.3)"), ["fill[0].spacing", "1.000e10"]),
        (block("(5.0, 5.0)", "Mixture([])"), ["fill[0].radius", "no sizes"]),
        (format!("until: 1.0, {GRAIN}, pictures: (width: 20000, png: true)"), ["pictures.width", "pixels"]),
        (format!("until: 1.0e9, {GRAIN}, series: (interval: 1e-300)"), ["series.interval", "step"]),
        (format!("until: 1.0e9, {GRAIN}, pictures: (interval: 1e-4)"), ["pictures.interval", "1000000 steps"]),
        ("until: 1.0, grains: (file: \"/dev/zero\")".to_owned(), ["grains.file", "not a regular file"]),
        ("until: 1.0, silo: (file: \"/dev/zero\", unit: Metre)".to_owned(), ["silo.file", "not a regular file"]),
    ] {
        assert_refused(&keys, &words);
    }
}

#[test]
fn long_texts_are_quoted_in_part() {
    let long = |n: usize| "k".repeat(n);
    for (keys, words) in [
        // A long key around many values.
        (
            format!("until: 1.0, {}: (a: [{}])", long(100_000), "1,".repeat(40_000)),
            ["kkkk…: there is no such key", "a.ron:1:"],
        ),
        // An error far to the right.
        (format!("until: 1.0, title: \"{}\", seed: -1", long(70_000)), ["seed: integer is out of bounds", ":70"]),
        (format!("until: \"{}\"", long(100_000)), ["until", "kkkk…"]),
        (format!("until: 1.0, title: {}", long(100_000)), ["title", "a.ron:1:"]),
    ] {
        assert_refused(&keys, &words);
    }
}

#[test]
fn files_larger_than_their_limit_are_not_read() {
    let here = tempfile::tempdir().unwrap();
    // A file with a hole takes no space.
    let large = |name: &str, mebibytes: u64| {
        fs::File::create(here.path().join(name)).unwrap().set_len(mebibytes << 20).unwrap();
    };
    large("large.ron", 5);
    large("large.dat", 65);
    large("large.svg", 65);
    let keys = "until: 1.0, silo: (file: \"large.dat\", unit: Metre)";
    let silo = text(&run_bounded(here.path(), keys).stderr);
    assert!(silo.contains("silo.file") && silo.contains("limit of 64 MiB"), "{silo}");
    for (command, name, limit) in [("run", "large.ron", "4 MiB"), ("render", "large.svg", "64 MiB")] {
        let output = siloflow(here.path(), &[command, name]);
        assert_eq!(output.status.code(), Some(2));
        assert!(text(&output.stderr).contains(limit), "{}", text(&output.stderr));
    }
}

#[test]
fn no_title_makes_a_run_fail() {
    for title in ["a ]]> b", "\\u{1b}[2J\\u{0}", "<!--", "&amp;<script>"] {
        let here = tempfile::tempdir().unwrap();
        let keys =
            format!("until: 0.001, {GRAIN}, title: \"{title}\", pictures: (interval: 0.001, width: 60, png: true)");
        let output = run_bounded(here.path(), &keys);
        assert!(output.status.success(), "{title}: {}", text(&output.stderr));
        let svg = fs::read_to_string(here.path().join("run/frames/00000.svg")).unwrap();
        assert!(!svg.contains(['\u{1b}', '\0']) && !svg.contains("<script") && !svg.contains("<!--"), "{svg}");
        assert!(here.path().join("run/frames/00001.png").exists());
    }
}

#[test]
fn terminals_get_no_commands_from_scenes_and_file_names() {
    let here = tempfile::tempdir().unwrap();
    let name = "\u{1b}[31mred\u{7}.ron";
    for content in ["(\u{1b}[2J: 1)", "(gravity: \u{9b}2J)", "(gravity: (0.0, -1.0), \"\u{1b}]0;title\u{7}\": 3)"] {
        fs::write(here.path().join(name), content).unwrap();
        let output = siloflow(here.path(), &["check", name]);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(!message.contains(['\u{1b}', '\u{7}', '\u{9b}']) && message.contains("\\u{1b}[31mred"), "{message:?}");
    }
    fs::write(here.path().join(name), format!("({BASE}, {GRAIN}, until: 0.001, pictures: None)")).unwrap();
    for arguments in [["check", name], ["explain", name], ["run", name]] {
        let output = siloflow(here.path(), &arguments);
        assert!(output.status.success(), "{}", text(&output.stderr));
        let shown = text(&output.stdout) + &text(&output.stderr);
        assert!(!shown.contains(['\u{1b}', '\u{7}']), "{shown:?}");
    }
}
