//! Spawner: releases grains one after the other at a point.
//!
//! A grain is due `interval` after the previous one. It enters at `point` plus a uniform jitter within the given
//! half-widths, with the given velocity. At first only its weight acts on it.
//!
//! If the grain would overlap any particle or wall, its release is delayed, so that no overlap energy enters. The next
//! grain is due `interval` after the actual release. If the delay exceeds `release_timeout`, the run fails and states
//! the reason. Jitter and radius depend only on the seed and the number of the grain.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::grains::feed;
use crate::grains::file::GrainRow;
use crate::grains::mass::MassLaw;
use crate::grains::pending::{LeftOfSpawner, Pending};
use crate::grains::shaped::{OrientationLaw, Posture, ShapeNames, Shaped};
use crate::grains::sizes::{GrainSize, RadiusLaw, are_quotas};
use crate::random::Stream;
use siloflow_dem::messages::GrainReleased;
use siloflow_dem::outcome::{Failure, Outcome};
use siloflow_dem::particle::{Grain, GrainBundle, GrainId, Mass, Particle, Position, Radius, Species, Velocity};
use siloflow_dem::particles::Particles;
use siloflow_dem::periodic::Periodic;
use siloflow_dem::persist::{PersistApp as _, Problem};
use siloflow_dem::space::{Solid, Space};
use siloflow_dem::step::{Clock, Phase, Step};
use siloflow_dem::store::PlainCommands;
use siloflow_dem::values::{FiniteVector, NonNegative, Positive};
use siloflow_dem::walls::surface_wall::SurfaceWall;
use siloflow_dem::walls::surfaces::Surfaces;

/// The scene key `spawner`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Spawner {
    /// Release point, m.
    pub point: FiniteVector,
    /// Half-widths of the uniform jitter of the release point, m. Default 0: all grains enter at exactly one point.
    #[serde(default)]
    pub jitter: Option<FiniteVector>,
    /// Velocity at release, m/s.
    pub velocity: FiniteVector,
    /// Time between releases, s.
    pub interval: Positive,
    /// Number of grains.
    pub count: u32,
    /// Radii, m; of shaped grains those of spheres (discs) of equal volume (area). Default: none, needed without `shape`.
    #[serde(default)]
    pub radius: RadiusLaw,
    /// Name of the shape of these grains, or one for each size of a mixture. Default: spheres (discs).
    pub shape: Option<ShapeNames>,
    /// Sizes over that of the shape. Default: 1.
    pub scale: Option<RadiusLaw>,
    /// Orientations of shaped grains. Default: random.
    pub orientation: Option<OrientationLaw>,
    /// The shape, once the scene is loaded.
    #[serde(skip)]
    pub shaped: Option<Shaped>,
    /// Longest delay of a release before the run fails, s. Default 10.
    #[serde(default = "default_timeout")]
    pub release_timeout: NonNegative,
}

/// Default of `release_timeout`, s.
fn default_timeout() -> NonNegative {
    NonNegative::try_from(10.0).expect("10 is not negative")
}

/// Delays of releases, for the summary.
#[derive(Resource, Default, Debug, Clone, Copy, Serialize, Deserialize)]
pub struct ReleaseDelays {
    /// Number of releases that were delayed because their place was occupied.
    pub delayed_releases: u32,
    /// Longest delay, s.
    pub longest_delay_s: f64,
}

/// State of the spawner.
#[derive(Resource)]
pub(super) struct SpawnerState<V: Space> {
    config: Spawner,
    mass: MassLaw,
    random: Stream,
    quotas: Vec<u32>,
    /// The id of its first grain.
    first_id: u32,
    next_id: u32,
    /// Time at which the next grain is due, s.
    due: f64,
    /// Whether the release of the next grain is delayed.
    is_blocked: bool,
    /// The next grain, once its random numbers are drawn.
    next: Option<Candidate<V>>,
}

impl Spawner {
    /// Returns the random numbers of the spawner.
    fn stream(seed: u64) -> Stream {
        Stream::new(seed, "spawner")
    }

    /// Returns the grain with this id. Grains are drawn in the order of their ids.
    fn draw<V: Space>(&self, random: &Stream, id: GrainId, quotas: &mut [u32]) -> Candidate<V> {
        let [u, x, y, z, turns @ ..] = random.uniform::<7>(u64::from(id.number()));
        let GrainSize { radius, species } = self.radius.choose(u, quotas);
        let half_widths = self.jitter.map_or(V::ZERO, FiniteVector::get);
        let mut position = self.point.get::<V>();
        for (axis, share) in [x, y, z].into_iter().enumerate().take(V::COMPONENTS) {
            position = position.with_axis(axis, position.axis(axis) + half_widths.axis(axis) * (2.0 * share - 1.0));
        }
        let posture = self.shaped.as_ref().map(|shaped| shaped.posture::<V>(usize::from(species.0), radius, turns));
        Candidate { id, position, radius, species, posture }
    }

    /// Returns the grains in the order of their release, for programs that release them themselves.
    #[must_use]
    pub fn grains<V: Space>(&self, mass: MassLaw, seed: u64, first_id: u32) -> Vec<GrainRow> {
        let random = Self::stream(seed);
        let mut quotas = self.radius.quotas(self.count);
        let grain = |number: u32| {
            let id = GrainId::grain(first_id.checked_add(number)?)?;
            let Candidate { position, radius, species, posture, .. } = self.draw::<V>(&random, id, &mut quotas);
            let position = position.spread();
            let velocity = self.velocity.padded();
            Some(GrainRow {
                id,
                radius,
                mass: mass.of(radius),
                position,
                velocity,
                spin: Solid::ZERO,
                posture,
                species,
            })
        };
        (0..self.count).map_while(grain).collect()
    }
}

/// A grain to be released.
#[derive(Clone, Copy, Deserialize, Serialize)]
struct Candidate<V> {
    id: GrainId,
    position: V,
    radius: f64,
    species: Species,
    posture: Option<Posture>,
}

impl<V> Candidate<V> {
    /// Radius of the smallest sphere about the centre that holds the grain, m.
    fn reach(&self) -> f64 {
        self.posture.map_or(self.radius, |posture| posture.reach)
    }
}

/// The part of the state that changes.
#[derive(Deserialize, Serialize)]
struct Progress<V> {
    quotas: Vec<u32>,
    next_id: u32,
    due: f64,
    is_blocked: bool,
    next: Option<Candidate<V>>,
}

impl<V: Space> SpawnerState<V> {
    fn progress(&self) -> Progress<V> {
        Progress {
            quotas: self.quotas.clone(),
            next_id: self.next_id,
            due: self.due,
            is_blocked: self.is_blocked,
            next: self.next,
        }
    }

    /// Takes over the part that changes.
    ///
    /// # Errors
    /// If the spawner of the scene cannot have it.
    fn restore(&mut self, saved: Progress<V>) -> Result<(), Problem> {
        let Progress { quotas, next_id, due, is_blocked, next } = saved;
        let count = self.config.count;
        let is_next = |grain: &Candidate<V>| GrainId::grain(next_id) == Some(grain.id) && grain.radius > 0.0;
        let released = next_id.checked_sub(self.first_id).filter(|released| *released <= count);
        if released.is_none() || !are_quotas(&quotas, &self.quotas, count) || !next.iter().all(is_next) {
            return Err("it has released other grains than the scene's spawner can".to_owned());
        }
        self.quotas = quotas;
        self.next_id = next_id;
        self.due = due;
        self.is_blocked = is_blocked;
        self.next = next;
        Ok(())
    }

    /// Number of grains still to be released.
    pub(super) fn left(&self) -> u32 {
        self.config.count.saturating_sub(self.next_id - self.first_id)
    }

    /// Returns the next grain, and draws its random numbers if needed.
    fn candidate(&mut self, periodic: Option<&Periodic<V>>) -> Option<Candidate<V>> {
        if self.next.is_none() {
            let id = GrainId::grain(self.next_id)?;
            let mut grain = self.config.draw::<V>(&self.random, id, &mut self.quotas);
            grain.position = periodic.map_or(grain.position, |periodic| periodic.wrapped(grain.position));
            self.next = Some(grain);
        }
        self.next
    }
}

#[expect(clippy::too_many_arguments, reason = "a release reads and writes all of them")]
fn release<V: Space>(
    mut commands: Commands,
    particles: Particles<V>,
    mut state: ResMut<SpawnerState<V>>,
    mut pending: ResMut<Pending>,
    mut delays: ResMut<ReleaseDelays>,
    mut outcome: ResMut<Outcome>,
    mut released: MessageWriter<GrainReleased>,
    clock: Res<Clock>,
    walls: Res<Surfaces<V>>,
) {
    let Some(grain) = state.candidate(particles.periodic()) else { return };
    let delay = clock.time() - state.due;
    if let Some(blocker) = blocker(&grain, &particles, &walls) {
        state.is_blocked = true;
        if delay > state.config.release_timeout.get() {
            outcome.fail(Failure::ReleaseBlocked { step: clock.steps, grain: grain.id, waited_s: delay, blocker });
        }
        return;
    }
    if state.is_blocked {
        if delays.delayed_releases == 0 {
            tracing::warn!(
                "t = {:.3} s: {} was released {delay:.3} s late, its place was taken",
                clock.time(),
                grain.id
            );
        }
        delays.delayed_releases += 1;
        delays.longest_delay_s = delays.longest_delay_s.max(delay);
    }
    let mass = state.mass.of(grain.radius);
    let mut new = commands.spawn(GrainBundle {
        particle: Particle {
            id: grain.id,
            position: Position(grain.position),
            velocity: Velocity(state.config.velocity.get()),
            radius: Radius(grain.radius),
        },
        mass: Mass(mass),
        species: grain.species,
        grain: Grain,
    });
    if let Some(posture) = grain.posture {
        new.insert(posture.components::<V>());
    }
    released.write(GrainReleased { id: grain.id });
    pending.0 -= 1;
    state.next = None;
    state.next_id += 1;
    // After a release on time, the next due time is counted from this due time, so that due times do not drift by
    // round-off.
    let now = if state.is_blocked { clock.time() } else { state.due };
    state.due = now + state.config.interval.get();
    state.is_blocked = false;
}

/// Returns the name of a particle or wall that `grain` would overlap.
fn blocker<V: Space>(grain: &Candidate<V>, particles: &Particles<V>, walls: &Surfaces<V>) -> Option<String> {
    let overlaps = |row: usize| {
        let reach = particles.radius(row) + grain.reach();
        particles.separation(particles.position(row), grain.position).length() < reach
    };
    if let Some(row) = particles.spheres().find(|&row| overlaps(row)) {
        return Some(particles.id(row).to_string());
    }
    let overlaps = |wall: &&SurfaceWall<V>| wall.is_present && wall.surface.distance(grain.position) < grain.reach();
    let near = walls.near(grain.position, grain.reach());
    let wall = near.iter().map(|index| &walls.all[index]).find(overlaps)?;
    Some(format!("wall {} of the scene", wall.number + 1))
}

fn release_due<V: Space>(clock: Res<Clock>, state: Res<SpawnerState<V>>, pending: Res<Pending>) -> bool {
    pending.0 > 0 && clock.has_reached(state.due)
}

/// Spawner of a scene.
pub struct SpawnerPlugin<V: Space> {
    /// Configuration.
    pub config: Spawner,
    /// Law for the masses of grains.
    pub mass: MassLaw,
    /// The scene's seed.
    pub seed: u64,
    /// Id of the first grain.
    pub first_id: u32,
    /// The space.
    pub space: PhantomData<V>,
}

impl<V: Space> Plugin for SpawnerPlugin<V> {
    fn build(&self, app: &mut App) {
        app.world_mut().resource_mut::<Pending>().0 += self.config.count;
        app.persist_sound::<ReleaseDelays>()
            .check_restored(feed::check_restored::<V>)
            .persist_sound_part::<SpawnerState<V>, _>(|state| Ok(state.progress()), SpawnerState::restore);
        app.derived::<LeftOfSpawner>();
        let left = |world: &World| world.get_resource::<SpawnerState<V>>().map_or(0, SpawnerState::left);
        app.insert_resource(LeftOfSpawner(left));
        app.init_resource::<ReleaseDelays>().insert_resource(SpawnerState::<V> {
            config: self.config.clone(),
            mass: self.mass,
            random: Spawner::stream(self.seed),
            quotas: self.config.radius.quotas(self.config.count),
            first_id: self.first_id,
            next_id: self.first_id,
            due: 0.0,
            is_blocked: false,
            next: None,
        });
        app.add_systems(Step, release::<V>.in_set(Phase::Spawn).in_set(PlainCommands).run_if(release_due::<V>));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mixture_has_exact_shares() {
        let size = |radius: f64, share: f64| (radius.try_into().unwrap(), share.try_into().unwrap());
        let law = RadiusLaw::Mixture(vec![size(0.04, 0.5), size(0.03, 0.3), size(0.02, 0.2)]);
        let mut quotas = law.quotas(1001);
        assert_eq!(quotas, [501, 300, 200]);
        let random = Stream::new(3, "spawner");
        let mut counts = [0; 3];
        for grain in 0..1001 {
            let [u] = random.uniform(grain);
            counts[usize::from(law.choose(u, &mut quotas).species.0)] += 1;
        }
        assert_eq!(counts, [501, 300, 200]);
    }
}
