//! The spawner: releases grains one after the other at a point.
//!
//! A grain is due `interval` after the one before it. It enters at `point` plus a jitter, uniform within the given
//! half-widths, with the given velocity, and at first feels only its weight. If its place overlaps anything, the
//! release waits, so that no overlap energy is injected; the next one is due `interval` after the actual release.
//! After `release_timeout` of waiting the run ends with the reason. Jitter and radius of a grain depend only on
//! the seed and the grain's number.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::grains::mass::MassLaw;
use crate::gravity::Gravity;
use crate::messages::GrainReleased;
use crate::outcome::{Failure, Outcome};
use crate::particle::{Force, Grain, GrainBundle, GrainId, Mass, Particle, Position, Radius, Species, Velocity};
use crate::particles::Particles;
use crate::periodic::Periodic;
use crate::random::Stream;
use crate::space::Space;
use crate::step::{Clock, Phase, Step};
use crate::store::PlainCommands;
use crate::values::{FiniteVector, NonNegative, Positive, Share};
use crate::walls::surfaces::Surfaces;

/// The scene's `spawner`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Spawner {
    /// Where grains are released, m.
    pub point: FiniteVector,
    /// Half-widths of the uniform jitter of the release point, m. Default none: one exact column.
    #[serde(default)]
    pub jitter: Option<FiniteVector>,
    /// Velocity at release, m/s.
    pub velocity: FiniteVector,
    /// Time between releases, s.
    pub interval: Positive,
    /// How many grains.
    pub count: u32,
    /// Their radii, m.
    pub radius: RadiusLaw,
    /// How long a release may wait for its place before the run ends, s. Default 10.
    #[serde(default = "patience")]
    pub release_timeout: NonNegative,
}

/// The scene's `spawner.radius`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub enum RadiusLaw {
    /// All the same, m.
    Fixed(Positive),
    /// Sizes (radius in m, share), in random order but with exact shares of the count, to the grain. The shares sum
    /// to 1; the place in the list is the species.
    Mixture(Vec<(Positive, Share)>),
    /// Uniform between two radii, m.
    Uniform(Positive, Positive),
}

fn patience() -> NonNegative {
    NonNegative::try_from(10.0).expect("ten is positive")
}

impl RadiusLaw {
    /// Smallest and largest radius, m.
    #[must_use]
    pub fn range(&self) -> (f64, f64) {
        match self {
            Self::Fixed(radius) => (radius.get(), radius.get()),
            Self::Uniform(a, b) => (a.get().min(b.get()), a.get().max(b.get())),
            Self::Mixture(sizes) => {
                let radii = || sizes.iter().map(|(radius, _)| radius.get());
                (radii().fold(f64::INFINITY, f64::min), radii().fold(0.0, f64::max))
            }
        }
    }

    /// How many of `count` grains each size of a mixture gets: shares rounded, the last size takes the rest.
    pub(crate) fn quotas(&self, count: u32) -> Vec<u32> {
        let Self::Mixture(sizes) = self else { return Vec::new() };
        let mut left = count;
        let mut quotas: Vec<u32> = sizes
            .iter()
            .map(|(_, share)| {
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "a share of a count is one"
                )]
                let quota = ((share.get() * f64::from(count)).round() as u32).min(left);
                left -= quota;
                quota
            })
            .collect();
        if let Some(last) = quotas.last_mut() {
            *last += left;
        }
        quotas
    }

    /// Radius (m) and species of a grain from its random number; `quotas` are what is left of each size.
    pub(crate) fn choose(&self, u: f64, quotas: &mut [u32]) -> (f64, Species) {
        match self {
            Self::Fixed(radius) => (radius.get(), Species(0)),
            Self::Uniform(a, b) => (a.get() + u * (b.get() - a.get()), Species(0)),
            Self::Mixture(sizes) => {
                let mut ticket = u * f64::from(quotas.iter().sum::<u32>());
                let mut chosen = quotas.iter().rposition(|&quota| quota > 0).unwrap_or(0);
                for (size, &quota) in quotas.iter().enumerate() {
                    if ticket < f64::from(quota) {
                        chosen = size;
                        break;
                    }
                    ticket -= f64::from(quota);
                }
                quotas[chosen] = quotas[chosen].saturating_sub(1);
                (sizes[chosen].0.get(), Species(u8::try_from(chosen).unwrap_or(u8::MAX)))
            }
        }
    }
}

/// Grains that are still to come, from whatever source; rest and the end of a run wait for them.
#[derive(Resource, Default, Debug)]
pub struct Pending(pub u32);

/// What became of the releases, for the report.
#[derive(Resource, Default, Debug, Clone, Copy, Serialize)]
pub struct ReleaseDelays {
    /// Releases that had to wait for their place.
    pub delayed_releases: u32,
    /// Longest wait, s.
    pub longest_delay_s: f64,
}

#[derive(Resource)]
struct SpawnerState<V: Space> {
    config: Spawner,
    mass: MassLaw,
    random: Stream,
    quotas: Vec<u32>,
    next_id: u32,
    due: f64,
    is_blocked: bool,
    waiting: Option<Candidate<V>>,
}

#[derive(Clone, Copy)]
struct Candidate<V> {
    id: GrainId,
    position: V,
    radius: f64,
    species: Species,
}

impl<V: Space> SpawnerState<V> {
    fn candidate(&mut self, periodic: Option<&Periodic<V>>) -> Option<Candidate<V>> {
        if self.waiting.is_none() {
            let id = GrainId::grain(self.next_id)?;
            let [u, share @ ..] = self.random.uniform::<4>(u64::from(self.next_id));
            let (radius, species) = self.config.radius.choose(u, &mut self.quotas);
            let half_widths = self.config.jitter.map_or(V::ZERO, FiniteVector::get);
            let mut position = self.config.point.get::<V>();
            for (axis, share) in share.into_iter().enumerate().take(V::COMPONENTS) {
                position = position.with_axis(axis, position.axis(axis) + half_widths.axis(axis) * (2.0 * share - 1.0));
            }
            let position = periodic.map_or(position, |periodic| periodic.wrapped(position));
            self.waiting = Some(Candidate { id, position, radius, species });
        }
        self.waiting
    }
}

#[expect(clippy::too_many_arguments, reason = "what a release touches")]
fn release<V: Space>(
    mut commands: Commands,
    particles: Particles<V>,
    mut state: ResMut<SpawnerState<V>>,
    mut pending: ResMut<Pending>,
    mut delays: ResMut<ReleaseDelays>,
    mut outcome: ResMut<Outcome>,
    mut released: MessageWriter<GrainReleased>,
    (clock, gravity, walls): (Res<Clock>, Res<Gravity<V>>, Res<Surfaces<V>>),
) {
    let Some(grain) = state.candidate(particles.periodic()) else { return };
    let waited = clock.time() - state.due;
    if let Some(blocker) = blocker(&grain, &particles, &walls) {
        state.is_blocked = true;
        if waited > state.config.release_timeout.get() {
            outcome.fail(Failure::ReleaseBlocked { step: clock.steps, grain: grain.id, waited_s: waited, blocker });
        }
        return;
    }
    if state.is_blocked {
        if delays.delayed_releases == 0 {
            tracing::warn!(
                "t = {:.3} s: {} was released {waited:.3} s late, its place was taken",
                clock.time(),
                grain.id
            );
        }
        delays.delayed_releases += 1;
        delays.longest_delay_s = delays.longest_delay_s.max(waited);
    }
    let mass = state.mass.of(grain.radius);
    commands.spawn(GrainBundle {
        particle: Particle {
            id: grain.id,
            position: Position(grain.position),
            velocity: Velocity(state.config.velocity.get()),
            force: Force(gravity.0 * mass),
            radius: Radius(grain.radius),
        },
        mass: Mass(mass),
        species: grain.species,
        grain: Grain,
    });
    released.write(GrainReleased { id: grain.id });
    pending.0 -= 1;
    state.waiting = None;
    state.next_id += 1;
    // On time, the next moment is counted from this one's due time, so that moments do not drift by round-off.
    let now = if state.is_blocked { clock.time() } else { state.due };
    state.due = now + state.config.interval.get();
    state.is_blocked = false;
}

fn blocker<V: Space>(grain: &Candidate<V>, particles: &Particles<V>, walls: &Surfaces<V>) -> Option<String> {
    let overlaps = |row: usize| {
        let reach = particles.radius(row) + grain.radius;
        particles.separation(particles.position(row), grain.position).length() < reach
    };
    if let Some(row) = particles.all().find(|&row| overlaps(row)) {
        return Some(particles.id(row).to_string());
    }
    let wall =
        walls.0.iter().position(|wall| wall.is_present && wall.surface.distance(grain.position) < grain.radius)?;
    Some(format!("flat wall {} of the scene", wall + 1))
}

fn release_due<V: Space>(clock: Res<Clock>, state: Res<SpawnerState<V>>, pending: Res<Pending>) -> bool {
    pending.0 > 0 && clock.has_reached(state.due)
}

/// A spawner whose grains get ids from `first_id` on.
pub struct SpawnerPlugin<V: Space> {
    /// What the scene says.
    pub config: Spawner,
    /// How heavy grains are.
    pub mass: MassLaw,
    /// The scene's seed.
    pub seed: u64,
    /// Id of the first grain.
    pub first_id: u32,
    /// Where.
    pub space: PhantomData<V>,
}

impl<V: Space> Plugin for SpawnerPlugin<V> {
    fn build(&self, app: &mut App) {
        app.world_mut().resource_mut::<Pending>().0 += self.config.count;
        app.init_resource::<ReleaseDelays>().insert_resource(SpawnerState::<V> {
            config: self.config.clone(),
            mass: self.mass,
            random: Stream::new(self.seed, "spawner"),
            quotas: self.config.radius.quotas(self.config.count),
            next_id: self.first_id,
            due: 0.0,
            is_blocked: false,
            waiting: None,
        });
        app.add_systems(Step, release::<V>.in_set(Phase::Spawn).in_set(PlainCommands).run_if(release_due::<V>));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mixture_has_its_shares_to_the_grain() {
        let size = |radius: f64, share: f64| (radius.try_into().unwrap(), share.try_into().unwrap());
        let law = RadiusLaw::Mixture(vec![size(0.04, 0.5), size(0.03, 0.3), size(0.02, 0.2)]);
        let mut quotas = law.quotas(1001);
        assert_eq!(quotas, [501, 300, 200]);
        let random = Stream::new(3, "spawner");
        let mut counts = [0; 3];
        for grain in 0..1001 {
            let [u] = random.uniform(grain);
            counts[usize::from(law.choose(u, &mut quotas).1.0)] += 1;
        }
        assert_eq!(counts, [501, 300, 200]);
    }
}
