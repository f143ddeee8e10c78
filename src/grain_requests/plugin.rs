//! The plugin that carries out requests.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::grain_requests::Waiting;
use crate::grain_requests::accounts::Accounts;
use crate::grain_requests::carry_out::{are_waiting, carry_out};
use crate::grain_requests::request::GrainMade;
use crate::grain_requests::resolve::Rules;
use crate::grains::mass::MassLaw;
use siloflow_dem::persist::PersistApp as _;
use siloflow_dem::space::Space;
use siloflow_dem::step::{Part, Step};

/// Adds the requests of behaviours ([`GrainRequests`](super::GrainRequests)).
pub struct RequestsPlugin<V: Space> {
    /// The scene's `mass`.
    pub mass: Option<MassLaw>,
    /// The space.
    pub space: PhantomData<V>,
}

impl<V: Space> Plugin for RequestsPlugin<V> {
    fn build(&self, app: &mut App) {
        app.init_resource::<Waiting<V>>()
            .init_resource::<Accounts<V>>()
            .insert_resource(Rules { mass: self.mass })
            .persist_sound::<Waiting<V>>()
            .persist_sound::<Accounts<V>>()
            .add_message::<GrainMade>()
            // Requests are sorted before they are carried out.
            .allow_ambiguous_resource::<Waiting<V>>()
            .add_systems(Step, carry_out::<V>.run_if(are_waiting::<V>).in_set(Part::Requests));
    }
}
