//! Contacts of a batch near an event: for these few the law is evaluated anew, one by one and averaged over the step
//! ([`centred`](crate::contact::centred)).

use crate::contact::batch::{Batch, Bodies};
use crate::contact::centred::start::force_at_start;
use crate::contact::centred::window::Window;
use crate::contact::law::{LawRequirements, PairLaw};
use crate::contact::memory::Memory;
use crate::contact::pair::{Gathered, MemoryTimes, Pair};
use crate::contact::pair_force::PairForce;
use crate::instruction_set::InstructionSet;
use crate::neighbours::list::Candidate;
use crate::space::Space;
use crate::store::ParticleStore;

/// The widest gap that a pair is assumed to close in half a step, divided by half a step times the predicted speed. More than one, because
/// the velocity in the middle of the step differs from the predicted one.
const CLOSED_IN_HALF_A_STEP: f64 = 1.25;

/// Turns a contact with predicted velocities into one with the velocities in the middle of the step and their prediction.
pub type Predict<'a, V> = &'a dyn Fn(&ParticleStore<V>, Candidate, &mut Pair<V>);

impl<V: Space> Bodies<V> {
    /// Returns whether a gap wider than `range` (m) stays so for half a step, `half` (s).
    #[inline(always)]
    fn stay_apart(&self, lane: usize, range: f64, half: f64) -> bool {
        let speed = self.relative_velocity.get(lane).dot(self.normal.get(lane)).abs();
        self.overlap[lane] + range + CLOSED_IN_HALF_A_STEP * half * speed < 0.0
    }
}

impl<V: Space> Batch<V> {
    /// Evaluates the law anew for the contacts near an event, `near` (bits of lanes).
    #[inline(never)]
    pub fn evaluate_events<L: PairLaw<V> + LawRequirements>(
        &mut self,
        law: &L,
        times: MemoryTimes,
        step: &EventStep<V>,
        near: u64,
    ) {
        step.instructions.run_narrow(
            #[inline(always)]
            || self.evaluate_each::<L>(law, times, step, near),
        );
    }

    /// As [`Self::evaluate_events`], compiled for the instruction set of the calling code.
    #[inline(always)]
    fn evaluate_each<L: PairLaw<V> + LawRequirements>(
        &mut self,
        law: &L,
        times: MemoryTimes,
        step: &EventStep<V>,
        mut near: u64,
    ) {
        while near != 0 {
            let lane = near.trailing_zeros() as usize;
            near &= near - 1;
            if !step.starts {
                let range = if L::REACHES {
                    law.range_of(&self.pair::<L>(lane, times), &self.memory.get::<L, V>(lane))
                } else {
                    0.0
                };
                if self.bodies.stay_apart(lane, range, step.store.prediction.velocities_ahead) {
                    self.clear::<L>(lane);
                    continue;
                }
            }
            let mut pair = self.pair::<L>(lane, times);
            let mut memory = self.memory.get::<L, V>(lane);
            let force = if step.starts {
                force_at_start(law, &pair, &mut memory, step.store.prediction.velocities_ahead, self.bodies.reach[lane])
            } else {
                step.force(law, self.pairs[lane], &mut pair, &mut memory)
            };
            let Some(force) = force else {
                self.clear::<L>(lane);
                continue;
            };
            self.output.store_force::<L>(lane, &pair, &force);
            if step.store.tracks_energy {
                self.output.store_energy_numbers::<L>(lane, &pair.predicted(), &force);
            }
            if L::REACHES {
                self.output.contact(lane);
                // A contact that forms after this evaluation does not exist yet.
                if memory.exists || pair.overlap > 0.0 {
                    memory.exists = true;
                } else {
                    memory = Memory::default();
                }
            }
            self.memory_after.set::<L, V>(lane, &memory);
        }
    }

    /// Makes a lane a gap, without force and memory.
    fn clear<L: LawRequirements>(&mut self, lane: usize) {
        self.output.clear_lane::<L>(lane);
        self.memory_after.set::<L, V>(lane, &Memory::default());
    }
}

/// The step in which contacts near an event are evaluated.
pub struct EventStep<'a, V: Space> {
    /// The particles.
    pub store: &'a ParticleStore<V>,
    /// Adds the velocity prediction to a contact.
    pub predict: Predict<'a, V>,
    /// Whether it is step zero.
    pub starts: bool,
    /// Instruction set of the law.
    pub instructions: InstructionSet,
}

impl<V: Space> EventStep<'_, V> {
    /// Returns the averaged force of a contact, or `None` if there is no contact in this step.
    #[inline(always)]
    fn force<L: PairLaw<V> + LawRequirements>(
        &self,
        law: &L,
        contact: Candidate,
        pair: &mut Pair<V>,
        memory: &mut Memory,
    ) -> Option<PairForce<V>> {
        let overlap = if L::REACHES { pair.overlap + law.range_of(pair, memory) } else { pair.overlap };
        (self.predict)(self.store, contact, pair);
        if self.store.prediction.springs_exact {
            pair.gathered = Some(Gathered { relative_velocity: pair.relative_velocity, spins: pair.spins });
        }
        Window::of(pair).touches(overlap).then(|| law.centred(pair, memory))
    }
}
