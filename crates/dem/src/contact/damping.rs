//! How a scene gives the damping of a contact, and closed forms for a damped linear bounce.
//!
//! With w0 = sqrt(k/m_eff), beta = c/(2 m_eff) and zeta = beta/w0, the overlap obeys
//! `delta'' + 2 zeta w0 delta' + w0^2 delta = 0`, starting from `delta = 0`, `delta' = v0`.
//!
//! * Attraction allowed: the contact lasts t_c = pi/w with w = w0 sqrt(1 - zeta^2), and
//!   e = exp(-pi zeta/sqrt(1 - zeta^2)). At zeta >= 1 it never ends, e = 0.
//! * Attraction forbidden: the contact ends when k delta + c delta' = 0. With zeta = sin(phi) this is at
//!   t_c = (pi - 2 phi)/w, and e = exp(-tan(phi) (pi - 2 phi)) (Schwager and Poeschel, Granular Matter 9, 465, 2007, in
//!   other symbols). Beyond critical damping, with s = sqrt(zeta^2 - 1), t_c = 2 ln(zeta + s)/(s w0) and
//!   e = exp(-zeta w0 t_c). No finite damping gives e = 0.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use crate::math;
use crate::values::{NonNegative, Restitution};

/// The dashpot coefficient c of the normal force `k delta - c v_n`, in N s/m.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub enum Damping {
    /// c = b, N s/m, the same for every pair.
    B(NonNegative),
    /// c = gamma_n m_eff for this gamma_n, 1/s, as in LAMMPS: the same decay rate for every pair.
    PerMass(NonNegative),
    /// The restitution, the same for every pair: c = 2 zeta sqrt(k m_eff).
    Restitution(Restitution),
}

/// A dashpot coefficient, N s/m: constant + per_mass m_eff + per_other x. At most one of the terms is nonzero. A sum
/// avoids a branch in the loop over contacts. The caller defines x: sqrt(m_eff) for the normal dashpot, the normal c for
/// the tangential dashpot.
#[derive(Clone, Copy, Debug, Default)]
pub struct Coefficient {
    /// The constant term, N s/m.
    pub constant: f64,
    /// Factor of m_eff, 1/s.
    pub per_mass: f64,
    /// Factor of x, N s/m per unit of x.
    pub per_other: f64,
}

impl Coefficient {
    /// Returns the coefficient of a pair, N s/m; `other` is x.
    #[inline(always)]
    #[must_use]
    pub fn of(self, reduced_mass: f64, other: f64) -> f64 {
        self.constant + self.per_mass * reduced_mass + self.per_other * other
    }

    /// Returns the mean coefficient over a step that has a contact in the fraction `share`, N s/m. `mean_other` is the mean
    /// of x over the whole step.
    #[inline(always)]
    #[must_use]
    pub fn mean(self, reduced_mass: f64, share: f64, mean_other: f64) -> f64 {
        (self.constant + self.per_mass * reduced_mass) * share + self.per_other * mean_other
    }
}

/// Whether the normal force may pull.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Deserialize, Serialize)]
pub enum Attraction {
    /// A contact lasts as long as the overlap; near its end the dashpot pulls.
    Allowed,
    /// The normal force is never below zero.
    #[default]
    Forbidden,
}

impl Attraction {
    /// Returns the lower bound of the normal force, N.
    #[must_use]
    pub fn floor(self) -> f64 {
        match self {
            Self::Allowed => f64::NEG_INFINITY,
            Self::Forbidden => 0.0,
        }
    }

    /// Returns the restitution of a bounce with damping ratio `zeta`.
    #[must_use]
    pub fn restitution(self, zeta: f64) -> f64 {
        match self {
            Self::Allowed if zeta >= 1.0 => 0.0,
            Self::Allowed => math::exp(-PI * zeta / (1.0 - zeta * zeta).sqrt()),
            Self::Forbidden => restitution_without_attraction(zeta),
        }
    }

    /// Returns the contact duration in units of 1/w0; infinite if the contact never ends.
    #[must_use]
    pub fn duration(self, zeta: f64) -> f64 {
        let root = (1.0 - zeta * zeta).abs().sqrt();
        match self {
            Self::Allowed if zeta >= 1.0 => f64::INFINITY,
            Self::Allowed => PI / root,
            Self::Forbidden if root < 1e-6 => 2.0,
            Self::Forbidden if zeta < 1.0 => (PI - 2.0 * math::asin(zeta)) / root,
            Self::Forbidden => 2.0 * math::ln(zeta + root) / root,
        }
    }

    /// Returns the damping ratio for restitution `e`.
    #[must_use]
    pub fn damping_ratio(self, e: Restitution) -> f64 {
        let e = e.get();
        match self {
            Self::Allowed => -math::ln(e) / (PI * PI + math::ln(e).powi(2)).sqrt(),
            Self::Forbidden if e >= 1.0 => 0.0,
            Self::Forbidden => bisect(e),
        }
    }
}

/// Returns e(zeta) without attraction; it falls from 1 through exp(-2) at zeta = 1 towards 0.
fn restitution_without_attraction(zeta: f64) -> f64 {
    let root = (1.0 - zeta * zeta).abs().sqrt();
    if root < 1e-6 {
        return math::exp(-2.0);
    }
    let exponent = if zeta < 1.0 {
        zeta / root * (PI - 2.0 * math::asin(zeta))
    } else {
        2.0 * zeta / root * math::ln(zeta + root)
    };
    math::exp(-exponent)
}

/// Returns the zeta that gives restitution `e` without attraction. Bisection, because e(zeta) falls monotonically.
fn bisect(e: f64) -> f64 {
    let mut low = 0.0;
    let mut high = 1.0;
    while restitution_without_attraction(high) > e {
        high *= 2.0;
    }
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if restitution_without_attraction(middle) > e { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damping_ratio_inverts_restitution() {
        for rule in [Attraction::Allowed, Attraction::Forbidden] {
            for e in [1.0, 0.95, 0.9, 0.5, 0.2, 0.1353, 0.05, 1e-3] {
                let zeta = rule.damping_ratio(Restitution::try_from(e).unwrap());
                // Conditioning: d(ln e)/d(zeta) stays of order 10 here, so 1e-13 in zeta is 1e-12 in e.
                assert!((rule.restitution(zeta) - e).abs() < 1e-12, "{rule:?} {e}: {zeta}");
            }
        }
    }

    #[test]
    fn undamped_contact_lasts_half_a_period() {
        for rule in [Attraction::Allowed, Attraction::Forbidden] {
            assert!((rule.duration(0.0) - PI).abs() < 1e-15);
            assert!((rule.restitution(0.0) - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn forms_without_attraction_join_at_critical_damping() {
        for rule in [Attraction::restitution, Attraction::duration] {
            let below = rule(Attraction::Forbidden, 0.999);
            let at = rule(Attraction::Forbidden, 1.0);
            let above = rule(Attraction::Forbidden, 1.001);
            // The function is smooth: its second difference is of order 1e-6.
            assert!((below - 2.0 * at + above).abs() < 1e-5, "{below} {at} {above}");
        }
    }
}
