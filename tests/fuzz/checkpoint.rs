//! The target `checkpoint`: a saved state in which bytes of one part are changed, and the file of such a state.

use std::num::NonZeroUsize;
use std::path::Path;

use bolero::TypeGenerator;
use siloflow::dem::persist::Section;
use siloflow::lattice_silo::loaded::LoadedLattice;
use siloflow::output::checkpoint::file::{self, FORMAT, Header};
use siloflow::prelude::*;
use siloflow::text::fault::Fault;
use siloflow::text::source::Source;

/// One change of bytes. Places are shares of the length, in 65,536ths.
#[derive(Clone, Debug, TypeGenerator)]
pub enum Change {
    /// Replaces a byte.
    Byte { at: u16, value: u8 },
    /// Removes some bytes.
    Remove { at: u16, length: u8 },
    /// Repeats some bytes at another place.
    Repeat { from: u16, length: u8, at: u16 },
}

fn changed(bytes: &mut Vec<u8>, change: &Change) {
    let length = bytes.len();
    let place = |share: u16| length * usize::from(share) / 65_536;
    match *change {
        Change::Byte { at, value } => {
            if let Some(byte) = bytes.get_mut(place(at)) {
                *byte = value;
            }
        }
        Change::Remove { at, length: count } => {
            let from = place(at);
            bytes.drain(from..length.min(from + usize::from(count)));
        }
        Change::Repeat { from, length: count, at } => {
            let from = place(from);
            let at = place(at);
            let part = bytes[from..length.min(from + usize::from(count))].to_vec();
            bytes.splice(at..at, part);
        }
    }
}

/// A scene, and its state after some steps.
pub enum Seed {
    Grains(Box<Loaded>, Vec<Section>),
    Gas(Box<LoadedLattice>, Vec<Section>),
}

const ONE: NonZeroUsize = NonZeroUsize::MIN;

/// Shipped scenes with settings, and the steps after which their states are saved: in mid-release, a door that moves and one that is about
/// to be removed, a mesh and a polygon with a hole, a feed that waits, clumps, a wall that forces move.
const GRAINS: [(&str, &[(&str, &str)], u64); 7] = [
    (
        "silo1.ron",
        &[
            ("spawner.count", "20"),
            (
                "contact",
                "Linear(k: 1.0e4, damping: Restitution(0.5), tangential: Spring(k: 3.0e3, damping: OfNormal(0.5), friction: 0.5))",
            ),
        ],
        700,
    ),
    (
        "gated-bin.ron",
        &[
            ("fill[0].count", "40"),
            ("doors", "[(walls: \"gate\", opens: Schedule([(0.001, 0.004)]), how: Move(by: (0.2, 0.0), speed: 20.0))]"),
        ],
        60,
    ),
    ("hard/pressed-door.ron", &[("fill[0].count", "40"), ("door", "(opens: At(1.2e-3))")], 5),
    ("hard/facets.ron", &[("fill[0].count", "20")], 20),
    (
        "fed-hopper.ron",
        &[("feed[0].rate", "Mass(40.0)"), ("feed[0].radius", "Mixture([(0.004, 0.5), (0.003, 0.5)])")],
        40,
    ),
    ("hard/clumps-in-corner.ron", &[("fill[0].count", "20")], 100),
    (
        "hard/lid-loses-bed.ron",
        &[
            ("fill[0].count", "20"),
            ("free_walls[0].from", "0.0"),
            ("free_walls[0].load", "[(0.0, -10.0), (0.01, -20.0)]"),
            ("slopes", "[(name: \"top\", falls: Along((1.0, 0.0)), low: (-9.0, -9.0), high: (9.0, 9.0), from: 0.0)]"),
        ],
        50,
    ),
];

/// Returns the seeds: [`GRAINS`], and a gas before and after its door has opened.
pub fn seeds() -> Vec<Seed> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let owned = |settings: &[(&str, &str)]| -> Vec<(String, String)> {
        settings.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect()
    };
    let grains = GRAINS.iter().map(|(scene, settings, steps)| {
        let loaded = load::load(&root.join(scene), &owned(settings)).unwrap();
        let mut run = Simulation::new(&loaded, &Registry::default(), ONE).unwrap();
        assert_eq!(run.run_steps(*steps), None, "{scene}");
        let saved = run.save().unwrap();
        Seed::Grains(Box::new(loaded), saved)
    });
    let gases = ["AtRest", "At(2)"].into_iter().map(|opens| {
        let source = Source::read(&root.join("funnel-flow.ron")).unwrap();
        let gas = LoadedLattice::new(source, &owned(&[("door.opens", opens)])).unwrap();
        let mut run = Simulation::of_lattice(&gas, &Registry::default(), ONE).unwrap();
        run.run_steps(5);
        let saved = run.save().unwrap();
        Seed::Gas(Box::new(gas), saved)
    });
    grains.chain(gases).collect()
}

/// Restores a changed state and steps it, and reads a changed file. Both may be refused, and neither may panic.
pub fn target(seed: &Seed, part: u8, changes: &[Change]) {
    let (Seed::Grains(_, sections) | Seed::Gas(_, sections)) = seed;
    let mut sections = sections.clone();
    let part = usize::from(part) % sections.len();
    for change in changes {
        changed(&mut sections[part].1, change);
    }
    match seed {
        Seed::Grains(loaded, _) => step(Simulation::restored(loaded, &Registry::default(), ONE, &sections)),
        Seed::Gas(loaded, _) => step(Simulation::restored_lattice(loaded, &Registry::default(), ONE, &sections)),
    }
    let header = Header {
        format: FORMAT,
        version: String::new(),
        program: 0,
        input: 0,
        scene: String::new(),
        steps: 0,
        time: 0.0,
        is_final: false,
        files: siloflow::files::run_files::Manifest::default(),
    };
    let mut bytes = Vec::new();
    file::write(&mut bytes, &header, &sections[part..=part]).unwrap();
    assert!(file::read_from(&bytes).is_ok());
    let whole = bytes.clone();
    for change in changes {
        changed(&mut bytes, change);
    }
    assert!(bytes == whole || file::read_from(&bytes).is_err());
}

/// Does three steps with a state that was not refused.
fn step(run: Result<Simulation, Fault>) {
    if let Ok(mut run) = run {
        let done = run.world().resource::<Clock>().steps;
        run.run_steps(done + 3);
    }
}
