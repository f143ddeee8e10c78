//! The plan for packing a run: its grid, its quantities with their scales, and the choice of frames.

use super::facts::{Facts, QuantityFacts};
use super::grid::Grid;
use super::scale::Scale;
use super::thinning::Thinning;
use siloflow_files::frames::Header;

/// How the frames of a run are packed.
pub(super) struct Plan {
    pub facts: Facts,
    pub grid: Grid,
    pub forces: Scale,
    /// The scale of each quantity, in their order; `None` if all its numbers are equal.
    pub scales: Vec<Option<Scale>>,
    pub thinning: Thinning,
}

impl Plan {
    /// Makes a plan for all frames, or for as many as fit into the memory of a browser.
    pub fn new(header: &Header, facts: Facts) -> Self {
        let grid = Grid::new(header.domain, facts.bounds.0);
        let forces = Scale { low: 0.0, ..facts.forces.scale(false) };
        let scale = |of: &QuantityFacts| {
            let own = || Scale { is_root: of.name == "speed", ..of.spread.scale(of.is_whole) };
            suggested(header, &of.name).or_else(|| (!of.spread.is_constant()).then(own))
        };
        let scales: Vec<_> = facts.quantities.iter().map(scale).collect();
        let all = facts.frames;
        let mut plan = Self { facts, grid, forces, scales, thinning: Thinning::new(all, 0) };
        // Two bytes along each axis; about six for a contact.
        let row = 2 * u64::from(header.dimension) + plan.changing().count() as u64;
        let content = plan.facts.rows.saturating_mul(row).saturating_add(plan.facts.contacts.saturating_mul(6));
        plan.thinning = Thinning::new(all, content);
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
}

/// Returns the scale that a behaviour suggests for its column.
fn suggested(header: &Header, name: &str) -> Option<Scale> {
    let scale = header.columns.iter().find(|column| column.name == name)?.scale?;
    let is_sound = scale.from < scale.to && (scale.to - scale.from).is_finite();
    is_sound.then_some(Scale { low: scale.from, high: scale.to, is_root: false })
}
