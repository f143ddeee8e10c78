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
