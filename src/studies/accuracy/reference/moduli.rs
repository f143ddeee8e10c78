//! Stiffnesses and damping coefficients of one contact of the reference, as functions of the overlap.

use super::closed::damping_ratio;
use super::{Law, Rolling};

/// The coefficients of a contact.
#[derive(Clone, Copy, Debug)]
pub enum Moduli {
    /// Coefficients k and b of the assignment's law. Its drag acts on the whole velocity.
    Full([f64; 2]),
    /// Constant coefficients k, c, k_t and c_t.
    Constant([f64; 4]),
    /// Factors of Hertz's law: of the force, of S_n, of k_t, and of the damping coefficients.
    Hertz { force: f64, normal: f64, tangential: f64, damping: f64 },
}

impl Moduli {
    /// Returns the coefficients of a contact with these reduced mass (kg) and radius (m).
    pub fn new(law: &Law, mass: f64, radius: f64) -> Self {
        match *law {
            Law::Full { k, b } => Self::Full([k, b]),
            Law::Linear { k, e, attracts, friction } => {
                let c = 2.0 * damping_ratio(e, attracts) * (k * mass).sqrt();
                let (k_t, c_t) = friction.map_or((0.0, 0.0), |f| (f.k, f.share * c));
                Self::Constant([k, c, k_t, c_t])
            }
            Law::Jkr { young, poisson, .. } => Self::new(&Law::Hertz { young, poisson, e: 1.0, mu: 0.0 }, mass, radius),
            Law::Hertz { young, poisson, e, .. } | Law::Adhesive { young, poisson, e, .. } => {
                // Both sides have the same material: 1/E* = 2 (1 - nu^2)/E and 1/G* = 4 (2 - nu) (1 + nu)/E.
                let normal = young / (2.0 * (1.0 - poisson * poisson));
                let shear = young / (4.0 * (2.0 - poisson) * (1.0 + poisson));
                Self::Hertz {
                    force: 4.0 / 3.0 * normal * radius.sqrt(),
                    normal: 2.0 * normal * radius.sqrt(),
                    tangential: 8.0 * shear * radius.sqrt(),
                    damping: 2.0 * (5.0f64 / 6.0).sqrt() * damping_ratio(e, false) * mass.sqrt(),
                }
            }
        }
    }

    /// Whether stiffnesses depend on the overlap.
    pub fn vary(&self) -> bool {
        matches!(self, Self::Hertz { .. })
    }

    /// Returns the force of the normal spring, N.
    pub fn spring(&self, overlap: f64) -> f64 {
        match self {
            Self::Full([k, _]) | Self::Constant([k, ..]) => k * overlap,
            Self::Hertz { force, .. } => force * overlap.max(0.0).powf(1.5),
        }
    }

    /// Returns the normal damping coefficient, N s/m.
    pub fn damping(&self, overlap: f64) -> f64 {
        match self {
            Self::Full([_, c]) | Self::Constant([_, c, ..]) => *c,
            Self::Hertz { normal, damping, .. } => damping * (normal * overlap.max(0.0).sqrt()).sqrt(),
        }
    }

    /// Returns stiffness (N/m) and damping coefficient (N s/m) of friction.
    pub fn friction(&self, overlap: f64) -> [f64; 2] {
        match self {
            Self::Full(_) => [0.0; 2],
            Self::Constant([.., k, c]) => [*k, *c],
            Self::Hertz { tangential, damping, .. } => {
                let k = tangential * overlap.max(0.0).sqrt();
                [k, damping * k.sqrt()]
            }
        }
    }
}

/// Returns the coefficients of friction of a law, and its rolling resistance.
pub fn sliders(law: &Law) -> (f64, Option<Rolling>) {
    match law {
        Law::Full { .. } | Law::Jkr { .. } => (0.0, None),
        Law::Linear { friction, .. } => friction.map_or((0.0, None), |friction| (friction.mu, friction.rolling)),
        Law::Hertz { mu, .. } | Law::Adhesive { mu, .. } => (*mu, None),
    }
}
