//! The state of a simulation in a file: a [checkpoint](crate::output::checkpoint) without a run directory.

use std::io;
use std::num::NonZeroUsize;
use std::path::Path;

use bevy_app::App;

use crate::behaviour::Registry;
use crate::output::checkpoint::file::{self, FORMAT, Header};
use crate::output::checkpoint::find;
use crate::scene::loaded::Loaded;
use crate::simulation::{Caller, Simulation, plugins_of_program};
use siloflow_dem::persist::{Section, UnknownState};
use siloflow_dem::step::Clock;
use siloflow_files::run_files::Manifest;
use siloflow_files::whole_file;
use siloflow_text::fault::Fault;

impl Simulation {
    /// Writes the whole state into a file. A file of this name is replaced once the new one is whole.
    ///
    /// # Errors
    /// If the state cannot be encoded, or the file cannot be written.
    pub fn save_to(&mut self, path: &Path, scene: &str) -> io::Result<()> {
        let sections = self.save().map_err(io::Error::other)?;
        let clock = self.world().resource::<Clock>();
        let header = Header {
            format: FORMAT,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            program: 0,
            input: 0,
            scene: scene.to_owned(),
            steps: clock.steps,
            time: clock.time(),
            is_final: false,
            files: Manifest::default(),
        };
        whole_file::write_with(path, |out| file::write(out, &header, &sections))
    }

    /// Builds the app that the scene needs with plugins of the caller, and continues a state of the same scene: one of [`Simulation::save_to`], a checkpoint
    /// of a run, or the latest one in a run directory.
    ///
    /// # Errors
    /// As [`Simulation::new`], or if the state cannot be read, is that of another version, or does not fit the scene.
    pub fn continued(
        loaded: &Loaded,
        registry: &Registry,
        threads: NonZeroUsize,
        state: &Path,
        more: impl FnOnce(&mut App),
    ) -> Result<Self, Fault> {
        let sections = read(state)?;
        Self::with(
            loaded,
            registry,
            threads,
            Caller::Outside,
            plugins_of_program(more),
            // A checkpoint of a run has outputs too.
            Some((&sections, UnknownState::Skip)),
        )
    }
}

fn read(path: &Path) -> Result<Vec<Section>, Fault> {
    let packed = if path.is_dir() { Ok(find::latest(path)?.into_packed()) } else { file::open(path) };
    packed.and_then(|packed| packed.unpack(u64::MAX)).map(|checkpoint| checkpoint.sections).map_err(|error| {
        Fault::new("checkpoint::refused", format!("could not read the state {}: {error}", path.display()))
            .help("name a file that a simulation has saved, a checkpoint, or a run directory with one")
    })
}
