//! Persistent state: the registry of everything that a checkpoint saves.
//!
//! State is registered where it is declared, in one line of the plugin that owns it. There is no central list. Behaviours of
//! other crates register in the same way:
//!
//! ```
//! use siloflow::prelude::*;
//!
//! /// Energy that grains have lost to the air, J.
//! #[derive(Resource, Default, serde::Serialize, serde::Deserialize)]
//! struct LostToAir(f64);
//!
//! # fn build(app: &mut App) {
//! app.init_resource::<LostToAir>().persist::<LostToAir>();
//! # }
//! ```
//!
//! | kind of state | registered with |
//! |---|---|
//! | a resource | [`persist`](PersistApp::persist) |
//! | a part of a resource; the rest comes from the scene | [`persist_part`](PersistApp::persist_part) |
//! | a component, also one without data | [`persist_component`](PersistApp::persist_component) |
//! | a cache that is rebuilt from other state | [`derived`](PersistApp::derived) |
//!
//! Each of the first three has a form for state whose floats are finite and whose whole numbers are below 2^53
//! ([`persist_sound`](PersistApp::persist_sound) and so on): other numbers in a checkpoint are refused. State that fits only other state,
//! an index for example, is checked once all is restored ([`check_restored`](PersistApp::check_restored)). A checkpoint can hold anything,
//! because its hashes protect from accidents alone: what the checks let pass must not make a step panic.
//!
//! [`unregistered`] finds state that systems write and that no line registers, from the access that systems declare and from the
//! components that entities have.
//!
//! Limits:
//! * Access lists do not show a `Local`, a captured variable or a `static`, so physics must not keep state there.
//! * An [`Entity`] in saved data is not translated; refer to a particle by its [`GrainId`](crate::particle::GrainId).
//! * Messages are not saved: read a message in the step in which it is written, in a later phase or `.after` its writer.

mod config;
mod entities;
pub mod numbers;
mod unregistered;

use std::any::type_name;

use bevy_app::App;
use bevy_ecs::component::ComponentId;
use bevy_ecs::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;

pub use self::config::{CheckpointConfig, CheckpointFigures, default_checkpoint};
pub use self::entities::{EntityNumbers, SavedEntities};
pub use self::unregistered::{Unregistered, unregistered};

/// State that can be saved and restored.
pub trait Persistent: Serialize + DeserializeOwned + Send + Sync + 'static {}

impl<T: Serialize + DeserializeOwned + Send + Sync + 'static> Persistent for T {}

/// Why state could not be saved or restored, in words.
pub type Problem = String;

type Save = Box<dyn Fn(&mut World, &EntityNumbers) -> Result<Option<Vec<u8>>, Problem> + Send + Sync>;
type Restore = Box<dyn Fn(&mut World, &[u8], &SavedEntities) -> Result<(), Problem> + Send + Sync>;
type CheckRestored = fn(&mut World) -> Result<(), Problem>;

/// One registered piece of state.
struct Entry {
    name: &'static str,
    id: ComponentId,
    is_component: bool,
    save: Save,
    restore: Restore,
}

/// The registry.
#[derive(Resource, Default)]
pub struct Registered {
    entries: Vec<Entry>,
    derived: Vec<ComponentId>,
    checks: Vec<CheckRestored>,
}

/// One saved piece of state: its type name and its bytes.
pub type Section = (String, Vec<u8>);

/// Registration of state in an [`App`].
pub trait PersistApp {
    /// Saves the resource `R` with every checkpoint.
    fn persist<R: Resource + Persistent>(&mut self) -> &mut Self;

    /// Saves a part `S` of the resource `R`. The rest of it is as the scene makes it.
    fn persist_part<R: Resource<Mutability = bevy_ecs::component::Mutable>, S: Persistent>(
        &mut self,
        save: fn(&R) -> Result<S, Problem>,
        restore: fn(&mut R, S) -> Result<(), Problem>,
    ) -> &mut Self;

    /// Saves the component `C` of every entity that has it.
    fn persist_component<C: Component + Persistent>(&mut self) -> &mut Self;

    /// As [`persist`](PersistApp::persist), and refuses saved numbers that are not [sound](numbers::check).
    fn persist_sound<R: Resource + Persistent>(&mut self) -> &mut Self;

    /// As [`persist_part`](PersistApp::persist_part), and refuses saved numbers that are not [sound](numbers::check).
    fn persist_sound_part<R: Resource<Mutability = bevy_ecs::component::Mutable>, S: Persistent>(
        &mut self,
        save: fn(&R) -> Result<S, Problem>,
        restore: fn(&mut R, S) -> Result<(), Problem>,
    ) -> &mut Self;

    /// As [`persist_component`](PersistApp::persist_component), and refuses saved numbers that are not [sound](numbers::check).
    fn persist_sound_component<C: Component + Persistent>(&mut self) -> &mut Self;

    /// Calls `check` after all state of a checkpoint is restored. A problem refuses the checkpoint.
    fn check_restored(&mut self, check: fn(&mut World) -> Result<(), Problem>) -> &mut Self;

    /// States that the resource or component `T` is rebuilt from other state and need not be saved.
    fn derived<T: Component>(&mut self) -> &mut Self;
}

impl PersistApp for App {
    fn persist<R: Resource + Persistent>(&mut self) -> &mut Self {
        self.persist_resource::<R>(|_| Ok(()))
    }

    fn persist_part<R: Resource<Mutability = bevy_ecs::component::Mutable>, S: Persistent>(
        &mut self,
        save: fn(&R) -> Result<S, Problem>,
        restore: fn(&mut R, S) -> Result<(), Problem>,
    ) -> &mut Self {
        self.persist_part_of(save, restore, |_| Ok(()))
    }

    fn persist_component<C: Component + Persistent>(&mut self) -> &mut Self {
        self.persist_column::<C>(|_| Ok(()))
    }

    fn persist_sound<R: Resource + Persistent>(&mut self) -> &mut Self {
        self.persist_resource::<R>(numbers::check)
    }

    fn persist_sound_part<R: Resource<Mutability = bevy_ecs::component::Mutable>, S: Persistent>(
        &mut self,
        save: fn(&R) -> Result<S, Problem>,
        restore: fn(&mut R, S) -> Result<(), Problem>,
    ) -> &mut Self {
        self.persist_part_of(save, restore, numbers::check)
    }

    fn persist_sound_component<C: Component + Persistent>(&mut self) -> &mut Self {
        self.persist_column::<C>(numbers::check)
    }

    fn check_restored(&mut self, check: fn(&mut World) -> Result<(), Problem>) -> &mut Self {
        self.world_mut().get_resource_or_init::<Registered>().checks.push(check);
        self
    }

    fn derived<T: Component>(&mut self) -> &mut Self {
        let id = self.world_mut().register_component::<T>();
        self.world_mut().get_resource_or_init::<Registered>().derived.push(id);
        self
    }
}

/// Registration of state with a check of restored values, and of state that refers to entities.
pub(crate) trait PersistWith {
    /// Saves the resource `R`. `check` refuses restored ones.
    fn persist_resource<R: Resource + Persistent>(&mut self, check: fn(&R) -> Result<(), Problem>) -> &mut Self;

    /// Saves a part of the resource `R`. `check` refuses restored parts.
    fn persist_part_of<R: Resource<Mutability = bevy_ecs::component::Mutable>, S: Persistent>(
        &mut self,
        save: fn(&R) -> Result<S, Problem>,
        restore: fn(&mut R, S) -> Result<(), Problem>,
        check: fn(&S) -> Result<(), Problem>,
    ) -> &mut Self;

    /// Saves the component `C` of every entity that has it. `check` refuses restored ones.
    fn persist_column<C: Component + Persistent>(&mut self, check: fn(&C) -> Result<(), Problem>) -> &mut Self;

    /// Saves the resource `R` as `S`, with functions that translate entities.
    fn persist_with<R: Resource, S: Persistent>(
        &mut self,
        save: impl Fn(&World, &EntityNumbers) -> Result<Option<Vec<u8>>, Problem> + Send + Sync + 'static,
        restore: impl Fn(&mut World, S, &SavedEntities) -> Result<(), Problem> + Send + Sync + 'static,
    ) -> &mut Self;

    fn register<T: Component>(&mut self, is_component: bool, save: Save, restore: Restore) -> &mut Self;
}

impl PersistWith for App {
    fn persist_resource<R: Resource + Persistent>(&mut self, check: fn(&R) -> Result<(), Problem>) -> &mut Self {
        self.persist_with::<R, R>(
            |world, _| world.get_resource::<R>().map(encode).transpose(),
            move |world, resource: R, _| {
                check(&resource)?;
                world.insert_resource(resource);
                Ok(())
            },
        )
    }

    fn persist_part_of<R: Resource<Mutability = bevy_ecs::component::Mutable>, S: Persistent>(
        &mut self,
        save: fn(&R) -> Result<S, Problem>,
        restore: fn(&mut R, S) -> Result<(), Problem>,
        check: fn(&S) -> Result<(), Problem>,
    ) -> &mut Self {
        self.persist_with::<R, S>(
            move |world, _| world.get_resource::<R>().map(|resource| encode(&save(resource)?)).transpose(),
            move |world, part: S, _| {
                check(&part)?;
                let mut resource = world.get_resource_mut::<R>().ok_or("the scene does not have this state")?;
                restore(&mut resource, part)
            },
        )
    }

    fn persist_column<C: Component + Persistent>(&mut self, check: fn(&C) -> Result<(), Problem>) -> &mut Self {
        self.register::<C>(
            true,
            Box::new(|world, numbers| entities::save_column::<C>(world, numbers).map(Some)),
            Box::new(move |world, bytes, entities| entities::restore_column::<C>(world, bytes, entities, check)),
        )
    }

    fn persist_with<R: Resource, S: Persistent>(
        &mut self,
        save: impl Fn(&World, &EntityNumbers) -> Result<Option<Vec<u8>>, Problem> + Send + Sync + 'static,
        restore: impl Fn(&mut World, S, &SavedEntities) -> Result<(), Problem> + Send + Sync + 'static,
    ) -> &mut Self {
        self.register::<R>(
            false,
            Box::new(move |world, numbers| save(world, numbers)),
            Box::new(move |world, bytes, entities| restore(world, decode(bytes)?, entities)),
        )
    }

    fn register<T: Component>(&mut self, is_component: bool, save: Save, restore: Restore) -> &mut Self {
        let id = self.world_mut().register_component::<T>();
        let mut registered = self.world_mut().get_resource_or_init::<Registered>();
        // Two plugins may share a type; the first one registers it.
        if !registered.knows(id) {
            registered.entries.push(Entry { name: type_name::<T>(), id, is_component, save, restore });
        }
        self
    }
}

impl Registered {
    /// Returns the registered components.
    fn components(&self) -> Vec<ComponentId> {
        self.entries.iter().filter(|entry| entry.is_component).map(|entry| entry.id).collect()
    }

    /// Whether the resource or component is saved or derived.
    fn knows(&self, id: ComponentId) -> bool {
        self.derived.contains(&id) || self.entries.iter().any(|entry| entry.id == id)
    }
}

/// Encodes a value.
///
/// # Errors
/// If a value cannot be encoded.
pub fn encode<T: Serialize>(value: &T) -> Result<Vec<u8>, Problem> {
    postcard::to_allocvec(value).map_err(|error| error.to_string())
}

/// Decodes a value; all bytes must be used.
///
/// # Errors
/// If the bytes are not those of such a value.
pub fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, Problem> {
    match postcard::take_from_bytes(bytes) {
        Ok((value, [])) => Ok(value),
        Ok(_) => Err("there are more bytes than the state has".to_owned()),
        Err(error) => Err(error.to_string()),
    }
}

/// Saves all registered state of a world whose components are up to date.
///
/// # Errors
/// If a value cannot be encoded.
pub fn save(world: &mut World) -> Result<Vec<Section>, Problem> {
    let mut sections = Vec::new();
    save_each(world, |name, bytes| {
        sections.push((name.to_owned(), bytes));
        Ok(())
    })?;
    Ok(sections)
}

/// As [`save`], but one section at a time, because all together need as much memory as the run. `keep` receives name and bytes.
///
/// # Errors
/// If a value cannot be encoded, or if `keep` fails.
pub fn save_each(world: &mut World, mut keep: impl FnMut(&str, Vec<u8>) -> Result<(), Problem>) -> Result<(), Problem> {
    world.init_resource::<Registered>();
    world.resource_scope(|world, registered: Mut<Registered>| {
        let numbers = EntityNumbers::of(world, &registered.components());
        keep(ENTITIES, encode(&numbers.len())?)?;
        for Entry { name, save, .. } in &registered.entries {
            if let Some(bytes) = save(world, &numbers).map_err(|problem| format!("{name}: {problem}"))? {
                keep(name, bytes)?;
            }
        }
        Ok(())
    })
}

/// Name of the section with the number of entities.
const ENTITIES: &str = "entities";

/// Most entities that a checkpoint may have without bytes for them.
const MOST_BARE_ENTITIES: usize = 1 << 20;

/// Treatment of saved state that a world does not have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnknownState {
    /// It is an error.
    Refuse,
    /// It is left out: outputs, for example, in a world that writes none.
    Skip,
}

/// Restores saved state in a world of the same scene that has no particle yet. Components come first, because hooks record
/// what enters in resources.
///
/// # Errors
/// If a section cannot be decoded, belongs to state that is not registered and `unknown` refuses it, or does not fit the rest.
pub fn restore(world: &mut World, sections: &[Section], unknown: UnknownState) -> Result<(), Problem> {
    world.init_resource::<Registered>();
    world.resource_scope(|world, registered: Mut<Registered>| {
        let content = |name: &str| sections.iter().find(|(section, _)| section == name).map(|(_, bytes)| &bytes[..]);
        let is_known = |name: &str| name == ENTITIES || registered.entries.iter().any(|entry| entry.name == name);
        if let Some((name, _)) = sections.iter().find(|(name, _)| !is_known(name))
            && unknown == UnknownState::Refuse
        {
            return Err(format!("it holds {name}, which this scene does not have"));
        }
        let count = decode(content(ENTITIES).ok_or("it does not say how many entities there are")?)?;
        // A particle takes more than 16 bytes. A behaviour may have entities with less.
        let most = MOST_BARE_ENTITIES + sections.iter().map(|(_, bytes)| bytes.len()).sum::<usize>() / 16;
        // Entities that plugins have made are among the saved ones.
        let made: Vec<_> = EntityNumbers::of(world, &registered.components()).entities().collect();
        for entity in made {
            world.despawn(entity);
        }
        let entities = SavedEntities::spawn(world, count, most)?;
        let mut in_order: Vec<_> = registered.entries.iter().collect();
        in_order.sort_by_key(|entry| !entry.is_component);
        for Entry { name, id, is_component, restore, .. } in in_order {
            match content(name) {
                Some(bytes) => restore(world, bytes, &entities).map_err(|problem| format!("{name}: {problem}"))?,
                None if *is_component || world.contains_resource_by_id(*id) => return Err(format!("it lacks {name}")),
                None => {}
            }
        }
        world.flush();
        registered.checks.iter().try_for_each(|check| check(world))
    })
}
