//! Columns, values and files of behaviours appear in every output, survive an interruption, and cost nothing where no output is due.

use std::collections::HashMap;
use std::f64::consts::PI;
use std::ffi::OsString;
use std::fs;
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use serde::{Deserialize, Serialize};
use serde_json::Value;
use siloflow::files::frames::Frame;
use siloflow::files::frames::reader::FrameReader;
use siloflow::lattice::gas::Gas;
use siloflow::prelude::*;

/// Gives each grain a number, and registers outputs in every way.
#[derive(Deserialize)]
struct Marks {}

#[derive(Component, Serialize, Deserialize)]
struct Mark(f64);

fn mark(mut commands: Commands, new: Query<(Entity, &GrainId), (With<Grain>, Without<Mark>)>) {
    for (grain, id) in &new {
        commands.entity(grain).insert(Mark(1.5 * f64::from(id.number())));
    }
}

fn areas<V: Space>(particles: Particles<V>) -> Vec<f64> {
    (0..particles.len()).map(|row| PI * particles.radius(row) * particles.radius(row)).collect()
}

fn kinetic_energy<V: Space>(motion: Motion<V>) -> f64 {
    motion.grains().map(|row| motion.kinetic_energy(row)).sum()
}

fn marked(grains: Query<&Mark>) -> f64 {
    grains.iter().count() as f64
}

impl Behaviour for Marks {
    fn lives_in(&self, _: Dimension) -> bool {
        true
    }

    fn build(self: Box<Self>, app: &mut App) {
        app.persist_component::<Mark>().add_systems(Step, mark.in_set(Phase::Spawn));
        app.grain_column::<Mark>("mark", "", |mark| mark.0)
            .column_label("mark", "a <mark>, & \"more\"")
            .column_scale("mark", Scale { from: 0.0, to: 30.0, palette: Palette::BlueRed })
            .series_column("marked", "grains", marked)
            .summary_value("marked", "grains", marked);
        match Dimension::of_world(app.world()) {
            Dimension::Plane => {
                app.grain_column_from("area", "m^2", areas::<Plane>);
                app.series_column("moving_j", "J", kinetic_energy::<Plane>);
            }
            Dimension::Solid => {
                app.grain_column_from("area", "m^2", areas::<Solid>);
                app.series_column("moving_j", "J", kinetic_energy::<Solid>);
            }
        }
    }
}

/// Fails once, at a step.
#[derive(Deserialize)]
struct Breaks(u64);

static HAS_BROKEN: AtomicBool = AtomicBool::new(false);

impl Behaviour for Breaks {
    fn build(self: Box<Self>, app: &mut App) {
        let breaks = move |clock: Res<Clock>, mut outcome: ResMut<Outcome>| {
            if clock.steps == self.0 && !HAS_BROKEN.swap(true, Ordering::Relaxed) {
                outcome.fail(Failure::Behaviour("broken".to_owned()));
            }
        };
        app.add_systems(Step, breaks.in_set(Phase::Control));
    }
}

/// Counts how often its columns are computed.
#[derive(Deserialize)]
struct Counts {}

static CALLS: [AtomicUsize; 2] = [AtomicUsize::new(0), AtomicUsize::new(0)];

fn count(place: usize) {
    CALLS[place].fetch_add(1, Ordering::Relaxed);
}

impl Behaviour for Counts {
    fn build(self: Box<Self>, app: &mut App) {
        let rows = |_: Query<&GrainId>| {
            count(0);
            0.0
        };
        let frames = |_: Query<&GrainId>| {
            count(1);
            Vec::new()
        };
        app.series_column("calls", "", rows).grain_column_from("calls", "", frames);
    }
}

/// Registers a name of its scene.
#[derive(Deserialize)]
struct Named(String);

impl Behaviour for Named {
    fn build(self: Box<Self>, app: &mut App) {
        let (name, file) = self.0.split_once('+').unwrap_or((&self.0, "named.csv"));
        app.grain_column::<Mass>(name, "kg", |mass| mass.0).series_column(name, "", || 0.0).run_file(file);
    }
}

/// Writes a file of its own.
#[derive(Deserialize)]
struct Writes {}

impl Behaviour for Writes {
    fn build(self: Box<Self>, app: &mut App) {
        let write = |clock: Res<Clock>, run: Option<Res<RunPath>>| {
            if let Some(run) = run {
                fs::write(run.file("own.csv"), format!("{}\n", clock.steps)).unwrap();
            }
        };
        app.run_file("own.csv").add_systems(Step, write.in_set(ObserveStage::Write));
    }
}

/// A column of a lattice gas.
#[derive(Deserialize)]
struct Crowd {}

impl Behaviour for Crowd {
    fn lives_on_lattice(&self) -> bool {
        true
    }

    fn build(self: Box<Self>, app: &mut App) {
        fn inside(gas: Res<Gas>) -> f64 {
            gas.inside() as f64
        }
        app.series_column("crowd", "particles", inside).summary_value("crowd", "particles", inside);
    }
}

fn registry() -> Registry {
    let mut registry = Registry::default();
    registry
        .register::<Marks>("marks")
        .register::<Breaks>("breaks")
        .register::<Counts>("counts")
        .register::<Named>("named")
        .register::<Writes>("writes")
        .register::<Crowd>("crowd");
    registry
}

fn call(arguments: &[&str]) -> bool {
    exit_code(arguments) == ExitCode::SUCCESS
}

fn exit_code(arguments: &[&str]) -> ExitCode {
    siloflow::cli::run_with(&registry(), ["siloflow"].iter().chain(arguments).map(OsString::from))
}

/// Runs a scene into `out` and returns whether it succeeded.
fn run(out: &Path, scene: &str, behaviours: &str, settings: &[&str]) -> bool {
    let scene = crate::scene(scene).display().to_string();
    let behaviours = format!("behaviours={behaviours}");
    let out = out.display().to_string();
    let mut arguments = vec!["run", &scene, "--quiet", "--out", &out, "--set", &behaviours];
    for setting in settings {
        // Options have no spaces.
        arguments.extend(if setting.starts_with("--") { setting.split(' ').collect() } else { vec!["--set", setting] });
    }
    call(&arguments)
}

fn summary(run: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(run.join("summary.json")).unwrap()).unwrap()
}

/// The columns of `series.csv` by name.
fn series(run: &Path) -> HashMap<String, Vec<f64>> {
    let mut rows = csv::Reader::from_path(run.join("series.csv")).unwrap();
    let names = rows.headers().unwrap().clone();
    let rows: Vec<_> = rows.records().map(Result::unwrap).collect();
    let column = |place: usize| rows.iter().map(|row| row[place].parse().unwrap()).collect();
    names.iter().enumerate().map(|(place, name)| (name.to_owned(), column(place))).collect()
}

fn frames(run: &Path) -> (FrameReader, Vec<Frame>) {
    let path = run.join("frames.bin");
    let frames = FrameReader::open(&path).unwrap().map(Result::unwrap).collect();
    (FrameReader::open(&path).unwrap(), frames)
}

const PLANE: [&str; 3] =
    ["spawner.count=12", "until=2.1", "data_frames=(interval: 0.37, format: [Vtk, ExtXyz, LammpsDump])"];

#[test]
fn columns_are_in_every_output_in_both_spaces() {
    let solid = ["until=0.02", "data_frames=(interval: 0.01, format: [Vtk, ExtXyz, LammpsDump])"];
    for (scene, settings) in [("silo1-mixture.ron", &PLANE[..]), ("silo3d.ron", &solid)] {
        let here = tempfile::tempdir().unwrap();
        let out = here.path().join("run");
        assert!(run(&out, scene, "{\"marks\": ()}", settings));
        let (reader, frames) = frames(&out);
        assert_eq!(reader.header.columns.iter().map(|column| &*column.name).collect::<Vec<_>>(), ["mark", "area"]);
        let [mark, area] = &reader.header.columns[..] else { unreachable!() };
        assert_eq!((&*mark.label, &*mark.behaviour, &*area.unit), ("a <mark>, & \"more\"", "marks", "m^2"));
        assert_eq!(mark.scale, Some(Scale { from: 0.0, to: 30.0, palette: Palette::BlueRed }));
        let mut marks = 0;
        for frame in &frames {
            let grains = frame.table("grains").unwrap();
            let numbers = ["radius", "mark", "area"].map(|name| grains.floats(name).unwrap());
            for (row, (id, kind)) in grains.whole("id").unwrap().iter().zip(grains.whole("kind").unwrap()).enumerate() {
                let [radius, mark, area] = numbers.map(|column| column[row]);
                assert_eq!(area, PI * radius * radius);
                // A grain that has just been released is marked one step later.
                assert!(mark == 1.5 * *id as f64 || mark.is_nan(), "{id}: {mark}");
                assert!(kind == 0 || mark.is_nan(), "{id} of kind {kind}: {mark}");
                marks += usize::from(mark.is_finite());
            }
        }
        assert!(marks > 10, "{scene}: {marks}");
        let series = series(&out);
        let last = |name: &str| *series[name].last().unwrap();
        assert_eq!(last("marked"), last("inside"));
        assert!(last("marked") > 5.0);
        for (moving, (kinetic, rotational)) in
            series["moving_j"].iter().zip(series["kinetic_j"].iter().zip(&series["rotational_j"]))
        {
            assert!((moving - kinetic - rotational).abs() <= 1e-12 * kinetic, "{moving} {kinetic} {rotational}");
        }
        let value = &summary(&out)["behaviours"]["marks"]["marked"];
        assert_eq!((value["value"].as_f64().unwrap(), &value["unit"]), (last("marked"), &Value::from("grains")));
        for (file, name) in
            [("frames.xyz", ":mark:R:1"), ("frames.dump", " mark "), ("vtk/grains-00000.vtp", "\"mark\"")]
        {
            let bytes = fs::read(out.join(file)).unwrap();
            assert!(bytes.windows(name.len()).any(|part| part == name.as_bytes()), "{file}");
        }
    }
}

#[test]
fn a_resumed_run_has_the_same_columns() {
    let here = tempfile::tempdir().unwrap();
    let straight = here.path().join("straight");
    let broken = here.path().join("broken");
    HAS_BROKEN.store(true, Ordering::Relaxed);
    let behaviours = "{\"marks\": (), \"breaks\": (1300)}";
    assert!(run(&straight, "silo1-mixture.ron", behaviours, &PLANE));
    HAS_BROKEN.store(false, Ordering::Relaxed);
    let settings = [&PLANE[..], &["--checkpoint-every 0.00001"]].concat();
    assert!(!run(&broken, "silo1-mixture.ron", behaviours, &settings));
    assert_eq!(summary(&broken)["failure"], "broken");
    assert!(call(&["run", "--quiet", "--resume", &broken.display().to_string()]));
    for file in ["series.csv", "frames.bin", "frames.xyz", "frames.dump", "vtk/grains.pvd", "state.csv"] {
        let [one, other] = [&straight, &broken].map(|run| fs::read(run.join(file)).unwrap());
        assert!(one == other, "{file} differs");
    }
    assert_eq!(summary(&broken)["behaviours"], summary(&straight)["behaviours"]);
}

#[test]
fn columns_are_computed_for_rows_and_frames_only() {
    let here = tempfile::tempdir().unwrap();
    let out = here.path().join("run");
    for calls in &CALLS {
        calls.store(0, Ordering::Relaxed);
    }
    assert!(run(&out, "silo1-mixture.ron", "{\"counts\": ()}", &["until=1.0", "data_frames=(interval: 0.21)"]));
    let counts = [series(&out)["time_s"].len(), frames(&out).1.len()];
    assert_eq!(CALLS.each_ref().map(|calls| calls.load(Ordering::Relaxed)), counts);
    assert!(counts[0] > 10 && counts[1] == 6, "{counts:?}");
    // Without frames the column of grains is not computed.
    assert!(run(
        &here.path().join("none"),
        "silo1-mixture.ron",
        "{\"counts\": ()}",
        &["until=1.0", "pictures=None", "data_frames=None"]
    ));
    assert_eq!(CALLS[1].load(Ordering::Relaxed), counts[1]);
}

#[test]
fn wrong_names_are_refused_and_leave_nothing() {
    let here = tempfile::tempdir().unwrap();
    for name in
        ["radius", "kinetic_energy", "time_s", "Temperature", "", "a b", "mark", "fine+series.csv", "fine+../up"]
    {
        let behaviours = format!("{{\"marks\": (), \"named\": ({name:?})}}");
        for command in ["run", "check"] {
            let scene = crate::scene("silo1.ron").display().to_string();
            let set = format!("behaviours={behaviours}");
            let out = here.path().join("run").display().to_string();
            let mut arguments = vec![command, &scene, "--set", &set];
            if command == "run" {
                arguments.extend(["--out", &out]);
            }
            assert_eq!(exit_code(&arguments), ExitCode::from(2), "{command} {name}");
        }
        assert_eq!(fs::read_dir(here.path()).unwrap().count(), 0, "{name}");
    }
    let settings = [("behaviours".to_owned(), "{\"marks\": (), \"named\": (\"mark\")}".to_owned())];
    let loaded = load::load(&crate::scene("silo1.ron"), &settings).unwrap();
    let fault = Simulation::new(&loaded, &registry(), std::num::NonZeroUsize::MIN).map(|_| ()).unwrap_err();
    assert_eq!((fault.code(), fault.scene_key()), ("behaviour::output", Some("behaviours.named")));
    assert!(fault.to_string().contains("`marks`"), "{fault}");
}

#[test]
fn files_of_behaviours_go_with_their_run() {
    let here = tempfile::tempdir().unwrap();
    let out = here.path().join("run");
    let settings = ["until=0.01", "pictures=None"];
    assert!(run(&out, "silo1.ron", "{\"writes\": ()}", &settings));
    assert_eq!(fs::read_to_string(out.join("own.csv")).unwrap(), "10\n");
    fs::write(out.join("notes.txt"), "mine").unwrap();
    // A run that stops before its first step changes nothing.
    assert!(!run(&out, "silo1.ron", "{\"writes\": (), \"named\": (\"id\")}", &["--force"]));
    assert!(out.join("own.csv").exists());
    // A run without the behaviour removes its file, and keeps files that nobody declared.
    assert!(run(&out, "silo1.ron", "{}", &[&settings[..], &["--force"]].concat()));
    assert!(!out.join("own.csv").exists());
    assert_eq!(fs::read_to_string(out.join("notes.txt")).unwrap(), "mine");
    assert!(run(&out, "silo1.ron", "{\"writes\": ()}", &["until=0.02", "pictures=None", "--force"]));
    assert_eq!(fs::read_to_string(out.join("own.csv")).unwrap(), "20\n");
    assert_eq!(fs::read_dir(here.path()).unwrap().count(), 1);
}

#[test]
fn lattice_gases_have_columns_too() {
    let here = tempfile::tempdir().unwrap();
    let out = here.path().join("run");
    assert!(run(&out, "funnel-flow.ron", "{\"crowd\": ()}", &["until=50", "pictures=None"]));
    let series = series(&out);
    assert!(series["crowd"] == series["inside"] && series["crowd"].len() == 6);
    assert_eq!(summary(&out)["behaviours"]["crowd"]["crowd"]["value"].as_f64(), series["crowd"].last().copied());
}
