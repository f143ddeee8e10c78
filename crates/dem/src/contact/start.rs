//! The force of a contact in the first half step of a run, for [`centred`](super::centred) contacts.
//!
//! The first half kick covers only this half step, so a share of the whole step around the evaluation would be wrong. The
//! spring between the centres acts as at the beginning. Drag, friction and rolling resistance are averaged over the part of
//! the half step in which the contact exists, and multiplied by the share of that part.
//!
//! The average is Gauss's rule with three nodes in s, the overlap being d = a + (b - a) s^4. It is exact for forces that are
//! constant, proportional to d^(1/4), like the drag of Hertz's law, or to d^(1/2) where the contact begins.

use crate::contact::{Memory, Pair, PairForce, PairLaw, Turning};
use crate::space::Space;

/// Nodes in s, and weights that include the derivative of s^4.
const NODES: [f64; 3] = [0.112_701_665_379_258_3, 0.5, 0.887_298_334_620_741_7];
const WEIGHTS: [f64; 3] = [5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0];

/// Returns the force on i averaged over the first half step of a run, `half` (s), or `None` if there is no contact in it. A
/// grain that moves by more than `reach` (m), the sum of the radii, does not meet its partner but flies through it.
#[inline(never)]
pub(super) fn force_at_start<V: Space>(
    law: &dyn PairLaw<V>,
    pair: &Pair<V>,
    memory: &mut Memory<V>,
    half: f64,
    reach: f64,
) -> Option<PairForce<V>> {
    if law.range(pair, memory) > 0.0 {
        // A contact of an earlier run.
        return Some(law.force(pair, memory));
    }
    let moved = -half * pair.normal_velocity();
    // The overlap changes from `overlap` to `overlap + moved`.
    let [least, most] = [pair.overlap.min(pair.overlap + moved), pair.overlap.max(pair.overlap + moved)];
    if most <= 0.0 || pair.overlap <= 0.0 && moved > reach {
        return None;
    }
    if law.range_at(pair.reduced_radius()) > 0.0 {
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
        let mut drag = V::ZERO;
        let mut turning = Turning { arms: force.turning.arms, ..Turning::default() };
        for (node, weight) in NODES.into_iter().zip(WEIGHTS) {
            // Not `powi`: the compiler may evaluate it for a constant, and then rounds it in another way.
            let square = node * node;
            let at = law.force(&pair.at_overlap(least + (most - least) * (square * square)), &mut { empty });
            let weight = share * weight * 4.0 * (node * square);
            drag += at.drag * weight;
            turning.friction += at.turning.friction * weight;
            turning.friction_drag += at.turning.friction_drag * weight;
            turning.rolling += at.turning.rolling * weight;
            turning.rolling_drag += at.turning.rolling_drag * weight;
            turning.is_sliding |= at.turning.is_sliding;
        }
        let mut smooth = force.elastic() + drag;
        // A pull jumps to its value at touch, so that it acts in the share of the half step in contact.
        let missing = (1.0 - share) * law.pull(&pair.at_overlap(pair.overlap));
        if missing > 0.0 {
            smooth += pair.normal * missing;
        }
        force = PairForce { smooth, drag, turning, ..force };
    }
    Some(force)
}

/// Returns the force of a contact that may exist beyond touch. It acts as it is if the bodies overlap. Otherwise it begins within
/// the half step, and the force at touch acts in the share `lasts`.
fn beyond_touch<V: Space>(law: &dyn PairLaw<V>, pair: &Pair<V>, memory: &mut Memory<V>, lasts: f64) -> PairForce<V> {
    if pair.overlap > 0.0 {
        return law.force(pair, memory);
    }
    let touching = Pair { overlap: f64::MIN_POSITIVE, ..*pair };
    let PairForce { smooth, drag, turning, .. } = law.force(&touching, &mut Memory::default());
    let share = lasts.min(1.0);
    let turning = Turning {
        friction: turning.friction * share,
        friction_drag: turning.friction_drag * share,
        rolling: turning.rolling * share,
        rolling_drag: turning.rolling_drag * share,
        lost_by_sliding: 0.0,
        lost_by_rolling: 0.0,
        ..turning
    };
    PairForce { smooth: smooth * share, drag: drag * share, turning, load: None }
}
