//! The output of a batch of contacts: forces and torques to be summed, and numbers for the energy balance.

use crate::contact::force_accumulation::{dashpot, total};
use crate::contact::history::losses::ContactLosses;
use crate::contact::law::LawRequirements;
use crate::contact::pair::Pair;
use crate::contact::pair_force::PairForce;
use crate::lanes::{Lanes, Scalars};
use crate::space::{Linear, Space};
use crate::store::TOTAL_AND_DISSIPATIVE;

/// Forces, torques and losses of contacts, side by side.
#[derive(Clone, Debug, Default)]
pub struct ContactOutput<V: Space> {
    /// Bits of the lanes whose particles turned out not to touch.
    gaps: u64,
    /// Force on i, N: the total, and its dissipative part.
    forces: [Lanes<V>; TOTAL_AND_DISSIPATIVE],
    /// n x F_t, N: of the total tangential force, and of its dissipative part. Multiplied by the arms they give
    /// torques.
    moments: [Lanes<V::Spin>; TOTAL_AND_DISSIPATIVE],
    arms: [Scalars; 2],
    /// Torque of rolling resistance on i, N m.
    rolling: Lanes<V::Spin>,
    /// Torque on i of the dashpots of rolling resistance, N m.
    pub rolling_dashpot_torque: Lanes<V::Spin>,
    /// Energy lost to sliding, to rolling beyond the cap, and to tangential dashpots, J.
    lost: [Scalars; 3],
}

impl<V: Space> ContactOutput<V> {
    /// Returns whether the particles in a lane touch. With centred contacts a batch also holds pairs that may touch within
    /// half a step; a pair that does not touch exerts no force.
    #[inline(always)]
    pub fn is_contact(&self, lane: usize) -> bool {
        self.gaps >> lane & 1 == 0
    }

    /// Returns the bits of the lanes whose particles touch. The bits of lanes beyond the last contact are set too.
    #[inline(always)]
    pub fn contacts(&self) -> u64 {
        !self.gaps
    }

    /// Returns the lanes whose particles do not touch.
    #[inline(always)]
    pub fn gaps(&self) -> impl Iterator<Item = usize> {
        let mut left = self.gaps;
        std::iter::from_fn(move || {
            let lane = (left != 0).then(|| left.trailing_zeros() as usize)?;
            left &= left - 1;
            Some(lane)
        })
    }

    /// Sets the bits of the lanes whose particles do not touch.
    #[inline(always)]
    pub(super) fn set_gaps(&mut self, gaps: u64) {
        self.gaps = gaps;
    }

    /// Makes a lane a gap without force, torque and losses.
    pub(super) fn clear_lane<L: LawRequirements>(&mut self, lane: usize) {
        self.gaps |= 1 << lane;
        self.forces.iter_mut().for_each(|forces| forces.set(lane, V::ZERO));
        if L::SPIN {
            self.moments.iter_mut().for_each(|moments| moments.set(lane, V::Spin::ZERO));
            self.lost.iter_mut().for_each(|lost| lost[lane] = 0.0);
        }
        if L::ROLLING {
            self.rolling.set(lane, V::Spin::ZERO);
            self.rolling_dashpot_torque.set(lane, V::Spin::ZERO);
        }
    }

    /// Marks a lane as a contact.
    pub(super) fn contact(&mut self, lane: usize) {
        self.gaps &= !(1 << lane);
    }

    /// Marks all lanes as contacts.
    #[inline(always)]
    pub fn clear_gaps(&mut self) {
        self.gaps = 0;
    }

    /// Returns the force on i, N, as an entry of an [`Accumulator`](crate::store::Accumulator).
    #[inline(always)]
    pub fn force<const NUMBERS: usize>(&self, lane: usize) -> [V; NUMBERS] {
        std::array::from_fn(
            #[inline(always)]
            |part| self.forces[part].get(lane),
        )
    }

    /// Returns the torque that i gains and the torque that j loses, N m, as entries of an accumulator.
    #[inline(always)]
    pub fn torques<L: LawRequirements, const NUMBERS: usize>(&self, lane: usize) -> [[V::Spin; NUMBERS]; 2] {
        let mut torques = [[V::Spin::ZERO; NUMBERS]; 2];
        for (part, moments) in self.moments.iter().enumerate().take(NUMBERS) {
            let moment = moments.get(lane);
            torques[0][part] = moment * -self.arms[0][lane];
            torques[1][part] = moment * self.arms[1][lane];
        }
        if L::ROLLING {
            let rolling = self.rolling.get(lane);
            torques[0][0] += rolling;
            torques[1][0] += rolling;
        }
        torques
    }

    /// Stores the total force and torque.
    #[inline(always)]
    pub(super) fn store_force<L: LawRequirements>(&mut self, lane: usize, pair: &Pair<V>, force: &PairForce<V>) {
        self.forces[0].set(lane, total::<L, V>(force));
        if L::SPIN {
            let resistance = &force.resistance;
            self.moments[0].set(lane, pair.normal.cross(resistance.friction));
            (self.arms[0][lane], self.arms[1][lane]) = resistance.arms.into();
            if L::ROLLING {
                self.rolling.set(lane, resistance.rolling);
            }
        }
    }

    /// Stores the numbers that only the energy balance needs. The velocities of `pair` are those of the dashpots.
    #[inline(always)]
    pub(super) fn store_energy_numbers<L: LawRequirements>(
        &mut self,
        lane: usize,
        pair: &Pair<V>,
        force: &PairForce<V>,
    ) {
        self.forces[1].set(lane, dashpot::<L, V>(force));
        if L::SPIN {
            let resistance = &force.resistance;
            self.moments[1].set(lane, pair.normal.cross(resistance.friction_dashpot));
            self.lost[0][lane] = resistance.lost_by_sliding;
            self.lost[2][lane] = pair.dashpot_loss(resistance);
            if L::ROLLING {
                self.rolling_dashpot_torque.set(lane, resistance.rolling_dashpot);
                self.lost[1][lane] = resistance.lost_by_rolling;
            }
        }
    }

    /// Returns the energy lost in the first `lanes` lanes, J. Four partial sums per kind shorten the chain of dependent
    /// additions.
    #[inline(always)]
    pub(super) fn lost<L: LawRequirements>(&mut self, lanes: usize) -> ContactLosses {
        self.lost.iter_mut().for_each(|numbers| numbers[lanes..].fill(0.0));
        let sum = |kind: usize| {
            let mut sums = [0.0; 4];
            for four in self.lost[kind][..lanes.next_multiple_of(4)].as_chunks::<4>().0 {
                sums.iter_mut().zip(four).for_each(|(sum, number)| *sum += number);
            }
            sums.into_iter().sum()
        };
        ContactLosses {
            sliding: sum(0),
            rolling: if L::ROLLING { sum(1) } else { 0.0 },
            dashpots: sum(2),
            breaking: 0.0,
        }
    }
}
