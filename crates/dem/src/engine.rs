//! The plugins whose loops take the time of a run, compiled in this crate for both spaces.
//!
//! These plugins are generic over the space, and the compiler makes code of a generic function in the crate that names its types. So
//! [`Engine`] names them here. Its methods add a plugin to an app, like `App::add_plugins`.

use std::sync::Arc;

use bevy_app::App;

use crate::contact::centred::velocity_prediction::VelocityPredictionPlugin;
use crate::contact::law::{LawRequirements, PairLaw};
use crate::contact::plugin::ContactPlugin;
use crate::contact::selection::{Contacts, LawReceiver};
use crate::integrate::IntegratorPlugin;
use crate::integrate::rigid::BodiesPlugin;
use crate::integrate::rotation::SpinPlugin;
use crate::integrate::wrap::PeriodicPlugin;
use crate::neighbours::NeighboursPlugin;
use crate::space::{Plane, Solid, Space};
use crate::store::StorePlugin;

macro_rules! engine {
    ($($name:ident: $plugin:ident,)*) => {
        /// A space with its compiled plugins.
        pub trait Engine: Space {
            $(
                #[doc = concat!("Adds a [`", stringify!($plugin), "`].")]
                fn $name(app: &mut App, plugin: $plugin<Self>);
            )*

            /// Adds the [`ContactPlugin`] with the law of a scene.
            fn add_contacts(app: &mut App, contacts: &Contacts);
        }

        engine!(@space Plane, $($name: $plugin,)*);
        engine!(@space Solid, $($name: $plugin,)*);
    };
    (@space $space:ident, $($name:ident: $plugin:ident,)*) => {
        impl Engine for $space {
            $(
                fn $name(app: &mut App, plugin: $plugin<Self>) {
                    app.add_plugins(plugin);
                }
            )*

            fn add_contacts(app: &mut App, contacts: &Contacts) {
                contacts.pass_to::<Self, _>(AddContacts(app));
            }
        }
    };
}

engine! {
    add_store: StorePlugin,
    add_neighbours: NeighboursPlugin,
    add_integrator: IntegratorPlugin,
    add_periodic: PeriodicPlugin,
    add_spins: SpinPlugin,
    add_bodies: BodiesPlugin,
    add_velocity_prediction: VelocityPredictionPlugin,
}

struct AddContacts<'a>(&'a mut App);

impl<V: Space> LawReceiver<V> for AddContacts<'_> {
    type Output = ();

    fn receive<L: PairLaw<V> + LawRequirements>(self, law: L) {
        self.0.add_plugins(ContactPlugin::<V, L>::new(Arc::new(law)));
    }
}
