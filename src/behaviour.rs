//! Behaviours from other crates: systems that a program adds to those of siloflow, and that a scene switches on.
//!
//! A scene lists them under `behaviours`, each with its own keys in RON:
//!
//! ```text
//! behaviours: {"wind": (force: 0.2)},
//! ```
//!
//! # A separate crate
//!
//! The `Cargo.toml` of the crate needs two dependencies:
//!
//! ```toml
//! [package]
//! name = "windy"
//! version = "0.1.0"
//! edition = "2024"
//!
//! [dependencies]
//! siloflow = { path = "../siloflow" } # or git = "..."
//! serde = { version = "1.0", features = ["derive"] }
//!
//! [profile.dev]
//! opt-level = 2 # a simulation without optimisation takes twenty times as long
//! ```
//!
//! Every module that derives `Component`, `Resource`, `Message`, `Bundle`, `SystemSet`, `SystemParam` or `QueryData`
//! needs `use siloflow::prelude::*;`. These derives name the crate `bevy_ecs`, which the prelude exports. (A crate with
//! its own dependency on `bevy_ecs` needs the version that siloflow uses.) `examples/outside` in the repository is an
//! example: air drag, temperatures with conduction at contacts, a cohesive contact law, one with memory, and an attraction on top of any
//! law.
//!
//! A program registers the type that is read from the keys of the scene, and passes the registry to
//! [`crate::cli::main_with`]:
//!
//! ```
//! use serde::Deserialize;
//! use siloflow::prelude::*;
//!
//! #[derive(Deserialize)]
//! #[serde(deny_unknown_fields)]
//! struct Wind {
//!     /// Force on every grain, N.
//!     force: f64,
//! }
//!
//! impl Behaviour for Wind {
//!     fn build(self: Box<Self>, app: &mut App) {
//!         let force = Vector::new(self.force, 0.0);
//!         let blow = move |mut grains: AddForce| grains.each(|()| force);
//!         app.add_systems(Step, blow.in_set(ForceStage::Added));
//!     }
//! }
//!
//! let mut registry = Registry::default();
//! registry.register::<Wind>("wind");
//! // In `main`: siloflow::cli::main_with(&registry)
//! ```
//!
//! # Both spaces
//!
//! Components default to the plane. A behaviour for both spaces has systems that are generic over
//! [`Space`](siloflow_dem::space::Space). It declares this in [`Behaviour::lives_in`], and adds them with
//! [`in_space!`](crate::in_space) in [`Behaviour::build`]:
//!
//! ```
//! # use siloflow::prelude::*;
//! # struct AirDrag;
//! fn slow_down<V: Space>(mut grains: AddForce<V, &'static Velocity<V>>) {
//!     grains.each(|velocity| velocity.0 * -0.1);
//! }
//!
//! impl Behaviour for AirDrag {
//!     fn lives_in(&self, _: Dimension) -> bool {
//!         true
//!     }
//!
//!     fn build(self: Box<Self>, app: &mut App) {
//!         in_space!(app, V => app.add_systems(Step, slow_down::<V>.in_set(ForceStage::Added)));
//!     }
//! }
//! ```
//!
//! # New components
//!
//! A system of [`Phase::Spawn`](siloflow_dem::step::Phase::Spawn) inserts new components, by `Commands`, on grains without
//! them: a query of `(With<Grain>, Without<Temperature>)`. A grain that has just been released may get them one step
//! later.
//!
//! # Results
//!
//! [`measure::outputs`](crate::measure::outputs) explains how a behaviour adds columns of grains, columns of `series.csv`, values of
//! the summary, and files of its own.
//!
//! # Contacts
//!
//! | a behaviour that | uses |
//! |---|---|
//! | reads contacts | [`ContactView::iter`]: 20 to 40 ns per grain; [`ContactView::all`] for all data, in id order |
//! | adds forces to the scene's law | [`PairForces`] in [`ForceStage::Added`](siloflow_dem::step::ForceStage::Added) |
//! | keeps a number for each contact | [`PairMap`] |
//! | replaces the law | [`PairLaw`] with [`ContactPlugin`]; [`Memory`] holds its memory of a contact |
//!
//! # Forces
//!
//! [`AddForce`](siloflow_dem::added_loads::AddForce), [`AddTorque`](siloflow_dem::added_loads::AddTorque) and [`PairForces`] add to the sums of forces and
//! torques. Systems with these parameters need no declared order: they run in the order of their behaviours' names. A system that writes `Force` itself may also
//! set it, and needs one (`.after(...)`).
//!
//! # Grains
//!
//! [`grain_requests`](crate::grain_requests) explains how a behaviour splits, merges, resizes, removes and creates grains.
//!
//! [`ContactView::iter`]: siloflow_dem::survey::view::ContactView::iter
//! [`ContactView::all`]: siloflow_dem::survey::view::ContactView::all
//! [`PairForces`]: siloflow_dem::survey::pair_forces::PairForces
//! [`PairMap`]: siloflow_dem::survey::pair_map::PairMap
//! [`PairLaw`]: siloflow_dem::contact::PairLaw
//! [`ContactPlugin`]: siloflow_dem::contact::ContactPlugin
//! [`Memory`]: siloflow_dem::contact::Memory

use std::collections::BTreeMap;

use bevy_app::App;
use ron::value::RawValue;
use serde::de::DeserializeOwned;

use crate::lattice_silo::loaded::LoadedLattice;
use crate::scene::loaded::Loaded;
use siloflow_dem::space::Dimension;
use siloflow_text::fault::Fault;
use siloflow_text::source::Source;
use siloflow_text::source::parse;

/// A behaviour, read from its keys in the scene.
pub trait Behaviour: 'static {
    /// Checks the keys against the scene. The error text names the problem and a remedy.
    ///
    /// # Errors
    /// If the behaviour cannot work in this scene.
    fn check(&self, _scene: &Loaded) -> Result<(), String> {
        Ok(())
    }

    /// Whether the behaviour works in a scene of this space. Components default to the plane, so systems that query
    /// `Position` and `Force` find no particles in solid space. A behaviour that queries `Position<Solid>` declares
    /// solid space here.
    fn lives_in(&self, space: Dimension) -> bool {
        space == Dimension::Plane
    }

    /// Whether the behaviour works in a scene of the lattice gas, on [`Gas`](siloflow_lattice::gas::Gas) and
    /// [`Sites`](siloflow_lattice::sites::Sites). A lattice gas has no grains.
    fn lives_on_lattice(&self) -> bool {
        false
    }

    /// Whether [`Behaviour::build`] adds the contact law: a [`siloflow_dem::contact::ContactPlugin`] with its own
    /// [`siloflow_dem::contact::PairLaw`].
    ///
    /// If it does, the scene's `contact` serves only for the estimates of `check`, and decides whether a grain file may
    /// give spins. For a law that rotates grains, the scene's `contact` should therefore have `tangential` too.
    fn brings_contact_law(&self) -> bool {
        false
    }

    /// Adds components, resources and systems. Systems go into the schedule [`siloflow_dem::step::Step`].
    fn build(self: Box<Self>, app: &mut App);
}

type Parse = fn(&Source, &str, &str) -> Result<Box<dyn Behaviour>, Fault>;

/// The behaviours of a program, by name.
#[derive(Default, Clone)]
pub struct Registry(BTreeMap<&'static str, Parse>);

impl Registry {
    /// Registers `T` under `name`.
    pub fn register<T: Behaviour + DeserializeOwned>(&mut self, name: &'static str) -> &mut Self {
        self.0.insert(name, parse_keys::<T>);
        self
    }

    /// Returns the behaviours that a scene of grains requests, in the order of their names.
    ///
    /// # Errors
    /// If a name is unknown, or its keys are wrong. The fault gives the place in the scene.
    pub fn of_scene(&self, loaded: &Loaded) -> Result<Vec<(String, Box<dyn Behaviour>)>, Fault> {
        self.find(&loaded.source, &loaded.scene.behaviours, |behaviour| {
            if !behaviour.lives_in(loaded.scene.space) {
                let message = format!("this behaviour does not work with `space: {:?}`", loaded.scene.space);
                return Err((message, "the behaviour declares its spaces in `Behaviour::lives_in`"));
            }
            behaviour.check(loaded).map_err(|message| (message, "see the documentation of the behaviour"))
        })
    }

    /// Returns the behaviours that a lattice gas scene requests, in the order of their names.
    ///
    /// # Errors
    /// As [`Registry::of_scene`].
    pub fn of_lattice(&self, loaded: &LoadedLattice) -> Result<Vec<(String, Box<dyn Behaviour>)>, Fault> {
        self.find(&loaded.source, &loaded.scene.behaviours, |behaviour| {
            if behaviour.lives_on_lattice() {
                return Ok(());
            }
            let message = "this behaviour does not work with the lattice gas".to_owned();
            Err((message, "the behaviour declares this in `Behaviour::lives_on_lattice`"))
        })
    }

    fn find(
        &self,
        source: &Source,
        wanted: &BTreeMap<String, Box<RawValue>>,
        check: impl Fn(&dyn Behaviour) -> Result<(), (String, &'static str)>,
    ) -> Result<Vec<(String, Box<dyn Behaviour>)>, Fault> {
        wanted
            .iter()
            .map(|(name, keys)| {
                let key = format!("behaviours.{name}");
                let parse = self.0.get(name.as_str()).ok_or_else(|| self.unknown(source, name, &key))?;
                let behaviour = parse(source, &key, keys.get_ron())?;
                check(&*behaviour)
                    .map_err(|(message, help)| source.fault("scene::behaviour", &key, message).help(help))?;
                Ok((name.clone(), behaviour))
            })
            .collect()
    }

    fn unknown(&self, source: &Source, name: &str, key: &str) -> Fault {
        let known: Vec<_> = self.0.keys().copied().collect();
        let help = if known.is_empty() {
            "this program has no behaviours; another program can register some (examples/vibrating_wall.rs)".to_owned()
        } else {
            format!("this program has: {}", known.join(", "))
        };
        source.fault("scene::unknown_behaviour", key, format!("there is no behaviour `{name}`")).help(help)
    }
}

fn parse_keys<T: Behaviour + DeserializeOwned>(
    source: &Source,
    key: &str,
    ron: &str,
) -> Result<Box<dyn Behaviour>, Fault> {
    match parse::ron_options().from_str::<T>(ron.trim()) {
        Ok(behaviour) => Ok(Box::new(behaviour)),
        Err(error) => Err(source.explain(key, &error)),
    }
}
