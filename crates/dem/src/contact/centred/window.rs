//! The averaged forces of contacts near an event, in the scheme [`Centred`](super).
//!
//! Velocity Verlet evaluates forces at x(t+dt) with the velocities v_h of t+dt/2. With dashpots this is only of first
//! order, for two reasons: the dashpot force uses a velocity half a step old, and it jumps when a contact opens or closes inside
//! a step. Predicted velocities correct the first for all contacts ([`crate::contact::centred::velocity_prediction`]). The forces of this
//! module correct the second. They are for contacts near an event:
//!
//! * the overlap is less than [`overlap_without_events`](crate::contact::law::PairLaw::overlap_without_events) half-widths w of the step,
//!   so that the contact may open or close;
//! * with friction, the normal force may change its sign within the step, so that the cap is zero there;
//! * a grain of the contact is lone: since it was last without any contact, no count of its contacts (one in eight steps) has found a
//!   second one. All forces that change the velocity of a lone grain are known, so that averaging makes the error three to ten times
//!   smaller.
//!
//! In a dense bed these are a few contacts in a hundred. Below, h = dt/2, u is the closing speed (along the normal,
//! positive when approaching) and delta the overlap:
//!
//! * **Share.** The evaluation at t+dt represents the step centred on it. In that step the overlap changes from
//!   delta - w to delta + w, w = h |u_h|. The contact exists in the share theta = clamp((delta + w)/(2 w), 0, 1) of
//!   that step, and the dashpot force is multiplied by theta. So it also acts across a gap of up to w. A coefficient that varies
//!   with the overlap is replaced by its mean. Gaps of more than 1.25 h times the predicted speed get no force.
//! * **Centred velocity.** The dashpot force uses u at t+dt, solved for implicitly in the pair's own dashpot force. All other forces are
//!   lagged by a step: u = (u_h + h A_t + h D_t/m + h (F_t - F_s)/m')/(1 + h theta c/m). A_t is the closing
//!   acceleration of the previous step, of all forces. F_t and D_t are the pair's own spring force and dashpot force in that
//!   step. They are not stored but computed again from delta_t = delta - dt u_h and u_t = u_h - h A_t. F_s is the
//!   spring force now. The change of the spring force counts only for lone grains: 1/m' is the
//!   sum of 1/m_i over these grains. In a dense packing, other neighbours cancel the force of one neighbour, and a
//!   light grain between heavy ones would get too large a correction.
//! * **Spring.** The spring force k max(delta, 0) is unchanged. Without dashpots and friction the scheme is velocity Verlet
//!   to the last bit, and symplectic.
//! * **Friction** ([`Slider::pull_centred`](crate::contact::spring::Slider::pull_centred)). The tangential spring accumulates
//!   v_h from the moment of contact on, not during the whole first step. If the dashpot force exceeds the cap at that moment,
//!   the spring is set there as in any slip. The same is done where the normal force changes sign, with a cap of zero.
//!   The dashpot uses the velocity at t+dt, solved for as along the normal, with 1/m_t = 1/m + l_i^2/I_i + l_j^2/I_j. For bodies of several spheres 1/m_t
//!   is that of the contact point, and the velocities at the event and at t+dt know that the normal force turns the body.
//!   Spring and dashpot are averaged over the step, and the force is capped with the averaged normal force. A contact that
//!   still sticks when its normal force reaches zero acts only in the share of the step before that moment. The spring is
//!   stored half a step ahead, with the velocity of the end that this force gives.
//!
//! In step zero the average is over the first half step alone, which is all that the first half kick covers (`centred::start`).
//!
//! Stability of a single linear contact, in the normal and in the tangential direction: w0 dt < min(2, 1/zeta). The
//! motion has det = (1 - h c/m)/(1 + h c/m) and trace = (2 - (w0 dt)^2)/(1 + h c/m), and an error of F_t is multiplied
//! by -h c/m in each step. Velocity Verlet with a lagged dashpot velocity has a lower limit at every zeta. With several contacts the
//! order is reversed (module `scene::check::crowd` of `siloflow`). `tests/physics/schemes.rs` compares these limits with simulations.
//!
//! Limits:
//!
//! * Contacts with a wall that a behaviour accelerates are of first order: fixed particles have no velocity prediction,
//!   so the dashpot misses the velocity that the wall gains in half a step.
//! * The force of a new contact may make another contact of the same grain stick while the dashpot of that other contact slips. The law
//!   of the other contact does not know at which moment of the step the new contact opened, and sets its spring at the evaluation, up to
//!   half a step later. A spring grows at another rate in slip than in stick, so that its error is of first order.
//! * A contact that is not near an event, such as those of a body that touches with several spheres, is cut along its new force. In solid space that is of first order in the turn of the force of a slider that slips.
//! * With strong damping (e = 0.2) the normal force of Hertz's law has order 1.5 from t_c/20 to t_c/80, and 1.9 from t_c/320
//!   on, with and without friction.
//! * The energy balance is of second order.
//! * theta uses u_h. So grazing contacts, with a normal that turns within a step, are of second order with a larger
//!   constant.
//!
//! Sources: the averaged dashpot force is exact for a linear dashpot. The implicit dashpot force is the trapezoidal rule. Their
//! combination with lagged forces of other contacts was developed for this project.

use crate::contact::pair::Pair;
use crate::space::{Linear, Space};

/// The step centred on an evaluation, along the normal.
#[derive(Clone, Copy, Debug)]
pub struct Window {
    /// Closing speed u_h, m/s.
    pub closing: f64,
    /// w, m: change of the overlap in half a step.
    pub half_width: f64,
    /// dt u_h, m: increase of the overlap since the previous evaluation.
    pub moved: f64,
}

impl Window {
    /// Returns the window of a pair.
    #[inline(always)]
    #[must_use]
    pub fn of<V: Space>(pair: &Pair<V>) -> Self {
        let closing = -pair.normal_velocity();
        let moved = pair.dt * closing;
        Self { closing, half_width: 0.5 * moved.abs(), moved }
    }

    /// Returns whether the contact exists in any part of the step.
    #[inline(always)]
    #[must_use]
    pub fn touches(&self, overlap: f64) -> bool {
        overlap + self.half_width > 0.0
    }

    /// Returns theta for an evaluation at `overlap`, m.
    #[inline(always)]
    #[must_use]
    pub fn share(&self, overlap: f64) -> f64 {
        let w = self.half_width;
        if overlap >= w { 1.0 } else { (0.5 * (overlap + w) / w).clamp(0.0, 1.0) }
    }
}

/// Returns whether `a` is longer than `cap`, and `a` shortened to at most `cap`.
#[inline(always)]
pub(in crate::contact) fn cut<V: Linear>(a: V, cap: f64) -> (bool, V) {
    let squared = a.length_squared();
    if squared > cap * cap { (true, a * (cap / squared.sqrt())) } else { (false, a) }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "exact values")]
mod tests {
    use super::*;
    use crate::contact::pair::tests::pair;
    use crate::space::Vector;

    fn window(speed: f64) -> Window {
        Window::of(&Pair { relative_velocity: Vector::new(-speed, 3.0), dt: 1e-3, ..pair() })
    }

    #[test]
    fn share_is_the_fraction_of_the_step_in_contact() {
        // Approaching or separating at 2 m/s: 2 mm per step, 1 mm to each side of the evaluation.
        for speed in [2.0, -2.0] {
            let w = window(speed);
            let shares = [-1.5e-3, -1e-3, -0.5e-3, 0.0, 0.5e-3, 1e-3, 1.5e-3].map(|overlap| w.share(overlap));
            assert_eq!(shares, [0.0, 0.0, 0.25, 0.5, 0.75, 1.0, 1.0]);
            assert!(!w.touches(-1e-3) && w.touches(-0.9e-3));
        }
        // At rest the window has zero width.
        let still = window(0.0);
        assert_eq!([still.share(1e-9), still.share(0.0)], [1.0, 1.0]);
        assert!(!still.touches(0.0) && still.touches(1e-300));
    }
}
