//! Which grains are near which walls: all others are spared the look at every wall in every step.
//!
//! A grain is near a wall if its surface is less than a radius of the largest grain away from it: of a packing those
//! are mostly the ones that touch it. The list holds until somebody can have gone that far, or a wall has changed.

use crate::displacement_trigger::DisplacementTrigger;
use crate::neighbours::list::Candidate;
use crate::space::Space;
use crate::store::ParticleStore;
use crate::walls::surfaces::FlatWall;

/// Pairs of an entry of the columns and a wall's index, ascending.
#[derive(Debug, Default)]
pub struct NearWalls {
    pairs: Vec<Candidate>,
    trigger: DisplacementTrigger,
}

impl NearWalls {
    /// Those of now.
    pub fn of<V: Space>(&mut self, store: &ParticleStore<V>, walls: &[FlatWall<V>], has_changed: bool) -> &[Candidate] {
        if walls.is_empty() {
            return &[];
        }
        if has_changed || self.trigger.has_fired(store.travel_meter(), store.margin) {
            let grains = &store.body[..store.movable_end];
            let slack = grains.iter().map(|body| body.radius).fold(0.0, f64::max);
            self.pairs.clear();
            for (i, body) in (0u32..).zip(grains) {
                for (number, wall) in (0u32..).zip(walls) {
                    // Written so that a NaN is near nothing.
                    if wall.surface.distance(body.position) < body.radius + slack {
                        self.pairs.push(Candidate::new(i, number));
                    }
                }
            }
            self.trigger = DisplacementTrigger::for_distance(store.travel_meter(), slack);
        }
        &self.pairs
    }
}
