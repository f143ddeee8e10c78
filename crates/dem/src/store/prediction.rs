//! The prediction of velocities, for the [centred](crate::contact::centred) scheme.
//!
//! Between the drift and the kick, [`Body::velocity`](super::Body) and [`Rotation::spin`](super::Rotation) are predicted for
//! the end of the step. The kick needs the velocities in the middle of the step, so they are kept too. In the plane they
//! fill up the cache line of the body; in solid space, whose bodies fill one without them, they are stored apart.

use crate::space::{Plane, Rotor, Space};
use crate::store::ParticleStore;
use crate::store::longest_move::LongestMove;

/// The state of the prediction. It is empty for other schemes.
#[derive(Clone, Debug)]
pub struct Prediction<V: Space = Plane> {
    /// Time by which predicted velocities are ahead of the middle of the step, s: half a step, or 0 for other schemes.
    pub velocities_ahead: f64,
    /// Share of the gain in half a step that predicted velocities contain.
    pub share: f64,
    /// Like `share`, of spins.
    pub spin_share: f64,
    /// Whether springs advance with the velocities in the middle of the step, in place of predicted ones
    /// ([`velocity_prediction`](crate::contact::centred::velocity_prediction)).
    pub springs_exact: bool,
    /// The largest gap that two particles can close in the time `velocities_ahead`, m.
    pub margin: f64,
    /// Radii of the particles, each with the distance that the particle moves in the time `velocities_ahead` and half of `range`, m.
    pub swept: Vec<f64>,
    /// Whether `swept` is kept: a contact law has memory.
    pub sweeps: bool,
    /// The largest range of a contact beyond touch, m. It belongs to the contact law and does not change.
    pub range: f64,
    /// 1 for particles that have had at most one contact since a count found them without any, else 0.
    pub lone: Vec<u8>,
    /// Particles whose `lone` the last count changed, ascending.
    pub(crate) lone_changed: Vec<usize>,
    /// Number of counts that have changed `lone`.
    pub(crate) lone_changes: u64,
    /// Whether velocities are predicted ones.
    pub(crate) is_ahead: bool,
    /// Velocities in the middle of the step, m/s, if the bodies do not hold them.
    pub(crate) middle: Vec<V::MiddleBesideBody>,
    /// Spins in the middle of the step, rad/s.
    pub(crate) middle_spin: Vec<V::Spin>,
}

impl<V: Space> Default for Prediction<V> {
    fn default() -> Self {
        Self {
            velocities_ahead: 0.0,
            share: 0.0,
            spin_share: 0.0,
            springs_exact: false,
            margin: 0.0,
            swept: Vec::new(),
            sweeps: false,
            range: 0.0,
            lone: Vec::new(),
            lone_changed: Vec::new(),
            lone_changes: 0,
            is_ahead: false,
            middle: Vec::new(),
            middle_spin: Vec::new(),
        }
    }
}

/// A factor on distances moved that allows for rounding.
const ROUNDING: f64 = 1.0 + 1e-6;

/// Returns an entry of [`Prediction::swept`], m, from a radius, the distance moved in a whole step and the range of contacts, m.
#[inline(always)]
pub(crate) fn swept_radius(radius: f64, moved: f64, range: f64) -> f64 {
    radius + (0.5 * ROUNDING * moved + 0.5 * range)
}

impl<V: Space> ParticleStore<V> {
    /// Whether velocities are predicted between the drift and the kick.
    #[inline]
    #[must_use]
    pub fn predicts(&self) -> bool {
        self.prediction.velocities_ahead > 0.0
    }

    /// Time by which the springs of contact memories are ahead of the evaluation, s: 0, or the time by which velocities are ahead.
    #[inline]
    #[must_use]
    pub fn springs_ahead(&self) -> f64 {
        if self.prediction.springs_exact { 0.0 } else { self.prediction.velocities_ahead }
    }

    /// Whether the velocity of particle `i` is a predicted one now. Fixed particles gain no velocity.
    #[inline]
    pub(super) fn is_ahead(&self, i: usize) -> bool {
        self.prediction.is_ahead && !self.is_fixed(i)
    }

    /// Velocity of particle `i` in the middle of the step, m/s, between the drift and the kick.
    #[inline]
    #[must_use]
    pub fn middle_velocity(&self, i: usize) -> V {
        if self.is_ahead(i) {
            V::middle(&self.body[i].middle, &self.prediction.middle[i])
        } else {
            self.body[i].velocity
        }
    }

    /// Spin of particle `i` in the middle of the step, rad/s, between the drift and the kick; zero if particles do not spin.
    #[inline]
    #[must_use]
    pub fn middle_spin(&self, i: usize) -> V::Spin {
        if self.is_ahead(i) { self.prediction.middle_spin.get(i).copied().unwrap_or_default() } else { self.spin(i) }
    }

    /// Sets the velocity of particle `i`, m/s, and shifts that in the middle of the step by the same difference. If
    /// `is_pending`, the velocity in the middle of the step becomes the same.
    pub(super) fn set_velocity(&mut self, i: usize, velocity: V, is_pending: bool) {
        if self.is_ahead(i) {
            let shifted = self.middle_velocity(i) + (velocity - self.body[i].velocity);
            let middle = if is_pending { velocity } else { shifted };
            V::set_middle(middle, &mut self.body[i].middle, &mut self.prediction.middle[i]);
        }
        self.body[i].velocity = velocity;
        // Without prediction this time is zero, and so are the margins.
        self.widen_margins(i, 2.0 * self.prediction.velocities_ahead * self.middle_velocity(i).length());
        self.move_spheres_of(i);
    }

    /// Sets the margins from the velocities of particles from slot `first` on, for a step of `dt`, s. `longest` is the longest
    /// move of the other particles in a step, m; the drift sets their swept radii.
    pub(crate) fn set_margins(&mut self, first: usize, longest: f64, dt: f64) {
        // NaN counts as no move: the finite-value check reports it at the end of the step.
        self.prediction.margin = 0f64.max(longest * ROUNDING);
        self.prediction.swept.iter_mut().skip(first).for_each(|swept| *swept = 0.0);
        for i in first..self.body.len() {
            self.widen_margins(i, dt * self.body[i].velocity.length());
        }
    }

    /// Widens the margins if they do not allow for a move of particle `i` by `moved`, m, in a whole step.
    pub(super) fn widen_margins(&mut self, i: usize, moved: f64) {
        self.widen_margin(moved);
        let Prediction { swept, range, .. } = &mut self.prediction;
        if let Some(swept) = swept.get_mut(i) {
            *swept = swept.max(swept_radius(self.body[i].radius, moved, *range));
        }
    }

    /// Widens the margin of all pairs if it does not allow for a move by `moved`, m, in a whole step.
    pub(crate) fn widen_margin(&mut self, moved: f64) {
        self.prediction.margin = self.prediction.margin.max(moved * ROUNDING);
    }

    /// Like [`Self::set_velocity`], for the spin, rad/s.
    pub(super) fn set_spin(&mut self, i: usize, spin: V::Spin, is_pending: bool) {
        if self.is_ahead(i) {
            let shifted = self.prediction.middle_spin[i] + (spin - self.rotation[i].spin);
            self.prediction.middle_spin[i] = if is_pending { spin } else { shifted };
        }
        if let Some(body) = self.body_of_row(i) {
            let rotor = self.bodies.rotor[body.index()];
            let inverse_inertia = self.bodies.inverse_inertia[body.index()];
            let momentum = if self.is_ahead(i) && !is_pending {
                self.bodies.momentum[body.index()] + rotor.momentum(spin - self.rotation[i].spin, inverse_inertia)
            } else {
                rotor.momentum(spin, inverse_inertia)
            };
            self.bodies.momentum[body.index()] = momentum;
        }
        self.rotation[i].spin = spin;
        self.move_spheres_of(i);
    }

    /// Gives the spheres of the body in row `i` its motion, if it is a body.
    fn move_spheres_of(&mut self, i: usize) {
        if let Some(body) = self.body_of_row(i) {
            self.place_spheres(body, &mut LongestMove::default());
        }
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "exact values")]
mod tests {
    use super::*;
    use crate::space::Solid;
    use crate::store::Body;

    #[test]
    fn a_swept_radius_has_the_move_of_half_a_step_and_half_the_range() {
        // 3 mm in a whole step.
        assert!((swept_radius(0.01, 3e-3, 4e-4) - (0.01 + 1.5e-3 + 2e-4)).abs() < 1.5e-3 * 1e-6 + 0.01 * f64::EPSILON);
        assert_eq!(swept_radius(0.01, 0.0, 0.0), 0.01);
    }

    #[test]
    fn a_faster_velocity_widens_the_margins_and_a_slower_one_keeps_them() {
        let mut store = ParticleStore::<Solid>::default();
        let still = Solid::ZERO;
        let body = Body { position: still, velocity: still, radius: 0.01, inverse_mass: 1.0, middle: () };
        store.body = vec![body; 2];
        (store.free_end, store.prediction.is_ahead) = (1, true);
        store.prediction.velocities_ahead = 0.5e-3;
        store.prediction.middle = vec![still; 2];
        store.prediction.swept = vec![0.01; 2];
        // A grain and a fixed particle: 2 m/s for a step of 1 ms.
        for i in [0, 1] {
            store.set_velocity(i, Solid::new(0.0, 2.0, 0.0), false);
            assert_eq!(store.prediction.swept[i], swept_radius(0.01, 2e-3, 0.0));
            assert!((store.prediction.margin / 2e-3 - 1.0).abs() < 2e-6);
            store.set_velocity(i, still, false);
            assert_eq!(store.prediction.swept[i], swept_radius(0.01, 2e-3, 0.0));
        }
        // Schemes without prediction have no margins.
        (store.prediction.velocities_ahead, store.prediction.margin, store.prediction.swept) = (0.0, 0.0, Vec::new());
        store.set_velocity(1, Solid::X, false);
        assert!(store.prediction.swept.is_empty() && store.prediction.margin == 0.0);
    }
}
