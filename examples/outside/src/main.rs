//! Behaviours in a crate outside siloflow: air drag, heat conduction at contacts, a cohesive contact law, bonds that remember, an
//! attraction in addition to any contact law, grains that break, a feeder that follows the level, and a magnet. Each has its own file. Tests compare
//! them with closed forms; `mill.rs` tests those that make and unmake grains.
//!
//! ```text
//! cargo run --release --manifest-path examples/outside/Cargo.toml -- run examples/outside/scenes/outside.ron
//! cargo test --release --manifest-path examples/outside/Cargo.toml
//! ```

mod attraction;
mod bond;
mod breakage;
mod cohesion;
mod drag;
mod level_feeder;
mod magnet;
#[cfg(test)]
mod mill;
mod temperature;

use std::process::ExitCode;

use siloflow::prelude::*;

fn registry() -> Registry {
    let mut registry = Registry::default();
    registry
        .register::<drag::AirDrag>("air_drag")
        .register::<temperature::Conduction>("conduction")
        .register::<cohesion::Cohesion>("cohesion")
        .register::<bond::Bond>("bond")
        .register::<attraction::Attraction>("attraction")
        .register::<breakage::Breakage>("breakage")
        .register::<level_feeder::LevelFeeder>("level_feeder")
        .register::<magnet::Magnet>("magnet");
    registry
}

/// Runs the program `siloflow` with these behaviours.
fn main() -> ExitCode {
    siloflow::cli::main_with(&registry())
}

#[cfg(test)]
mod tests {
    use std::num::NonZeroUsize;
    use std::path::{Path, PathBuf};

    use siloflow::files::frames::Frame;
    use siloflow::files::frames::reader::FrameReader;

    use super::*;

    /// Returns the scene of `pair.csv`, two grains in contact without gravity, in either space.
    pub fn pair(space: Dimension, behaviours: &str, until: f64) -> Simulation {
        simulation("pair", scene_of_pair(space, behaviours, until))
    }

    fn scene_of_pair(space: Dimension, behaviours: &str, until: f64) -> String {
        format!(
            "(space: {space:?}, gravity: {}, grains: (file: \"pair.csv\"), step: Fixed(1.0e-4), until: {until:?}, \
              contact: Linear(k: 1.0e4, damping: B(20.0), attraction: Allowed), pictures: None, behaviours: {behaviours})",
            match space {
                Dimension::Plane => "(0.0, 0.0)",
                Dimension::Solid => "(0.0, 0.0, 0.0)",
            }
        )
    }

    /// Runs the scene of [`pair`] with the command line, a frame every 0.5 s, and returns the run directory.
    pub fn run_pair(here: &Path, space: Dimension, behaviours: &str, until: f64) -> PathBuf {
        let grains = include_str!("../scenes/pair.csv");
        std::fs::write(here.join("pair.csv"), grains).expect("a file");
        let text = scene_of_pair(space, behaviours, until)
            .replace("pictures: None", "pictures: None, data_frames: (interval: 0.5)");
        std::fs::write(here.join("pair.ron"), text).expect("a file");
        let [scene, out] = ["pair.ron", "run"].map(|name| here.join(name));
        let arguments =
            ["siloflow".into(), "run".into(), "--quiet".into(), scene.into(), "--out".into(), out.clone().into()];
        assert_eq!(siloflow::cli::run_with(&registry(), arguments), ExitCode::SUCCESS);
        out
    }

    /// Returns the time of each frame of a run, and a column of its grains.
    pub fn columns(run: &Path, name: &str) -> Vec<(f64, Vec<f64>)> {
        let frames = FrameReader::open(&run.join("frames.bin")).expect("frames");
        let column = |frame: Frame| Some((frame.time, frame.table("grains")?.floats(name)?.to_vec()));
        frames.map(|frame| column(frame.expect("a whole frame")).expect("the column is there")).collect()
    }

    pub fn simulation(name: &'static str, text: String) -> Simulation {
        let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
        let loaded = load::from_text(name, name, &scenes, text, &[]).expect("the scene is right");
        Simulation::new(&loaded, &registry(), NonZeroUsize::MIN).expect("the behaviours fit the scene")
    }

    /// Returns the overlap of the two grains, m.
    pub fn overlap(run: &mut Simulation, space: Dimension) -> f64 {
        fn overlap<V: Space>(world: &mut World) -> f64 {
            let grains: Vec<_> = world.query::<(&Position<V>, &Radius)>().iter(world).collect();
            grains[0].1.0 + grains[1].1.0 - (grains[0].0.0 - grains[1].0.0).length()
        }
        match space {
            Dimension::Plane => overlap::<Plane>(run.world_mut()),
            Dimension::Solid => overlap::<Solid>(run.world_mut()),
        }
    }
}
