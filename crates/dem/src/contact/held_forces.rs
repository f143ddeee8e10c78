//! Forces that are added later: those of the pairs of one task on particles of earlier tasks, which these tasks add, and those of walls on
//! particles that still wait for forces of later tasks.

use crate::contact::batch::Batch;
use crate::contact::law::LawRequirements;
use crate::lanes::LANES;
use crate::neighbours::list::Candidate;
use crate::space::Space;
use crate::store::TOTAL_AND_DISSIPATIVE;

/// Forces on the first particles of contacts, the one in the lower slot or at a wall, in ascending order of contacts. Columns that the law does
/// not need stay empty.
#[derive(Debug, Default)]
pub struct HeldForces<V: Space> {
    pub(super) pairs: Vec<Candidate>,
    /// N: the numbers of an [`Accumulator`](crate::store::Accumulator) for each pair.
    pub(super) force: Vec<V>,
    /// N m: the numbers of an accumulator for each pair.
    pub(super) torque: Vec<V::Spin>,
    /// N m.
    pub(super) rolling_drag: Vec<V::Spin>,
    /// Whether the particles touch, in passes that count contacts.
    pub(super) touches: Vec<bool>,
}

impl<V: Space> HeldForces<V> {
    /// Removes all forces, and keeps the memory.
    pub(super) fn clear(&mut self) {
        let Self { pairs, force, torque, rolling_drag, touches } = self;
        pairs.clear();
        force.clear();
        torque.clear();
        rolling_drag.clear();
        touches.clear();
    }

    /// Appends the forces of the contacts of a batch for which `is_wanted` returns true. `counts` tells whether this pass counts contacts.
    pub(super) fn extend<C: LawRequirements, const NUMBERS: usize>(
        &mut self,
        batch: &Batch<V>,
        counts: bool,
        is_wanted: impl Fn(Candidate) -> bool,
    ) {
        let output = &batch.output;
        for lane in (0..batch.len.min(LANES)).filter(|&lane| is_wanted(batch.pairs[lane])) {
            self.pairs.push(batch.pairs[lane]);
            self.force.extend(output.force::<NUMBERS>(lane));
            if C::SPIN {
                self.torque.extend(output.torques::<C, NUMBERS>(lane)[0]);
            }
            if C::ROLLING && NUMBERS == TOTAL_AND_DISSIPATIVE {
                self.rolling_drag.push(output.rolling_dashpot_torque.get(lane));
            }
            if counts {
                self.touches.push(output.is_contact(lane));
            }
        }
    }
}
