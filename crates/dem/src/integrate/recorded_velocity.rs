//! The velocity or spin that the record of a particle holds between the drift and the kick: the one in the middle of the step, or a
//! prediction for its end, with the one in the middle beside it ([`centred`](crate::contact::centred)). The passes of the integrator are written
//! once for both.

use crate::space::Space;
use crate::store::{Body, Rotation, swept_radius};

/// The velocity or spin, of type `T`, that a scheme keeps in the record `R` of a particle.
pub(super) trait RecordedVelocity<R, T>: Copy + Sync {
    /// The data of a particle that the scheme keeps apart from the record.
    type Apart: Copy + Default + Send;

    /// Returns the value in the middle of the step.
    fn middle(self, record: &R, apart: &Self::Apart) -> T;

    /// Stores the value in the middle of the step. `gain` is its gain in half a step by the present force.
    fn store(self, middle: T, gain: T, record: &mut R, apart: &mut Self::Apart);
}

/// An entry of [`Prediction::swept`](crate::store::Prediction), or `()` if no contact law needs it.
pub(super) trait Swept: Copy + Default + Send {
    /// Returns the entry of a particle, m, from its radius, m, the squared length of its move in a whole step, m^2, and the range of
    /// contacts, m.
    fn of(radius: f64, squared: f64, range: f64) -> Self;
}

impl Swept for () {
    #[inline(always)]
    fn of(_: f64, _: f64, _: f64) {}
}

impl Swept for f64 {
    #[inline(always)]
    fn of(radius: f64, squared: f64, range: f64) -> Self {
        swept_radius(radius, squared.sqrt(), range)
    }
}

/// The record holds the value in the middle of the step.
#[derive(Clone, Copy)]
pub(super) struct InTheMiddle;

/// The record holds a prediction, which contains this share of the gain in half a step.
#[derive(Clone, Copy)]
pub(super) struct Predicted {
    pub(super) share: f64,
}

impl<V: Space> RecordedVelocity<Body<V>, V> for InTheMiddle {
    type Apart = ();

    #[inline(always)]
    fn middle(self, body: &Body<V>, (): &()) -> V {
        body.velocity
    }

    #[inline(always)]
    fn store(self, middle: V, _: V, body: &mut Body<V>, (): &mut ()) {
        body.velocity = middle;
    }
}

impl<V: Space> RecordedVelocity<Body<V>, V> for Predicted {
    type Apart = V::MiddleBesideBody;

    #[inline(always)]
    fn middle(self, body: &Body<V>, apart: &V::MiddleBesideBody) -> V {
        V::middle(&body.middle, apart)
    }

    #[inline(always)]
    fn store(self, middle: V, gain: V, body: &mut Body<V>, apart: &mut V::MiddleBesideBody) {
        V::set_middle(middle, &mut body.middle, apart);
        body.velocity = middle + gain * self.share;
    }
}

impl<V: Space> RecordedVelocity<Rotation<V>, V::Spin> for InTheMiddle {
    type Apart = ();

    #[inline(always)]
    fn middle(self, rotation: &Rotation<V>, (): &()) -> V::Spin {
        rotation.spin
    }

    #[inline(always)]
    fn store(self, middle: V::Spin, _: V::Spin, rotation: &mut Rotation<V>, (): &mut ()) {
        rotation.spin = middle;
    }
}

impl<V: Space> RecordedVelocity<Rotation<V>, V::Spin> for Predicted {
    type Apart = V::Spin;

    #[inline(always)]
    fn middle(self, _: &Rotation<V>, apart: &V::Spin) -> V::Spin {
        *apart
    }

    #[inline(always)]
    fn store(self, middle: V::Spin, gain: V::Spin, rotation: &mut Rotation<V>, apart: &mut V::Spin) {
        *apart = middle;
        rotation.spin = middle + gain * self.share;
    }
}
