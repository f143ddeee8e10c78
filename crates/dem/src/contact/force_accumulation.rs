//! Force accumulation: adds contact forces and torques to the loads of both particles, starting from their weight.
//!
//! Numbers that only the energy balance needs are added if the store tracks energy.

use std::ops::{AddAssign, Range, SubAssign};

use crate::contact::batch::Batch;
use crate::contact::held_forces::HeldForces;
use crate::contact::law::LawRequirements;
use crate::contact::pair::Pair;
use crate::contact::pair_force::{PairForce, Resistance};
use crate::lanes::LANES;
use crate::neighbours::list::Candidate;
use crate::space::Space;
use crate::store::{Loads, ParticleStore, TOTAL, TOTAL_AND_DISSIPATIVE};

impl<V: Space> Pair<V> {
    /// Returns the energy that the tangential dashpot dissipates in this step, J.
    #[inline(always)]
    pub(crate) fn dashpot_loss(&self, resistance: &Resistance<V>) -> f64 {
        -resistance.friction_dashpot.dot(self.sliding_velocity(resistance.arms)) * self.dt
    }
}

/// Returns the dissipative part of the force on i, N.
#[inline(always)]
pub(crate) fn dashpot<L: LawRequirements, V: Space>(force: &PairForce<V>) -> V {
    if L::SPIN { force.dashpot + force.resistance.friction_dashpot } else { force.dashpot }
}

/// Returns the total force on i, N.
#[inline(always)]
pub(crate) fn total<L: LawRequirements, V: Space>(force: &PairForce<V>) -> V {
    if L::SPIN { force.normal + force.resistance.friction } else { force.normal }
}

/// Mutable loads of consecutive particles.
pub(crate) struct AccumulatorSlice<'a, V: Space> {
    /// Numbers of an [`Accumulator`](crate::store::Accumulator), `each` per particle.
    force: &'a mut [V],
    torque: &'a mut [V::Spin],
    each: usize,
    rolling_drag: &'a mut [V::Spin],
    contacts: &'a mut [u16],
}

impl<'a, V: Space> AccumulatorSlice<'a, V> {
    /// Returns the loads of all particles.
    pub(crate) fn all(loads: &'a mut Loads<V>) -> Self {
        let Loads { force, torque, rolling_drag, contacts } = loads;
        let (force, each) = force.numbers_mut();
        Self { force, torque: torque.numbers_mut().0, each, rolling_drag, contacts }
    }

    /// Splits off the loads of the first `particles` particles.
    pub(crate) fn split_front(&mut self, particles: usize) -> Self {
        let entries = ..particles;
        let numbers = ..particles * self.each;
        // Accumulators that the law does not need are empty.
        Self {
            force: self.force.split_off_mut(numbers).unwrap_or_default(),
            torque: self.torque.split_off_mut(numbers).unwrap_or_default(),
            each: self.each,
            rolling_drag: self.rolling_drag.split_off_mut(entries).unwrap_or_default(),
            contacts: self.contacts.split_off_mut(entries).unwrap_or_default(),
        }
    }

    /// Initialises the sums from position `start` on: forces to the weights of `masses` (kg), the rest to zero.
    fn initialise<const NUMBERS: usize>(&mut self, start: usize, masses: &[f64], gravity: V) {
        fn clear<T: Copy + Default>(column: &mut [T], places: Range<usize>) {
            if let Some(sums) = column.get_mut(places) {
                sums.fill(T::default());
            }
        }
        let end = start + masses.len();
        for (entry, mass) in self.force.as_chunks_mut::<NUMBERS>().0[start..end].iter_mut().zip(masses) {
            *entry = [V::ZERO; NUMBERS];
            entry[0] = gravity * *mass;
        }
        clear(self.torque, start * NUMBERS..end * NUMBERS);
        clear(self.rolling_drag, start..end);
        clear(self.contacts, start..end);
    }
}

/// Adds numbers to an accumulator entry.
#[inline(always)]
fn add<T: AddAssign, const NUMBERS: usize>(entry: &mut [T; NUMBERS], numbers: [T; NUMBERS]) {
    entry.iter_mut().zip(numbers).for_each(|(sum, number)| *sum += number);
}

/// Subtracts numbers from an accumulator entry.
#[inline(always)]
fn subtract<T: SubAssign, const NUMBERS: usize>(entry: &mut [T; NUMBERS], numbers: [T; NUMBERS]) {
    entry.iter_mut().zip(numbers).for_each(|(sum, number)| *sum -= number);
}

/// The sums of a range of rows.
pub(crate) struct ForceAccumulation<'a, V: Space> {
    rows: Range<usize>,
    /// Sums before this slot are initialised.
    initialised_end: usize,
    slice: AccumulatorSlice<'a, V>,
}

impl<'a, V: Space> ForceAccumulation<'a, V> {
    pub(crate) fn new(rows: Range<usize>, slice: AccumulatorSlice<'a, V>) -> Self {
        Self { initialised_end: rows.start, rows, slice }
    }

    /// Initialises the sums before slot `end` that are not initialised yet.
    pub(super) fn initialise(&mut self, end: usize, gravity: V, store: &ParticleStore<V>) {
        let end = end.clamp(self.initialised_end, self.rows.end);
        let masses = &store.mass[self.initialised_end..end];
        let start = self.initialised_end - self.rows.start;
        if self.slice.each == TOTAL_AND_DISSIPATIVE {
            self.slice.initialise::<TOTAL_AND_DISSIPATIVE>(start, masses, gravity);
        } else {
            self.slice.initialise::<TOTAL>(start, masses, gravity);
        }
        self.initialised_end = end;
    }

    /// Adds the forces of a batch to both particles, or only to that in the row if the other belongs to another thread.
    #[inline(always)]
    pub(super) fn add_to_both<C: LawRequirements, const NUMBERS: usize>(&mut self, batch: &Batch<V>) {
        let start = self.rows.start;
        let AccumulatorSlice { force, torque, rolling_drag, .. } = &mut self.slice;
        // Copied to locals so that the compiler can prove that stores do not alias them. Forces and torques have equal
        // length.
        let forces = force.as_chunks_mut::<NUMBERS>().0;
        let mut torques = torque.as_chunks_mut::<NUMBERS>().0;
        if C::SPIN {
            torques = &mut torques[..forces.len()];
        }
        let rolling = &mut **rolling_drag;
        let output = &batch.output;
        for lane in 0..batch.len.min(LANES) {
            let [lower, row] = batch.pairs[lane].slots().map(|slot| slot.wrapping_sub(start));
            let is_here = lower < forces.len();
            // All reads come before all writes: the compiler cannot prove that the sums do not alias the batch.
            let torques_of = output.torques::<C, NUMBERS>(lane);
            let force = output.force::<NUMBERS>(lane);
            subtract(&mut forces[row], force);
            if C::SPIN {
                subtract(&mut torques[row], torques_of[1]);
            }
            if is_here {
                add(&mut forces[lower], force);
                if C::SPIN {
                    add(&mut torques[lower], torques_of[0]);
                }
            }
            if C::ROLLING && NUMBERS == TOTAL_AND_DISSIPATIVE {
                let dashpot = output.rolling_dashpot_torque.get(lane);
                rolling[row] -= dashpot;
                if is_here {
                    rolling[lower] += dashpot;
                }
            }
        }
    }

    /// Adds the forces of a batch of contacts with walls to their particles.
    pub(crate) fn add_to_rows<C: LawRequirements, const NUMBERS: usize>(&mut self, batch: &Batch<V>) {
        let AccumulatorSlice { force, torque, rolling_drag, .. } = &mut self.slice;
        let forces = force.as_chunks_mut::<NUMBERS>().0;
        let torques = torque.as_chunks_mut::<NUMBERS>().0;
        let output = &batch.output;
        for lane in 0..batch.len.min(LANES) {
            let entry = batch.pairs[lane].row() - self.rows.start;
            add(&mut forces[entry], output.force::<NUMBERS>(lane));
            if C::SPIN {
                add(&mut torques[entry], output.torques::<C, NUMBERS>(lane)[0]);
            }
            if C::ROLLING && NUMBERS == TOTAL_AND_DISSIPATIVE {
                rolling_drag[entry] += output.rolling_dashpot_torque.get(lane);
            }
        }
    }

    /// Adds forces that were held, and counts their contacts. `slot` returns the particle of a contact; particles of other tasks are skipped.
    pub(super) fn add_held<C: LawRequirements, const NUMBERS: usize>(
        &mut self,
        held: &HeldForces<V>,
        slot: impl Fn(Candidate) -> usize,
    ) {
        let AccumulatorSlice { force, torque, rolling_drag, contacts, .. } = &mut self.slice;
        let forces = force.as_chunks_mut::<NUMBERS>().0;
        let torques = torque.as_chunks_mut::<NUMBERS>().0;
        for (number, &contact) in held.pairs.iter().enumerate() {
            let entry = slot(contact).wrapping_sub(self.rows.start);
            if entry >= forces.len() {
                continue;
            }
            add(&mut forces[entry], held.force.as_chunks::<NUMBERS>().0[number]);
            if C::SPIN {
                add(&mut torques[entry], held.torque.as_chunks::<NUMBERS>().0[number]);
            }
            if C::ROLLING && NUMBERS == TOTAL_AND_DISSIPATIVE {
                rolling_drag[entry] += held.rolling_drag[number];
            }
            if let Some(touches) = held.touches.get(number) {
                contacts[entry] += u16::from(*touches);
            }
        }
    }

    /// Counts the contacts of a batch for the particles in the rows and, between particles (`BOTH`), for those in the lower slots.
    #[inline(always)]
    pub(super) fn count<const BOTH: bool>(&mut self, batch: &Batch<V>) {
        let start = self.rows.start;
        let counts = &mut *self.slice.contacts;
        let touching = batch.output.contacts();
        let mut count = |lane: usize| {
            let touches = u16::from(touching >> lane & 1 > 0);
            let [lower, row] = batch.pairs[lane].slots().map(|slot| slot.wrapping_sub(start));
            counts[row] += touches;
            if BOTH && let Some(count) = counts.get_mut(lower) {
                *count += touches;
            }
        };
        // Neighbouring lanes share their row, and each addition to it waits for the one before. So lanes of other rows come
        // in between.
        let quarter = batch.len.min(LANES) / 4;
        for lane in 0..quarter {
            for part in 0..4 {
                count(lane + part * quarter);
            }
        }
        (4 * quarter..batch.len.min(LANES)).for_each(count);
    }
}
