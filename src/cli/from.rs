//! `siloflow run SCENE --from DIR`: starts a run with the grains and contacts of another run.

use std::num::NonZeroUsize;
use std::path::Path;

use bevy_ecs::prelude::*;

use crate::behaviour::Registry;
use crate::grains::file;
use crate::ledger::Ledger;
use crate::output::checkpoint::find;
use crate::output::parent::Parent;
use crate::output::state_hash;
use crate::scene::load;
use crate::scene::load::start_state::{StartState, started_from};
use crate::scene::loaded::{AnyScene, Loaded};
use crate::simulation::{Caller, Simulation};
use siloflow_dem::contact::AnyLaw;
use siloflow_dem::contact::history::History;
use siloflow_dem::contact::history::remembered::{self, PartnerKind, RememberedContacts};
use siloflow_dem::particle::{Grain, GrainId};
use siloflow_dem::persist::UnknownState;
use siloflow_dem::space::{Dimension, Plane, Solid, Space};
use siloflow_dem::store::ParticleStore;
use siloflow_dem::walls::surfaces::Surfaces;
use siloflow_files::run_directory::{RunDirectory, scene_of};
use siloflow_text::fault::Fault;

/// The state of a run from which another starts.
pub(super) struct Origin {
    pub parent: Parent,
    state: StartState,
    /// The seed of the run.
    seed: u64,
}

impl Origin {
    /// Reads the latest checkpoint of the run in a directory. Grains that are out or lost are left out.
    ///
    /// # Errors
    /// * The directory holds no run, or no checkpoint that can be used; or another process uses it.
    /// * The run is one of the lattice gas, or needs a behaviour that is not registered.
    pub(super) fn of(path: &Path, registry: &Registry) -> Result<Self, Fault> {
        let directory = RunDirectory::reopen(path)?;
        let found = find::latest(path)?;
        let scene = load::named(&scene_of(path), &found.header().scene)?;
        let checkpoint = found.read(&scene)?;
        let AnyScene::Grains(loaded) = scene else {
            let message = format!("{} is a run of the lattice gas, which has no grains", path.display());
            return Err(Fault::new("checkpoint::method", message).help("give the directory of a run of grains"));
        };
        let saved = (&checkpoint.sections[..], UnknownState::Skip);
        let mut run = Simulation::with(
            &loaded,
            registry,
            NonZeroUsize::MIN,
            Caller::CommandLine,
            Box::new(|_| Ok(())),
            Some(saved),
        )?;
        let parent = Parent {
            run: directory.absolute().display().to_string(),
            scene: checkpoint.header.scene.clone(),
            steps: checkpoint.header.steps,
            time_s: checkpoint.header.time,
            state_hash: format!("{:016x}", state_hash::of_world(run.world_mut())),
        };
        let state = match loaded.scene.space {
            Dimension::Plane => state_of::<Plane>(run.world_mut(), &loaded),
            Dimension::Solid => state_of::<Solid>(run.world_mut(), &loaded),
        }?;
        Ok(Self { parent, state, seed: loaded.scene.seed })
    }

    /// Loads the scene at `path` with the grains and contacts of this state.
    ///
    /// # Errors
    /// Like [`started_from`]; also if another seed would move fixed grains.
    pub(super) fn load(self, path: &Path, settings: &[(String, String)]) -> Result<Box<Loaded>, Fault> {
        let loaded = started_from(path, settings, self.state, &self.parent.note())?;
        let random = loaded.scene.fill.iter().position(|fill| fill.fixed && fill.is_random());
        if let Some(number) = random.filter(|_| loaded.scene.seed != self.seed) {
            let message = format!(
                "the fixed grains of `fill[{number}]` depend on the seed: the run began with seed {}, and seed {} would put \
                 them elsewhere under its grains",
                self.seed, loaded.scene.seed
            );
            return Err(loaded.fault("scene::seed", "seed", message).help(format!("set the seed to {}", self.seed)));
        }
        Ok(loaded)
    }
}

/// Returns the grains and the memories of contacts of a world, which is that of a scene.
fn state_of<V: Space>(world: &mut World, loaded: &Loaded) -> Result<StartState, Fault> {
    let grains: Vec<_> =
        world.query_filtered::<(Entity, &GrainId), With<Grain>>().iter(world).map(|(e, id)| (e, *id)).collect();
    let ledger = world.resource::<Ledger>();
    let gone: Vec<_> = grains.into_iter().filter(|(_, id)| ledger.is_gone(*id)).collect();
    for (grain, _) in gone {
        world.despawn(grain);
    }
    let grains = file::write::<V>(world);
    let walls = &world.resource::<Surfaces<V>>().all;
    let mut contacts = match (world.get_resource::<History>(), world.get_resource::<AnyLaw<V>>()) {
        (Some(history), Some(law)) => {
            let layout = law.0.needs().memory.unwrap_or_default();
            history.remembered(world.resource::<ParticleStore<V>>(), walls, &layout)
        }
        _ => RememberedContacts::default(),
    };
    let names = loaded.wall_names();
    for row in contacts.rows.iter_mut().filter(|row| row.with == PartnerKind::Wall) {
        row.wall = names[walls[row.number as usize - 1].number].map(str::to_owned);
    }
    let contacts = remembered::write(&contacts).map_err(|problem| Fault::new("checkpoint::contacts", problem))?;
    Ok(StartState { space: V::DIMENSION, grains, contacts })
}
