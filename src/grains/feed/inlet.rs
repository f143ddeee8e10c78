//! One feed while it runs: draws grains and places, and keeps count.

use serde::{Deserialize, Serialize};

use super::{Feed, FeedFigure, Rate};
use crate::grains::free_id::FreeId;
use crate::grains::mass::MassLaw;
use crate::grains::shaped::Posture;
use crate::grains::sizes::{GrainSize, are_quotas};
use crate::random::Stream;
use siloflow_dem::particle::{GrainId, Species};
use siloflow_dem::particles::Particles;
use siloflow_dem::periodic::Periodic;
use siloflow_dem::persist::Problem;
use siloflow_dem::space::{Solid, Space};
use siloflow_dem::spin::InertiaLaw;
use siloflow_dem::step::Clock;
use siloflow_dem::values::{FiniteVector, NonNegative};

/// Number of grains over which a feed without an end keeps the shares of a mixture exact.
const BLOCK: u32 = 1000;

/// A grain that is due.
#[derive(Clone, Copy, Deserialize, Serialize)]
struct Candidate {
    id: GrainId,
    radius: f64,
    species: Species,
    /// Number of places that were tried.
    tries: u32,
    /// Time of the first step in which it did not enter, s.
    waits_since: Option<f64>,
}

/// The part of the state that changes.
#[derive(Clone, Deserialize, Serialize)]
pub(super) struct Progress {
    quotas: Vec<u32>,
    left: Option<u32>,
    fed: f64,
    next: Option<Candidate>,
}

/// A grain with a place.
pub(super) struct Released<V: Space> {
    pub id: GrainId,
    pub position: V,
    pub velocity: V,
    pub rotation: Option<(InertiaLaw, V::Spin)>,
    pub radius: f64,
    /// Radius of the smallest sphere about the centre that holds the grain, m.
    pub reach: f64,
    pub posture: Option<Posture>,
    pub mass: f64,
    pub species: Species,
    waits_since: Option<f64>,
}

/// A feed.
pub(super) struct Inlet<V: Space> {
    pub config: Feed,
    /// Number of grains still to come; `None` without an end.
    pub left: Option<u32>,
    mass: MassLaw,
    inertia: Option<InertiaLaw>,
    sizes: Stream,
    places: Stream,
    motions: Stream,
    turns: Stream,
    /// Centre and half extents of the region, m.
    middle: V,
    half: V,
    quotas: Vec<u32>,
    /// The amount that has entered, in the unit of the rate.
    fed: f64,
    next: Option<Candidate>,
}

impl<V: Space> Inlet<V> {
    pub(super) fn new(config: &Feed, number: usize, mass: MassLaw, inertia: Option<InertiaLaw>, seed: u64) -> Self {
        let stream = |what: &str| Stream::new(seed, &format!("feed {number} {what}"));
        let (low, high) = config.region.bounds();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked by the scene's rules")]
        let left = config.count(mass).map(|count| count as u32);
        Self {
            left,
            mass,
            inertia,
            sizes: stream("size"),
            places: stream("place"),
            motions: stream("motion"),
            turns: stream("orientation"),
            middle: V::narrow(0.5 * (low + high)),
            half: V::narrow(0.5 * (high - low)),
            quotas: config.radius.quotas(left.unwrap_or(BLOCK)),
            fed: 0.0,
            next: None,
            config: config.clone(),
        }
    }

    pub(super) fn progress(&self) -> Progress {
        Progress { quotas: self.quotas.clone(), left: self.left, fed: self.fed, next: self.next }
    }

    /// Takes over the part that changes.
    ///
    /// # Errors
    /// If a feed of the scene cannot have it.
    pub(super) fn restore(&mut self, saved: Progress) -> Result<(), Problem> {
        let Progress { quotas, left, fed, next } = saved;
        let can_be_left = match (left, self.left) {
            (Some(left), Some(of_scene)) => left <= of_scene,
            (left, of_scene) => left == of_scene,
        };
        let is_grain = |grain: &Candidate| !grain.id.is_wall() && grain.radius > 0.0;
        let most = self.left.unwrap_or(BLOCK);
        if !can_be_left
            || fed < 0.0
            || !are_quotas(&quotas, &self.quotas, most.max(BLOCK))
            || !next.iter().all(is_grain)
        {
            return Err("a feed has released other grains than that of the scene can".to_owned());
        }
        self.quotas = quotas;
        self.left = left;
        self.fed = fed;
        self.next = next;
        Ok(())
    }

    fn rate(&self) -> f64 {
        match self.config.rate {
            Rate::Grains(rate) | Rate::Mass(rate) => rate.get(),
        }
    }

    fn start(&self) -> f64 {
        self.config.from.map_or(0.0, NonNegative::get)
    }

    /// Whether a grain is due.
    pub(super) fn is_due(&self, clock: &Clock) -> bool {
        self.left != Some(0) && clock.has_reached(self.start() + self.fed / self.rate())
    }

    /// Returns the particles that may overlap a grain in the region, as places and radii.
    pub(super) fn near(&self, particles: &Particles<V>) -> Vec<(V, f64)> {
        let largest = self.config.largest_reach();
        let is_near = |&row: &usize| {
            let away = particles.separation(particles.position(row), self.middle);
            let reach = particles.radius(row) + largest;
            (0..V::COMPONENTS).all(|axis| away.axis(axis).abs() <= self.half.axis(axis) + reach)
        };
        particles.spheres().filter(is_near).map(|row| (particles.position(row), particles.radius(row))).collect()
    }

    /// Draws the next grain, if none is waiting. Returns false if there are no ids left.
    pub(super) fn draw(&mut self, ids: &mut FreeId) -> bool {
        if self.next.is_none() {
            let Some(id) = ids.take() else { return false };
            if self.quotas.iter().all(|&quota| quota == 0) {
                self.quotas = self.config.radius.quotas(BLOCK);
            }
            let [u] = self.sizes.uniform(u64::from(id.number()));
            let GrainSize { radius, species: Species(size) } = self.config.radius.choose(u, &mut self.quotas);
            let species = Species(self.config.species.saturating_add(size));
            self.next = Some(Candidate { id, radius, species, tries: 0, waits_since: None });
        }
        true
    }

    /// Draws places for the waiting grain until one is free, or no tries are left. Returns the grain if it has a place.
    pub(super) fn enter(
        &mut self,
        periodic: Option<&Periodic<V>>,
        tries_left: &mut u32,
        is_free: impl Fn(V, f64) -> bool,
    ) -> Option<Released<V>> {
        let grain = self.next.as_mut()?;
        let number = u64::from(grain.id.number());
        while *tries_left > 0 {
            *tries_left -= 1;
            let u = self.places.uniform(number << 32 | u64::from(grain.tries));
            grain.tries = grain.tries.wrapping_add(1);
            let position = V::narrow(self.config.region.point(u));
            let position = periodic.map_or(position, |periodic| periodic.wrapped(position));
            let reach = self.config.reach(grain.species, grain.radius);
            if !is_free(position, reach) {
                continue;
            }
            let Candidate { id, radius, species, waits_since, .. } = self.next.take()?;
            let [x, y, z, wx, wy, wz] = self.motions.gaussian(number);
            let agitation = self.config.agitation.map_or(V::ZERO, FiniteVector::get);
            let gauss = V::narrow(Solid::new(x, y, z));
            let velocity = V::from_components(|axis| agitation.axis(axis) * gauss.axis(axis));
            let spin = Solid::new(wx, wy, wz) * self.config.spin.map_or(0.0, NonNegative::get);
            return Some(Released {
                id,
                position,
                velocity: self.config.velocity.get::<V>() + velocity,
                rotation: self.inertia.map(|law| (law, V::narrow_spin(spin))),
                radius,
                reach,
                posture: self.config.shaped.as_ref().map(|shaped| {
                    shaped.posture::<V>(self.config.size_of(species), radius, self.turns.uniform(number))
                }),
                mass: self.mass.of(radius),
                species,
                waits_since,
            });
        }
        None
    }

    /// Counts a grain that has entered.
    pub(super) fn record(&mut self, figure: &mut FeedFigure, new: &Released<V>, clock: &Clock, number: usize) {
        self.left = self.left.map(|left| left - 1);
        self.fed += match self.config.rate {
            Rate::Grains(_) => 1.0,
            Rate::Mass(_) => new.mass,
        };
        figure.grains += 1;
        figure.mass_kg += new.mass;
        if let Some(since) = new.waits_since {
            let wait = clock.time() - since;
            if figure.waited == 0 {
                tracing::warn!(
                    "t = {:.3} s: {} of feed {number} found a free place after {wait:.3} s",
                    clock.time(),
                    new.id
                );
            }
            figure.waited += 1;
            figure.longest_wait_s = figure.longest_wait_s.max(wait);
        }
    }

    /// Returns the share of the amount due that has not entered.
    pub(super) fn shortfall(&self, clock: &Clock) -> f64 {
        let due = self.rate() * (clock.time() - self.start());
        let is_missing = self.next.is_some() && due > 0.0;
        if is_missing { ((due - self.fed) / due).clamp(0.0, 1.0) } else { 0.0 }
    }

    /// Notes that the grain at the head of the queue waits. Returns it with its waiting time (s) if that exceeds the limit.
    pub(super) fn is_stuck(&mut self, clock: &Clock) -> Option<(GrainId, f64)> {
        let grain = self.next.as_mut()?;
        let waited = clock.time() - *grain.waits_since.get_or_insert(clock.time());
        (waited > self.config.timeout.get()).then_some((grain.id, waited))
    }
}
