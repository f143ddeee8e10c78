//! Who leads: components, or columns.
//!
//! A behaviour may look at grains and change them at any moment: with one, components are the live state, and every step
//! copies them into the columns and back. Without one columns are. Grains move there, and nothing is copied in a step. Until somebody
//! asks for components there are none ([`bare`]); then they are made, and follow when somebody asks again: slots that are
//! dealt out anew, the spawner, whoever is handed the world between steps ([`Simulation::step`](crate::simulation::Simulation::step)), and in
//! every step the systems that a program has added.
//!
//! What is fixed is moved by whoever moves it in its components, and copied into the columns in steps in which these have changed.

use bevy_app::App;
use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use bevy_ecs::system::SystemId;

use crate::columns::{
    BeforeRenumbering, Columns, GatheredVelocities, Kicked, Longest, Slot, SpinsDrifted, bare, settle,
};
use crate::particle::{Fixed, Force, Position, Velocity};
use crate::space::Space;
use crate::spin::{Spin, Torque};
use crate::step::{Drifted, ForceStage, Phase, Step, is_step_zero};

/// Who leads, in scenes where columns may.
#[derive(Resource, Clone, Copy, Debug)]
pub(crate) struct Lead {
    /// Makes entities of grains that are none.
    embody: Option<SystemId>,
    follow: SystemId,
    take_over: SystemId,
    state: State,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// Components are of an earlier step.
    Columns,
    /// They agree.
    Both,
    /// Somebody may have changed components.
    Components,
}

impl Lead {
    /// Gives the lead to the columns, before a step.
    pub(crate) fn to_columns(world: &mut World) {
        let Some(mut lead) = world.get_resource_mut::<Self>() else { return };
        let Self { take_over, state, .. } = *lead;
        lead.state = State::Columns;
        if state == State::Components {
            run(world, take_over);
        }
    }

    /// Brings components up to date.
    pub(crate) fn to_both(world: &mut World) {
        let Some(mut lead) = world.get_resource_mut::<Self>() else { return };
        if lead.state == State::Columns {
            lead.state = State::Both;
            let (embody, follow) = (lead.embody.take(), lead.follow);
            settle::settle(world);
            if let Some(embody) = embody {
                run(world, embody);
            }
            run(world, follow);
        }
    }

    /// Gives the lead to components.
    pub(crate) fn to_components(world: &mut World) {
        Self::to_both(world);
        if let Some(mut lead) = world.get_resource_mut::<Self>() {
            lead.state = State::Components;
        }
    }
}

fn run(world: &mut World, system: SystemId) {
    world.run_system(system).expect("it was registered with the resource, and needs nothing that may be missing");
}

/// What follows.
#[derive(QueryData)]
#[query_data(mutable)]
pub(crate) struct Follower<V: Space> {
    slot: &'static Slot,
    position: &'static mut Position<V>,
    velocity: &'static mut Velocity<V>,
    force: &'static mut Force<V>,
    spin: Option<&'static mut Spin<V::Spin>>,
    torque: Option<&'static mut Torque<V::Spin>>,
    is_fixed: Has<Fixed>,
}

/// Copies the columns into components: of what is fixed, forces alone.
pub(crate) fn follow<V: Space>(columns: Res<Columns<V>>, mut particles: Query<Follower<V>>) {
    for mut particle in &mut particles {
        let i = particle.slot.index();
        // Who has no place yet has not moved either.
        let (Some(body), Some(force)) = (columns.body.get(i), columns.loads.force.get(i)) else { continue };
        particle.force.bypass_change_detection().0 = force;
        if let (Some(torque), Some(sum)) = (&mut particle.torque, columns.loads.torque.get(i)) {
            torque.bypass_change_detection().0 = sum;
        }
        if particle.is_fixed {
            continue;
        }
        particle.position.bypass_change_detection().0 = body.position;
        particle.velocity.bypass_change_detection().0 = body.velocity;
        if let (Some(spin), Some(rotation)) = (&mut particle.spin, columns.rotation.get(i)) {
            spin.bypass_change_detection().0 = rotation.spin;
        }
    }
}

/// The same, where somebody looks in every step, at one of several times of it: a system of its own for each, so that an order of
/// systems can be asked for.
fn follow_at<V: Space, const TIME: u8>(columns: Res<Columns<V>>, particles: Query<Follower<V>>) {
    follow(columns, particles);
}

/// What may have been changed.
type Changed<V> = (
    &'static Slot,
    (&'static Position<V>, &'static Velocity<V>, &'static Force<V>),
    Option<(&'static Spin<<V as Space>::Spin>, &'static Torque<<V as Space>::Spin>)>,
);

/// Copies components into the columns.
fn take_over<V: Space>(mut columns: ResMut<Columns<V>>, grains: Query<Changed<V>, Without<Fixed>>) {
    let columns = &mut *columns;
    let mut longest = Longest::default();
    for (slot, (x, v, force), turning) in &grains {
        columns.put(*slot, x.0, v.0, &mut longest);
        columns.loads.force.set(slot.index(), force.0);
        let Some((spin, torque)) = turning else { continue };
        if let Some(rotation) = columns.rotation.get_mut(slot.index()) {
            rotation.spin = spin.0;
        }
        columns.loads.torque.set(slot.index(), torque.0);
    }
    columns.travel += longest.length();
}

/// Lets columns lead; `watched` says whether somebody looks at components in every step.
pub(super) fn add<V: Space>(app: &mut App, watched: bool) {
    let world = app.world_mut();
    let (follow, take_over) = (world.register_system(follow::<V>), world.register_system(take_over::<V>));
    world.resource_mut::<Columns<V>>().is_bare = !watched;
    let (embody, state) = if watched {
        (None, State::Components)
    } else {
        (Some(world.register_system(bare::embody::<V>)), State::Columns)
    };
    world.insert_resource(Lead { embody, follow, take_over, state });
    if watched {
        let drifted = follow_at::<V, 0>.in_set(Phase::Drift).after(Drifted).after(SpinsDrifted);
        let kicked = follow_at::<V, 1>.in_set(Phase::Kick).in_set(GatheredVelocities).after(Kicked);
        // In step zero nothing is kicked.
        let begun = follow_at::<V, 2>.in_set(ForceStage::Written).run_if(is_step_zero);
        app.add_systems(Step, (drifted, kicked, begun));
    } else {
        app.add_systems(Step, self::follow::<V>.in_set(BeforeRenumbering));
        settle::add(app);
    }
}
