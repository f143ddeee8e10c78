//! Feed: releases grains at a rate, at random places of a region.
//!
//! The amount due at time t is `rate` (t - `from`), in grains or in kg. A grain is due when this amount exceeds all that has entered.
//! Its centre is uniform among the places of `region` where it overlaps no particle and no wall: places are drawn until one is free.
//! So no elastic energy enters. Its velocity is `velocity` plus a Gaussian `agitation`; in scenes whose grains spin, its spin is Gaussian.
//!
//! * Bounded effort: in one step a feed draws at most `tries` places, so no more grains enter. A grain that finds no free place waits, and
//!   tries again in the next step. Grains enter in the order in which they are due, so the sizes that enter have the distribution of `radius`.
//! * A feed that was late catches up as soon as there is room. [`FeedFigures`] tells how much is missing.
//! * If a grain waits for longer than `timeout`, the run fails and states the reason.
//!
//! Random numbers depend only on the seed, the number of the feed, the number of the grain and of its try.
//!
//! Limits: a step with a grain due compares each try with every particle near the region. A `total` in kg is rounded to grains of the mean
//! mass. Equal grains that do not move away fill a region to at most 0.55 of an area or 0.38 of a volume ([`super::fill`] has sources).

mod inlet;

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use self::inlet::{Inlet, Progress, Released};
use crate::grains::free_id::FreeId;
use crate::grains::mass::MassLaw;
use crate::grains::pending::{LeftOfSpawner, Pending};
use crate::grains::region::Region;
use crate::grains::shaped::{OrientationLaw, ShapeNames, Shaped, largest_reach, reach};
use crate::grains::sizes::RadiusLaw;
use siloflow_dem::messages::GrainReleased;
use siloflow_dem::outcome::{Failure, Outcome};
use siloflow_dem::particle::Species;
use siloflow_dem::particle::{Grain, GrainBundle, GrainId, Mass, Particle, Position, Radius, Velocity};
use siloflow_dem::particles::Particles;
use siloflow_dem::persist::{PersistApp as _, Problem};
use siloflow_dem::space::Space;
use siloflow_dem::spin::{InertiaLaw, Spin};
use siloflow_dem::step::{Clock, Phase, Step};
use siloflow_dem::store::PlainCommands;
use siloflow_dem::values::{FiniteVector, NonNegative, Positive};
use siloflow_dem::walls::surface_wall::SurfaceWall;
use siloflow_dem::walls::surfaces::Surfaces;

/// One entry of the scene key `feed`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Feed {
    /// Region of the centres.
    pub region: Region,
    /// Amount per time.
    pub rate: Rate,
    /// Amount after which the feed ends. Default: no end.
    pub total: Option<Total>,
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
    /// Mean velocity of entering grains, m/s.
    pub velocity: FiniteVector,
    /// Standard deviations of the components of the velocity, m/s. Default 0.
    pub agitation: Option<FiniteVector>,
    /// Standard deviation of the components of the spin, rad/s. Default 0.
    pub spin: Option<NonNegative>,
    /// Time of the first grain, s. Default 0.
    pub from: Option<NonNegative>,
    /// Most places that the feed draws in a step, from 1 to 10,000. Default 100.
    #[serde(default = "default_tries")]
    pub tries: u32,
    /// Longest wait of a grain before the run fails, s. Default 10.
    #[serde(default = "default_timeout")]
    pub timeout: NonNegative,
    /// Species of the first size of `radius`. Default 0.
    #[serde(default)]
    pub species: u8,
    /// Law for the masses of these grains. Default: the scene's `mass`.
    pub mass: Option<MassLaw>,
}

/// Most places that a feed may draw in a step. Each is compared with all particles near the region.
pub const MOST_TRIES: u32 = 10_000;

fn default_tries() -> u32 {
    100
}

fn default_timeout() -> NonNegative {
    NonNegative::try_from(10.0).expect("10 is not negative")
}

/// The rate of a feed.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub enum Rate {
    /// Grains per time, 1/s.
    Grains(Positive),
    /// Mass per time, kg/s.
    Mass(Positive),
}

/// The amount after which a feed ends.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub enum Total {
    /// A number of grains.
    Grains(u32),
    /// A mass, kg, rounded to grains of the mean mass.
    Mass(Positive),
}

impl Feed {
    /// Returns the number of grains that will enter; `None` without an end. Infinite if the number is too large for whole numbers.
    #[must_use]
    pub fn count(&self, mass: MassLaw) -> Option<f64> {
        self.total.map(|total| match total {
            Total::Grains(count) => f64::from(count),
            Total::Mass(total) => (total.get() / self.mean_mass(mass)).round(),
        })
    }

    /// Returns the largest radius (m) of the smallest sphere about its centre that holds a grain.
    #[must_use]
    pub fn largest_reach(&self) -> f64 {
        largest_reach(&self.radius, self.shaped.as_ref())
    }

    /// Returns the number of the size of a grain of this species.
    pub(super) fn size_of(&self, species: Species) -> usize {
        usize::from(species.0.saturating_sub(self.species))
    }

    /// Returns the radius (m) of the smallest sphere about its centre that holds a grain of this species and radius, m.
    pub(super) fn reach(&self, species: Species, radius: f64) -> f64 {
        reach(self.shaped.as_ref(), self.size_of(species), radius)
    }

    /// Returns the mean number of grains per second.
    #[must_use]
    pub fn grains_per_second(&self, mass: MassLaw) -> f64 {
        match self.rate {
            Rate::Grains(rate) => rate.get(),
            Rate::Mass(rate) => rate.get() / self.mean_mass(mass),
        }
    }

    /// Returns the mean mass of a grain, kg.
    #[must_use]
    pub fn mean_mass(&self, mass: MassLaw) -> f64 {
        let mass = self.mass.unwrap_or(mass);
        match &self.radius {
            RadiusLaw::Fixed(radius) => mass.of(radius.get()),
            RadiusLaw::Mixture(sizes) => sizes.iter().map(|(radius, share)| share.get() * mass.of(radius.get())).sum(),
            RadiusLaw::Uniform(low, high) => {
                // Simpson's rule is exact for masses that grow as the square or the cube of the radius.
                let low = low.get();
                let high = high.get();
                (mass.of(low) + 4.0 * mass.of(0.5 * (low + high)) + mass.of(high)) / 6.0
            }
        }
    }
}

/// Figures of all feeds for the summary, in the order of the scene.
#[derive(Resource, Default, Debug, Clone, Serialize, Deserialize)]
pub struct FeedFigures(pub Vec<FeedFigure>);

/// Figures of one feed.
#[derive(Default, Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FeedFigure {
    /// Number of grains that entered.
    pub grains: u32,
    /// Their mass, kg.
    pub mass_kg: f64,
    /// Share of the amount due that had not entered at the last step in which a grain was due.
    pub shortfall: f64,
    /// Number of grains that did not enter in the first step in which they could.
    pub waited: u32,
    /// Longest time from such a step to the entry, s.
    pub longest_wait_s: f64,
}

/// All feeds of a scene.
#[derive(Resource)]
struct Feeds<V: Space> {
    inlets: Vec<Inlet<V>>,
}

fn is_due<V: Space>(clock: Res<Clock>, feeds: Res<Feeds<V>>) -> bool {
    feeds.inlets.iter().any(|inlet| inlet.is_due(&clock))
}

#[expect(clippy::too_many_arguments, reason = "a release reads and writes all of them")]
fn feed<V: Space>(
    mut commands: Commands,
    particles: Particles<V>,
    mut feeds: ResMut<Feeds<V>>,
    mut ids: ResMut<FreeId>,
    mut pending: ResMut<Pending>,
    mut figures: ResMut<FeedFigures>,
    mut outcome: ResMut<Outcome>,
    mut released: MessageWriter<GrainReleased>,
    clock: Res<Clock>,
    walls: Res<Surfaces<V>>,
) {
    let Feeds { inlets } = &mut *feeds;
    // Grains of this step have no row yet.
    let mut newcomers: Vec<(V, f64)> = Vec::new();
    for (number, (inlet, figure)) in inlets.iter_mut().zip(&mut figures.0).enumerate() {
        if !inlet.is_due(&clock) {
            continue;
        }
        let near = inlet.near(&particles);
        let mut tries_left = inlet.config.tries;
        while inlet.is_due(&clock) && inlet.draw(&mut ids) {
            let place = |x: V, radius: f64| {
                let touches = |&(y, other): &(V, f64)| particles.separation(x, y).length() < radius + other;
                let is_free = !near.iter().chain(&newcomers).any(touches);
                let is_clear = |wall: &SurfaceWall<V>| !wall.is_present || wall.surface.distance(x) >= radius;
                is_free && walls.near(x, radius).iter().all(|index| is_clear(&walls.all[index]))
            };
            let Some(new) = inlet.enter(particles.periodic(), &mut tries_left, place) else { break };
            newcomers.push((new.position, new.reach));
            spawn(&mut commands, &new);
            released.write(GrainReleased { id: new.id });
            if inlet.left.is_some() {
                pending.0 -= 1;
            }
            inlet.record(figure, &new, &clock, number);
        }
        figure.shortfall = inlet.shortfall(&clock);
        if let Some((grain, waited_s)) = inlet.is_stuck(&clock) {
            outcome.fail(Failure::FeedBlocked { step: clock.steps, feed: number, grain, waited_s });
        }
    }
}

fn spawn<V: Space>(commands: &mut Commands, new: &Released<V>) {
    let bundle = GrainBundle {
        particle: Particle {
            id: new.id,
            position: Position(new.position),
            velocity: Velocity(new.velocity),
            radius: Radius(new.radius),
        },
        mass: Mass(new.mass),
        species: new.species,
        grain: Grain,
    };
    match (new.posture, new.rotation) {
        (Some(posture), Some((_, spin))) => commands.spawn((Spin(spin), posture.components::<V>(), bundle)),
        (Some(posture), None) => commands.spawn((posture.components::<V>(), bundle)),
        (None, Some((law, spin))) => commands.spawn((law.turning::<V>(new.mass, new.radius, spin), bundle)),
        (None, None) => commands.spawn(bundle),
    };
}

/// Feeds of a scene.
pub struct FeedPlugin<V: Space> {
    /// The feeds.
    pub feeds: Vec<Feed>,
    /// Law for the masses of grains.
    pub mass: MassLaw,
    /// Law for the moments of inertia, if grains spin.
    pub inertia: Option<InertiaLaw>,
    /// The scene's seed.
    pub seed: u64,
    /// The space.
    pub space: PhantomData<V>,
}

/// Refuses restored counts of grains to come that are not those of the spawner and the feeds.
pub(super) fn check_restored<V: Space>(world: &mut World) -> Result<(), Problem> {
    let of_spawner = world.get_resource::<LeftOfSpawner>().map_or(0, |left| left.0(world));
    let inlets = world.get_resource::<Feeds<V>>().map_or(&[][..], |feeds| &feeds.inlets);
    let of_feeds = inlets.iter().map(|inlet| u64::from(inlet.left.unwrap_or(1))).sum::<u64>();
    let figures = world.get_resource::<FeedFigures>().map_or(&[][..], |figures| &figures.0);
    let are_figures = figures.iter().all(|figure| figure.grains.max(figure.waited) <= GrainId::MAX_GRAIN);
    let has_pending =
        world.get_resource::<Pending>().is_some_and(|pending| u64::from(pending.0) == u64::from(of_spawner) + of_feeds);
    if has_pending && figures.len() == inlets.len() && are_figures {
        Ok(())
    } else {
        Err("its numbers of grains that are still to come differ".to_owned())
    }
}

impl<V: Space> Plugin for FeedPlugin<V> {
    fn build(&self, app: &mut App) {
        let inlet = |(number, config): (usize, &Feed)| {
            Inlet::new(config, number, config.mass.unwrap_or(self.mass), self.inertia, self.seed)
        };
        let inlets: Vec<Inlet<V>> = self.feeds.iter().enumerate().map(inlet).collect();
        // A feed without an end always has a grain to come.
        let to_come = inlets.iter().map(|inlet| inlet.left.unwrap_or(1));
        app.world_mut().resource_mut::<Pending>().0 += to_come.sum::<u32>();
        app.insert_resource(FeedFigures(vec![FeedFigure::default(); inlets.len()]))
            .insert_resource(Feeds { inlets })
            .persist_sound::<FeedFigures>()
            .check_restored(check_restored::<V>)
            .persist_sound_part::<Feeds<V>, _>(
                |feeds| Ok(feeds.inlets.iter().map(Inlet::progress).collect::<Vec<Progress>>()),
                |feeds, progress| {
                    if progress.len() != feeds.inlets.len() {
                        return Err(format!("it has {} feeds, the scene {}", progress.len(), feeds.inlets.len()));
                    }
                    feeds.inlets.iter_mut().zip(progress).try_for_each(|(inlet, progress)| inlet.restore(progress))
                },
            )
            .add_systems(Step, feed::<V>.in_set(Phase::Spawn).in_set(PlainCommands).run_if(is_due::<V>));
    }
}
