//! Closed forms: of the thrown grain, and of the damped head-on bounce, `delta'' + 2 beta delta' + w0^2 delta = 0`.
//!
//! With zeta = beta/w0 < 1 and s = sqrt(1 - zeta^2): attraction allowed, the contact ends at delta = 0 after pi/(s w0) with
//! e = exp(-pi zeta/s); forbidden, it ends where the force is 0, at the angle pi - atan2(2 zeta s, 1 - 2 zeta^2) of the
//! swing instead of pi.

use std::f64::consts::PI;

use glam::DVec2;

/// The angle of the swing s w0 t at which the force ends.
fn angle(zeta: f64, attracts: bool) -> f64 {
    let s = (1.0 - zeta * zeta).sqrt();
    if attracts { PI } else { PI - (2.0 * zeta * s).atan2(1.0 - 2.0 * zeta * zeta) }
}

/// zeta for a restitution above e^-2, 0.135, by halving: e falls with zeta.
#[must_use]
pub fn damping_ratio(e: f64, attracts: bool) -> f64 {
    if e >= 1.0 {
        return 0.0;
    }
    let (mut low, mut high) = (0.0, 1.0 - f64::EPSILON);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        let restitution = (-middle / (1.0f64 - middle * middle).sqrt() * angle(middle, attracts)).exp();
        if restitution > e { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Contact duration, s, of a reduced mass (kg) on a spring (N/m).
#[must_use]
pub fn duration(k: f64, e: f64, attracts: bool, mass: f64) -> f64 {
    let zeta = damping_ratio(e, attracts);
    angle(zeta, attracts) / ((k / mass).sqrt() * (1.0 - zeta * zeta).sqrt())
}

/// Velocities after the head-on bounce of two masses (kg) with these before, m/s.
#[must_use]
pub fn after_bounce(masses: [f64; 2], before: [DVec2; 2], e: f64) -> [DVec2; 2] {
    let mean = (before[0] * masses[0] + before[1] * masses[1]) / (masses[0] + masses[1]);
    let parting = (before[0] - before[1]) * -e / (masses[0] + masses[1]);
    [mean + parting * masses[1], mean - parting * masses[0]]
}

/// Position and velocity after a time t (s) of flight.
#[must_use]
pub fn flight(x: DVec2, v: DVec2, g: DVec2, t: f64) -> (DVec2, DVec2) {
    (x + v * t + g * (0.5 * t * t), v + g * t)
}
