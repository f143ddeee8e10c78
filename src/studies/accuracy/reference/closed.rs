//! Closed forms of free flight and of the damped head-on bounce, `delta'' + 2 beta delta' + w0^2 delta = 0`.
//!
//! Let zeta = beta/w0 < 1 and s = sqrt(1 - zeta^2).
//!
//! * With attraction the contact ends at delta = 0, after the time pi/(s w0), with e = exp(-pi zeta/s).
//! * Without attraction it ends where the force vanishes, at the phase s w0 t = pi - atan2(2 zeta s, 1 - 2 zeta^2)
//!   instead of pi.

use std::f64::consts::PI;

use glam::DVec2;

/// Returns the phase s w0 t of the oscillation at which the contact force ends.
fn phase_at_end(zeta: f64, attracts: bool) -> f64 {
    let s = (1.0 - zeta * zeta).sqrt();
    if attracts { PI } else { PI - (2.0 * zeta * s).atan2(1.0 - 2.0 * zeta * zeta) }
}

/// Returns the damping ratio zeta of a restitution e above 0.135 = exp(-2), by bisection, because e decreases with
/// zeta.
#[must_use]
pub fn damping_ratio(e: f64, attracts: bool) -> f64 {
    if e >= 1.0 {
        return 0.0;
    }
    let mut low = 0.0;
    let mut high = 1.0 - f64::EPSILON;
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        let restitution = (-middle / (1.0f64 - middle * middle).sqrt() * phase_at_end(middle, attracts)).exp();
        if restitution > e { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Returns the contact duration (s) of a reduced mass `mass` (kg) on a spring of stiffness `k` (N/m).
#[must_use]
pub fn duration(k: f64, e: f64, attracts: bool, mass: f64) -> f64 {
    let zeta = damping_ratio(e, attracts);
    phase_at_end(zeta, attracts) / ((k / mass).sqrt() * (1.0 - zeta * zeta).sqrt())
}

/// Returns the velocities (m/s) of two masses (kg) after a head-on bounce, from the velocities `before` it (m/s).
#[must_use]
pub fn after_bounce(masses: [f64; 2], before: [DVec2; 2], e: f64) -> [DVec2; 2] {
    let mean = (before[0] * masses[0] + before[1] * masses[1]) / (masses[0] + masses[1]);
    let parting = (before[0] - before[1]) * -e / (masses[0] + masses[1]);
    [mean + parting * masses[1], mean - parting * masses[0]]
}

/// Returns position and velocity after a time `t` (s) of free flight under the gravity `g` (m/s^2).
#[must_use]
pub fn flight(x: DVec2, v: DVec2, g: DVec2, t: f64) -> (DVec2, DVec2) {
    (x + v * t + g * (0.5 * t * t), v + g * t)
}
