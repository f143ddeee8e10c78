//! What is packed of a run: its grid, its quantities with their scales, and the number of its frames.

use super::facts::{Facts, QuantityFacts};
use super::grid::Grid;
use super::scale::Scale;
use crate::output::frame_data::Header;

/// Most bytes of all frames before they are compressed, in the memory of a browser.
const LARGEST_CONTENT: u64 = 256 << 20;

/// How the frames of a run are packed.
pub(super) struct Plan {
    pub facts: Facts,
    pub grid: Grid,
    pub forces: Scale,
    /// The scale of each quantity, in their order; `None` if all its numbers are equal.
    pub scales: Vec<Option<Scale>>,
    /// Number of frames to pack.
    pub frames: usize,
}

impl Plan {
    /// Makes a plan for all frames, or for as many as fit into the memory of a browser.
    pub fn new(header: &Header, facts: Facts) -> Self {
        let grid = Grid::new(header.domain, facts.bounds.0);
        let forces = Scale { low: 0.0, ..facts.forces.scale(false) };
        let scale = |of: &QuantityFacts| {
            suggested(header, &of.name).or_else(|| (!of.spread.is_constant()).then(|| of.spread.scale(of.is_whole)))
        };
        let scales: Vec<_> = facts.quantities.iter().map(scale).collect();
        let mut plan = Self { facts, grid, forces, scales, frames: 0 };
        // Two bytes along each axis; about six for a contact.
        let row = 2 * u64::from(header.dimension) + plan.changing().count() as u64;
        let content = plan.facts.rows.saturating_mul(row).saturating_add(plan.facts.contacts.saturating_mul(6));
        plan.frames = share(plan.facts.frames, LARGEST_CONTENT, content);
        plan
    }

    /// Returns the quantities that change for at least one particle, with their scales.
    pub fn changing(&self) -> impl Iterator<Item = (&QuantityFacts, Scale)> {
        self.quantities().filter(|(facts, _)| facts.fixed.is_none())
    }

    /// Returns the quantities that every particle keeps, with the number of each particle.
    pub fn kept(&self) -> impl Iterator<Item = (&[f64], Scale)> {
        self.quantities().filter_map(|(facts, scale)| Some((facts.fixed.as_deref()?, scale)))
    }

    /// Returns all quantities with their scales.
    pub fn quantities(&self) -> impl Iterator<Item = (&QuantityFacts, Scale)> {
        self.facts.quantities.iter().zip(&self.scales).filter_map(|(facts, scale)| Some((facts, (*scale)?)))
    }

    /// Whether a frame of this number is packed. Packed frames are evenly spaced, from the first to the last.
    pub fn takes(&self, number: usize) -> bool {
        let (kept, all) = (self.frames, self.facts.frames);
        let rank = |number: usize| (number as u128 * (kept.max(2) - 1) as u128) / (all.max(2) - 1) as u128;
        number == 0 || (kept > 1 && rank(number) > rank(number - 1))
    }

    /// Takes fewer frames, after so many bytes of `frames` packed ones where `most` bytes are allowed. Returns `false` if there are only
    /// two frames left.
    pub fn thin(&mut self, bytes: usize, frames: usize, most: usize) -> bool {
        let estimate = (bytes as u64).saturating_mul(self.frames as u64) / frames.max(1) as u64;
        // Differences between frames further apart are longer.
        let fewer = share(self.frames, most as u64 / 20 * 19, estimate).min(self.frames.saturating_sub(1));
        let is_possible = self.frames > 2;
        self.frames = fewer.max(2).min(self.frames);
        is_possible
    }
}

/// Returns the scale that a behaviour suggests for its column.
fn suggested(header: &Header, name: &str) -> Option<Scale> {
    let scale = header.columns.iter().find(|column| column.name == name)?.scale?;
    let is_sound = scale.from < scale.to && (scale.to - scale.from).is_finite();
    is_sound.then_some(Scale { low: scale.from, high: scale.to })
}

/// Returns the number of frames of which `allowed` bytes consist, if all have `bytes`; at least two.
fn share(frames: usize, allowed: u64, bytes: u64) -> usize {
    if bytes <= allowed {
        return frames;
    }
    let part = frames as u128 * u128::from(allowed) / u128::from(bytes);
    usize::try_from(part).unwrap_or(frames).max(2).min(frames)
}
