//! Runs whose disk forgets what was not synced: a power failure after every operation on a file.
//!
//! After any power failure a run with a summary is complete, and a run with a checkpoint continues to the results of a run without a
//! failure. Without either the run says that it cannot continue.

use std::cell::Cell;
use std::collections::BTreeSet;
use std::fs;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use bevy_app::App;
use bevy_ecs::prelude::*;
use serde::Deserialize;
use serde_json::Value;
use tempfile::TempDir;

use crate::behaviour::{Behaviour, Registry};
use crate::cli::disk_recorder::{Disk, Operation, Tree, make, record, tree};
use crate::cli::run::{resume, run_scene};
use crate::cli::run_path::runnable::{RunOptions, RunResult};
use crate::cli::signals::Signals;
use crate::measure::outputs::OutputApp as _;
use crate::output::verification;
use crate::scene::load;
use crate::writers::rows::Rows;
use crate::writers::run_path::RunPath;
use siloflow_dem::outcome::{End, Failure, Outcome};
use siloflow_dem::persist::PersistApp as _;
use siloflow_dem::step::{Clock, Phase, Step};
use siloflow_files::whole_file;
use siloflow_text::fault::Fault;

/// Every kind of output, within few steps.
const GRAINS: &str = r#"(
    gravity: (0.0, -9.81),
    contact: Linear(k: 1.0e4, damping: B(20.0)),
    step: Fixed(1.0e-3),
    grains: (file: "grains.csv"),
    walls: [Segment(from: (-1.0, 0.0), to: (1.0, 0.0), name: "floor")],
    until: 0.006,
    checkpoint: (every: 0.0, keep: 2),
    series: (interval: 0.002),
    pictures: (interval: 0.003, width: 50),
    data_frames: (interval: 0.003, format: [Vtk, ExtXyz, LammpsDump]),
    profiles: [(axis: Y, low: 0.0, high: 1.0, bins: 2, sample: 0.001, average: 0.002, section: 2.0)],
    wall_bands: [(walls: "floor", low: -0.1, high: 0.1, bins: 1, sample: 0.001, average: 0.002)],
    slopes: [(name: "surface", falls: Along((1.0, 0.0)), low: (-1.0, -1.0), high: (1.0, 1.0))],
    fields: [(grid: XY(low: (-1.0, 0.0), high: (1.0, 1.0), cells: (1, 2)), sample: 0.001, average: 0.002)],
    flow: (cell: 0.5, sample: 0.001, from: 0.0),
    behaviours: {"diary": ()},
)"#;

const LATTICE: &str = "(
    method: LatticeGas(spacing: 0.1, p: 0.2, q: 0.2, b: 0.05, k: 0.05, g: 0.2, h: 0.05),
    outline: [(-0.5, 0.0), (0.5, 0.0), (0.5, 1.0), (-0.5, 1.0)],
    door: (from: (-0.1, 0.0), to: (0.1, 0.0), opens: AtRest),
    rest: (hold: 2),
    fill: (per_site: 6.0),
    until: 6,
    checkpoint: (every: 0.0, keep: 2),
    series: (interval: 2),
    pictures: (interval: 3, width: 50.0),
    flow: (cell: 0.5, sample: 1),
)";

/// Writes two files: rows, and the number of the latest step. A run that is not resumed may be interrupted after a step.
#[derive(Deserialize)]
struct Diary {
    interrupt: Option<u64>,
}

#[derive(Resource)]
struct DiaryRows {
    rows: Option<Rows>,
    saved: Option<u64>,
    interrupt: Option<u64>,
}

fn write_diary(
    run: Option<Res<RunPath>>,
    clock: Res<Clock>,
    mut diary: ResMut<DiaryRows>,
    mut outcome: ResMut<Outcome>,
) {
    let Some(run) = run else { return };
    if diary.rows.is_none() {
        let mut rows = Rows::at(&run.rows("diary.csv"), "step").unwrap();
        if let Some(saved) = diary.saved {
            rows.restore(saved).unwrap();
        }
        diary.rows = Some(rows);
    }
    if let Some(rows) = &mut diary.rows {
        rows.append(format_args!("{}\n", clock.steps), &mut outcome);
    }
    let latest = whole_file::write(&run.file("latest.txt"), clock.steps.to_string().as_bytes());
    if let Err(error) = latest {
        outcome.fail(Failure::Output { path: "latest.txt".to_owned(), reason: error.to_string() });
    }
    if diary.interrupt == Some(clock.steps) && !run.is_resumed {
        outcome.finish(End::Interrupted);
    }
}

impl Behaviour for Diary {
    fn build(self: Box<Self>, app: &mut App) {
        app.run_file("diary.csv").run_file("latest.txt");
        app.insert_resource(DiaryRows { rows: None, saved: None, interrupt: self.interrupt })
            .add_systems(Step, write_diary.in_set(Phase::Observe));
        app.persist_part::<DiaryRows, Option<u64>>(
            // The rows are opened with the first step after a restore.
            |diary| Ok(diary.rows.as_ref().map(Rows::saved).transpose()?.or(diary.saved)),
            |diary, saved| {
                diary.saved = saved;
                Ok(())
            },
        );
    }
}

/// Scenes and run directories of a test, and what its runs need.
struct Place {
    here: TempDir,
    registry: Registry,
    signals: Signals,
}

impl Place {
    fn new() -> Self {
        // In memory a sync takes no time.
        let memory = Path::new("/dev/shm");
        let here = if memory.is_dir() { tempfile::tempdir_in(memory) } else { tempfile::tempdir() };
        let mut registry = Registry::default();
        registry.register::<Diary>("diary");
        let place = Self { here: here.unwrap(), registry, signals: Signals::default() };
        fs::create_dir(place.path("out")).unwrap();
        let grains = "id,radius,mass,x,y,vx,vy\n1,0.04,0.16,0.0,0.039,0.0,0.0\n2,0.04,0.16,0.3,0.5,0.0,0.0\n";
        fs::write(place.path("grains.csv"), grains).unwrap();
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.here.path().canonicalize().unwrap().join(name)
    }

    fn options(&self, force: bool) -> RunOptions<'_> {
        RunOptions {
            registry: &self.registry,
            threads: NonZeroUsize::MIN,
            quiet: true,
            force,
            signals: &self.signals,
            parent: None,
            checkpoint_every: None,
            report: false,
        }
    }

    /// Runs a scene in `out/run`, and returns the operations.
    fn run(&self, text: &str, force: bool) -> Vec<Operation> {
        fs::write(self.path("scene.ron"), text).unwrap();
        let mut scene = load::any(&self.path("scene.ron"), &[]).unwrap();
        record(&self.path("out"), || {
            run_scene(&self.path("out/run"), &mut scene, &self.options(force)).unwrap();
        })
    }

    fn resume(&self, run: &Path) -> Result<RunResult, Fault> {
        resume(run, false, &self.options(false))
    }
}

/// Names of files that differ between runs with the same results.
fn is_volatile(path: &Path) -> bool {
    let has_part = path.extension().is_some_and(|ending| ending == "part");
    has_part || path.starts_with("checkpoints") || path == Path::new(".siloflow")
}

/// Returns the results of a run, without what it has cost.
fn results(run: &Tree) -> Tree {
    let mut results = run.clone();
    results.retain(|path, _| !is_volatile(path));
    if let Some(Some(summary)) = results.get_mut(Path::new("summary.json")) {
        let mut json: Value = serde_json::from_slice(summary).unwrap();
        let keys = json.as_object_mut().unwrap();
        for key in ["performance", "checkpoints", "provenance", "files"] {
            keys.remove(key);
        }
        *summary = json.to_string().into_bytes();
    }
    results
}

/// Returns the part of a tree inside `out/run`; `None` without this directory.
fn run_in(out: &Tree) -> Option<Tree> {
    out.get(Path::new("run"))?;
    let inside = |(path, content): (&PathBuf, &Option<Vec<u8>>)| {
        let name = path.strip_prefix("run").ok().filter(|name| *name != Path::new(""))?;
        Some((name.to_owned(), content.clone()))
    };
    Some(out.iter().filter_map(inside).collect())
}

fn assert_same(found: &Tree, expected: &Tree, case: &str) {
    let found = results(found);
    let expected = results(expected);
    assert_eq!(found.keys().collect::<Vec<_>>(), expected.keys().collect::<Vec<_>>(), "{case}");
    for (path, content) in &expected {
        assert!(found[path] == *content, "{case}: {} differs", path.display());
    }
}

/// Checks what a power failure has left of a run whose results should be `expected`. It may have taken the place of the run `old`.
fn check(place: &Place, left: &Tree, expected: &Tree, old: Option<&Tree>, case: &str) {
    let file = |name: &str| left.get(Path::new(name)).and_then(Option::as_ref);
    let is_old = old.is_some_and(|old| file("scene.ron") == old[Path::new("scene.ron")].as_ref());
    assert!(old.is_none() || file("scene.ron").is_some_and(|scene| !scene.is_empty()), "{case}: both runs are lost");
    let summary = file("summary.json").map(|bytes| serde_json::from_slice::<Value>(bytes).expect(case));
    let here = tempfile::tempdir_in(place.path("")).unwrap();
    let run = here.path().join("run");
    fs::create_dir(&run).unwrap();
    make(&run, left);
    match summary {
        Some(summary) if summary["status"] != "interrupted" => {
            let expected = if is_old { old.unwrap() } else { expected };
            assert_same(left, expected, case);
            let found = verification::verify(&run).unwrap();
            assert!(found.damage.is_empty(), "{case}: {found:?}");
        }
        _ => {
            assert!(!is_old, "{case}: the old run has lost its summary");
            let has_checkpoint = left.keys().any(|path| path.extension().is_some_and(|ending| ending == "checkpoint"));
            match place.resume(&run) {
                Ok(_) => assert_same(&tree(&run), expected, case),
                Err(fault) => {
                    assert!(!has_checkpoint, "{case}: {fault}");
                    assert!(["checkpoint::none", "run::directory"].contains(&fault.code()), "{case}: {fault}");
                }
            }
        }
    }
}

/// Lets the power fail before each operation, in several ways. Returns the number of different states that were left.
fn fail_everywhere(place: &Place, operations: &[Operation], mut disk: Disk, old: Option<&Tree>) -> usize {
    let expected = run_in(&tree(&place.path("out"))).unwrap();
    let mut seen = BTreeSet::new();
    let random = Cell::new(1_u64);
    // A linear congruential generator; its high bits are random enough.
    let mut draw = |below: usize| {
        random.set(random.get().wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407));
        usize::try_from(random.get() >> 33).unwrap() % below
    };
    let mut all = Vec::new();
    for number in 0..=operations.len() {
        for contents in 0..4 {
            for names in [0, 1] {
                all.push((number, disk.after_power_failure(&mut |_| names, &mut |_| contents)));
            }
        }
        for _ in 0..2 {
            let names: Vec<_> = (0..256).map(|_| draw(2)).collect();
            let mut next = names.iter().cycle();
            all.push((number, disk.after_power_failure(&mut |_| *next.next().unwrap(), &mut draw)));
        }
        for (number, state) in all.drain(..) {
            let left = run_in(&state).unwrap_or_default();
            if seen.insert(left.clone()) {
                let next = operations.get(number);
                check(place, &left, &expected, old, &format!("before operation {number} ({})", words(next)));
            }
        }
        operations.get(number).into_iter().for_each(|operation| disk.apply(operation));
    }
    // A file that was written past the record would be missing here.
    let found = run_in(&disk.now()).unwrap();
    let names = |tree: &Tree| tree.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&found), names(&expected));
    for (path, content) in &expected {
        assert!(found[path] == *content, "{} was written in another way", path.display());
    }
    seen.len()
}

fn words(operation: Option<&Operation>) -> String {
    match operation {
        Some(Operation::Write { file, place, bytes }) => format!("Write {} bytes at {place} of {file}", bytes.len()),
        Some(other) => format!("{other:?}"),
        None => "none".to_owned(),
    }
}

#[test]
fn a_power_failure_at_any_moment_of_a_run_leaves_a_run_that_continues() {
    for text in [GRAINS, LATTICE] {
        let place = Place::new();
        let disk = Disk::of(&place.path("out"));
        let operations = place.run(text, false);
        let states = fail_everywhere(&place, &operations, disk, None);
        eprintln!("{} operations, {states} states", operations.len());
        assert!(states > 100, "{states}");
    }
}

#[test]
fn a_power_failure_at_any_moment_of_a_resume_leaves_a_run_that_continues() {
    let place = Place::new();
    place.run(&GRAINS.replace("\"diary\": ()", "\"diary\": (interrupt: Some(4))"), false);
    let summary: Value = serde_json::from_slice(&fs::read(place.path("out/run/summary.json")).unwrap()).unwrap();
    assert_eq!(summary["status"], "interrupted");
    let disk = Disk::of(&place.path("out"));
    let operations = record(&place.path("out"), || {
        place.resume(&place.path("out/run")).unwrap();
    });
    let states = fail_everywhere(&place, &operations, disk, None);
    eprintln!("{} operations, {states} states", operations.len());
    assert!(states > 50, "{states}");
}

#[test]
fn a_power_failure_while_a_run_is_replaced_leaves_the_old_run_or_one_that_continues() {
    let place = Place::new();
    place.run(GRAINS, false);
    let old = run_in(&tree(&place.path("out"))).unwrap();
    let disk = Disk::of(&place.path("out"));
    let operations = place.run(&GRAINS.replace("0.006", "0.004"), true);
    let states = fail_everywhere(&place, &operations, disk, Some(&old));
    eprintln!("{} operations, {states} states", operations.len());
    assert!(states > 100, "{states}");
}
