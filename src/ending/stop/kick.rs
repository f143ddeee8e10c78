//! Kicks: restart the flow when the outlet is clogged, so that one run has many avalanches.
//!
//! When no grain has left for `still` seconds although grains are above the outlet ([`clog`](super::clog)), the number of grains that
//! have left since the last kick is recorded as an avalanche, and a kick begins: for `duration` seconds all grains within `reach` of
//! the outlet feel the `acceleration` a, as a jet of air or a blow on the outlet gives it. The force m a counts as added work in the
//! energy balance. After `most` kicks clogs stay.
//!
//! The time without flow, here and for the conditions of `stop`, counts from the end of a kick too.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::door::DoorState;
use crate::ending::regular::Endings;
use crate::ending::stop::avalanches::{Avalanches, check_avalanches};
use crate::ending::stop::outlet::count_above;
use crate::ending::stop::stillness::is_still;
use crate::ledger::{GrainsAccounted, Ledger};
use siloflow_dem::particle::{Force, Grain, Mass, Position};
use siloflow_dem::particles::Particles;
use siloflow_dem::persist::PersistApp as _;
use siloflow_dem::space::{Solid, Space};
use siloflow_dem::step::{Clock, ForceStage, Phase, Step, time_moves};
use siloflow_dem::values::{FiniteVector, Positive};

/// The scene key `kick`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Kick {
    /// Time without a grain that leaves, s.
    pub still: Positive,
    /// Acceleration of the grains near the outlet, m/s^2.
    pub acceleration: FiniteVector,
    /// Length of a kick, s.
    pub duration: Positive,
    /// Distance from the box around the outlet up to which grains feel the kick, m.
    pub reach: Positive,
    /// Most kicks in a run, up to 10,000.
    pub most: u16,
}

/// The scene's kick, and the boxes around its doors, m.
#[derive(Resource)]
struct Jet {
    kick: Kick,
    boxes: Vec<[Solid; 2]>,
}

/// Run condition: the flow has stopped, and kicks are left.
fn is_due(
    (clock, jet, ledger): (Res<Clock>, Res<Jet>, Res<Ledger>),
    avalanches: Res<Avalanches>,
    door: Option<Res<DoorState>>,
) -> bool {
    avalanches.all.len() < usize::from(jet.kick.most)
        && is_still(&clock, &ledger, door.as_deref(), Some(&avalanches), jet.kick.still.get())
}

fn begin<V: Space>(
    (clock, jet, ledger): (Res<Clock>, Res<Jet>, Res<Ledger>),
    particles: Particles<V>,
    mut avalanches: ResMut<Avalanches>,
) {
    if count_above(&particles, &ledger, &jet.boxes) > 0 {
        avalanches.record(clock.time(), jet.kick.duration.get(), ledger.out());
    }
}

/// Run condition: a kick is under way.
fn is_under_way(clock: Res<Clock>, avalanches: Res<Avalanches>) -> bool {
    avalanches.kick_end.is_some_and(|end| !clock.has_reached(end))
}

fn push<V: Space>(jet: Res<Jet>, mut grains: Query<(&Position<V>, &Mass, &mut Force<V>), With<Grain>>) {
    let reach = jet.kick.reach.get();
    let acceleration = jet.kick.acceleration.get::<V>();
    let is_near = |x: Solid| jet.boxes.iter().any(|&[low, high]| x.distance(x.clamp(low, high)) < reach);
    for (x, mass, mut force) in &mut grains {
        if is_near(x.0.spread()) {
            force.0 += acceleration * mass.0;
        }
    }
}

/// Kicks the grains near a clogged outlet.
pub struct KickPlugin<V: Space> {
    /// The scene's key.
    pub kick: Kick,
    /// The boxes around the doors, m.
    pub boxes: Vec<[Solid; 2]>,
    /// The space.
    pub space: PhantomData<V>,
}

impl<V: Space> Plugin for KickPlugin<V> {
    fn build(&self, app: &mut App) {
        app.insert_resource(Jet { kick: self.kick, boxes: self.boxes.clone() })
            .init_resource::<Avalanches>()
            .persist_sound::<Avalanches>()
            .check_restored(check_avalanches)
            .add_systems(Step, push::<V>.in_set(ForceStage::Added).run_if(is_under_way))
            .add_systems(
                Step,
                begin::<V>.in_set(Phase::Cull).after(GrainsAccounted).after(Endings).run_if(is_due).run_if(time_moves),
            );
    }
}
