//! Centred contacts: damping and friction of second order in the step, with one evaluation of the forces.
//!
//! Velocity Verlet evaluates forces at x(t+dt) with the velocities v_h of t+dt/2. With drag that is of first order, for
//! two reasons: the drag sees a velocity half a step old; and it jumps when a contact opens or closes inside a step.
//! Both are mended here, with h = dt/2, closing speed u (along the normal, positive when approaching), overlap delta:
//!
//! * **Share.** The evaluation at t+dt stands for the step centred on it. In that step the overlap goes from
//!   delta - w to delta + w, w = h |u_h|; the drag acts in the share theta = clamp((delta + w)/(2 w), 0, 1) of it in which
//!   there is a contact, and so also across a gap of up to w. (For a coefficient that varies with the overlap: its mean.)
//! * **Centred velocity.** The drag sees u at t+dt, solved for in the pair's own drag, with all other forces as they
//!   were a step ago: u = (u_h + h A_t + h D_t/m + h (F_t - F_s)/m')/(1 + h theta c/m). A_t is the closing acceleration of
//!   the step before, of all forces; F_t and D_t, the pair's own spring and drag in it, are not kept but made again
//!   from delta_t = delta - dt u_h and u_t = u_h - h A_t. The change of the spring's force counts for those grains only that
//!   touch nothing else, 1/m' = 1/m or less: in a crowd, what a neighbour adds on one side others take away on the
//!   other, and a light grain between heavy ones would be told too much.
//! * **Spring** as ever, k max(delta, 0): without drag and friction the scheme is velocity Verlet to the last bit, and
//!   symplectic.
//! * **Friction** ([`Slider::pull_centred`](super::spring::Slider::pull_centred)). The tangential spring gathers v_h from
//!   the moment of contact on, not for the whole first step; what a dashpot beyond the cap makes of the spring in that
//!   moment is made of it then, and again where the normal force changes its sign, and the cap is zero. The dashpot sees
//!   the velocity of t+dt, solved for as along the normal, with 1/m_t = 1/m + l_i^2/I_i + l_j^2/I_j. The force is cut at the
//!   cap of the contact as it stands, weighed with theta, and cut at the cap of the averaged normal force.
//!
//! One lone linear contact is stable for w0 dt < min(2, 1/zeta), in the normal and in the tangential direction: the motion has
//! det = (1 - h c/m)/(1 + h c/m) and trace = (2 - (w0 dt)^2)/(1 + h c/m), and what F_t is wrong by shrinks by -h c/m a step.
//! Plain Verlet with lagged drag stays below that at every zeta. With more contacts it is the other way round: n that meet in a
//! motion are stable for n ((w0 dt)^2 + 8 zeta w0 dt/(1 + zeta w0 dt)) < 4, each alone having w0 and zeta, and with
//! plain Verlet for n ((w0 dt)^2 + 4 zeta w0 dt) < 4 ([`crate::scene::check::step`]). Against simulation:
//! `tests/physics/schemes.rs`.
//!
//! Limits: what is fixed gains nothing, so that contacts with a wall that a behaviour accelerates are of first order
//! (the drag misses what the wall gains in half a step); where the force of one contact, as it sets in, makes another
//! one stick whose dashpot slips, that one learns of it a step later, of first order too; bookkeeping of energy is of
//! second order; theta uses u_h, so that grazing contacts, where the normal turns within a step, are of second order
//! with a larger constant. Sources: the averaged drag is exact for a linear dashpot; the implicit drag is the
//! trapezoidal rule; their union with forces of other contacts lagged is ours.

use crate::contact::{Bounce, LawRequirements, Memory, Pair, PairForce, PairLaw};
use crate::space::{Linear, Plane, Space};

/// What a pair's velocities gain until the end of the step, if forces stay what they were at its beginning; from the
/// side of i.
#[derive(Clone, Copy, Debug, Default)]
pub struct VelocityPrediction<V: Space = Plane> {
    /// dt/2 (a_i - a_j), m/s.
    pub velocity: V,
    /// dt/2 times the angular accelerations of i and j, rad/s.
    pub spins: [V::Spin; 2],
    /// 1/m of i and j, 1/kg: 0 for what is fixed.
    pub inverse_masses: [f64; 2],
    /// 1/I of i and j, 1/(kg m^2): 0 for what is fixed.
    pub inverse_inertias: [f64; 2],
    /// 1 for those of i and j that had no other contact at the beginning of the step, else 0.
    pub only_contact: [f64; 2],
}

impl<V: Space> VelocityPrediction<V> {
    /// How fast a force along the normal changes the closing speed, counting only grains without another contact, 1/kg.
    #[inline(always)]
    pub(super) fn lone_mobility(&self) -> f64 {
        self.only_contact[0] * self.inverse_masses[0] + self.only_contact[1] * self.inverse_masses[1]
    }
}

impl<V: Space> Pair<V> {
    /// The pair with the velocities predicted for the end of the step.
    #[inline(always)]
    #[must_use]
    pub fn predicted(&self) -> Self {
        let mut pair = *self;
        pair.relative_velocity += self.ahead.velocity;
        pair.spins[0] += self.ahead.spins[0];
        pair.spins[1] += self.ahead.spins[1];
        pair
    }

    /// The pair at another overlap, m; none if that is negative.
    #[inline(always)]
    #[must_use]
    pub fn at_overlap(&self, overlap: f64) -> Self {
        Self { overlap: overlap.max(0.0), ..*self }
    }
}

/// The step centred on an evaluation, along the normal.
#[derive(Clone, Copy, Debug)]
pub struct Window {
    /// u_h, m/s.
    pub closing: f64,
    /// w, m.
    pub half_width: f64,
    /// dt u_h, m: by how much the overlap was less at the evaluation before.
    pub moved: f64,
}

impl Window {
    /// That of a pair.
    #[inline(always)]
    #[must_use]
    pub fn of<V: Space>(pair: &Pair<V>) -> Self {
        let closing = -pair.normal_velocity();
        let moved = pair.dt * closing;
        Self { closing, half_width: 0.5 * moved.abs(), moved }
    }

    /// Whether the contact exists in any part of the step.
    #[inline(always)]
    #[must_use]
    pub fn touches(&self, overlap: f64) -> bool {
        overlap + self.half_width > 0.0
    }

    /// theta, for an evaluation at this overlap, m.
    #[inline(always)]
    #[must_use]
    pub fn share(&self, overlap: f64) -> f64 {
        let w = self.half_width;
        if overlap >= w { 1.0 } else { (0.5 * (overlap + w) / w).clamp(0.0, 1.0) }
    }
}

/// A law that can be centred.
pub trait CentredLaw<V: Space = Plane>: PairLaw<V> {
    /// The force on i, averaged over the step centred on the evaluation; `pair.overlap` may be a gap, negative, of up to
    /// w. Advances the memory by `pair.dt`.
    fn centred(&self, pair: &Pair<V>, memory: &mut Memory<V>) -> PairForce<V>;
}

/// A law, centred.
#[derive(Clone, Copy, Debug)]
pub struct Centred<L>(pub L);

impl<L: LawRequirements> LawRequirements for Centred<L> {
    const SPIN: bool = L::SPIN;
    const SPECIES: bool = L::SPECIES;
    const RADII: bool = L::RADII;
    const SPRING: bool = L::SPRING;
    const ROLLING: bool = L::ROLLING;
    const STIFFNESS: bool = L::STIFFNESS;
    const PREDICTION: bool = true;
}

impl<V: Space, L: CentredLaw<V>> PairLaw<V> for Centred<L> {
    #[inline(always)]
    fn force(&self, pair: &Pair<V>, memory: &mut Memory<V>) -> PairForce<V> {
        self.0.centred(pair, memory)
    }

    fn elastic_energy(&self, pair: &Pair<V>, memory: &Memory<V>) -> f64 {
        self.0.elastic_energy(pair, memory)
    }

    fn on_contact_end(&self, pair: &Pair<V>, memory: &Memory<V>) -> [f64; 2] {
        self.0.on_contact_end(pair, memory)
    }

    fn needs_mass_root(&self) -> bool {
        self.0.needs_mass_root()
    }

    fn friction(&self, pair: &Pair<V>) -> f64 {
        self.0.friction(pair)
    }

    fn stiffness(&self, bounce: &Bounce) -> f64 {
        self.0.stiffness(bounce)
    }

    fn damping(&self, bounce: &Bounce) -> f64 {
        self.0.damping(bounce)
    }

    fn deepest(&self, bounce: &Bounce) -> f64 {
        self.0.deepest(bounce)
    }

    fn contact_duration(&self, bounce: &Bounce) -> f64 {
        self.0.contact_duration(bounce)
    }

    fn restitution(&self, bounce: &Bounce) -> f64 {
        self.0.restitution(bounce)
    }

    fn modes(&self, bounce: &Bounce) -> [[f64; 2]; 3] {
        self.0.modes(bounce)
    }
}

/// Whether `a` is longer than `cap`, and what shortens it to that.
#[inline(always)]
pub(super) fn cut<V: Linear>(a: V, cap: f64) -> (bool, V) {
    let squared = a.length_squared();
    if squared > cap * cap { (true, a * (cap / squared.sqrt())) } else { (false, a) }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "exact values")]
mod tests {
    use super::*;
    use crate::contact::tests::pair;
    use crate::space::Vector;

    fn window(speed: f64) -> Window {
        Window::of(&Pair { relative_velocity: Vector::new(-speed, 3.0), dt: 1e-3, ..pair() })
    }

    #[test]
    fn the_share_is_that_of_the_step_in_contact() {
        // Approaching or parting at 2 m/s: 2 mm a step, 1 mm to each side of the evaluation.
        for speed in [2.0, -2.0] {
            let w = window(speed);
            let shares = [-1.5e-3, -1e-3, -0.5e-3, 0.0, 0.5e-3, 1e-3, 1.5e-3].map(|overlap| w.share(overlap));
            assert_eq!(shares, [0.0, 0.0, 0.25, 0.5, 0.75, 1.0, 1.0]);
            assert!(!w.touches(-1e-3) && w.touches(-0.9e-3));
        }
        // At rest there is no window: in contact or not.
        let still = window(0.0);
        assert_eq!([still.share(1e-9), still.share(0.0)], [1.0, 1.0]);
        assert!(!still.touches(0.0) && still.touches(1e-300));
    }
}
