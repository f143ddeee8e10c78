//! Figures of a discharge over a window of time: the scene key `outflow`.
//!
//! The window is divided into [`BLOCKS`] equal blocks. Only blocks that the run completes count. A window may begin and end at events
//! ([`Moment`]). Then every exit is kept until the end of the run, 32 bytes for a grain.
//!
//! * *Rates* in grains/s and kg/s: mean over the blocks, with the 95 % confidence interval ([`Rate`]).
//! * *Residence time*: from the entry of a grain to its exit through a door, over the grains that leave in the blocks. Grains of the
//!   start enter at 0.
//! * *Segregation index*: Danckwerts' intensity of segregation of the outflow. With the share x_ks of species s in the mass of
//!   block k, its share p_s in all, and the share w_k of the block in the mass: sum w_k (x_ks - p_s)^2 / sum p_s (1 - p_s). It
//!   is 0 if all blocks are alike, and 1 if each block has one species. Grains that leave at random, n in a block, give
//!   about 1/n. (Danckwerts, Appl. Sci. Res. A 3, 279 (1952).)
//! * *Mass-flow index*: mean downward velocity near the wall over that near the axis, in a range of heights. About 0.3 and more
//!   is mass flow (Johanson and Jenike). It is sampled [`SAMPLES`] times in the window; its standard error is the jackknife's
//!   ([`Blocks`]).

use serde::{Deserialize, Serialize};

use crate::measure::fields::Blocks;
use crate::measure::moment::{Events, Moment};
use siloflow_dem::particle::GrainId;
use siloflow_dem::space::Space;
use siloflow_dem::values::{Finite, FiniteVector, Positive};
use siloflow_figures::statistics::rate::Rate;

/// Number of blocks of a window.
pub const BLOCKS: usize = Rate::MOST_BLOCKS;

/// Number of samples of velocities in a window.
pub const SAMPLES: u32 = 128;

/// The scene key `outflow`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Outflow {
    /// Start of the window.
    pub from: Moment,
    /// End of the window.
    pub to: Moment,
    /// Where velocities are compared for the mass-flow index.
    pub mass_flow: Option<MassFlow>,
}

/// Two zones about a vertical axis.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct MassFlow {
    /// A point of the axis, m.
    pub axis: FiniteVector,
    /// Lowest height of both zones, m.
    pub low: Finite,
    /// Highest height, m.
    pub high: Finite,
    /// Largest distance from the axis in the inner zone, m.
    pub centre: Positive,
    /// Least distance from the axis in the zone near the wall, m.
    pub wall: Positive,
}

/// A window in time, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Start.
    pub from: f64,
    /// End.
    pub to: f64,
}

impl Outflow {
    /// The window, if it is known beforehand.
    #[must_use]
    pub fn fixed(&self) -> Option<Window> {
        Some(Window { from: self.from.fixed()?, to: self.to.fixed()? })
    }

    /// The window, once its events have happened; never if it depends on a share of the grains.
    #[must_use]
    pub fn after(&self, events: Events) -> Option<Window> {
        Some(Window { from: self.from.after(events)?, to: self.to.after(events)? })
    }
}

impl MassFlow {
    /// Returns the zone of a place: 0 near the axis, 1 near the wall.
    #[must_use]
    pub fn zone<V: Space>(&self, place: V) -> Option<usize> {
        let arm = (place - self.axis.get::<V>()).with_axis(V::COMPONENTS - 1, 0.0);
        let is_between = (self.low.get()..self.high.get()).contains(&place.height());
        match arm.length() {
            distance if is_between && distance <= self.centre.get() => Some(0),
            distance if is_between && distance >= self.wall.get() => Some(1),
            _ => None,
        }
    }
}

/// Grains that left in one block of time.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
struct Block {
    grains: u32,
    /// Mass by species, kg.
    mass: Vec<f64>,
    /// Sums of the residence times, s, and of their squares.
    residence: [f64; 2],
}

/// The exit of a grain.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub struct Exit {
    /// Time, s.
    pub time: f64,
    /// Species.
    pub species: usize,
    /// Mass, kg.
    pub mass: f64,
    /// Time that the grain was inside, s.
    pub stay: f64,
}

/// Sums over a window.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct OutflowSums {
    blocks: Vec<Block>,
    /// All exits so far, if the window is not known beforehand.
    exits: Vec<Exit>,
    /// Momentum downwards and mass in both zones, each zone in turn.
    zones: Blocks,
}

/// Residence times, s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Residence {
    /// Mean over the grains.
    pub mean: f64,
    /// Standard deviation of the grains.
    pub deviation: f64,
}

/// The mass-flow index.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MassFlowIndex {
    /// Velocity near the wall over that near the axis.
    pub value: f64,
    /// Standard error; `None` below eight blocks of samples.
    pub error: Option<f64>,
}

/// The figures of `summary.json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OutflowFigures {
    /// Start of the window, s.
    pub from_s: f64,
    /// End of the last complete block, s.
    pub to_s: f64,
    /// Number of complete blocks.
    pub blocks: usize,
    /// Grains that left in them.
    pub grains: u32,
    /// Their mass, kg.
    pub mass_kg: f64,
    /// Grains/s; `None` without a complete block.
    pub rate_per_s: Option<Rate>,
    /// Mass rate, kg/s.
    pub rate_kg_per_s: Option<Rate>,
    /// Residence times; `None` if no grain left.
    pub residence_s: Option<Residence>,
    /// Segregation index; `None` unless two species left in two blocks.
    pub segregation_index: Option<f64>,
    /// Mass-flow index; `None` if the scene has no zones, or a zone had no grain.
    pub mass_flow_index: Option<MassFlowIndex>,
}

/// Numbers of both zones: momentum and mass of each.
const ZONES: usize = 4;

impl OutflowSums {
    /// Makes sums without grains, of species up to `largest`.
    #[must_use]
    pub fn new(largest: usize) -> Self {
        let block = Block { mass: vec![0.0; largest + 1], ..Block::default() };
        Self { blocks: vec![block; BLOCKS], exits: Vec::new(), zones: Blocks::new(ZONES) }
    }

    /// Whether restored sums have the blocks of every window, and species up to `largest`.
    pub(crate) fn fit(&self, largest: usize) -> bool {
        let is_block = |block: &Block| block.mass.len() == largest + 1 && block.grains <= GrainId::MAX_GRAIN;
        let is_exit = |exit: &Exit| {
            exit.species <= largest && [exit.time, exit.mass, exit.stay].iter().all(|x| x.is_finite() && *x >= 0.0)
        };
        self.blocks.len() == BLOCKS
            && self.blocks.iter().all(is_block)
            && self.exits.len() <= GrainId::MAX_GRAIN as usize
            && self.exits.iter().all(is_exit)
            && self.zones.fit(ZONES)
    }

    /// Adds the exit of a grain. `window` is `None` if it is not known beforehand.
    pub fn add(&mut self, window: Option<Window>, exit: Exit) {
        match window {
            Some(window) => add_to_blocks(&mut self.blocks, window, exit),
            None => self.exits.push(exit),
        }
    }

    /// Returns the time at which a share of `released` grains was out, s; `None` if it was not, or if the exits are not kept.
    #[must_use]
    pub fn time_of(&self, share: f64, released: u32) -> Option<f64> {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a number of grains")]
        let count = (share * f64::from(released)).ceil() as usize;
        self.exits.get(count.max(1) - 1).map(|exit| exit.time)
    }

    /// Adds a grain of a zone to the present sample.
    pub fn add_velocity(&mut self, zone: usize, mass: f64, downwards: f64) {
        self.zones.present()[2 * zone] += mass * downwards;
        self.zones.present()[2 * zone + 1] += mass;
    }

    /// Ends a sample of velocities.
    pub fn end_sample(&mut self) {
        self.zones.end_sample();
    }

    /// Number of samples of velocities.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.zones.samples()
    }

    /// Returns the figures at `time`, s.
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_precision_loss,
        reason = "16 blocks"
    )]
    pub fn figures(&self, window: Window, time: f64) -> OutflowFigures {
        let mut blocks = self.blocks.clone();
        self.exits.iter().for_each(|exit| add_to_blocks(&mut blocks, window, *exit));
        let from = window.from;
        let length = (window.to - window.from) / BLOCKS as f64;
        // A run that ends at the end of the window may do so by rounding a little before it.
        let count = (((time - from) / length + 1e-6).max(0.0) as usize).min(BLOCKS);
        let blocks = &blocks[..count];
        let mass = |block: &Block| block.mass.iter().sum::<f64>();
        let grains = blocks.iter().map(|block| block.grains).sum::<u32>();
        let rate = |of: &dyn Fn(&Block) -> f64| {
            (count > 0).then(|| Rate::of(&blocks.iter().map(|block| of(block) / length).collect::<Vec<_>>()))
        };
        let sums = [0, 1].map(|power: usize| blocks.iter().map(|block| block.residence[power]).sum::<f64>());
        let residence = (grains > 0).then(|| {
            let mean = sums[0] / f64::from(grains);
            Residence { mean, deviation: (sums[1] / f64::from(grains) - mean * mean).max(0.0).sqrt() }
        });
        let index = |sums: &[f64]| vec![(sums[2] / sums[3]) / (sums[0] / sums[1])];
        let [(value, error)] = self.zones.estimate(0..4, index)[..] else { unreachable!("one index") };
        OutflowFigures {
            from_s: from,
            to_s: from + count as f64 * length,
            blocks: count,
            grains,
            mass_kg: blocks.iter().map(mass).sum(),
            rate_per_s: rate(&|block| f64::from(block.grains)),
            rate_kg_per_s: rate(&mass),
            residence_s: residence,
            segregation_index: segregation(&blocks.iter().map(|block| &block.mass[..]).collect::<Vec<_>>()),
            mass_flow_index: value.is_finite().then_some(MassFlowIndex { value, error }),
        }
    }
}

/// Adds the exit of a grain to the block of its time, if the window has it.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss, reason = "16 blocks")]
fn add_to_blocks(blocks: &mut [Block], window: Window, Exit { time, species, mass, stay }: Exit) {
    let share = (time - window.from) / (window.to - window.from);
    if (0.0..1.0).contains(&share) {
        let block = &mut blocks[((share * BLOCKS as f64) as usize).min(BLOCKS - 1)];
        block.grains += 1;
        block.mass[species] += mass;
        block.residence[0] += stay;
        block.residence[1] += stay * stay;
    }
}

/// Returns the intensity of segregation of blocks, each with its masses by species, kg.
fn segregation(blocks: &[&[f64]]) -> Option<f64> {
    let blocks: Vec<_> = blocks.iter().map(|masses| (masses.iter().sum::<f64>(), masses)).collect();
    let filled = blocks.iter().filter(|(mass, _)| *mass > 0.0);
    let all: f64 = filled.clone().map(|(mass, _)| mass).sum();
    let mut between = 0.0;
    let mut whole = 0.0;
    for species in 0..blocks.first().map_or(0, |(_, masses)| masses.len()) {
        let share = filled.clone().map(|(_, masses)| masses[species]).sum::<f64>() / all;
        between +=
            filled.clone().map(|(mass, masses)| mass / all * (masses[species] / mass - share).powi(2)).sum::<f64>();
        whole += share * (1.0 - share);
    }
    (whole > 0.0 && filled.count() > 1).then(|| between / whole)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segregation_is_1_in_pure_blocks_and_0_in_equal_ones() {
        assert_eq!(segregation(&[&[2.0, 0.0], &[0.0, 0.0], &[0.0, 3.0]]), Some(1.0));
        assert_eq!(segregation(&[&[1.0, 3.0], &[2.0, 6.0]]), Some(0.0));
        // Shares 3/4 and 1/4 in blocks of equal mass: variance 1/16 over 1/4.
        assert_eq!(segregation(&[&[3.0, 1.0], &[1.0, 3.0]]), Some(0.25));
        assert_eq!((segregation(&[&[3.0], &[1.0]]), segregation(&[&[3.0, 1.0]])), (None, None));
    }
}
