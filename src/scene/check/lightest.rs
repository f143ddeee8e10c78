//! The lightest bodies of a scene, by species: grains at the start, grains that the spawner and the feeds will release, and walls.
//!
//! A grain of a shape counts with its smallest effective mass, that of a contact at its end, and with its smallest sphere. If it has so many spheres that they
//! are stiffer together when it lies flat, all springs count that much more.

use crate::grains::feed::Feed;
use crate::grains::shaped::{ShapeFacts, SizeRange, size_ranges};
use crate::grains::sizes::RadiusLaw;
use crate::random::Stream;
use crate::scene::loaded::Loaded;
use siloflow_dem::walls::config::shape::WallShape;

/// Number of radii to be released that are examined, if each is drawn at random.
const DRAWN: u32 = 10_000;

/// Mass (kg) and radius (m) of a body; infinite mass if fixed, infinite radius if flat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Body {
    pub mass: f64,
    pub radius: f64,
    /// Springs that act at once in a contact with a flat partner, times the share of the mass that `mass` is: 1 for a sphere.
    pub springs: f64,
}

impl Body {
    /// A body that is one sphere, or a wall.
    pub(super) fn sphere(mass: f64, radius: f64) -> Self {
        Self { mass, radius, springs: 1.0 }
    }

    /// Returns the lightest contact of a grain of a shape: its smallest effective mass, at its smallest sphere. A grain that lies flat has
    /// its whole mass on as many springs as it has spheres. Without a shape it is the body itself.
    fn of_shape(self, facts: Option<&ShapeFacts>) -> Self {
        let Some(facts) = facts else { return self };
        let count = u32::try_from(facts.count).map_or(f64::INFINITY, f64::from);
        Self {
            mass: self.mass / facts.mobility,
            radius: self.radius * facts.factors()[1],
            springs: (count / facts.mobility).max(1.0),
        }
    }
}

/// The lightest grain of each species, and the second lightest if there is one.
pub(super) fn lightest(loaded: &Loaded) -> Vec<(u8, Body, Option<Body>)> {
    let mut species: Vec<(u8, Body, Option<Body>)> = Vec::new();
    let start = loaded.grains.iter().map(|grain| {
        let facts = grain.posture.and_then(|posture| loaded.shapes.facts_of(posture.shape));
        (grain.species.0, Body::sphere(grain.mass, grain.radius).of_shape(facts))
    });
    for (number, body) in start.chain(to_come(loaded)).chain(fed(loaded)) {
        match species.iter_mut().find(|entry| entry.0 == number) {
            None => species.push((number, body, None)),
            Some((_, first, second)) if body.mass < first.mass => *second = Some(std::mem::replace(first, body)),
            Some((_, _, second)) if second.is_none_or(|second| body.mass < second.mass) => *second = Some(body),
            Some(_) => {}
        }
    }
    species
}

/// Grains that the feeds will release: two of each size, or two of the smallest radius of a range.
fn fed(loaded: &Loaded) -> Vec<(u8, Body)> {
    let Some(law) = loaded.scene.mass else { return Vec::new() };
    let of_feed = |feed: &Feed| {
        let law = feed.mass.unwrap_or(law);
        let ranges = size_ranges(&feed.radius, feed.shaped.as_ref());
        let two = |(species, range): (u8, &SizeRange<'_>)| {
            [(species, Body::sphere(law.of(range.low), range.low).of_shape(range.facts)); 2]
        };
        let is_drawn = |size: usize| match &feed.radius {
            RadiusLaw::Mixture(sizes) => sizes.get(size).is_some_and(|(_, share)| share.get() > 0.0),
            _ => true,
        };
        // The species of sizes follow each other.
        let sizes = (feed.species..=u8::MAX).zip(&ranges).enumerate();
        sizes.filter(|&(size, _)| is_drawn(size)).flat_map(|(_, of_size)| two(of_size)).collect::<Vec<_>>()
    };
    loaded.scene.feed.iter().flat_map(of_feed).collect()
}

/// Grains that the spawner will release: two of each size, or the radii that it will draw from a range.
fn to_come(loaded: &Loaded) -> Vec<(u8, Body)> {
    let Some((spawner, law)) = loaded.scene.spawner.as_ref().zip(loaded.scene.mass) else { return Vec::new() };
    let body = |species: u8, radius: f64| {
        let facts = spawner.shaped.as_ref().map(|shaped| &shaped.of_size(usize::from(species)).facts);
        Body::sphere(law.of(radius), radius).of_shape(facts)
    };
    let two = |count: u32, species: u8, radius: f64| {
        let body = body(species, radius);
        (0..count.min(2)).map(move |_| (species, body))
    };
    match &spawner.radius {
        RadiusLaw::Fixed(radius) => two(spawner.count, 0, radius.get()).collect(),
        RadiusLaw::Mixture(sizes) => {
            let quotas = (0..=u8::MAX).zip(spawner.radius.quotas(spawner.count));
            quotas.zip(sizes).flat_map(|((species, count), (radius, _))| two(count, species, radius.get())).collect()
        }
        RadiusLaw::Uniform(..) => {
            let random = Stream::new(loaded.scene.seed, "spawner");
            let ids = u64::from(loaded.first_free_id())..;
            let drawn = ids.take(spawner.count.min(DRAWN) as usize).map(|id| {
                let [u] = random.uniform(id);
                let size = spawner.radius.choose(u, &mut []);
                (size.species.0, body(size.species.0, size.radius))
            });
            drawn.collect()
        }
    }
}

/// The flattest wall of each species, which makes the stiffest contact.
pub(super) fn walls(loaded: &Loaded) -> Vec<(u8, Body)> {
    let own = loaded.scene.walls.iter().map(|wall| match wall.shape {
        WallShape::Disc { radius, .. } => (wall.species, radius.get()),
        _ => (wall.species, f64::INFINITY),
    });
    let of_silo = loaded.scene.silo.as_ref().map_or(0, |silo| silo.species);
    let silo = loaded.silo.wall.iter().chain(&loaded.silo.door).map(|disc| (of_silo, disc.radius));
    let fixed = loaded.fixed.iter().map(|grain| (grain.species.0, grain.radius));
    let mut walls: Vec<(u8, Body)> = Vec::new();
    for (species, radius) in own.chain(silo).chain(fixed) {
        match walls.iter_mut().find(|wall| wall.0 == species) {
            Some(wall) => wall.1.radius = wall.1.radius.max(radius),
            None => walls.push((species, Body::sphere(f64::INFINITY, radius))),
        }
    }
    walls
}
