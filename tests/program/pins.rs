//! Pinned hashes: `tests/data/hashes.csv` holds the state hash of every scene in `scenes` and `scenes/hard`, under
//! `Verlet` and under `Centred`. A change of a single bit in any of these runs fails this test, which names scene and
//! scheme.
//!
//! This command renews the table:
//!
//! ```sh
//! SILOFLOW_RENEW_HASHES=1 cargo test --test program pins
//! ```
//!
//! A commit that renews the table states why bits have changed. A renewal keeps all columns except the hash. For a new
//! scene it adds rows with the scene's own `until`. Shorten that value by hand, so that the whole test takes at most 20
//! s.
//!
//! | column | content |
//! |---|---|
//! | `scene` | the path below `scenes` |
//! | `scheme` | `Verlet` or `Centred`, set as `integrator`; `LatticeGas` for a scene of the lattice gas, which has no `integrator` |
//! | `until` | end of the run: simulated time in s, or steps for the lattice gas; shortened where the scene would take long |
//! | `set` | further settings, separated by `; ` |
//! | `hash` | the state hash at the end, or `refused CODE` with the error code if the scene cannot use the scheme |
//!
//! `siloflow run scenes/SCENE --set integrator=SCHEME --until UNTIL --set SET` prints the same hash.
//!
//! Limits: the first line names the target of the hashes. The test is skipped on others with a message, although mathematical functions
//! are the same everywhere (`siloflow_dem::math`); `crates/web/node/pins.mjs` compares the same rows in WebAssembly. Three kinds of scenes
//! have no row: `examples/vibrating_wall.ron`, which needs a behaviour that the plain program lacks, studies in
//! `scenes/studies`, and sweeps with their scenes in `scenes/sweeps` and `scenes/validation`.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::time::Instant;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use siloflow::lattice::gas::Gas;
use siloflow::lattice::sites::Sites;
use siloflow::output::summary::lattice;
use siloflow::prelude::*;
use siloflow::scene::load as loading;
use siloflow::scene::loaded::AnyScene;

use crate::{hash, root, scene};

const RENEW: &str = "SILOFLOW_RENEW_HASHES";
const COMMAND: &str = "SILOFLOW_RENEW_HASHES=1 cargo test --test program pins";
const LATTICE: &str = "LatticeGas";

/// A row of the table.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Row {
    scene: String,
    scheme: String,
    until: String,
    set: String,
    pub hash: String,
}

impl Row {
    fn key(&self) -> (String, String) {
        (self.scene.clone(), self.scheme.clone())
    }

    fn settings(&self) -> Vec<(String, String)> {
        let scheme = (self.scheme != LATTICE).then(|| ("integrator".to_owned(), self.scheme.clone()));
        let more = self.set.split("; ").filter_map(|setting| setting.split_once('='));
        let more = more.map(|(key, value)| (key.to_owned(), value.to_owned()));
        more.chain(scheme).chain([("until".to_owned(), self.until.clone())]).collect()
    }

    /// Loads the scene with the settings of the row.
    pub fn load(&self) -> Result<AnyScene, siloflow::text::fault::Fault> {
        loading::any(&scene(&self.scene), &self.settings())
    }

    /// Returns the hash at the end of the run, or the reason why there is none.
    fn found(&self) -> String {
        let one = NonZeroUsize::MIN;
        let registry = Registry::default();
        let run = match self.load() {
            Err(fault) => return format!("refused {}", fault.code()),
            Ok(AnyScene::Lattice(loaded)) => Simulation::of_lattice(&loaded, &registry, one).map(|mut run| {
                run.run();
                lattice::state_hash(run.world().resource::<Sites>(), run.world().resource::<Gas>())
            }),
            Ok(AnyScene::Grains(loaded)) => Simulation::new(&loaded, &registry, one).map(|mut run| {
                run.run();
                hash(&mut run)
            }),
        };
        run.map_or_else(|fault| format!("refused {}", fault.code()), |hash| format!("{hash:016x}"))
    }
}

fn table() -> PathBuf {
    root().join("tests/data/hashes.csv")
}

/// Returns the target triple of this build.
fn target() -> String {
    let arch = std::env::consts::ARCH;
    let os = std::env::consts::OS;
    let environment = [
        (cfg!(target_env = "gnu"), "-gnu"),
        (cfg!(target_env = "musl"), "-musl"),
        (cfg!(target_env = "msvc"), "-msvc"),
    ];
    let environment = environment.into_iter().find(|(is, _)| *is).map_or("", |(_, name)| name);
    let vendor = match os {
        "macos" => "apple",
        "windows" => "pc",
        _ => "unknown",
    };
    format!("{arch}-{vendor}-{os}{environment}")
}

/// Returns the target of the table, and its rows.
fn read() -> (String, Vec<Row>) {
    let text = fs::read_to_string(table()).unwrap();
    let (first, rows) = text.split_once('\n').unwrap();
    let rows = csv::Reader::from_reader(rows.as_bytes()).into_deserialize().collect::<Result<_, _>>().unwrap();
    (first.strip_prefix("# target ").expect("a first line that names the target").to_owned(), rows)
}

fn write(rows: &[Row]) {
    let mut writer = csv::Writer::from_writer(format!("# target {}\n", target()).into_bytes());
    for row in rows {
        writer.serialize(row).unwrap();
    }
    fs::write(table(), writer.into_inner().unwrap()).unwrap();
}

/// Returns the rows, or none if they hold for another target.
pub fn rows_of_this_target() -> Vec<Row> {
    let (pinned_for, rows) = read();
    if pinned_for == target() { rows } else { Vec::new() }
}

/// Returns scene and scheme of every required row, with the scene's own `until`.
fn needed() -> BTreeMap<(String, String), String> {
    let mut needed = BTreeMap::new();
    for folder in ["", "hard/"] {
        for entry in fs::read_dir(scene(folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_none_or(|ending| ending != "ron") {
                continue;
            }
            let name = format!("{folder}{}", path.file_name().unwrap().display());
            let (schemes, until) = match loading::any(&scene(&name), &[]).unwrap() {
                AnyScene::Grains(loaded) => (&["Verlet", "Centred"][..], loaded.scene.until.get().to_string()),
                AnyScene::Lattice(loaded) => (&[LATTICE][..], loaded.scene.until.to_string()),
            };
            needed.extend(schemes.iter().map(|scheme| ((name.clone(), (*scheme).to_owned()), until.clone())));
        }
    }
    needed
}

/// Returns the rows with their current hashes, each with its run time in seconds.
fn rerun(rows: &[Row]) -> Vec<(Row, f64)> {
    let rerun = |row: &Row| {
        let start = Instant::now();
        (Row { hash: row.found(), ..row.clone() }, start.elapsed().as_secs_f64())
    };
    rows.par_iter().with_max_len(1).map(rerun).collect()
}

/// Rewrites the table, with a row for every existing scene, and prints the run time of each.
fn renew(mut rows: Vec<Row>) {
    let mut needed = needed();
    rows.retain(|row| needed.remove(&row.key()).is_some());
    let new = |((scene, scheme), until)| Row { scene, scheme, until, set: String::new(), hash: String::new() };
    rows.extend(needed.into_iter().map(new));
    rows.sort_by(|a, b| (&a.scene, &b.scheme).cmp(&(&b.scene, &a.scheme)));
    let rerun = rerun(&rows);
    for (row, seconds) in &rerun {
        eprintln!("{:<28} {:<10} until {:<8} {seconds:>6.2} s  {}", row.scene, row.scheme, row.until, row.hash);
    }
    write(&rerun.into_iter().map(|(row, _)| row).collect::<Vec<_>>());
}

#[test]
fn every_scene_has_its_pinned_hash() {
    let (pinned_for, rows) = read();
    if std::env::var_os(RENEW).is_some() {
        return renew(rows);
    }
    if pinned_for != target() {
        eprintln!("skipped: the hashes are pinned for {pinned_for}, and this is {}", target());
        return;
    }
    let have: BTreeSet<_> = rows.iter().map(Row::key).collect();
    let needed: BTreeSet<_> = needed().into_keys().collect();
    let mut wrong = String::new();
    for (scene, scheme) in needed.difference(&have) {
        let _ = writeln!(wrong, "scenes/{scene} has no row for {scheme}");
    }
    for (scene, scheme) in have.difference(&needed) {
        let _ = writeln!(wrong, "row for {scheme} of scenes/{scene}, which does not exist");
    }
    for ((now, _), pinned) in rerun(&rows).iter().zip(&rows).filter(|((now, _), pinned)| now.hash != pinned.hash) {
        let Row { scene, scheme, until, set, hash } = pinned;
        let comma = if set.is_empty() { "" } else { ", " };
        let _ =
            writeln!(wrong, "scenes/{scene}, {scheme}, until {until}{comma}{set}: expected {hash}, got {}", now.hash);
    }
    assert!(
        wrong.is_empty(),
        "{wrong}if the change of bits is intended, renew the table and state the reason in the commit:\n  {COMMAND}"
    );
}
