//! Profiles: averages over bins along an axis, and over time.
//!
//! Every `sample` seconds, each grain adds to the bins that it overlaps. After `average` seconds, or at the end of the
//! run, the sums become means, with the number of samples:
//!
//! * *count*: grains per sample with their centre in the bin;
//! * *packing fraction*: volume of the grains in the bin (in the plane: area) over the volume of the bin. The volume of
//!   a grain between the two ends of the bin is exact. The volume of the bin is its width times `section`. Overlaps
//!   count twice;
//! * *velocity*: momentum over mass of the grains with their centre in the bin;
//! * *granular temperature*: sum m |v - v_mean|^2/(D sum m), m^2/s^2, with D = 2 or 3 components and the mean velocity
//!   of the same bin and samples. It contains the variation of the mean flow across the bin and in time;
//! * *inclination* and *nematic order* ([`orientation`](super::orientation)) of the grains with their centre in the bin.
//!
//! The volume of a sphere below a plane at h from its centre, |h| <= R, is pi (2 R^3/3 + R^2 h - h^3/3). The area of a
//! disc is R^2 (pi/2 + asin(h/R)) + h sqrt(R^2 - h^2). Along a periodic axis the nearest image of a grain on each side
//! counts too. Fixed grains do not count.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use crate::measure::orientation::{DirectorSums, MeanOrientation};
use siloflow_dem::math;
use siloflow_dem::particle::Species;
use siloflow_dem::persist::Problem;
use siloflow_dem::space::{Dimension, Space};
use siloflow_dem::store::ParticleStore;
use siloflow_dem::values::{Finite, NonNegative, Positive};

/// One entry of the scene key `profiles`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// Axis of the profile.
    pub axis: Axis,
    /// Lower end of the first bin, m.
    pub low: Finite,
    /// Upper end of the last bin, m.
    pub high: Finite,
    /// Number of bins.
    pub bins: u16,
    /// Time between samples, s.
    pub sample: Positive,
    /// Time of the first sample, s. Default 0.
    pub from: Option<NonNegative>,
    /// Time over which samples are averaged, s. Default: the whole run.
    pub average: Option<Positive>,
    /// Area of the cross section perpendicular to the axis, m^2; in the plane its length, m. Default: cross section of
    /// the periodic box, if that bounds every other axis.
    pub section: Option<Positive>,
}

/// An axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum Axis {
    /// First axis.
    X,
    /// Second axis; upwards in the plane.
    Y,
    /// Third axis; upwards in solid space.
    Z,
}

impl Axis {
    /// Returns the number of the axis, from 0.
    #[must_use]
    pub fn number(self) -> usize {
        match self {
            Self::X => 0,
            Self::Y => 1,
            Self::Z => 2,
        }
    }
}

/// Sums over one species in one bin.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
struct Sums<V> {
    count: u64,
    volume: f64,
    mass: f64,
    momentum: V,
    energy: f64,
}

/// Means over one species in one bin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Means<V> {
    /// Middle of the bin along the axis, m.
    pub place: f64,
    /// Grains per sample with their centre in the bin.
    pub count: f64,
    /// Share of the bin's volume that grains fill.
    pub packing_fraction: f64,
    /// Mean velocity, m/s.
    pub velocity: V,
    /// Granular temperature, m^2/s^2.
    pub temperature: f64,
    /// Orientation of the grains with their centre in the bin; zero unless the scene has shapes.
    pub orientation: MeanOrientation,
}

/// Sums of a profile so far.
#[derive(Clone, Debug)]
pub struct Sampler<V: Space> {
    /// Configuration of the profile.
    pub profile: Profile,
    section: f64,
    bins: Vec<Sums<V>>,
    /// Sums over directors in each bin; empty unless a grain has one.
    directors: Vec<DirectorSums>,
    /// Number of samples in the sums.
    pub samples: u64,
}

/// The sums of a [`Sampler`] in a checkpoint.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(bound = "")]
pub(crate) struct SavedSampler<V: Space> {
    bins: Vec<Sums<V>>,
    directors: Vec<DirectorSums>,
    samples: u64,
}

/// Returns the volume (m^3) or area (m^2) of a grain below a plane at `h` (m) from its centre.
fn below(dimension: Dimension, radius: f64, h: f64) -> f64 {
    let h = h.clamp(-radius, radius);
    match dimension {
        Dimension::Plane => {
            radius * radius * (0.5 * PI + math::asin(h / radius)) + h * (radius * radius - h * h).max(0.0).sqrt()
        }
        Dimension::Solid => PI * (2.0 / 3.0 * radius.powi(3) + radius * radius * h - h.powi(3) / 3.0),
    }
}

impl<V: Space> Sampler<V> {
    /// Makes a sampler without samples; `section` in m^2 (in the plane: m).
    #[must_use]
    pub fn new(profile: Profile, section: f64) -> Self {
        let bins = vec![Sums::default(); usize::from(profile.bins)];
        Self { profile, section, bins, directors: Vec::new(), samples: 0 }
    }

    /// Returns the sums so far, for a checkpoint.
    pub(crate) fn saved(&self) -> SavedSampler<V> {
        SavedSampler { bins: self.bins.clone(), directors: self.directors.clone(), samples: self.samples }
    }

    /// Continues from saved sums.
    pub(crate) fn restore(&mut self, saved: SavedSampler<V>) -> Result<(), Problem> {
        let directors = saved.directors.len();
        if saved.bins.len() != self.bins.len() || (directors > 0 && directors != self.bins.len()) {
            return Err("the number of bins differs".to_owned());
        }
        self.bins = saved.bins;
        self.directors = saved.directors;
        self.samples = saved.samples;
        Ok(())
    }

    fn width(&self) -> f64 {
        (self.profile.high.get() - self.profile.low.get()) / f64::from(self.profile.bins)
    }

    /// Adds a sample of the grains of `species`, or of all grains if `None`. `vertical` is the unit vector upwards.
    pub fn add(&mut self, store: &ParticleStore<V>, species: Option<Species>, vertical: V) {
        let axis = self.profile.axis.number();
        let side = store.periodic.and_then(|periodic| periodic.side(axis));
        let grains = store.integrated_rows();
        for i in grains.filter(|&i| species.is_none_or(|species| store.species[i] == species)) {
            let x = store.body[i].position.axis(axis);
            let images = side.map_or([None; 2], |side| [Some(x - side), Some(x + side)]);
            for image in images.into_iter().flatten().chain([x]) {
                self.add_centre(store, i, image, vertical);
                self.add_volume(store.body[i].radius, image);
            }
        }
        self.samples += 1;
    }

    fn add_centre(&mut self, store: &ParticleStore<V>, i: usize, x: f64, vertical: V) {
        let bin = ((x - self.profile.low.get()) / self.width()).floor();
        if !(0.0..f64::from(self.profile.bins)).contains(&bin) {
            return;
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a valid bin number")]
        let bin = bin as usize;
        if let Some(director) = store.director(i) {
            self.directors.resize(self.bins.len(), DirectorSums::default());
            self.directors[bin].add(director, vertical);
        }
        let sums = &mut self.bins[bin];
        let mass = store.mass[i];
        let v = store.body[i].velocity;
        sums.count += 1;
        sums.mass += mass;
        sums.momentum += v * mass;
        sums.energy += mass * v.length_squared();
    }

    fn add_volume(&mut self, radius: f64, x: f64) {
        let low = self.profile.low.get();
        let width = self.width();
        let bin = |x: f64| ((x - low) / width).floor().clamp(0.0, f64::from(self.profile.bins) - 1.0);
        let first = bin(x - radius);
        let last = bin(x + radius);
        if x + radius <= low || x - radius >= self.profile.high.get() {
            return;
        }
        let mut bin = first;
        while bin <= last {
            let start = low + bin * width - x;
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a valid bin number")]
            let sums = &mut self.bins[bin as usize];
            sums.volume += below(V::DIMENSION, radius, start + width) - below(V::DIMENSION, radius, start);
            bin += 1.0;
        }
    }

    /// Returns the means and resets the sums.
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    pub fn take(&mut self) -> Vec<Means<V>> {
        let width = self.width();
        let samples = self.samples.max(1) as f64;
        let axes = V::COMPONENTS as f64;
        let means = (0u32..).zip(&self.bins).map(|(bin, sums)| {
            let velocity = if sums.mass > 0.0 { sums.momentum / sums.mass } else { V::ZERO };
            let excess = sums.energy - sums.mass * velocity.length_squared();
            Means {
                place: self.profile.low.get() + (f64::from(bin) + 0.5) * width,
                count: sums.count as f64 / samples,
                packing_fraction: sums.volume / (samples * width * self.section),
                velocity,
                temperature: if sums.mass > 0.0 { (excess / (axes * sums.mass)).max(0.0) } else { 0.0 },
                orientation: self.directors.get(bin as usize).copied().unwrap_or_default().means(V::COMPONENTS),
            }
        });
        let means = means.collect();
        *self = Self::new(self.profile, self.section);
        means
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "exact values")]
mod tests {
    use super::*;
    use bevy_ecs::prelude::Entity;
    use siloflow_dem::particle::GrainId;
    use siloflow_dem::periodic::{Periodic, PeriodicSides};
    use siloflow_dem::space::{Plane, Solid};
    use siloflow_dem::store::Body;

    fn store<V: Space>(grains: &[(V, V, f64)]) -> ParticleStore<V> {
        let mut store = ParticleStore::default();
        for (n, &(position, velocity, radius)) in (0u32..).zip(grains) {
            store.id.push(GrainId::grain(n).unwrap());
            store.entity.push(Entity::PLACEHOLDER);
            store.body.push(Body { position, velocity, radius, inverse_mass: 0.5, middle: Default::default() });
            store.mass.push(2.0);
            store.species.push(Species(u8::try_from(n % 2).unwrap()));
        }
        store.free_end = grains.len();
        store
    }

    fn profile(low: f64, high: f64, bins: u16) -> Profile {
        let low = low.try_into().unwrap();
        let high = high.try_into().unwrap();
        let sample = 1.0.try_into().unwrap();
        Profile { axis: Axis::X, low, high, bins, sample, from: None, average: None, section: None }
    }

    #[test]
    fn slices_make_up_the_whole_grain() {
        let disc = store(&[(Plane::new(0.3, 0.0), Plane::ZERO, 0.25)]);
        let sphere = store(&[(Solid::new(0.3, 0.0, 0.0), Solid::ZERO, 0.25)]);
        let mut plane = Sampler::new(profile(0.0, 1.0, 7), 2.0);
        let mut solid = Sampler::new(profile(0.0, 1.0, 7), 2.0);
        plane.add(&disc, None, Plane::Y);
        solid.add(&sphere, None, Solid::Z);
        let area: f64 = plane.take().iter().map(|bin| bin.packing_fraction * 2.0 / 7.0).sum();
        let volume: f64 = solid.take().iter().map(|bin| bin.packing_fraction * 2.0 / 7.0).sum();
        // Seven differences of rounded numbers below one.
        assert!((area - PI * 0.0625).abs() < 14.0 * f64::EPSILON, "{area}");
        assert!((volume - 4.0 / 3.0 * PI * 0.25f64.powi(3)).abs() < 14.0 * f64::EPSILON, "{volume}");
        // Half of the sphere lies on each side of its middle.
        let mut halves = Sampler::new(profile(0.0, 0.6, 2), 1.0);
        halves.add(&sphere, None, Solid::Z);
        let halves = halves.take();
        assert!((halves[0].packing_fraction - halves[1].packing_fraction).abs() < 1e-15);
    }

    #[test]
    fn images_count_along_a_periodic_axis() {
        let mut disc = store(&[(Plane::new(0.05, 0.0), Plane::ZERO, 0.2)]);
        disc.periodic = Periodic::new(&PeriodicSides { x: Some((0.0, 1.0)), ..PeriodicSides::default() });
        let mut sampler = Sampler::new(profile(0.0, 1.0, 4), 1.0);
        sampler.add(&disc, None, Plane::Y);
        let means = sampler.take();
        let area: f64 = means.iter().map(|bin| bin.packing_fraction / 4.0).sum();
        assert!((area - PI * 0.04).abs() < 1e-15 && means[3].packing_fraction > 0.1, "{area}");
    }

    #[test]
    fn velocity_and_temperature_use_the_grains_of_the_bin() {
        let v = |x: f64, y: f64| Plane::new(x, y);
        let grains =
            [(v(0.1, 0.0), v(1.0, 0.0), 0.01), (v(0.2, 0.0), v(3.0, 2.0), 0.01), (v(0.9, 0.0), v(9.0, 9.0), 0.01)];
        let mut sampler = Sampler::new(profile(0.0, 1.0, 2), 1.0);
        sampler.add(&store(&grains), None, Plane::Y);
        sampler.add(&store(&grains), None, Plane::Y);
        assert_eq!(sampler.samples, 2);
        let means = sampler.take();
        assert_eq!((means[0].count, means[0].velocity), (2.0, v(2.0, 1.0)));
        // Each of the two velocities differs from the mean by (1, 1) in magnitude.
        assert_eq!((means[0].temperature, means[1].temperature), (1.0, 0.0));
        assert_eq!(sampler.samples, 0);
        sampler.add(&store(&grains), Some(Species(1)), Plane::Y);
        assert_eq!(sampler.take()[0].count, 1.0);
    }
}
