//! Speed against error: how wrong a scheme is at a step, and what less error would cost.
//!
//! * [`cases`]: small systems with a known answer, run by [`trial`] through the product's own app over a [`ladder`] of steps
//!   and all schemes, and held against [`mod@reference`], which shares nothing with the product.
//! * [`work_precision`]: orders, the step that a wanted error needs, Pareto fronts. [`report`] and [`figure`] show them.
//! * [`scene_study`]: the same question for a scene of the user's, which has no closed form: its own observables over steps
//!   and seeds.
//!
//! Steps are counted per contact duration, t_c/dt, and are incommensurate with it; errors are root mean squares over
//! contacts that begin at many moments of a step, because at one moment, or at a whole t_c/dt, errors may cancel.

pub mod case;
pub mod cases;
pub mod cost;
pub mod figure;
pub mod ladder;
pub mod reference;
pub mod report;
pub mod scene_study;
pub mod trial;
pub mod work_precision;

use crate::integrate::Integrator;

/// A scheme that is compared.
#[derive(Clone, Copy, Debug)]
pub struct Scheme {
    /// As the scene's `integrator` has it.
    pub integrator: Integrator,
    /// Evaluations of the forces a step.
    pub evaluations: f64,
}

/// All schemes, the plain one first: others are measured by it.
pub const SCHEMES: &[Scheme] = &[
    Scheme { integrator: Integrator::Verlet, evaluations: 1.0 },
    Scheme { integrator: Integrator::Centred, evaluations: 1.0 },
    Scheme { integrator: Integrator::SymplecticEuler, evaluations: 1.0 },
    Scheme { integrator: Integrator::ExplicitEuler, evaluations: 1.0 },
];

impl Scheme {
    /// Its name in a scene.
    #[must_use]
    pub fn name(&self) -> String {
        format!("{:?}", self.integrator)
    }
}
