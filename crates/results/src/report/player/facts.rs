//! The first reading of `frames.bin`: which particles there are, and between which numbers their quantities are.

use std::io;

use rustc_hash::FxHashMap;

use super::grains::{Grains, damaged};
use super::scale::Spread;
use siloflow_files::frames::{Frame, Header, ParticleKey};

/// Facts about all frames of a run.
#[derive(Default)]
pub(super) struct Facts {
    /// Number of frames.
    pub frames: usize,
    /// Rows of grains in all frames.
    pub rows: u64,
    /// Contacts in all frames.
    pub contacts: u64,
    /// Every particle that is in a frame.
    pub place: FxHashMap<ParticleKey, usize>,
    /// The particles in the order in which they appear.
    pub particles: Vec<Particle>,
    /// Whether every particle keeps its radius.
    pub changes_radius: bool,
    /// Quantities of the grains.
    pub quantities: Vec<QuantityFacts>,
    /// Normal forces, N.
    pub forces: Spread,
    /// Lowest and highest coordinates of grains, m.
    pub bounds: Bounds,
}

/// Lowest and highest corner.
pub(super) struct Bounds(pub [[f64; 3]; 2]);

impl Default for Bounds {
    fn default() -> Self {
        Self([[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]])
    }
}

/// The quantities of a particle that are constant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Particle {
    pub key: ParticleKey,
    pub kind: u8,
    pub species: u8,
    /// Radius in the first frame that has the particle, m.
    pub radius: f64,
    /// Time of that frame, s.
    pub first: f64,
}

/// Numbers of a quantity in all frames.
pub(super) struct QuantityFacts {
    pub name: String,
    pub unit: String,
    pub is_whole: bool,
    pub spread: Spread,
    /// The number of each particle, while no particle has been found to change its number.
    pub fixed: Option<Vec<f64>>,
}

impl Facts {
    /// Reads all frames.
    ///
    /// # Errors
    /// If a frame cannot be read, or breaks the rules of the format.
    pub fn of(header: &Header, frames: impl Iterator<Item = io::Result<Frame>>) -> io::Result<Self> {
        if !matches!(header.dimension, 2 | 3) {
            return Err(damaged("its vectors have neither two nor three components"));
        }
        let mut facts = Self::default();
        for frame in frames {
            facts.add(header, &frame?)?;
        }
        facts.sort();
        Ok(facts)
    }

    /// Reads one frame.
    ///
    /// # Errors
    /// As [`Facts::of`].
    pub fn of_frame(header: &Header, frame: &Frame) -> io::Result<Self> {
        let mut facts = Self::default();
        facts.add(header, frame)?;
        facts.sort();
        Ok(facts)
    }

    fn add(&mut self, header: &Header, frame: &Frame) -> io::Result<()> {
        self.frames += 1;
        for table in ["contacts", "wall_contacts"].into_iter().filter_map(|name| frame.table(name)) {
            self.contacts += table.rows as u64;
            table.floats("normal_force").unwrap_or_default().iter().for_each(|force| self.forces.add(force.abs()));
        }
        let Some(grains) = Grains::of(frame, header.dimension)? else { return Ok(()) };
        self.rows += grains.keys.len() as u64;
        let mut places = Vec::with_capacity(grains.keys.len());
        for (row, &key) in grains.keys.iter().enumerate() {
            for (axis, &coordinate) in grains.position(row).iter().enumerate().filter(|(_, place)| place.is_finite()) {
                let Bounds([low, high]) = &mut self.bounds;
                low[axis] = low[axis].min(coordinate);
                high[axis] = high[axis].max(coordinate);
            }
            let radius = grains.radii[row];
            let next = self.particles.len();
            let place = *self.place.entry(key).or_insert(next);
            if place == next {
                let byte = |numbers: &[i64]| u8::try_from(numbers[row]).unwrap_or(u8::MAX);
                let kind = byte(&grains.kinds);
                let species = byte(&grains.species);
                self.particles.push(Particle { key, kind, species, radius, first: frame.time });
            }
            self.changes_radius |= self.particles[place].radius.to_bits() != radius.to_bits();
            places.push(place);
        }
        self.add_quantities(&grains, &places);
        Ok(())
    }

    fn add_quantities(&mut self, grains: &Grains, places: &[usize]) {
        for quantity in grains.quantities() {
            let is_new = !self.quantities.iter().any(|known| known.name == quantity.name);
            if is_new {
                self.quantities.push(QuantityFacts {
                    name: quantity.name.to_owned(),
                    unit: quantity.unit.to_owned(),
                    is_whole: quantity.is_whole(),
                    spread: Spread::default(),
                    fixed: Some(Vec::new()),
                });
            }
            let Some(facts) = self.quantities.iter_mut().find(|known| known.name == quantity.name) else { continue };
            for (row, &place) in places.iter().enumerate() {
                facts.add(place, quantity.number(row));
            }
        }
    }

    /// Puts particles into the order of their ids.
    fn sort(&mut self) {
        let mut from: Vec<usize> = (0..self.particles.len()).collect();
        from.sort_unstable_by_key(|&place| self.particles[place].key.place());
        self.particles = from.iter().map(|&place| self.particles[place]).collect();
        for fixed in self.quantities.iter_mut().filter_map(|quantity| quantity.fixed.as_mut()) {
            *fixed = from.iter().map(|&place| fixed.get(place).copied().unwrap_or(f64::NAN)).collect();
        }
        self.place = self.particles.iter().enumerate().map(|(place, particle)| (particle.key, place)).collect();
    }
}

impl QuantityFacts {
    /// Adds the number of a particle in a frame.
    fn add(&mut self, place: usize, number: f64) {
        self.spread.add(number);
        let Some(fixed) = &mut self.fixed else { return };
        if place >= fixed.len() {
            // A particle between that has no number of this quantity yet.
            fixed.resize(place, f64::NAN);
            fixed.push(number);
        } else if fixed[place].to_bits() != number.to_bits() {
            self.fixed = None;
        }
    }
}
