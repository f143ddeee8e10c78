//! The system that runs the kernel with the scene's law, search and threads.

use std::marker::PhantomData;
use std::sync::Arc;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::columns::Columns;
use crate::contact::history::{CHUNK, History};
use crate::contact::kernel::{OverlapRatio, Pass};
use crate::contact::{AnyLaw, Demands, PairLaw};
use crate::energy::SpinEnergyPlugin;
use crate::neighbours::Search;
use crate::periodic::{Metric, Open};
use crate::space::{Plane, Space};
use crate::spin::{InertiaLaw, SpinPlugin};
use crate::step::{Clock, ForceStage, Step};
use crate::threads::Threads;

/// The contact law that the kernel is compiled for.
#[derive(Resource)]
pub struct Law<L>(pub Arc<L>);

/// The largest overlap so far, of grains with grains and with walls.
#[derive(Resource, Default)]
pub struct LargestOverlap(pub OverlapRatio);

/// The set of the contact pass.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct ContactForces;

/// By how much memories advance in this run of the schedule, s.
pub(crate) fn memory_step(clock: &Clock) -> f64 {
    if clock.is_step_zero() { 0.0 } else { clock.dt }
}

fn contact_forces<V: Space, L: PairLaw<V> + Demands>(
    law: Res<Law<L>>,
    clock: Res<Clock>,
    search: Res<Search<V>>,
    threads: Res<Threads>,
    mut columns: ResMut<Columns<V>>,
    mut history: ResMut<History<V>>,
    mut largest: ResMut<LargestOverlap>,
) {
    let (law, dt) = (&*law.0, memory_step(&clock));
    if L::MEMORY {
        let books = if threads.pool().is_some() { columns.len().div_ceil(CHUNK) } else { 1 };
        history.follow(&columns.id, columns.generation, books);
    }
    let partners = search.partners();
    let pass = match columns.periodic {
        None => sum(&Pass { law, metric: Open, partners, dt }, &mut columns, &threads, &mut history),
        Some(metric) => sum(&Pass { law, metric, partners, dt }, &mut columns, &threads, &mut history),
    };
    largest.0.merge(pass);
}

fn sum<V: Space, L: PairLaw<V> + Demands, M: Metric<V>>(
    pass: &Pass<V, L, M>,
    columns: &mut Columns<V>,
    threads: &Threads,
    history: &mut History<V>,
) -> OverlapRatio {
    match threads.pool() {
        None => pass.half(columns, &mut history.pairs[0]),
        Some(pool) => pool.install(|| pass.full(columns, history)),
    }
}

/// Contacts with the law `law`. Outsiders' laws enter here: `app.add_plugins(ContactPlugin::plane(Arc::new(MyLaw)))`.
pub struct ContactPlugin<V: Space, L: PairLaw<V>> {
    law: Arc<L>,
    space: PhantomData<V>,
}

impl<V: Space, L: PairLaw<V>> ContactPlugin<V, L> {
    /// The law in the space `V`.
    #[must_use]
    pub fn new(law: Arc<L>) -> Self {
        Self { law, space: PhantomData }
    }
}

impl<L: PairLaw<Plane>> ContactPlugin<Plane, L> {
    /// The law in the plane.
    #[must_use]
    pub fn plane(law: Arc<L>) -> Self {
        Self::new(law)
    }
}

impl<V: Space, L: PairLaw<V> + Demands> Plugin for ContactPlugin<V, L> {
    fn build(&self, app: &mut App) {
        // A law that a behaviour brings may turn grains where the scene's own does not.
        if L::SPIN && !app.is_plugin_added::<SpinPlugin<V>>() {
            app.add_plugins(SpinPlugin::<V>(InertiaLaw::usual(V::DIMENSION), PhantomData))
                .add_plugins(SpinEnergyPlugin::<V>(PhantomData));
        }
        app.insert_resource(Law(self.law.clone()))
            .insert_resource(AnyLaw::<V>(self.law.clone()))
            .init_resource::<History<V>>()
            .init_resource::<LargestOverlap>()
            .add_systems(Step, contact_forces::<V, L>.in_set(ForceStage::Contacts).in_set(ContactForces));
    }
}
