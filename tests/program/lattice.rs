//! The lattice gas as users see it: run directories, messages, behaviours.

use std::fs;

use serde::Deserialize;
use siloflow::lattice::gas::Gas;
use siloflow::lattice::sites::Sites;
use siloflow::lattice_silo::loaded::LoadedLattice;
use siloflow::prelude::*;
use siloflow::text::source::Source;

use crate::command_line::siloflow;
use crate::root;

const SMALL: &str = "(
    method: LatticeGas(spacing: 0.01, p: 0.2, q: 0.2, b: 0.05, k: 0.05, g: 0.2, h: 0.05),
    outline: [(-0.2, 0.0), (0.2, 0.0), (0.2, 0.5), (-0.2, 0.5)],
    door: (from: (-0.2, 0.0), to: (0.2, 0.0)),
    fill: (per_site: 6.0),
    rest: (hold: 10),
    until: 5000,
    flow: (cell: 0.05, sample: 5.0),
    pictures: (interval: 200),
)";

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn run_directory_is_complete_and_every_particle_is_accounted_for() {
    let here = tempfile::tempdir().unwrap();
    fs::write(here.path().join("small.ron"), SMALL).unwrap();
    let done = siloflow(here.path(), &["run", "small.ron", "--png", "--threads", "2"]);
    assert_eq!(done.status.code(), Some(0), "{}", text(&done.stderr));
    let out = here.path().join("out/small");
    let summary: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(out.join("summary.json")).unwrap()).unwrap();
    assert_eq!((summary["status"].as_str(), summary["method"].as_str()), (Some("empty"), Some("LatticeGas")));
    let particles = |what: &str| summary["particles"][what].as_u64().unwrap();
    assert_eq!((particles("entered"), particles("inside")), (particles("out"), 0));
    assert_eq!((summary["rest_step"].as_u64(), summary["door_open_step"].as_u64()), (Some(10), Some(10)));
    assert_eq!(summary["empty_step"], summary["steps"]);
    let series = fs::read_to_string(out.join("series.csv")).unwrap();
    assert!(series.starts_with("step,entered,inside,out,") && series.lines().count() > 10);
    assert!(fs::read_to_string(out.join("flow.csv")).unwrap().contains("vy_m_per_step"));
    assert_eq!(fs::read_to_string(out.join("state.csv")).unwrap(), "x_m,y_m,state\n");
    for picture in ["frames/00000.svg", "frames/00000.png", "frames/00001.svg"] {
        assert!(out.join(picture).exists(), "{picture}");
    }
    // A run from the directory gives the same result for any number of threads.
    let again = siloflow(&out, &["run", "scene.ron", "--out", "again", "--json"]);
    let again: serde_json::Value = serde_json::from_str(&text(&again.stdout)).unwrap();
    assert_eq!(again["state_hash"], summary["state_hash"]);
}

#[test]
fn check_and_explain_describe_a_lattice_scene() {
    let check = siloflow(root(), &["check", "scenes/mass-flow.ron"]);
    let said = text(&check.stdout);
    assert!(said.contains("35047 sites") && said.contains("no warnings"), "{said}");
    let gas = siloflow(root(), &["check", "scenes/mass-flow.ron", "--set", "method.g=0.03", "--set", "method.h=0.0"]);
    let said = text(&gas.stdout);
    assert!(said.contains("check::all_gas") && said.contains("check::stuck_particles"), "{said}");
    let explained = |settings: &[&str]| {
        let arguments = [&["explain", "scenes/mass-flow.ron"], settings].concat();
        text(&siloflow(root(), &arguments).stdout)
    };
    let base = explained(&[]);
    assert!(base.contains("stop_at_walls") && base.contains("trickle_down"), "{base}");
    // Neither systems of grains nor systems of a rule that is switched off.
    assert!(!base.contains("contact") && !base.contains("neighbours") && !base.contains("store"), "{base}");
    let less = explained(&["--set", "method.b=0.0", "--set", "method.h=0.0"]);
    assert!(!less.contains("stop_at_walls") && !less.contains("trickle_down"), "{less}");
    let grains = text(&siloflow(root(), &["explain", "scenes/silo1.ron"]).stdout);
    assert!(!grains.contains("lattice"), "{grains}");
}

#[test]
fn closed_outline_gives_the_same_silo() {
    let outlines = [
        "(-0.2, 0.0), (0.2, 0.0), (0.2, 0.5), (-0.2, 0.5)",
        "(-0.2, 0.0), (0.2, 0.0), (0.2, 0.0), (0.2, 0.5), (-0.2, 0.5), (-0.2, 0.0)",
    ];
    let [open, closed] = outlines.map(|outline| {
        let source = Source::new("small.ron", "small", root(), SMALL.to_owned());
        let loaded = LoadedLattice::new(source, &[("outline".to_owned(), format!("[{outline}]"))]).unwrap();
        loaded.sites.edges.iter().map(|edge| (edge.site, edge.blocked, edge.reflection)).collect::<Vec<_>>()
    });
    assert_eq!(open, closed);
}

#[test]
fn method_of_a_scene_cannot_be_set() {
    let method = "method=LatticeGas(spacing: 0.01, p: 0.2, q: 0.2, b: 0.05, k: 0.05, g: 0.2, h: 0.05)";
    let refused = siloflow(root(), &["check", "scenes/silo1.ron", "--set", method]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("scene::method"), "{}", text(&refused.stderr));
}

#[test]
fn study_writes_its_tables_and_figures_and_reports_errors_before_it_runs() {
    let here = tempfile::tempdir().unwrap();
    fs::write(here.path().join("small.ron"), SMALL.replace("until: 5000", "until: 120")).unwrap();
    let study = |silos: &str, seeds: &str, variants: &str, pictures: &str| {
        let plan = format!("(silos: {{{silos}}}, seeds: {seeds}, variants: {variants}, pictures: {pictures})");
        fs::write(here.path().join("study.ron"), plan).unwrap();
        let done = siloflow(here.path(), &["study", "study.ron", "--out", "out", "--quiet"]);
        (done.status.code(), text(&done.stderr))
    };
    let small = r#""small silo": "small.ron""#;
    for (arguments, key) in [
        ((small, "[1]", "[()]", "[0]"), "seeds"),
        ((small, "[1, 1]", "[()]", "[0]"), "seeds"),
        ((small, "[1, 2]", "[(), ()]", "[0]"), "variants[1]"),
        ((small, "[1, 2]", "[(p: 7.0)]", "[0]"), "variants[0].p"),
        ((small, "[1, 2]", "[()]", "[50, 0]"), "pictures"),
        ((r#""a/b": "small.ron""#, "[1, 2]", "[()]", "[0]"), "silos.a/b"),
        ((r#""a": "missing.ron""#, "[1, 2]", "[()]", "[0]"), "silos.a"),
    ] {
        let (silos, seeds, variants, pictures) = arguments;
        let (code, said) = study(silos, seeds, variants, pictures);
        assert_eq!(code, Some(2), "{said}");
        assert!(said.contains(key) && said.contains("study::plan"), "{key}: {said}");
        assert!(!here.path().join("out").exists(), "{key}");
    }
    let (code, said) = study(small, "[1, 2]", "[(), (g: 0.95)]", "[0, 50]");
    assert_eq!(code, Some(0), "{said}");
    for name in ["claims.md", "figures.csv", "sheet-small-silo-1.png", "vectors.svg", "thrown.png"] {
        assert!(here.path().join("out").join(name).exists(), "{name}");
    }
    let claims = fs::read_to_string(here.path().join("out/claims.md")).unwrap();
    // The runs are too short for most observables. The table lists these as not measured.
    assert!(claims.contains("not measured") && claims.contains("rho0(g = 0.95) > rho0(base)"), "{claims}");
    assert_eq!(fs::read_to_string(here.path().join("out/figures.csv")).unwrap().lines().count(), 5);
}

#[test]
fn rest_can_be_defined_by_a_constant_mean_height() {
    let settings = [("rest", "(hold: 50, drift: 0.002, stop: true)")].map(|(k, v)| (k.to_owned(), v.to_owned()));
    let source = Source::new("small.ron", "small", root(), SMALL.to_owned());
    let loaded = LoadedLattice::new(source, &settings).unwrap();
    let mut simulation = Simulation::of_lattice(&loaded, &Registry::default(), std::num::NonZeroUsize::MIN).unwrap();
    assert_eq!(simulation.run(), End::AtRest);
    let steps = simulation.world().resource::<Clock>().steps;
    // Several spans of 50 steps: a fresh fill falls.
    assert!(steps >= 100 && steps.is_multiple_of(50), "{steps}");
}

/// Adds one particle at the top in every step.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Drip {
    x: f64,
    y: f64,
}

impl Behaviour for Drip {
    fn lives_on_lattice(&self) -> bool {
        true
    }

    fn build(self: Box<Self>, app: &mut App) {
        let drip = move |sites: Res<Sites>, mut gas: ResMut<Gas>| {
            if let Some(site) = sites.nearest(Vector::new(self.x, self.y)) {
                gas.add(site, 4);
            }
        };
        app.add_systems(Step, drip.in_set(Phase::Spawn));
    }
}

#[derive(Deserialize)]
struct ForGrains {}

impl Behaviour for ForGrains {
    fn build(self: Box<Self>, _: &mut App) {}
}

#[test]
fn behaviour_works_on_the_lattice_if_it_supports_it() {
    let mut registry = Registry::default();
    registry.register::<Drip>("drip").register::<ForGrains>("for_grains");
    let scene = |behaviours: &str| {
        let settings = [("door.opens", "Never"), ("fill.per_site", "1.0"), ("behaviours", behaviours)];
        let settings = settings.map(|(k, v)| (k.to_owned(), v.to_owned()));
        LoadedLattice::new(Source::new("small.ron", "small", root(), SMALL.to_owned()), &settings).unwrap()
    };
    let loaded = scene(r#"{"drip": (x: 0.0, y: 0.5)}"#);
    let mut simulation = Simulation::of_lattice(&loaded, &registry, std::num::NonZeroUsize::MIN).unwrap();
    simulation.run_steps(0);
    let before = simulation.world().resource::<Gas>().entered();
    simulation.run_steps(20);
    let gas = simulation.world().resource::<Gas>();
    assert!(gas.entered() > before + 10, "{before} {}", gas.entered());
    assert_eq!(gas.count(), gas.inside());
    let fault = registry.of_lattice(&scene(r#"{"for_grains": ()}"#)).map(|_| ()).unwrap_err();
    assert_eq!(fault.code(), "scene::behaviour");
}
