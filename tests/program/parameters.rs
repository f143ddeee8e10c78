//! Parameters of scenes: expressions in the place of numbers, settings of one run, and errors with their places.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde::Deserialize;
use siloflow::lattice_silo::loaded::LoadedLattice;
use siloflow::prelude::*;
use siloflow::scene::check;
use siloflow::text::fault::Fault;
use siloflow::text::source::Source;

use crate::command_line::text;
use crate::{hash, simulation};

const SCENE: &str = r#"(
    parameters: {
        "radius": 0.05, "columns": 3, "angle": 3.0,
        "width": "= 2.2 * columns * radius",
        "slope": "= tan(angle * deg)",
    },
    gravity: (0.0, -9.81), contact: Linear(k: "= 1e7 / 2", damping: Restitution(0.5)), mass: Disc(100.0),
    step: Fixed(1.0e-5), until: 1.0, pictures: None,
    walls: [HalfPlane(point: (0.0, "= radius / 12"), normal: ("= -slope", 1.0))],
    fill: [(low: (0.0, 0.0), high: ("= width", "= width"), spacing: "= 2.2 * radius", radius: Fixed("= radius"),
        count: "= columns ^ 2 - 1")],
)"#;

fn loaded(scene: &str, settings: &[(&str, &str)]) -> Result<Loaded, Fault> {
    let settings: Vec<_> = settings.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
    load::from_text("a.ron", "a", Path::new(""), scene.to_owned(), &settings)
}

/// The scene with the numbers that its expressions should have.
fn written_out() -> String {
    let (_, rest) = SCENE.split_once("},\n").unwrap();
    let slope = -(3.0 * (std::f64::consts::PI / 180.0)).tan();
    let width = (2.2 * 3.0 * 0.05).to_string();
    [
        "= 1e7 / 2|5e6",
        "= radius / 12|0.004166666666666667",
        "= width|W",
        "= 2.2 * radius|0.11000000000000001",
        "= radius|0.05",
        "= columns ^ 2 - 1|8",
    ]
    .iter()
    .filter_map(|pair| pair.split_once('|'))
    .fold(format!("({rest}"), |text, (expression, value)| text.replace(&format!("\"{expression}\""), value))
    .replace("\"= -slope\"", &format!("{slope:?}"))
    .replace('W', &width)
}

#[test]
fn expressions_give_the_run_of_their_numbers_to_the_last_bit() {
    let numbers = written_out();
    assert!(!numbers.contains('='), "{numbers}");
    let [with, without] = [SCENE, &numbers].map(|text| {
        let mut run = simulation(&loaded(text, &[]).unwrap(), 1);
        run.run_steps(200);
        hash(&mut run)
    });
    assert_eq!(with, without);
}

#[test]
fn a_setting_changes_a_parameter_and_all_that_depend_on_it() {
    let scene = loaded(SCENE, &[("parameters.columns", "4"), ("parameters.radius", "\"= 0.1 / 4\"")]).unwrap();
    assert_eq!((scene.grains.len(), scene.grains[0].radius), (15, 0.025));
    assert_eq!(scene.scene.parameters["width"], 2.2 * 4.0 * 0.025);
    // An expression in a setting of another key.
    assert_eq!(loaded(SCENE, &[("until", "\"= 2 * radius\"")]).unwrap().scene.until.get(), 0.1);
    let fault = loaded(SCENE, &[("parameters.colums", "4")]).unwrap_err();
    assert_eq!(fault.code(), "call::set");
    assert!(format!("{:?}", miette::Report::new(fault)).contains("did you mean `columns`?"));
}

/// Code and key of a fault, and the begin of the text at its place in the scene.
fn place<'a>(fault: &'a Fault, scene: &'a str, length: usize) -> (&'a str, Option<&'a str>, &'a str) {
    let (line, column) = fault.line_and_column().unwrap();
    let text = &scene.lines().nth(line - 1).unwrap()[column - 1..];
    (fault.code(), fault.scene_key(), &text[..length.min(text.len())])
}

#[test]
fn faults_behind_and_in_expressions_point_into_the_file() {
    for (from, to, code, key, at, message) in [
        (
            "columns ^ 2",
            "columns / 2",
            "scene::wrong_type",
            "fill[0].count",
            "\"= columns / 2 - 1\")",
            "`0.5` is not of the type",
        ),
        (
            "Fixed(\"= radius\")",
            "Fixed(\"= -radius\")",
            "scene::out_of_range",
            "fill[0].radius.0",
            "\"= -radius\")",
            "greater than 0, got -0.05",
        ),
        ("1e7 / 2", "1e7 / raduis", "scene::expression", "contact.k", "raduis\",", "no parameter `raduis`"),
        // Behind expressions of the same line.
        ("radius: Fixed", "radios: Fixed", "scene::unknown_key", "fill[0].radios", "radios: Fixed", "no such key"),
        ("until: 1.0", "until: -1.0", "scene::out_of_range", "until", "-1.0, pictures", "greater than 0, got -1"),
        // A rule between keys.
        (
            "(\"= width\", \"= width\")",
            "(\"= -width\", \"= width\")",
            "scene::empty_box",
            "fill[0].low",
            "(0.0, 0.0)",
            "below the upper one",
        ),
    ] {
        let scene = SCENE.replacen(from, to, 1);
        let fault = loaded(&scene, &[]).unwrap_err();
        assert_eq!(place(&fault, &scene, at.len()), (code, Some(key), at), "{fault}");
        assert!(fault.to_string().contains(message), "{fault}");
    }
}

#[test]
fn an_expression_without_parameters_is_explained() {
    let scene = SCENE.replacen(SCENE.split_once("gravity").unwrap().0, "(", 1).replacen("= 1e7 / 2", "= 1e7 / 3", 1);
    let fault = loaded(&scene, &[]).unwrap_err();
    assert!(fault.to_string().contains("is an expression, and the scene has no `parameters`"), "{fault}");
    // Text that begins with `=` is allowed there, as it was before there were expressions.
    let titled = written_out().replacen('(', "(title: \"= 1 =\", ", 1);
    assert_eq!(loaded(&titled, &[]).unwrap().scene.title, "= 1 =");
}

#[test]
fn an_unused_parameter_is_a_warning() {
    let unused = |scene: &str| -> Vec<_> {
        let warnings = check::warnings(&loaded(scene, &[]).unwrap());
        warnings.into_iter().filter(|w| w.code == "check::unused_parameter").map(|w| w.message).collect()
    };
    assert_eq!(unused(SCENE), [""; 0]);
    let scene = SCENE.replacen("= -slope", "= -radius", 1);
    assert_eq!(unused(&scene), ["no expression uses the parameter `slope`"]);
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Wind {
    force: f64,
    gusts: u32,
}

impl Behaviour for Wind {
    fn check(&self, _: &Loaded) -> Result<(), String> {
        Err(format!("force {}, gusts {}", self.force, self.gusts))
    }

    fn build(self: Box<Self>, _: &mut App) {}
}

#[test]
fn keys_of_behaviours_may_hold_expressions() {
    let mut registry = Registry::default();
    registry.register::<Wind>("wind");
    let scene = |keys: &str| SCENE.replacen("until", &format!("behaviours: {{\"wind\": ({keys})}}, until"), 1);
    let fault = |scene: &str| registry.of_scene(&loaded(scene, &[]).unwrap()).map(drop).unwrap_err();
    let checked = fault(&scene("force: \"= 10 * radius\", gusts: \"= columns\""));
    assert!(checked.to_string().contains("force 0.5, gusts 3"), "{checked}");
    let scene = scene("force: \"= 10 * radius\", gusts: \"= columns / 2\"");
    let wrong = fault(&scene);
    let expected = ("scene::wrong_type", Some("behaviours.wind.gusts"), "\"= columns / 2\")}");
    assert_eq!(place(&wrong, &scene, expected.2.len()), expected, "{wrong}");
}

#[test]
fn a_lattice_gas_has_parameters_too() {
    let scene = fs::read_to_string(crate::root().join("tests/fuzz/corpus/scene/gas.ron")).unwrap();
    let with = scene.replacen('(', "(parameters: {\"steps\": 7, \"spare\": 1},", 1);
    let settings = [("until".to_owned(), "\"= 2 * steps\"".to_owned())];
    let loaded = LoadedLattice::new(Source::new("gas.ron", "gas", Path::new(""), with), &settings).unwrap();
    assert_eq!(loaded.scene.until, 14);
    let codes: Vec<_> =
        siloflow::lattice_silo::check::warnings(&loaded).into_iter().map(|warning| warning.code).collect();
    assert!(codes.contains(&"check::unused_parameter"), "{codes:?}");
}

fn siloflow(directory: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_siloflow")).args(arguments).current_dir(directory).output().unwrap()
}

#[test]
fn a_run_keeps_its_parameters_and_can_be_repeated_from_its_directory() {
    let here = tempfile::tempdir().unwrap();
    fs::write(here.path().join("a.ron"), SCENE).unwrap();
    let run = |scene: &str, out: &str, more: &[&str]| -> serde_json::Value {
        let arguments = [&["run", scene, "--until", "0.001", "--json", "--quiet", "--out", out], more].concat();
        let output = siloflow(here.path(), &arguments);
        assert!(output.status.success(), "{}", text(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let first = run("a.ron", "first", &["--set", "parameters.angle=2"]);
    assert_eq!(first["parameters"]["angle"], 2.0);
    let kept = fs::read_to_string(here.path().join("first/scene.ron")).unwrap();
    assert!(kept.contains("\"angle\": 2,") && kept.contains("\"= tan(angle * deg)\""), "{kept}");
    let again = run("first/scene.ron", "again", &[]);
    assert_eq!(first["state_hash"], again["state_hash"]);
    assert_ne!(first["state_hash"], run("a.ron", "other", &[])["state_hash"]);
    let explained = siloflow(here.path(), &["explain", "a.ron"]);
    assert!(text(&explained.stdout).contains("parameter columns = 3\n"), "{}", text(&explained.stdout));
    let refused = siloflow(here.path(), &["run", "a.ron", "--set", "parameters.radius=\"= 1 / 0\""]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("division by zero"), "{}", text(&refused.stderr));
}
