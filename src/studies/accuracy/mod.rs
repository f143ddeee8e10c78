//! Speed against error: the error of each integration scheme as a function of the time step, and the cost of less
//! error.
//!
//! * [`cases`]: small systems with a known solution. [`trial`] runs them in the simulator's own app, over a [`ladder`]
//!   of steps and with all schemes. Errors are measured against [`mod@reference`], which shares no code with the
//!   simulator.
//! * [`work_precision`]: orders of convergence, the step that a target error needs, Pareto fronts. [`report`] and
//!   [`figure`] present the results.
//! * [`scene_study`]: the effect of the step in a user's scene, which has no closed form. It compares the scene's
//!   observables over steps and seeds.
//!
//! Steps are counted per contact duration t_c, as t_c/dt, and never divide t_c. Errors are root mean squares over
//! contacts that begin at many phases of a step. With a single phase, or a whole number t_c/dt, errors may cancel.

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

use siloflow_dem::integrate::Integrator;

/// An integration scheme of the comparison.
#[derive(Clone, Copy, Debug)]
pub struct Scheme {
    /// Value of the scene key `integrator`.
    pub integrator: Integrator,
    /// Force evaluations per step.
    pub evaluations: f64,
}

/// All schemes. The first (plain Verlet) is the baseline of the comparison.
pub const SCHEMES: &[Scheme] = &[
    Scheme { integrator: Integrator::Verlet, evaluations: 1.0 },
    Scheme { integrator: Integrator::Centred, evaluations: 1.0 },
    Scheme { integrator: Integrator::SymplecticEuler, evaluations: 1.0 },
    Scheme { integrator: Integrator::ExplicitEuler, evaluations: 1.0 },
];

impl Scheme {
    /// Returns the scheme's name as written in a scene.
    #[must_use]
    pub fn name(&self) -> String {
        format!("{:?}", self.integrator)
    }
}
