//! A magnet at a point pulls grains of one species: F = -s x/(x^2 + c^2)^(3/2), with x the vector from the magnet, s the strength in
//! N m^2 and c the size of the magnet. The potential energy is -s/sqrt(x^2 + c^2).

use serde::Deserialize;
use siloflow::dem::values::{FiniteVector, Positive};
use siloflow::prelude::*;

/// The scene's `behaviours: {"magnet": (at: ..., strength: ..., size: ..., species: ...)}`.
#[derive(Resource, Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Magnet {
    /// Its place, m.
    at: FiniteVector,
    /// s, N m^2.
    strength: f64,
    /// c, m.
    size: Positive,
    /// The species that it pulls.
    species: u8,
}

fn pull<V: Space>(magnet: Res<Magnet>, mut grains: AddForce<V, (&'static Position<V>, &'static Species)>) {
    let place = magnet.at.get::<V>();
    grains.each(|(position, species)| {
        if species.0 != magnet.species {
            return V::ZERO;
        }
        let way = position.0 - place;
        let distance = (way.length_squared() + magnet.size.get() * magnet.size.get()).sqrt();
        way * (-magnet.strength / (distance * distance * distance))
    });
}

impl Behaviour for Magnet {
    fn lives_in(&self, _: Dimension) -> bool {
        true
    }

    fn build(self: Box<Self>, app: &mut App) {
        app.insert_resource(*self);
        in_space!(app, V => app.add_systems(Step, pull::<V>.in_set(ForceStage::Added)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::simulation;

    /// A grain released at rest 0.5 m from the magnet, seen at each step: potential and kinetic energy.
    fn energies<V: Space>(gravity: &str, at: &str) -> Vec<f64> {
        let text = format!(
            "(space: {:?}, gravity: {gravity}, grains: (file: \"pair.csv\"), step: Fixed(1.0e-4), until: 0.2, \
              contact: Linear(k: 1.0e4, damping: B(0.0)), pictures: None, \
              behaviours: {{\"magnet\": (at: {at}, strength: 0.5, size: 0.1, species: 0), \"air_drag\": (linear: 0.0)}})",
            V::DIMENSION
        );
        let mut run = simulation("magnet", text);
        let mut found = Vec::new();
        while run.step().is_none() {
            let world = run.world_mut();
            let mut grains = world.query::<(&Species, &Mass, &Position<V>, &Velocity<V>)>();
            let one = grains.iter(world).find(|grain| grain.0.0 == 0).expect("a grain of species 0");
            let way = one.2.0 - V::narrow(Solid::new(0.0, 0.5, 0.0));
            let potential = -0.5 / (way.length_squared() + 0.01).sqrt();
            found.push(potential + 0.5 * one.1.0 * one.3.0.length_squared());
        }
        found
    }

    #[test]
    fn a_grain_keeps_its_energy_while_it_falls_into_the_magnet() {
        let plane = energies::<Plane>("(0.0, 0.0)", "(0.0, 0.5)");
        let solid = energies::<Solid>("(0.0, 0.0, 0.0)", "(0.0, 0.5, 0.0)");
        for all in [plane, solid] {
            // Verlet: the error of the energy is of the order w^2 dt^2/8 of the depth, w^2 = s/(m c^3) at most, 3.1e3/s^2.
            let depth = 0.5 / 0.1;
            let limit = depth * 3.2e3 * 1e-8 / 8.0;
            let first = all[0];
            assert!(all.iter().all(|energy| (energy - first).abs() < limit), "{all:?}");
        }
    }
}
