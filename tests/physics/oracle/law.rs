//! Numbers of the contact laws, for the scene and for the oracle, and the coefficients derived from them for one
//! contact.
//!
//! * Linear: spring k delta; c = b, gamma m, or 2 zeta sqrt(k m). zeta follows from the restitution e, in units of w0
//!   with beta = zeta, w^2 = 1 - zeta^2. With attraction e = exp(-pi beta/w); without it e = exp(-(beta/w) (pi -
//!   atan2(2 beta w, w^2 - beta^2))).
//! * Hertz: S = 2 E* sqrt(R* delta), spring 2/3 S delta, c = 2 sqrt(5/6) zeta sqrt(S m), with 1/E* = sum (1 - nu^2)/E.
//! * Mindlin: k_t = 8 G* sqrt(R* delta), c_t = 2 sqrt(5/6) zeta sqrt(k_t m), with 1/G* = sum (2 - nu) 2 (1 + nu)/E.

use std::f64::consts::PI;

/// Definition of a damping coefficient: c in N s/m, gamma in 1/s, a restitution, or a share of the normal coefficient.
#[derive(Clone, Copy, Debug)]
pub enum Damping {
    B(f64),
    PerMass(f64),
    Restitution(f64),
    OfNormal(f64),
}

#[derive(Clone, Copy, Debug)]
pub enum Normal {
    Assignment { k: f64, b: f64 },
    Linear { k: f64, damping: Damping, pulls: bool },
    Hertz { restitution: f64, pulls: bool },
}

#[derive(Clone, Copy, Debug)]
pub enum Friction {
    Dashpot { damping: Damping, mu: f64 },
    Spring { k: f64, damping: Damping, mu: f64 },
    Mindlin { mu: f64 },
}

/// Stiffness (N/m), damping and coefficient of rolling resistance.
#[derive(Clone, Copy, Debug)]
pub struct Rolling {
    pub k: f64,
    pub damping: Damping,
    pub mu: f64,
}

#[derive(Clone, Copy, Debug)]
pub struct Law {
    pub normal: Normal,
    pub friction: Option<Friction>,
    pub rolling: Option<Rolling>,
    /// Whether friction acts at the contact point instead of at the radius.
    pub at_point: bool,
}

/// Young's modulus, Pa, and Poisson's ratio.
#[derive(Clone, Copy, Debug)]
pub struct Material {
    pub young: f64,
    pub poisson: f64,
}

impl Damping {
    fn ron(self) -> String {
        format!("{self:?}")
    }

    fn number(&mut self) -> (&'static str, &mut f64) {
        match self {
            Self::B(b) => ("b", b),
            Self::PerMass(gamma) => ("gamma", gamma),
            Self::Restitution(e) => ("e", e),
            Self::OfNormal(share) => ("share of c", share),
        }
    }

    /// Returns c, N s/m, for definitions that do not depend on a stiffness.
    pub fn drag(self, mass: f64, normal_drag: f64) -> f64 {
        match self {
            Self::B(b) => b,
            Self::PerMass(gamma) => gamma * mass,
            Self::OfNormal(share) => share * normal_drag,
            Self::Restitution(_) => panic!("only a normal force has a restitution"),
        }
    }
}

impl Law {
    /// Returns the scene's `contact` value.
    pub fn ron(&self) -> String {
        let attraction = |pulls: bool| if pulls { "Allowed" } else { "Forbidden" };
        let (head, pulls) = match self.normal {
            Normal::Assignment { k, b } => return format!("Assignment(k: {k:?}, b: {b:?})"),
            Normal::Linear { k, damping, pulls } => (format!("Linear(k: {k:?}, damping: {}", damping.ron()), pulls),
            Normal::Hertz { restitution, pulls } => (format!("Hertz(restitution: {restitution:?}"), pulls),
        };
        let tangential = self.friction.map_or(String::new(), |friction| match friction {
            Friction::Dashpot { damping, mu } => {
                format!(", tangential: Dashpot(damping: {}, friction: {mu:?})", damping.ron())
            }
            Friction::Spring { k, damping, mu } => {
                format!(", tangential: Spring(k: {k:?}, damping: {}, friction: {mu:?})", damping.ron())
            }
            Friction::Mindlin { mu } => format!(", tangential: Mindlin(friction: {mu:?})"),
        });
        let rolling = self.rolling.map_or(String::new(), |Rolling { k, damping, mu }| {
            format!(", rolling: (k: {k:?}, damping: {}, friction: {mu:?})", damping.ron())
        });
        let lever = if self.at_point { "ContactPoint" } else { "Radius" };
        format!("{head}, attraction: {}{tangential}{rolling}, lever: {lever})", attraction(pulls))
    }

    /// Returns all numbers of the law with their names.
    pub fn numbers(&mut self) -> Vec<(&'static str, &mut f64)> {
        let mut all = match &mut self.normal {
            Normal::Assignment { k, b } => vec![("k", k), ("b", b)],
            Normal::Linear { k, damping, .. } => vec![("k", k), damping.number()],
            Normal::Hertz { restitution, .. } => vec![("e", restitution)],
        };
        match &mut self.friction {
            None => {}
            Some(Friction::Dashpot { damping, mu }) => all.extend([damping.number(), ("mu", mu)]),
            Some(Friction::Spring { k, damping, mu }) => all.extend([("k_t", k), damping.number(), ("mu", mu)]),
            Some(Friction::Mindlin { mu }) => all.push(("mu", mu)),
        }
        if let Some(Rolling { k, damping, mu }) = &mut self.rolling {
            all.extend([("k_r", k), damping.number(), ("mu_r", mu)]);
        }
        all
    }

    pub fn is_hertz(&self) -> bool {
        matches!(self.normal, Normal::Hertz { .. })
    }
}

/// A law between two species with derived coefficients.
#[derive(Clone, Copy, Debug)]
pub struct Terms {
    pub law: Law,
    /// Damping ratio that gives the restitution of the linear law.
    zeta: f64,
    /// E* and G*, Pa.
    moduli: [f64; 2],
}

/// Reduced mass (kg) and reduced radius (m) of a contact.
#[derive(Clone, Copy, Debug)]
pub struct Reduced {
    pub mass: f64,
    pub radius: f64,
}

impl Terms {
    pub fn new(law: Law, materials: [Material; 2]) -> Self {
        let zeta = match law.normal {
            Normal::Linear { damping: Damping::Restitution(e), pulls, .. } => damping_ratio(e, pulls),
            Normal::Hertz { restitution, pulls } => damping_ratio(restitution, pulls),
            _ => 0.0,
        };
        let normal = |m: Material| (1.0 - m.poisson * m.poisson) / m.young;
        let shear = |m: Material| (2.0 - m.poisson) * 2.0 * (1.0 + m.poisson) / m.young;
        let [a, b] = materials;
        Self { law, zeta, moduli: [1.0 / (normal(a) + normal(b)), 1.0 / (shear(a) + shear(b))] }
    }

    /// Returns the spring force at an overlap (m); zero across a gap.
    pub fn spring(&self, reduced: Reduced, overlap: f64) -> f64 {
        let overlap = overlap.max(0.0);
        match self.law.normal {
            Normal::Assignment { k, .. } | Normal::Linear { k, .. } => k * overlap,
            Normal::Hertz { .. } => 4.0 / 3.0 * self.moduli[0] * (reduced.radius * overlap).sqrt() * overlap,
        }
    }

    /// Returns the damping coefficient c at an overlap, N s/m.
    pub fn drag(&self, reduced: Reduced, overlap: f64) -> f64 {
        let Reduced { mass, radius } = reduced;
        match self.law.normal {
            Normal::Assignment { b, .. } => b,
            Normal::Linear { k, damping: Damping::Restitution(_), .. } => 2.0 * self.zeta * (k * mass).sqrt(),
            Normal::Linear { damping, .. } => damping.drag(mass, 0.0),
            Normal::Hertz { .. } => {
                let stiffness = 2.0 * self.moduli[0] * (radius * overlap.max(0.0)).sqrt();
                2.0 * (5.0f64 / 6.0).sqrt() * self.zeta * (stiffness * mass).sqrt()
            }
        }
    }

    /// Returns the smallest allowed normal force, N.
    pub fn floor(&self) -> f64 {
        match self.law.normal {
            Normal::Linear { pulls: false, .. } | Normal::Hertz { pulls: false, .. } => 0.0,
            _ => f64::NEG_INFINITY,
        }
    }

    /// Returns k_t, c_t and mu at an overlap and a normal damping coefficient; `None` without friction.
    pub fn tangential(&self, reduced: Reduced, overlap: f64, normal_drag: f64) -> Option<[f64; 3]> {
        Some(match self.law.friction? {
            Friction::Dashpot { damping, mu } => [0.0, damping.drag(reduced.mass, normal_drag), mu],
            Friction::Spring { k, damping, mu } => [k, damping.drag(reduced.mass, normal_drag), mu],
            Friction::Mindlin { mu } => {
                let k = 8.0 * self.moduli[1] * (reduced.radius * overlap.max(0.0)).sqrt();
                [k, 2.0 * (5.0f64 / 6.0).sqrt() * self.zeta * (k * reduced.mass).sqrt(), mu]
            }
        })
    }

    /// Returns the means of c_t over two steps, from the shares of these steps in contact and the means of the normal damping
    /// coefficient.
    pub fn mean_tangential_drags(&self, reduced: Reduced, shares: [f64; 2], normal: [f64; 2]) -> [f64; 2] {
        let both = |of: &dyn Fn(usize) -> f64| [of(0), of(1)];
        match self.law.friction {
            None => [0.0; 2],
            Some(Friction::Dashpot { damping, .. } | Friction::Spring { damping, .. }) => match damping {
                Damping::OfNormal(_) => both(&|step| damping.drag(reduced.mass, normal[step])),
                _ => both(&|step| damping.drag(reduced.mass, 0.0) * shares[step]),
            },
            // Both coefficients go with the root of their stiffness, 8 G* and 2 E* times the same root.
            Some(Friction::Mindlin { .. }) => normal.map(|mean| mean * (4.0 * self.moduli[1] / self.moduli[0]).sqrt()),
        }
    }

    /// Whether the tangential stiffness changes while a contact lasts.
    pub fn stiffness_varies(&self) -> bool {
        matches!(self.law.friction, Some(Friction::Mindlin { .. }))
    }

    /// Whether the tangential force has a memory.
    pub fn has_spring(&self) -> bool {
        matches!(self.law.friction, Some(Friction::Mindlin { .. } | Friction::Spring { .. }))
    }
}

/// Returns the damping ratio below 1 with restitution `e`, by bisection (e falls with the ratio).
fn damping_ratio(e: f64, pulls: bool) -> f64 {
    let restitution = |zeta: f64| {
        let frequency = (1.0 - zeta * zeta).sqrt();
        let angle = if pulls { PI } else { PI - (2.0 * zeta * frequency).atan2(frequency * frequency - zeta * zeta) };
        (-zeta / frequency * angle).exp()
    };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if restitution(middle) > e { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}
