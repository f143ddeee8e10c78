//! A constant attraction of grains in contact, in addition to any contact law of the scene.
//!
//! Under a linear law of stiffness k two grains come to rest at the overlap F/k.

use serde::Deserialize;
use siloflow::prelude::*;

/// The scene's `behaviours: {"attraction": (force: ...)}`.
#[derive(Resource, Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Attraction {
    /// F, N.
    force: f64,
}

fn attract<V: Space>(attraction: Res<Attraction>, mut contacts: PairForces<V>) {
    contacts.add(|contact| contact.normal() * -attraction.force);
}

impl Behaviour for Attraction {
    fn lives_in(&self, _: Dimension) -> bool {
        true
    }

    fn build(self: Box<Self>, app: &mut App) {
        app.insert_resource(*self);
        in_space!(app, V => app.add_systems(Step, attract::<V>.in_set(ForceStage::Added)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{overlap, pair};

    #[test]
    fn two_grains_rest_at_their_equilibrium_overlap() {
        for space in [Dimension::Plane, Dimension::Solid] {
            let mut run = pair(space, "{\"attraction\": (force: 2.0), \"air_drag\": (linear: 0.0)}", 0.3);
            assert_eq!(run.run(), End::TimeReached);
            let overlap = overlap(&mut run, space);
            assert!((overlap / (2.0 / 1.0e4) - 1.0).abs() < 1e-9, "{overlap}");
        }
    }
}
