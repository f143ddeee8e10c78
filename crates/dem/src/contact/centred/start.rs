//! The force of a contact in the first half step of a run, in the scheme [`Centred`](super).
//!
//! The first half kick covers only this half step, so a share of the whole step around the evaluation would be wrong. The
//! spring between the centres acts as at the beginning. The dashpot force, friction and rolling resistance are averaged over the part of
//! the half step in which the contact exists, and multiplied by the share of that part.
//!
//! The average is Gauss's rule with three nodes in s, the overlap being d = a + (b - a) s^4. It is exact for forces that are
//! constant, proportional to d^(1/4), like the dashpot coefficient of Hertz's law, or to d^(1/2) where the contact begins.

use crate::contact::law::PairLaw;
use crate::contact::memory::Memory;
use crate::contact::pair::Pair;
use crate::contact::pair_force::{PairForce, Resistance};
use crate::space::Space;

/// Nodes in s, and weights that include the derivative of s^4.
const NODES: [f64; 3] = [0.112_701_665_379_258_3, 0.5, 0.887_298_334_620_741_7];
const WEIGHTS: [f64; 3] = [5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0];

/// Returns the force on i averaged over the first half step of a run, `half` (s), or `None` if there is no contact in it. A
/// grain that moves by more than `reach` (m), the sum of the radii, does not meet its partner but flies through it.
#[inline(never)]
pub(in crate::contact) fn force_at_start<V: Space>(
    law: &dyn PairLaw<V>,
    pair: &Pair<V>,
    memory: &mut Memory,
    half: f64,
    reach: f64,
) -> Option<PairForce<V>> {
    let range = law.range_of(pair, memory);
    if range > 0.0 {
        // A contact of an earlier run, which may have moved out of range.
        if pair.overlap + range <= 0.0 {
            *memory = Memory::default();
            return Some(PairForce::default());
        }
        return Some(law.force(pair, memory));
    }
    let moved = -half * pair.normal_velocity();
    // The overlap changes from `overlap` to `overlap + moved`.
    let [least, most] = [pair.overlap.min(pair.overlap + moved), pair.overlap.max(pair.overlap + moved)];
    if most <= 0.0 || pair.overlap <= 0.0 && moved > reach {
        return None;
    }
    if law.range(pair) > 0.0 {
        return Some(beyond_touch(law, pair, memory, most / moved.abs()));
    }
    let empty = *memory;
    let mut force = law.force(&pair.at_overlap(pair.overlap), memory);
    if pair.overlap <= 0.0 {
        // A spring starts when the contact begins.
        *memory = Memory::default();
    }
    if moved != 0.0 {
        let least = least.max(0.0);
        let share = (most / moved.abs()).min(1.0);
        let mut dashpot = V::ZERO;
        let mut resistance = Resistance { arms: force.resistance.arms, ..Resistance::default() };
        for (node, weight) in NODES.into_iter().zip(WEIGHTS) {
            // Not `powi`: the compiler may evaluate it for a constant, and then rounds it in another way.
            let square = node * node;
            let at = law.force(&pair.at_overlap(least + (most - least) * (square * square)), &mut { empty });
            let weight = share * weight * 4.0 * (node * square);
            dashpot += at.dashpot * weight;
            resistance.friction += at.resistance.friction * weight;
            resistance.friction_dashpot += at.resistance.friction_dashpot * weight;
            resistance.rolling += at.resistance.rolling * weight;
            resistance.rolling_dashpot += at.resistance.rolling_dashpot * weight;
            resistance.is_sliding |= at.resistance.is_sliding;
        }
        let mut normal = force.elastic() + dashpot;
        // A pull jumps to its value at touch, so that it acts in the share of the half step in contact.
        let missing = (1.0 - share) * law.pull(&pair.at_overlap(pair.overlap));
        if missing > 0.0 {
            normal += pair.normal * missing;
        }
        force = PairForce { normal, dashpot, resistance, ..force };
    }
    Some(force)
}

/// Returns the force of a contact that may exist beyond touch. It acts as it is if the bodies overlap. Otherwise it begins within
/// the half step, and the force at touch acts in the share `lasts`.
fn beyond_touch<V: Space>(law: &dyn PairLaw<V>, pair: &Pair<V>, memory: &mut Memory, lasts: f64) -> PairForce<V> {
    if pair.overlap > 0.0 {
        return law.force(pair, memory);
    }
    let touching = Pair { overlap: f64::MIN_POSITIVE, ..*pair };
    let PairForce { normal, dashpot, resistance, .. } = law.force(&touching, &mut Memory::default());
    let share = lasts.min(1.0);
    let resistance = Resistance {
        friction: resistance.friction * share,
        friction_dashpot: resistance.friction_dashpot * share,
        rolling: resistance.rolling * share,
        rolling_dashpot: resistance.rolling_dashpot * share,
        lost_by_sliding: 0.0,
        lost_by_rolling: 0.0,
        ..resistance
    };
    PairForce { normal: normal * share, dashpot: dashpot * share, resistance, load: None }
}
