//! The system that runs the kernel with the scene's law, search and threads.

use std::sync::Arc;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::columns::Columns;
use crate::contact::kernel::{self, OverlapRatio, Partners};
use crate::contact::{AnyLaw, PairLaw};
use crate::neighbours::{Method, Search};
use crate::step::{ForceStage, Step};
use crate::threads::Threads;

/// The contact law that the kernel is compiled for.
#[derive(Resource)]
pub struct Law<L: PairLaw>(pub Arc<L>);

/// The largest overlap so far, of grains with grains and with walls.
#[derive(Resource, Default)]
pub struct LargestOverlap(pub OverlapRatio);

/// The set of the contact pass.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct ContactForces;

fn contact_forces<L: PairLaw>(
    law: Res<Law<L>>,
    search: Res<Search>,
    threads: Res<Threads>,
    mut columns: ResMut<Columns>,
    mut largest: ResMut<LargestOverlap>,
) {
    let pass = match &search.method {
        Method::AllPairs(partners) => sum(&*law.0, &mut columns, &threads, partners),
        Method::Cells(partners) => sum(&*law.0, &mut columns, &threads, partners),
        Method::VerletList(partners) => sum(&*law.0, &mut columns, &threads, partners),
    };
    largest.0.merge(pass);
}

fn sum<L: PairLaw>(law: &L, columns: &mut Columns, threads: &Threads, partners: &impl Partners) -> OverlapRatio {
    match threads.pool() {
        None => kernel::half(law, columns, partners),
        Some(pool) => pool.install(|| kernel::full(law, columns, partners)),
    }
}

/// Contacts with the law `law`. Outsiders' laws enter here: `app.add_plugins(ContactPlugin(Arc::new(MyLaw)))`.
pub struct ContactPlugin<L: PairLaw>(pub Arc<L>);

impl<L: PairLaw> Plugin for ContactPlugin<L> {
    fn build(&self, app: &mut App) {
        app.insert_resource(Law(self.0.clone()))
            .insert_resource(AnyLaw(self.0.clone()))
            .init_resource::<LargestOverlap>()
            .add_systems(Step, contact_forces::<L>.in_set(ForceStage::Contacts).in_set(ContactForces));
    }
}
