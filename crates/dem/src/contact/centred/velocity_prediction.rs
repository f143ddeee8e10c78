//! The velocity prediction of the scheme `Centred`.
//!
//! Positions move as in `verlet`. The forces, however, see velocities that are predicted for the end of the step:
//! v_p = v(t+dt/2) + beta dt/2 a(t) for every particle, with beta = (1 - q)/(1 + q) and q = b dt. b = c/(2 m_eff) is the
//! largest damping rate of any contact along its normal; for spins it is the rate of sliding or rolling. So the force of most contacts is the plain force of the law, and
//! costs nothing more. Contacts that may open or close within the step, and contacts of a lone grain
//! (`lone_grains`), take an averaged force instead ([`window`](super::window)).
//!
//! **Why beta.** The drag should act with v(t+dt), to which its own force belongs: a(t+dt) in place of a(t). Solved for
//! the drag of one contact, the closing speed is u = u_h + (1 - q)/(1 + q) dt/2 A, with the closing acceleration A of the
//! step's beginning. For two equal grains that is c/m_eff = 2 c/m. In a packing, z neighbours at rest damp a grain at the
//! rate c z/(d m) in d dimensions, which is 2 to 3 c/m. So the factor of a pair serves a packing as well.
//! beta = 1 - O(dt), so any beta of this form keeps the order. Its value decides accuracy and stability: n contacts that
//! share a motion along their normals are stable for n ((w0 dt)^2 + 8 zeta w0 dt/(1 + zeta w0 dt)) < 4. `scene::check::crowd` has
//! the limit with friction.
//!
//! **Springs** along tangents, in rolling and in twisting gather how far the surfaces move against each other while the contact lasts. They
//! advance in one of two ways:
//!
//! * *With the velocities in the middle of the step*, S <- S + dt v_h, as in `verlet`. The stretch then follows the positions, and springs
//!   without dashpots keep their energy like all springs of velocity Verlet. Each contact also loads the velocities and spins in the middle of the step.
//! * *With the predicted velocities*, S <- S + dt v_p, where every spring has a dashpot c >= k dt. S is stored half a step ahead: the
//!   stretch at the evaluation is S - dt/2 v_p. This is the trapezoidal rule. The stretch lags, so that a spring acts as if its dashpot
//!   were weaker by (1 - beta)/2 k dt, and at beta = 1 by (w dt)^2/4 k dt for a motion of frequency w. A dashpot of k dt outweighs
//!   that in every stable step. A contact then loads the predicted velocities alone.
//!
//! [`VelocityPredictionPlugin::springs_exact`] tells which. In both ways a motion grows in no step below the limit of
//! `scene::check::crowd`, whatever the dashpots. A stiffness that grows with the root of the overlap counts with its exact mean over a step of
//! constant speed.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::space::Space;
use crate::step::{Clock, Part, Phase, Step};
use crate::store::{ParticleStore, VelocitiesPredicted};

/// The largest damping rates of any contact, 1/s.
#[derive(Resource, Clone, Copy)]
struct DampingRates([f64; 2]);

/// Returns the share beta of the velocity gain in half a step of `dt` (s) that is predicted, for a damping rate (1/s).
#[must_use]
pub fn prediction_share(rate: f64, dt: f64) -> f64 {
    let q = rate * dt;
    // At q = 1 a single contact is unstable anyway. A share above zero lets the gain be computed from the prediction.
    ((1.0 - q) / (1.0 + q)).max(0.01)
}

/// Sets the times of the prediction, and makes room for grains that have entered. A grain that has just entered does not
/// count as lone.
fn prepare<V: Space>(clock: Res<Clock>, rates: Res<DampingRates>, mut store: ResMut<ParticleStore<V>>) {
    let count = store.body.len();
    let prediction = &mut store.prediction;
    prediction.velocities_ahead = 0.5 * clock.dt;
    [prediction.share, prediction.spin_share] = rates.0.map(|rate| prediction_share(rate, clock.dt));
    prediction.lone.resize(count, 0);
    if clock.is_step_zero() {
        prediction.swept.resize(if prediction.sweeps { count } else { 0 }, 0.0);
        store.set_margins(0, 0.0, clock.dt);
    }
}

/// Velocity prediction for centred contacts, in addition to the integrator.
pub struct VelocityPredictionPlugin<V: Space> {
    /// Largest damping rates of any contact: c/(2 m) along the normal, and of sliding, rolling or twisting, 1/s.
    pub damping_rates: [f64; 2],
    /// Whether springs advance with the velocities in the middle of the step.
    pub springs_exact: bool,
    /// The space.
    pub space: PhantomData<V>,
}

impl<V: Space> Plugin for VelocityPredictionPlugin<V> {
    fn build(&self, app: &mut App) {
        app.insert_resource(DampingRates(self.damping_rates));
        app.world_mut().resource_mut::<ParticleStore<V>>().prediction.springs_exact = self.springs_exact;
        app.add_systems(Step, prepare::<V>.in_set(Part::Engine(Phase::Neighbours)).in_set(VelocitiesPredicted));
    }
}
