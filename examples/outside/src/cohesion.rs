//! A contact law of an external crate: a cohesive linear spring-dashpot, F on i = (k delta - c v_n - F_a) n.
//!
//! v_n is (v_i - v_j).n, k is in N/m, c in N s/m. F_a, in N, is a constant attraction while two particles touch. Two
//! grains without other forces come to rest at the overlap F_a/k.

use std::f64::consts::PI;
use std::sync::Arc;

use serde::Deserialize;
use siloflow::prelude::*;

/// The scene's `behaviours: {"cohesion": (...)}`, which replaces its `contact`.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cohesion {
    /// k, N/m.
    k: f64,
    /// c, N s/m.
    damping: f64,
    /// F_a, N.
    attraction: f64,
}

impl<V: Space> PairLaw<V> for Cohesion {
    fn force(&self, pair: &Pair<V>, _: &mut Memory) -> PairForce<V> {
        let elastic = self.k * pair.overlap - self.attraction;
        PairForce::along(pair.normal, elastic - self.damping * pair.normal_velocity(), elastic)
    }

    fn elastic_energy(&self, pair: &Pair<V>, _: &Memory) -> f64 {
        (0.5 * self.k * pair.overlap - self.attraction) * pair.overlap
    }

    fn stiffness(&self, _: &Bounce) -> f64 {
        self.k
    }

    fn damping(&self, _: &Bounce) -> f64 {
        self.damping
    }

    // Estimates without the attraction.
    fn contact_duration(&self, bounce: &Bounce) -> f64 {
        let decay = 0.5 * self.damping / bounce.reduced_mass;
        let squared = self.k / bounce.reduced_mass - decay * decay;
        if squared > 0.0 { PI / squared.sqrt() } else { f64::INFINITY }
    }

    fn restitution(&self, bounce: &Bounce) -> f64 {
        let decay = 0.5 * self.damping / bounce.reduced_mass;
        (-decay * <Self as PairLaw<V>>::contact_duration(self, bounce)).exp()
    }
}

impl LawRequirements for Cohesion {
    const RADII: bool = false;
}

impl Cohesion {
    fn add<V: Space>(self, app: &mut App) {
        let law = Arc::new(self);
        app.add_plugins(ContactPlugin::<V, _>::new(law));
    }
}

impl Behaviour for Cohesion {
    fn lives_in(&self, _: Dimension) -> bool {
        true
    }

    fn check(&self, scene: &Loaded) -> Result<(), String> {
        let overlap = self.attraction / self.k;
        match scene.grain_radii() {
            Some((smallest, _)) if overlap > 0.1 * smallest => Err(format!(
                "grains would rest {overlap} m deep in each other, more than a tenth of a radius: raise `k` or lower `attraction`"
            )),
            _ => Ok(()),
        }
    }

    fn brings_contact_law(&self) -> bool {
        true
    }

    fn build(self: Box<Self>, app: &mut App) {
        match Dimension::of_world(app.world()) {
            Dimension::Plane => self.add::<Plane>(app),
            Dimension::Solid => self.add::<Solid>(app),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{overlap, pair};

    #[test]
    fn two_grains_rest_at_their_equilibrium_overlap() {
        for space in [Dimension::Plane, Dimension::Solid] {
            let mut run = pair(space, "{\"cohesion\": (k: 2.0e4, damping: 20.0, attraction: 3.0)}", 0.2);
            assert_eq!(run.run(), End::TimeReached);
            let overlap = overlap(&mut run, space);
            assert!((overlap / (3.0 / 2.0e4) - 1.0).abs() < 1e-9, "{overlap}");
        }
    }
}
