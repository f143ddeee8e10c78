//! The turning of bodies in lanes.
//!
//! A free rotation is a chain of some hundred operations that depend on each other. Numbers of many bodies are put side by side, so that one vector
//! instruction works on several bodies, and the chains of several vectors overlap. Each lane makes the operations that one body alone would make.

use crate::lanes::{LANES, Lanes, RotorLanes};
use crate::space::{Linear, Rotor, Space, Turned};
use crate::store::{Rotation, kick_term};

/// The columns of bodies that a pass turns, all of the same length.
pub(super) struct TurningBodies<'a, V: Space, const NUMBERS: usize> {
    pub(super) torque: &'a [[V::Spin; NUMBERS]],
    pub(super) inverse_inertia: &'a [V::Principal],
    pub(super) momentum: &'a mut [V::Spin],
    pub(super) rotor: &'a mut [V::Rotor],
    pub(super) rotation: &'a mut [Rotation<V>],
    pub(super) middle_spin: &'a mut [V::Spin],
}

/// How a pass turns bodies.
#[derive(Clone, Copy)]
pub(super) struct Turn {
    /// Time step, s.
    pub(super) dt: f64,
    /// The share of the next half kick that predicted spins have; none without prediction.
    pub(super) prediction: Option<f64>,
}

/// Up to [`LANES`] bodies side by side.
pub(super) struct TurningLanes<V: Space, const NUMBERS: usize> {
    torque: [Lanes<V::Spin>; NUMBERS],
    inverse_inertia: Lanes<V::Principal>,
    momentum: Lanes<V::Spin>,
    rotor: RotorLanes<V>,
    /// The spin in the middle of the step, rad/s.
    middle: Lanes<V::Spin>,
    /// The predicted spin at the end of the step, rad/s.
    ahead: Lanes<V::Spin>,
    /// The [term](kick_term) of the sum of kicks.
    term: Lanes<V::Spin>,
}

impl<V: Space, const NUMBERS: usize> Default for TurningLanes<V, NUMBERS> {
    fn default() -> Self {
        Self {
            torque: std::array::from_fn(|_| Lanes::default()),
            inverse_inertia: Lanes::default(),
            momentum: Lanes::default(),
            rotor: RotorLanes::default(),
            middle: Lanes::default(),
            ahead: Lanes::default(),
            term: Lanes::default(),
        }
    }
}

impl<V: Space, const NUMBERS: usize> TurningLanes<V, NUMBERS> {
    /// Makes the first kick of all bodies and turns them, after the second kick of the previous step if `SECOND`. Returns the sum of the terms of
    /// the second kick.
    #[inline(always)]
    pub(super) fn turn_all<const SECOND: bool>(
        &mut self,
        turn: Turn,
        bodies: &mut TurningBodies<'_, V, NUMBERS>,
    ) -> V::Spin {
        let mut sum = V::Spin::ZERO;
        let end = bodies.torque.len();
        for start in (0..end).step_by(LANES) {
            let lanes = (end - start).min(LANES);
            self.load(bodies, start, lanes);
            self.turn::<SECOND>(turn, lanes);
            self.store(turn, bodies, start, lanes);
            if SECOND {
                for lane in 0..lanes {
                    sum += self.term.get(lane);
                }
            }
        }
        sum
    }

    #[inline(always)]
    fn load(&mut self, bodies: &TurningBodies<'_, V, NUMBERS>, start: usize, lanes: usize) {
        for lane in 0..lanes {
            let b = start + lane;
            for (lanes, torque) in self.torque.iter_mut().zip(bodies.torque[b]) {
                lanes.set(lane, torque);
            }
            self.inverse_inertia.set(lane, bodies.inverse_inertia[b]);
            self.momentum.set(lane, bodies.momentum[b]);
            self.rotor.set(lane, bodies.rotor[b]);
        }
    }

    #[inline(always)]
    fn turn<const SECOND: bool>(&mut self, turn: Turn, lanes: usize) {
        let Turn { dt, prediction } = turn;
        for lane in 0..lanes.min(LANES) {
            let inverse_inertia = self.inverse_inertia.get(lane);
            let rotor = self.rotor.get(lane);
            let torque = std::array::from_fn::<_, NUMBERS, _>(
                #[inline(always)]
                |number| self.torque[number].get(lane),
            );
            let mut momentum = self.momentum.get(lane);
            let gain = torque[0] * (0.5 * dt);
            let own_gain = rotor.own(gain);
            let mut own = rotor.own(momentum);
            if SECOND {
                momentum += gain;
                own += own_gain;
                self.term.set(lane, kick_term(&torque, rotor.spin_of_own(own, inverse_inertia)));
            }
            momentum += gain;
            own += own_gain;
            let before = rotor.spin_of_own(own, inverse_inertia);
            let Turned { rotor, own } = rotor.freely_turned(own, inverse_inertia, dt);
            let after = rotor.spin_of_own(own, inverse_inertia);
            self.middle.set(lane, (before + after) * 0.5);
            if let Some(share) = prediction {
                self.ahead.set(lane, rotor.spin_of_own(own + rotor.own(gain * share), inverse_inertia));
            }
            self.momentum.set(lane, momentum);
            self.rotor.set(lane, rotor);
        }
    }

    #[inline(always)]
    fn store(&self, turn: Turn, bodies: &mut TurningBodies<'_, V, NUMBERS>, start: usize, lanes: usize) {
        for lane in 0..lanes {
            let b = start + lane;
            bodies.momentum[b] = self.momentum.get(lane);
            bodies.rotor[b] = self.rotor.get(lane);
            let middle = self.middle.get(lane);
            if turn.prediction.is_some() {
                bodies.middle_spin[b] = middle;
                bodies.rotation[b].spin = self.ahead.get(lane);
            } else {
                bodies.rotation[b].spin = middle;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instruction_set::InstructionSet;
    use crate::space::{Plane, Solid};
    use crate::store::TOTAL_AND_DISSIPATIVE;

    /// Columns of bodies.
    #[derive(Clone, Debug)]
    struct Bodies<V: Space> {
        torque: Vec<[V::Spin; TOTAL_AND_DISSIPATIVE]>,
        inverse_inertia: Vec<V::Principal>,
        momentum: Vec<V::Spin>,
        rotor: Vec<V::Rotor>,
        rotation: Vec<Rotation<V>>,
        middle_spin: Vec<V::Spin>,
    }

    impl<V: Space> Bodies<V> {
        /// So many bodies of different numbers. Two moments of every second body are equal.
        fn new(count: usize) -> Self {
            // Multiples of the golden ratio, modulo 1, less a half.
            let mut seed = 0.0_f64;
            let mut number = || {
                seed = (seed + 0.618_033_988_749_895).fract();
                seed - 0.5
            };
            let spins = |number: &mut dyn FnMut() -> f64| V::Spin::from_components(|_| number());
            let inertia = |body: usize, number: &mut dyn FnMut() -> f64| {
                let [one, other] = [1.0 + number(), 1.0 + number()];
                let difference = if body.is_multiple_of(2) { 0.0 } else { number() };
                V::Principal::from_components(|axis| {
                    if axis == body % 3 {
                        one
                    } else {
                        other + difference * f64::from(u8::from(axis == (body + 1) % 3))
                    }
                })
            };
            Self {
                torque: (0..count).map(|_| [spins(&mut number), spins(&mut number)]).collect(),
                inverse_inertia: (0..count).map(|body| inertia(body, &mut number)).collect(),
                momentum: (0..count).map(|_| spins(&mut number)).collect(),
                rotor: (0..count)
                    .map(|_| V::Rotor::from_uniform([0.5 + number(), 0.5 + number(), 0.5 + number()]))
                    .collect(),
                rotation: (0..count).map(|_| Rotation { spin: V::Spin::ZERO, inverse_inertia: 1.0 }).collect(),
                middle_spin: vec![V::Spin::ZERO; count],
            }
        }

        /// Turns the bodies of a range side by side. Returns the sum of the terms of their second kicks.
        fn turn(&mut self, range: std::ops::Range<usize>, instructions: InstructionSet) -> V::Spin {
            let mut bodies = TurningBodies {
                torque: &self.torque[range.clone()],
                inverse_inertia: &self.inverse_inertia[range.clone()],
                momentum: &mut self.momentum[range.clone()],
                rotor: &mut self.rotor[range.clone()],
                rotation: &mut self.rotation[range.clone()],
                middle_spin: &mut self.middle_spin[range],
            };
            let mut lanes = TurningLanes::default();
            let turn = Turn { dt: 0.2, prediction: Some(0.7) };
            instructions.run(
                #[inline(always)]
                || lanes.turn_all::<true>(turn, &mut bodies),
            )
        }
    }

    fn check<V: Space>() {
        let count = 2 * LANES + 5;
        let mut alone = Bodies::<V>::new(count);
        let mut sum = V::Spin::ZERO;
        for body in 0..count {
            let before = alone.clone();
            sum += alone.turn(body..body + 1, InstructionSet::Baseline);
            // Two half kicks, and a rotation that keeps the angular momentum.
            let gain = before.torque[body][0] * 0.2;
            assert!((alone.momentum[body] - before.momentum[body] - gain).length() < 1e-15);
            let spin = alone.rotor[body].spin(alone.momentum[body], alone.inverse_inertia[body]);
            let ahead = alone.rotor[body].spin(before.torque[body][0] * (0.1 * 0.7), alone.inverse_inertia[body]);
            assert!((alone.rotation[body].spin - spin - ahead).length() < 1e-14);
            let start = before.rotor[body].spin(alone.momentum[body], alone.inverse_inertia[body]);
            assert!((alone.middle_spin[body] - (start + spin) * 0.5).length() < 1e-14);
            assert!(alone.rotor[body] != before.rotor[body]);
        }
        for instructions in InstructionSet::all() {
            let mut together = Bodies::<V>::new(count);
            assert_eq!(together.turn(0..count, instructions), sum);
            assert_eq!(format!("{together:?}"), format!("{alone:?}"), "{}", instructions.name());
        }
    }

    #[test]
    fn bodies_in_lanes_turn_as_each_would_alone() {
        check::<Plane>();
        check::<Solid>();
    }
}
