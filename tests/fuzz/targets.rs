//! The targets: each takes any text. A fault is shown as the program shows it, because showing has panicked before.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use siloflow::dem::values::LengthUnit;
use siloflow::dem::walls::silo_file;
use siloflow::figures::png;
use siloflow::grains::file::{self, Kind};
use siloflow::lattice_silo::loaded::LoadedLattice;
use siloflow::prelude::*;
use siloflow::scene::check;
use siloflow::scene::loaded::Loaded;
use siloflow::text::encoding::decode;
use siloflow::text::fault::Fault;
use siloflow::text::source::Source;

/// Most particles or sites of a scene that is stepped.
const SMALL: usize = 300;

/// Files that scenes of the corpus name.
fn files() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/files")
}

fn show<T>(result: Result<T, Fault>) -> Option<T> {
    result.map_err(|fault| drop(format!("{fault}\n{:?}", miette::Report::new(fault.clone())))).ok()
}

pub fn scene(text: &str) {
    with_settings(text, &[]);
}

fn with_settings(text: &str, settings: &[(String, String)]) {
    let source = Source::new("mutant.ron", "mutant", &files(), text.to_owned());
    let registry = Registry::default();
    if source.value_of("method").is_some_and(|method| method.starts_with("LatticeGas")) {
        let Some(loaded) = show(LoadedLattice::new(source, settings)) else { return };
        drop(siloflow::lattice_silo::check::warnings(&loaded));
        if loaded.sites.kinds.len() <= 100 * SMALL
            && let Some(mut run) = show(Simulation::of_lattice(&loaded, &registry, NonZeroUsize::MIN))
        {
            run.run_steps(3);
        }
        return;
    }
    let Some(loaded) = show(load::from_text("mutant.ron", "mutant", &files(), text.to_owned(), settings)) else {
        return;
    };
    drop(check::warnings(&loaded));
    if loaded.grains.len() + loaded.fixed.len() + loaded.silo.wall.len() <= SMALL
        && let Some(mut run) = show(Simulation::new(&loaded, &registry, NonZeroUsize::MIN))
    {
        run.run_steps(3);
    }
}

pub fn silo(text: &str) {
    show(silo_file::parse("mutant.dat", text, LengthUnit::Centimetre));
    let bytes: Vec<u8> = text.chars().map(|character| character as u8).collect();
    if let Ok(decoded) = decode(&bytes) {
        show(silo_file::parse("mutant.dat", &decoded, LengthUnit::Centimetre));
    }
}

/// Scenes with shapes, in the plane and in solid space.
static SHAPES: LazyLock<[Loaded; 2]> = LazyLock::new(|| {
    let texts = [include_str!("corpus/scene/shapes-plane.ron"), include_str!("corpus/scene/shapes-solid.ron")];
    texts.map(|text| load::from_text("shapes.ron", "shapes", &files(), text.to_owned(), &[]).unwrap())
});

pub fn grains(text: &str) {
    for (dimension, spins) in [(Dimension::Plane, false), (Dimension::Solid, true)] {
        for shapes in [&[][..], &SHAPES[usize::from(spins)].shapes.facts] {
            show(file::parse("mutant.csv", text, Kind { dimension, spins, shapes }));
        }
    }
}

/// Spheres inside and beside the meshes of the corpus.
const IN_MESH: &str = "(space: Solid, gravity: (0.0, 0.0, -9.81), mass: Sphere(2500.0), step: Fixed(1.0e-5), until: 1.0, on_loss: Continue,
    contact: Linear(k: 1.0e4, damping: Restitution(0.5), tangential: Spring(k: 3.0e3, damping: OfNormal(0.5), friction: 0.5)),
    fill: [(low: (0.0, 0.0, 0.0), high: (0.3, 0.3, 0.3), spacing: 0.1, radius: Fixed(0.05), velocity: (0.0, 0.0, -10.0))],
    walls: [Mesh(file: \"mesh.FORMAT\", unit: Metre)])";

pub fn mesh(text: &str) {
    let directory = tempfile::tempdir().unwrap();
    let as_bytes: Vec<u8> = text.chars().map(|character| character as u8).collect();
    let forms = ["obj", "stl"].into_iter().flat_map(|format| [(format, text.as_bytes()), (format, &as_bytes)]);
    for (format, bytes) in forms {
        std::fs::write(directory.path().join("mesh").with_extension(format), bytes).unwrap();
        let scene = IN_MESH.replace("FORMAT", format);
        let Some(loaded) = show(load::from_text("mutant.ron", "mutant", directory.path(), scene, &[])) else {
            continue;
        };
        drop(check::warnings(&loaded));
        if let Some(mut run) = show(Simulation::new(&loaded, &Registry::default(), NonZeroUsize::MIN)) {
            run.run_steps(3);
        }
    }
}

/// The first line is `PATH=VALUE`, as on the command line.
pub fn setting(text: &str) {
    const SCENE: &str = include_str!("corpus/scene/silo.ron");
    let (path, value) = text.split_once('=').unwrap_or((text, ""));
    with_settings(SCENE, &[(path.trim().to_owned(), value.trim().to_owned())]);
}

pub fn picture(text: &str) {
    let start = std::time::Instant::now();
    drop(png::encode_within(text.to_owned(), std::time::Duration::from_secs(5)));
    assert!(start.elapsed().as_secs() < 5, "{:?}", start.elapsed());
}
