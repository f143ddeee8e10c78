//! siloflow simulates granular flow in silos with discrete elements or a lattice gas. A scene file describes a run,
//! which is an app of an entity-component-system.
//!
//! The program is `siloflow run SCENE.ron`. This is its library, for programs that add new behaviours.
//!
//! * Particles are entities: [`dem::particle`]. One step is one run of one schedule with public phases: [`dem::step`].
//! * A scene describes the silo and so selects the plugins, components and systems that exist: [`scene`], [`plugins`].
//! * Each feature has its own file: [`grains::spawner`], [`rest`], [`door`], [`ledger`], [`energy`], [`dem::gravity`], ...
//! * Contact laws are [`dem::contact::PairLaw`]s. One pass sums contact forces over the particle [`dem::store`], in the order
//!   of slots, with candidate pairs from a search in [`dem::neighbours`].
//! * The lattice gas runs in the same phases, with its own systems and without particles: its rules are in [`lattice`], its silo in
//!   [`lattice_silo`].
//! * [`behaviour`] explains how another crate adds behaviours.
//! * *The assignment*, in this documentation, is the course assignment that siloflow answers: the grain silo of
//!   J. J. C. Remmers (2009). `docs/assignment.md` describes it.
//! * [`studies`] run many simulations, or compare some: [`studies::diff`] finds the first difference of two runs.
//! * Reports, figures and exports of finished runs are in [`results`], [`files`] and [`figures`], without the entity-component-system.
//!
//! ```
//! use std::num::NonZeroUsize;
//! use std::path::Path;
//! use siloflow::prelude::*;
//!
//! let scene = r#"(
//!     gravity: (0.0, -9.81),
//!     contact: Linear(k: 1.0e5, damping: Restitution(0.8)),
//!     mass: ArealSquare(100.0),
//!     step: Fixed(1.0e-4),
//!     walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0))],
//!     spawner: (point: (0.0, 1.0), velocity: (0.0, 0.0), interval: 1.0, count: 1, radius: Fixed(0.04)),
//!     until: 0.4,
//! )"#;
//! let loaded = load::from_text("fall.ron", "fall", Path::new(""), scene.to_owned(), &[])?;
//! let mut simulation = Simulation::new(&loaded, &Registry::default(), NonZeroUsize::MIN)?;
//! assert_eq!(simulation.run(), End::TimeReached);
//! let world = simulation.world_mut();
//! let x = world.query::<&Position>().single(world).unwrap().0;
//! assert!((x.y - (1.0 - 0.5 * 9.81 * 0.4f64.powi(2))).abs() < 1e-12);
//! # Ok::<(), siloflow::text::fault::Fault>(())
//! ```

// Numbers of a run have the same bits on every machine: see the module `math` of the kernel.
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod assembly;
pub mod behaviour;
#[allow(clippy::disallowed_methods, reason = "figures of commands are no input of a run")]
pub mod cli;
pub mod door;
pub mod ending;
pub mod energy;
pub mod grain_requests;
pub mod grains;
#[allow(clippy::disallowed_methods, reason = "another program computes with its numbers")]
pub mod lammps;
pub mod lattice_silo;
pub mod ledger;
pub mod measure;
pub mod output;
pub mod plugins;
pub mod random;
pub mod rest;
pub mod scene;
pub mod simulation;
#[allow(clippy::disallowed_methods, reason = "they judge results of runs")]
pub mod studies;
pub mod writers;

#[doc(inline)]
pub use siloflow_dem as dem;
#[doc(inline)]
pub use siloflow_figures as figures;
#[doc(inline)]
pub use siloflow_files as files;
#[doc(inline)]
pub use siloflow_lattice as lattice;
#[doc(inline)]
pub use siloflow_results as results;
#[doc(inline)]
pub use siloflow_text as text;

/// Runs an expression in the space of an app's scene: in `in_space!(app, V => app.add_systems(Step, push::<V>.in_set(Phase::Forces)))`, `V` is
/// the type [`Plane`](dem::space::Plane) or [`Solid`](dem::space::Solid).
#[macro_export]
macro_rules! in_space {
    ($app:expr, $space:ident => $run:expr) => {
        match $crate::dem::space::Dimension::of_world($app.world()) {
            $crate::dem::space::Dimension::Plane => {
                type $space = $crate::dem::space::Plane;
                $run;
            }
            $crate::dem::space::Dimension::Solid => {
                type $space = $crate::dem::space::Solid;
                $run;
            }
        }
    };
}

/// Names that a behaviour needs. A crate that depends on siloflow and serde alone can use the derives of the ECS too.
/// These derives name `bevy_ecs`, which `use siloflow::prelude::*` imports into the module ([`behaviour`] shows the
/// `Cargo.toml`).
pub mod prelude {
    pub use bevy_app::{App, Plugin};
    pub use bevy_ecs;
    pub use bevy_ecs::prelude::*;
    pub use bevy_ecs::query::{QueryData, QueryFilter};
    pub use bevy_ecs::system::SystemParam;

    pub use crate::behaviour::{Behaviour, Registry};
    pub use crate::grain_requests::{GrainMade, GrainRequests, NewGrain, Piece};
    pub use crate::in_space;
    pub use crate::ledger::Ledger;
    pub use crate::measure::outputs::OutputApp;
    pub use crate::measure::{ObserveStage, due, observe_every};
    pub use crate::scene::load;
    pub use crate::scene::loaded::Loaded;
    pub use crate::simulation::Simulation;
    pub use crate::writers::run_path::RunPath;
    pub use siloflow_dem::added_loads::{AddForce, AddTorque};
    pub use siloflow_dem::bodies::{Orientation, Shape};
    pub use siloflow_dem::contact::memory::{Memory, MemoryVariable, Parity};
    pub use siloflow_dem::contact::{Bounce, ContactPlugin, LawRequirements, Pair, PairForce, PairLaw};
    pub use siloflow_dem::messages::{CameToRest, DoorOpened, GrainLost, GrainOut, GrainReleased};
    pub use siloflow_dem::outcome::{End, Failure, Outcome};
    pub use siloflow_dem::particle::{
        Door, Fixed, Force, Grain, GrainBundle, GrainId, Mass, Particle, Position, Radius, Slot, Species, Velocity,
    };
    pub use siloflow_dem::particles::{Motion, Particles};
    pub use siloflow_dem::persist::PersistApp;
    pub use siloflow_dem::space::{Dimension, Linear, Plane, Solid, Space, Vector};
    pub use siloflow_dem::spin::{Inertia, Spin, Torque};
    pub use siloflow_dem::step::{Clock, ClockAdvanced, ForceStage, Phase, Step};
    pub use siloflow_dem::survey::contact_state::{ContactState, Touched};
    pub use siloflow_dem::survey::pair_forces::PairForces;
    pub use siloflow_dem::survey::pair_map::PairMap;
    pub use siloflow_dem::survey::touching::Touching;
    pub use siloflow_dem::survey::view::ContactView;
    pub use siloflow_files::frames::scale::{Palette, Scale};
}
