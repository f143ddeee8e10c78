//! Near walls: lists which grains are near which walls, so that all others need no wall test in most steps.
//!
//! A grain is near a wall if the gap between their surfaces is less than the largest grain radius. In a packing, most
//! near grains touch the wall. The list is valid until a grain may have moved by that distance, or a wall has changed.

use crate::displacement_trigger::DisplacementTrigger;
use crate::neighbours::list::Candidate;
use crate::space::Space;
use crate::store::ParticleStore;
use crate::walls::surfaces::SurfaceWall;

/// Pairs of a slot and a wall index, ascending.
#[derive(Debug, Default)]
pub struct NearWalls {
    pairs: Vec<Candidate>,
    trigger: DisplacementTrigger,
}

impl NearWalls {
    /// Returns the present pairs; updates them if needed.
    pub fn of<V: Space>(
        &mut self,
        store: &ParticleStore<V>,
        walls: &[SurfaceWall<V>],
        has_changed: bool,
    ) -> &[Candidate] {
        if walls.is_empty() {
            return &[];
        }
        if has_changed || self.trigger.has_fired(store.travel_meter(), store.prediction.margin) {
            let grains = &store.body[..store.movable_end];
            let slack = grains.iter().map(|body| body.radius).fold(0.0, f64::max);
            self.pairs.clear();
            for (i, body) in (0u32..).zip(grains) {
                for (number, wall) in (0u32..).zip(walls) {
                    // Written so that NaN counts as not near.
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
