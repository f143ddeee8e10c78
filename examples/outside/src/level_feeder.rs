//! A feeder that follows the level of the bed: while the level is below `level`, a grain enters at `point` every `interval`.
//!
//! The level is twice the height of the centre of mass of the grains inside over the height 0, as in a bed of the same height everywhere. A grain waits while
//! its place is taken.

use serde::{Deserialize, Serialize};
use siloflow::dem::values::FiniteVector;
use siloflow::prelude::*;

/// The scene's `behaviours: {"level_feeder": (...)}`.
#[derive(Resource, Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LevelFeeder {
    /// Level to be kept, m.
    level: f64,
    /// Place at which grains enter, m.
    point: FiniteVector,
    /// Radius of the grains, m. The scene's `mass` gives their mass.
    radius: f64,
    /// Shortest time between two grains, s.
    interval: f64,
}

/// When the next grain may enter, s.
#[derive(Resource, Default, Deserialize, Serialize)]
struct NextEntry(f64);

/// Twice the height of the centre of mass, m; 0 without grains.
fn level<V: Space>(particles: Particles<V>, ledger: Res<Ledger>) -> f64 {
    let inside = particles.grains().filter(|&row| !ledger.is_gone(particles.id(row)));
    let [moment, mass] = inside.fold([0.0, 0.0], |[moment, mass], row| {
        let m = particles.mass(row);
        [moment + m * particles.position(row).height(), mass + m]
    });
    if mass > 0.0 { 2.0 * moment / mass } else { 0.0 }
}

fn feed<V: Space>(
    In(level): In<f64>,
    feeder: Res<LevelFeeder>,
    clock: Res<Clock>,
    particles: Particles<V>,
    mut next: ResMut<NextEntry>,
    mut requests: GrainRequests<V>,
) {
    if level >= feeder.level || !clock.has_reached(next.0) {
        return;
    }
    let place = feeder.point.get::<V>();
    let is_taken = |row: usize| {
        particles.separation(particles.position(row), place).length() < particles.radius(row) + feeder.radius
    };
    if !particles.spheres().any(is_taken) {
        requests.create(NewGrain::new(place, feeder.radius), "level_feeder");
        next.0 = clock.time() + feeder.interval;
    }
}

impl Behaviour for LevelFeeder {
    fn lives_in(&self, _: Dimension) -> bool {
        true
    }

    fn build(self: Box<Self>, app: &mut App) {
        app.insert_resource(*self).init_resource::<NextEntry>().persist::<NextEntry>();
        in_space!(app, V => {
            app.series_column("level_m", "m", level::<V>);
            app.add_systems(Step, level::<V>.pipe(feed::<V>).in_set(Phase::Control))
        });
    }
}
