//! A batch of contacts: the inputs of the law in lanes, and its output.
//!
//! The loop over the lanes has no branches but those of the law and accesses only the batch, so the compiler vectorises
//! it. Each lane performs the operations of a single contact in the same order. So the batch size does not change any
//! result. Lanes beyond the last contact are also computed, from stale inputs, but never read.

mod bodies;
mod contact_output;
mod events;
mod filter;
mod gathered;
mod memories;
mod spins;

pub use self::bodies::Bodies;
pub use self::contact_output::ContactOutput;
pub use self::events::{EventStep, Predict};
pub use self::gathered::GatheredLanes;
pub use self::memories::MemoryLanes;
pub use self::spins::Spins;
use crate::contact::history::losses::ContactLosses;
use crate::contact::law::{LawComputation, LawRequirements, PairLaw};
use crate::contact::memory::Memory;
use crate::contact::pair::{MemoryTimes, Pair, VelocityPrediction};
use crate::contact::pair_force::PairForce;
use crate::instruction_set::InstructionSet;
use crate::lanes::{LANES, PerLane, of_both, smaller};
use crate::neighbours::list::Candidate;
use crate::particle::Species;
use crate::space::{Linear, Space};
use crate::store::{Rotation, TOTAL_AND_DISSIPATIVE};

/// Returns 1 if the contact may open or close within the step, or, with friction, if its normal force may change its sign; otherwise
/// 0. `event_time` (s) times the normal speed is the overlap from which neither happens without a dashpot. `range` (m) is how far the
/// contact exists beyond touch. Combining the sign bits of two numbers takes fewer vector instructions than comparing their minimum with
/// zero.
#[inline(always)]
fn near_event<L: PairLaw<V> + LawRequirements, V: Space>(
    law: &L,
    pair: &Pair<V>,
    force: &PairForce<V>,
    event_time: f64,
    range: f64,
) -> u64 {
    let nearest = event_time * pair.normal_velocity().abs();
    let overlap = if L::REACHES { pair.overlap + range } else { pair.overlap };
    let opening = overlap - nearest;
    if !L::SPIN {
        return opening.to_bits() >> 63;
    }
    // The dashpot of a separating contact reduces the force, so that its sign may change at a larger overlap.
    let [load, spring] = force.load.unwrap_or_else(
        #[inline(always)]
        || {
            let mut total = force.normal.dot(pair.normal);
            if L::PULLS {
                // An adhesive pull does not count in the cap of friction.
                total += law.pull(pair);
            }
            [total, total - force.dashpot.dot(pair.normal)]
        },
    );
    let unloading = smaller(load, spring) * overlap - spring * nearest;
    (opening.to_bits() | unloading.to_bits()) >> 63
}

/// Contacts i, j side by side; units as in [`Pair`].
#[derive(Clone, Debug, Default)]
pub struct Batch<V: Space> {
    /// Number of contacts.
    pub len: usize,
    /// The pairs. If both are particles, i is the one in the lower slot.
    pub pairs: PerLane<Candidate>,
    pub bodies: Bodies<V>,
    pub spins: Spins<V>,
    pub gathered: GatheredLanes<V>,
    pub species: [PerLane<Species>; 2],
    pub memory: MemoryLanes,
    pub output: ContactOutput<V>,
    /// Memories after the evaluation.
    pub memory_after: MemoryLanes,
    /// Bits of the lanes with a lone particle.
    pub lone: u64,
}

impl<V: Space> Batch<V> {
    /// Adds a contact with a wall surface, with its geometry. The reach is set to the radius of i. `C` is the class of the law.
    #[inline(always)]
    pub fn push<C: LawRequirements>(&mut self, contact: Candidate, pair: &Pair<V>) {
        let lane = self.len;
        let bodies = &mut self.bodies;
        self.pairs[lane] = contact;
        bodies.normal.set(lane, pair.normal);
        bodies.overlap[lane] = pair.overlap;
        bodies.relative_velocity.set(lane, pair.relative_velocity);
        bodies.reduced_mass[lane] = pair.reduced_mass;
        bodies.mass_root[lane] = pair.mass_root;
        bodies.reach[lane] = pair.radii[0];
        (bodies.radii[0][lane], bodies.radii[1][lane]) = pair.radii.into();
        bodies.inverse_reach[lane] = pair.inverse_reach;
        (self.species[0][lane], self.species[1][lane]) = pair.species.into();
        if C::SPIN {
            let rotations = pair.spins.map(|spin| Rotation { spin, inverse_inertia: 0.0 });
            self.spins.take(lane, rotations.each_ref());
        }
        self.len += 1;
    }

    /// Returns the contact in a lane as the input of the law.
    #[inline(always)]
    pub fn pair<L: LawRequirements>(&self, lane: usize, times: MemoryTimes) -> Pair<V> {
        let MemoryTimes { dt, springs_ahead } = times;
        let mut pair = Pair {
            normal: self.bodies.normal.get(lane),
            overlap: self.bodies.overlap[lane],
            relative_velocity: self.bodies.relative_velocity.get(lane),
            reduced_mass: self.bodies.reduced_mass[lane],
            mass_root: self.bodies.mass_root[lane],
            radii: [0.0; 2],
            inverse_reach: 0.0,
            spins: [V::Spin::ZERO; 2],
            species: [Species(0); 2],
            dt,
            springs_ahead,
            gathered: None,
            ahead: VelocityPrediction::default(),
        };
        if L::RADII {
            pair.radii = of_both(&self.bodies.radii, lane);
            pair.inverse_reach = self.bodies.inverse_reach[lane];
        }
        if L::SPIN {
            pair.spins = self.spins.get(lane);
        }
        if L::SPECIES {
            pair.species = [self.species[0][lane], self.species[1][lane]];
        }
        pair
    }

    /// Takes the marks of the pairs into [`Self::lone`]. `unmark` removes the marks from the pairs. Only contact histories compare pairs, so
    /// marks may stay where there is no memory.
    #[inline]
    pub fn take_marks(&mut self, unmark: bool, instructions: InstructionSet) {
        let pairs = &mut self.pairs;
        let marks = instructions.run(
            #[inline(always)]
            || {
                let mut marks = 0;
                for (lane, pair) in (0u64..).zip(pairs.iter()) {
                    marks |= pair.mark() << lane;
                }
                if unmark {
                    pairs.iter_mut().for_each(|pair| *pair = pair.unmarked());
                }
                marks
            },
        );
        // Lanes beyond the last contact hold pairs of earlier batches.
        self.lone = marks & !(u64::MAX << self.len);
    }

    /// Returns the energy that the contacts lose, J. `C` is the class of the law.
    #[inline]
    pub fn lost<C: LawRequirements>(&mut self) -> ContactLosses {
        self.output.lost::<C>(self.len.min(LANES))
    }

    /// Returns the number of lanes whose particles touch.
    #[inline]
    pub fn touching(&self) -> u32 {
        (self.output.contacts() & !(u64::MAX << self.len)).count_ones()
    }

    /// Returns the number of lanes to compute: whole vectors.
    #[inline(always)]
    pub fn lanes(&self) -> usize {
        self.len.next_multiple_of(8).min(LANES)
    }

    /// Evaluates `law` in all lanes, also in those beyond the last contact. `CENTRED`: velocities are predicted. `GATHERED`: springs
    /// advance with those in the middle of the step.
    #[inline(always)]
    fn evaluate_lanes<
        L: PairLaw<V> + LawRequirements,
        const NUMBERS: usize,
        const CENTRED: bool,
        const GATHERED: bool,
    >(
        &mut self,
        law: &L,
        call: &Call,
    ) -> Evaluated {
        let Call { times, deepest, event_time, .. } = *call;
        let mut deeper = 0;
        let mut near_events = 0;
        // So the compiler can tell whether this time is zero: plain contacts do not pay for centred ones, and the loop of
        // centred ones has no branch on it.
        let springs_ahead = if CENTRED && !GATHERED { times.springs_ahead.max(f64::MIN_POSITIVE) } else { 0.0 };
        let times = MemoryTimes { springs_ahead, ..times };
        if L::SPIN {
            self.spins.spread(self.lanes());
        }
        for lane in 0..self.lanes() {
            let mut pair = self.pair::<L>(lane, times);
            if GATHERED {
                pair.gathered = Some(self.gathered.get::<L>(lane));
            }
            let mut memory = self.memory.get::<L, V>(lane);
            let range = if L::REACHES { law.range_of(&pair, &memory) } else { 0.0 };
            let force = if L::REACHES && pair.overlap + range <= 0.0 {
                memory = Memory::default();
                PairForce::default()
            } else {
                let force = law.force(&pair, &mut memory);
                memory.exists = L::REACHES;
                force
            };
            deeper += u64::from(pair.overlap > deepest * self.bodies.reach[lane]);
            self.output.store_force::<L>(lane, &pair, &force);
            if NUMBERS == TOTAL_AND_DISSIPATIVE {
                self.output.store_energy_numbers::<L>(lane, &pair, &force);
            }
            self.memory_after.set::<L, V>(lane, &memory);
            if CENTRED {
                near_events |= near_event(law, &pair, &force, event_time, range) << lane;
            }
        }
        Evaluated { deeper, near_events }
    }

    /// Marks the lanes of bodies that are within range beyond touch but not in contact.
    #[inline]
    pub fn mark_gaps(&mut self) {
        self.output.set_gaps(!self.memory_after.exists & !(u64::MAX << self.len));
    }

    /// Evaluates `law` for all contacts of the batch. With [`TOTAL_AND_DISSIPATIVE`] as `NUMBERS` it also stores the
    /// numbers that only the energy balance needs.
    #[inline]
    pub fn evaluate<L: PairLaw<V> + LawRequirements, const NUMBERS: usize>(
        &mut self,
        law: &L,
        call: &Call,
    ) -> Evaluated {
        match call.velocities {
            Velocities::Middle => LaneLoop::<V, NUMBERS, false, false> { batch: self, call }.evaluate(law),
            // Springs exist only where there is memory.
            Velocities::PredictedAndMiddle if L::REMEMBERS => {
                LaneLoop::<V, NUMBERS, true, true> { batch: self, call }.evaluate(law)
            }
            _ => LaneLoop::<V, NUMBERS, true, false> { batch: self, call }.evaluate(law),
        }
    }

    /// Returns the two species of all contacts; `None` if they differ.
    #[inline]
    fn only_species(&self) -> Option<[Species; 2]> {
        let [first, second] = self.species.each_ref().map(|species| &species[..self.len.min(LANES)]);
        let species = [*first.first()?, *second.first()?];
        let is_same = |(a, b): (&Species, &Species)| [*a, *b] == species;
        first.iter().zip(second).all(is_same).then_some(species)
    }
}

/// The velocities that a law gets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Velocities {
    /// Velocities in the middle of the step.
    Middle,
    /// Velocities predicted for the end of the step ([`centred`](crate::contact::centred)).
    Predicted,
    /// Predicted velocities, and for springs the velocities in the middle of the step.
    PredictedAndMiddle,
}

/// Arguments of [`Batch::evaluate`].
#[derive(Clone, Copy, Debug)]
pub struct Call {
    /// The velocities in the lanes.
    pub velocities: Velocities,
    /// The times of memories.
    pub times: MemoryTimes,
    /// Instruction set of the loop over the lanes.
    pub instructions: InstructionSet,
    /// Overlap, divided by the sum of the radii, beyond which contacts are counted.
    pub deepest: f64,
    /// Time whose product with the normal speed is the overlap from which a contact has no event within the step, s.
    pub event_time: f64,
}

/// The result of [`Batch::evaluate`]. It includes lanes beyond the last contact.
#[derive(Clone, Copy, Debug)]
pub struct Evaluated {
    /// Number of lanes that overlap by more than [`Call::deepest`].
    pub deeper: u64,
    /// Bits of the lanes near an event: the contact may open or close within the step, or the normal force of a contact with friction
    /// may change its sign.
    pub near_events: u64,
}

/// The evaluation of all lanes of a batch. It holds two references and no numbers: a function receives two references in registers. It would
/// receive a larger struct through memory, and wait for it.
struct LaneLoop<'a, V: Space, const NUMBERS: usize, const CENTRED: bool, const GATHERED: bool> {
    batch: &'a mut Batch<V>,
    call: &'a Call,
}

impl<V: Space, const NUMBERS: usize, const CENTRED: bool, const GATHERED: bool>
    LaneLoop<'_, V, NUMBERS, CENTRED, GATHERED>
{
    /// Evaluates all lanes with one law if all contacts are between the same two species, as in most batches of a silo: contacts of grains of one kind, or
    /// of such grains with walls. Otherwise the law of each contact is looked up, which the compiler does not vectorise.
    #[inline]
    fn evaluate<L: PairLaw<V> + LawRequirements>(self, law: &L) -> Evaluated {
        let depends = L::SPECIES && law.depends_on_species();
        let only = if depends { self.batch.only_species() } else { Some([Species(0); 2]) };
        if let Some(species) = only {
            return law.between(species, self);
        }
        let Self { batch, call } = self;
        batch.evaluate_lanes::<L, NUMBERS, CENTRED, GATHERED>(law, call)
    }
}

impl<V: Space, const NUMBERS: usize, const CENTRED: bool, const GATHERED: bool> LawComputation<V>
    for LaneLoop<'_, V, NUMBERS, CENTRED, GATHERED>
{
    type Output = Evaluated;

    /// A function of its own: compiled once for a law and for its table of pairs of species.
    fn run<L: PairLaw<V> + LawRequirements>(self, law: &L) -> Evaluated {
        let Self { batch, call } = self;
        call.instructions.run(
            #[inline(always)]
            || batch.evaluate_lanes::<L, NUMBERS, CENTRED, GATHERED>(law, call),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::composite::Composite;
    use crate::contact::damping::{Attraction, Coefficient, Damping};
    use crate::contact::force_accumulation::{dashpot, total};
    use crate::contact::linear::LinearNormal;
    use crate::contact::rolling::NoRolling;
    use crate::contact::table::PairTable;
    use crate::contact::tangential::{ConstantStiffness, Lever, SpringSlider};
    use crate::space::{Linear, Plane, Solid};
    use crate::store::TOTAL;

    /// Returns the contact of grain `number`, of radius 1 to 5 cm, with a wall surface. The values vary with the number,
    /// and every other grain is fast enough to slide.
    fn on_wall<V: Space>(number: u32) -> Pair<V> {
        let part = f64::from(number % 17) / 17.0;
        let along = |x: f64, y: f64, z: f64| V::narrow(Solid::new(x, y, z));
        let speed = if number.is_multiple_of(2) { 0.01 } else { 3.0 };
        Pair {
            normal: along(0.6, 0.8, 0.0),
            overlap: 1e-4 * (0.1 + part),
            relative_velocity: along(speed, part - 0.5, 0.2 * part),
            reduced_mass: 0.1 + part,
            mass_root: (0.1 + part).sqrt(),
            radii: [0.01 + 0.04 * part, f64::INFINITY],
            inverse_reach: 0.0,
            spins: [V::narrow_spin(Solid::new(part, 1.0 - part, 3.0 * part)), V::Spin::ZERO],
            species: [Species(0), Species(1)],
            dt: 1e-5,
            springs_ahead: 0.0,
            gathered: None,
            ahead: VelocityPrediction {
                velocity: along(0.0, -1e-4, 2e-4),
                spins: [V::narrow_spin(Solid::new(0.1 * part, 0.2, 0.3)), V::Spin::ZERO],
                inverse_masses: [1.0 / (0.1 + part), 0.0],
                inverse_inertias: [40.0, 0.0],
                lone: [f64::from(number % 3 / 2), 0.0],
                ..VelocityPrediction::default()
            },
        }
    }

    const TIMES: MemoryTimes = MemoryTimes { dt: 1e-5, springs_ahead: 0.0 };

    fn check_batch<V: Space, L: PairLaw<V> + LawRequirements>(law: &L, species: fn(u32) -> u8) {
        let contacts = 33;
        let on_wall = |number: u32| Pair { species: [Species(species(number)), Species(1)], ..on_wall(number) };
        for instructions in InstructionSet::all() {
            let mut batch = Batch::<V>::default();
            for number in 0..contacts {
                batch.push::<L>(Candidate::new(number, 1), &on_wall(number));
            }
            let velocities = Velocities::Middle;
            let call = |deepest| Call { velocities, times: TIMES, instructions, deepest, event_time: 0.0 };
            let evaluated = batch.evaluate::<L, TOTAL_AND_DISSIPATIVE>(law, &call(0.0));
            assert!(evaluated.deeper >= u64::from(contacts));
            for (lane, number) in (0..contacts).enumerate() {
                let pair = on_wall(number);
                let mut memory = Memory::default();
                let on_i = law.force(&pair, &mut memory);
                let resistance = &on_i.resistance;
                let torque = |friction: V| pair.normal.cross(friction) * -resistance.arms[0];
                assert_eq!(
                    batch.output.force::<TOTAL_AND_DISSIPATIVE>(lane),
                    [total::<L, V>(&on_i), dashpot::<L, V>(&on_i)]
                );
                assert_eq!(
                    batch.output.torques::<L, TOTAL_AND_DISSIPATIVE>(lane)[0],
                    [torque(resistance.friction), torque(resistance.friction_dashpot)]
                );
                assert_eq!(batch.memory_after.get::<L, V>(lane), memory);
                assert!(batch.output.is_contact(lane));
            }
            assert_eq!(batch.evaluate::<L, TOTAL>(law, &call(1.0)).deeper, 0);
        }
    }

    /// Marks three of eight pairs, one of them beyond the end of a batch of seven. Checks the bits and the pairs.
    fn check_marks(unmark: bool) {
        for instructions in InstructionSet::all() {
            let mut batch = Batch::<Plane> { len: 7, ..Batch::default() };
            for (lane, number) in (0..8).enumerate() {
                batch.pairs[lane] = Candidate::new(number, 9).with_mark(u8::from([1, 6, 7].contains(&number)));
            }
            batch.take_marks(unmark, instructions);
            assert_eq!(batch.lone, 0b100_0010);
            assert_eq!(batch.pairs[1].row_and_partner(), [1, 9]);
            assert_eq!(batch.pairs[1].mark(), u64::from(!unmark));
        }
    }

    #[test]
    fn marks_become_bits_and_stay_unless_removed() {
        check_marks(false);
        check_marks(true);
    }

    #[test]
    fn batch_agrees_with_single_contacts() {
        let damping = |per_mass| Coefficient { per_mass, ..Coefficient::default() };
        for lever in [Lever::Radius, Lever::ContactPoint] {
            let law = Composite {
                normal: LinearNormal::new(
                    1e5.try_into().unwrap(),
                    Damping::PerMass(300.0.try_into().unwrap()),
                    Attraction::Allowed,
                ),
                tangential: SpringSlider {
                    modulus: ConstantStiffness { k: 3e4, damping: damping(150.0) },
                    friction: 0.4,
                    lever,
                },
                rolling: NoRolling,
            };
            check_batch::<Plane, _>(&law, |_| 0);
            check_batch::<Solid, _>(&law, |_| 0);
            // Batches of one kind of contact, and of both kinds.
            let twice = |a: u8, b: u8| Composite {
                normal: LinearNormal::new(
                    (1e5 * f64::from(1 + a + b)).try_into().unwrap(),
                    Damping::PerMass(300.0.try_into().unwrap()),
                    Attraction::Allowed,
                ),
                ..law
            };
            let table = PairTable::new(2, twice);
            for species in [|_| 0, |_| 1, |number| u8::from(number > 20)] {
                check_batch::<Solid, _>(&table, species);
            }
        }
    }
}
