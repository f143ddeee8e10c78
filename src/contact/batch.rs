//! A batch of contacts: what the law needs to know of each, in lanes, and what it answers.
//!
//! The loop over the lanes has no branch but those of the law, and touches nothing but the batch: the compiler makes vector
//! instructions of it. Each lane does what a single contact would, operation by operation, so that how many are computed at
//! once leaves no trace. Lanes beyond the last contact are computed too, from what an earlier one left there, and not read.

mod answer;
mod bodies;

pub use self::answer::Answer;
pub use self::bodies::Bodies;
use crate::columns::{BOOKED, Columns, Rotation};
use crate::contact::centred::{Ahead, Window};
use crate::contact::history::Lost;
use crate::contact::lanes::{LANES, Lanes, PerLane, Quads, Scalars, quad, spread};
use crate::contact::{Demands, Memory, Pair, PairLaw};
use crate::instructions::Instructions;
use crate::neighbours::list::Candidate;
use crate::particle::Species;
use crate::space::{Linear, Space};

/// Contacts i, j side by side; SI, as in [`Pair`].
#[derive(Clone, Debug, Default)]
pub struct Batch<V: Space> {
    /// How many there are.
    pub len: usize,
    /// Entries of the columns.
    pub pairs: PerLane<Candidate>,
    pub bodies: Bodies<V>,
    pub spins: Spins<V>,
    pub species: [PerLane<Species>; 2],
    pub ahead: AheadLanes<V>,
    pub memory: MemoryLanes<V>,
    pub answer: Answer<V>,
}

/// How the two spin.
#[derive(Clone, Debug, Default)]
pub struct Spins<V: Space> {
    /// As taken, where they have three components.
    taken: [Quads; 2],
    /// What lies beside them, which nobody reads.
    fourth: Scalars,
    lanes: [Lanes<V::Spin>; 2],
}

/// As [`Ahead`].
#[derive(Clone, Debug, Default)]
pub struct AheadLanes<V: Space> {
    pub velocity: Lanes<V>,
    pub spins: [Lanes<V::Spin>; 2],
    pub inverse_inertias: [Scalars; 2],
    pub lone: [Scalars; 2],
}

/// As [`Memory`].
#[derive(Clone, Debug, Default)]
pub struct MemoryLanes<V: Space> {
    spring: Lanes<V>,
    rolling: Lanes<V>,
    stiffness: Scalars,
}

impl<V: Space> Spins<V> {
    /// Takes those of two into a lane.
    #[inline(always)]
    pub fn take(&mut self, lane: usize, pair: [&Rotation<V>; 2]) {
        for (side, Rotation { spin, inverse_inertia }) in pair.into_iter().enumerate() {
            if V::Spin::COUNT == 1 {
                self.lanes[side].set(lane, *spin);
            } else {
                // Four that lie side by side.
                let number = |axis| if axis < V::Spin::COUNT { spin.component(axis) } else { *inverse_inertia };
                self.taken[side][lane] = quad(number);
            }
        }
    }

    /// Spreads what was taken over so many lanes.
    #[inline(always)]
    fn spread(&mut self, lanes: usize) {
        if V::Spin::COUNT > 1 {
            for (taken, spins) in self.taken.iter().zip(&mut self.lanes) {
                let [x, y, z] = spins.axes();
                spread(taken, lanes, x, y, z, &mut self.fourth);
            }
        }
    }
}

impl<V: Space> AheadLanes<V> {
    /// Fills in what is to come for a pair of entries.
    #[inline]
    pub fn describe<L: Demands>(&mut self, lane: usize, pair: [usize; 2], columns: &Columns<V>) {
        let [i, j] = pair.map(|entry| columns.gain[entry]);
        self.velocity.set(lane, i.velocity - j.velocity);
        for (side, entry) in pair.into_iter().enumerate() {
            self.lone[side][lane] = columns.gain[entry].lone;
            if L::SPIN {
                self.spins[side].set(lane, columns.spin_gain[entry].spin);
                self.inverse_inertias[side][lane] = columns.spin_gain[entry].inverse_inertia;
            }
        }
    }
}

impl<V: Space> MemoryLanes<V> {
    #[inline(always)]
    pub fn get<L: Demands>(&self, lane: usize) -> Memory<V> {
        Memory {
            spring: if L::SPRING { self.spring.get(lane) } else { V::ZERO },
            rolling: if L::ROLLING { self.rolling.get(lane) } else { V::ZERO },
            stiffness: if L::STIFFNESS { self.stiffness[lane] } else { 0.0 },
        }
    }

    #[inline(always)]
    pub fn set<L: Demands>(&mut self, lane: usize, memory: &Memory<V>) {
        if L::SPRING {
            self.spring.set(lane, memory.spring);
        }
        if L::ROLLING {
            self.rolling.set(lane, memory.rolling);
        }
        if L::STIFFNESS {
            self.stiffness[lane] = memory.stiffness;
        }
    }
}

impl<V: Space> Batch<V> {
    /// The contact of a lane, moved on by `dt` (s), as the law sees it.
    #[inline(always)]
    fn pair<L: Demands>(&self, lane: usize, dt: f64) -> Pair<V> {
        let of = |both: &[Scalars; 2]| [both[0][lane], both[1][lane]];
        let spins_of = |both: &[Lanes<V::Spin>; 2]| [both[0].get(lane), both[1].get(lane)];
        let mut pair = Pair {
            normal: self.bodies.normal.get(lane),
            overlap: self.bodies.overlap[lane],
            relative_velocity: self.bodies.relative_velocity.get(lane),
            reduced_mass: self.bodies.reduced_mass[lane],
            root: self.bodies.root[lane],
            radii: [0.0; 2],
            spins: [V::Spin::ZERO; 2],
            species: [Species(0); 2],
            dt,
            ahead: Ahead::default(),
        };
        if L::EACH {
            pair.radii = of(&self.bodies.radii);
        }
        if L::SPIN {
            pair.spins = spins_of(&self.spins.lanes);
        }
        if L::SPECIES {
            pair.species = [self.species[0][lane], self.species[1][lane]];
        }
        if L::AHEAD {
            let ahead = &self.ahead;
            pair.ahead.velocity = ahead.velocity.get(lane);
            pair.ahead.inverse_masses = of(&self.bodies.inverse_masses);
            pair.ahead.lone = of(&ahead.lone);
            if L::SPIN {
                pair.ahead.spins = spins_of(&ahead.spins);
                pair.ahead.inverse_inertias = of(&ahead.inverse_inertias);
            }
        }
        pair
    }

    /// What contacts lose, J.
    #[inline]
    pub fn lost<L: Demands>(&mut self) -> Lost {
        self.answer.lost::<L>(self.len.min(LANES))
    }

    /// How many lanes are computed: a whole number of vectors.
    #[inline(always)]
    pub fn lanes(&self) -> usize {
        self.len.next_multiple_of(8).min(LANES)
    }

    /// Asks `law` about all lanes; gives how many overlap by more than `deepest` times the sum of the radii.
    #[inline(always)]
    fn answer_all<L: PairLaw<V> + Demands, const EACH: usize>(&mut self, law: &L, dt: f64, deepest: f64) -> u32 {
        let mut deeper = 0;
        if L::SPIN {
            self.spins.spread(self.lanes());
        }
        for lane in 0..self.lanes() {
            let pair = self.pair::<L>(lane, dt);
            let mut memory = self.memory.get::<L>(lane);
            let force = law.force(&pair, &mut memory);
            if L::AHEAD {
                self.answer.touches[lane] = if Window::of(&pair).touches(pair.overlap) { 1.0 } else { 0.0 };
            }
            deeper += u32::from(pair.overlap > deepest * self.bodies.reach[lane]);
            self.answer.note::<L>(lane, &pair, &force);
            if EACH == BOOKED {
                self.answer.book::<L>(lane, &pair, &force);
            }
            self.memory.set::<L>(lane, &memory);
        }
        deeper
    }

    /// Asks `law` about all contacts of the batch; with [`BOOKED`] numbers to an entry also what serves the books of energy alone.
    /// Tells whether any of them overlaps by more than `deepest` times the sum of the radii.
    pub fn ask<L: PairLaw<V> + Demands, const EACH: usize>(
        &mut self,
        law: &L,
        dt: f64,
        instructions: Instructions,
        deepest: f64,
    ) -> bool {
        let deeper = instructions.run(
            #[inline(always)]
            || self.answer_all::<L, EACH>(law, dt, deepest),
        );
        deeper > 0
    }
}
