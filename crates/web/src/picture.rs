//! The present state of grains for the player.

use siloflow::cli::sliced::SlicedRun;
use siloflow::dem::space::{Dimension, Plane, Solid};
use siloflow::files::frames::Header;
use siloflow::output::frame_recording::{frame_of_world, header};
use siloflow::prelude::World;
use siloflow::results::report::player::live::LiveFrames;
use siloflow::scene::loaded::{AnyScene, Loaded};
use siloflow::scene::outputs::DataFrames;
use siloflow::text::fault::Fault;

/// Pictures of a run.
pub struct Pictures {
    frames: LiveFrames,
    space: Dimension,
}

impl Pictures {
    /// Begins; `None` for the lattice gas.
    pub fn of(run: &SlicedRun) -> Option<Self> {
        let of_world = |loaded: &Loaded, world: &World| -> Header {
            let config = DataFrames { walls: true, ..DataFrames::default() };
            match loaded.scene.space {
                Dimension::Plane => header::<Plane>(loaded, &config, world),
                Dimension::Solid => header::<Solid>(loaded, &config, world),
            }
        };
        let AnyScene::Grains(loaded) = run.scene() else { return None };
        let space = loaded.scene.space;
        let header = of_world(loaded, run.present());
        Some(Self { frames: LiveFrames::new(header), space })
    }

    /// Packs the present state.
    pub fn next(&mut self, world: &mut World, contacts: bool) -> Result<Vec<u8>, Fault> {
        let header = self.frames.header().clone();
        let frame = match self.space {
            Dimension::Plane => frame_of_world::<Plane>(&header, contacts, world),
            Dimension::Solid => frame_of_world::<Solid>(&header, contacts, world),
        };
        let packed = frame.and_then(|frame| self.frames.pack(&frame).map_err(|error| error.to_string()));
        packed.map_err(|reason| Fault::new("page::picture", reason))
    }
}
