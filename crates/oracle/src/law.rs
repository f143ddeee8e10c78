//! Numbers of the contact laws, for the scene and for the oracle, and the coefficients derived from them for one
//! contact.
//!
//! * Linear: spring k delta; c = b, gamma m, or 2 zeta sqrt(k m). zeta follows from the restitution e, in units of w0
//!   with beta = zeta, w^2 = 1 - zeta^2. With attraction e = exp(-pi beta/w); without it e = exp(-(beta/w) (pi -
//!   atan2(2 beta w, w^2 - beta^2))).
//! * Hertz: S = 2 E* sqrt(R* delta), spring 2/3 S delta, c = 2 sqrt(5/6) zeta sqrt(S m), with 1/E* = sum (1 - nu^2)/E.
//! * Adhesion: a pull F, 2 pi w R*, or 2 pi q R* delta, which does not count in the cap of friction.
//! * Rolling resistance: a spring of its own, one with k = k_t (`Elastic`), or a drag 0.05 m/dt (`Torque`).
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
    Assignment {
        k: f64,
        b: f64,
    },
    Linear {
        k: f64,
        damping: Damping,
        pulls: bool,
    },
    Hertz {
        restitution: f64,
        pulls: bool,
    },
    /// Johnson, Kendall and Roberts, with the work of adhesion.
    Jkr {
        restitution: f64,
        pulls: bool,
        work: f64,
    },
}

#[derive(Clone, Copy, Debug)]
pub enum Friction {
    Dashpot {
        damping: Damping,
        mu: f64,
    },
    Spring {
        k: f64,
        damping: Damping,
        mu: f64,
    },
    Mindlin {
        mu: f64,
    },
    /// With c_t as a share of the normal c.
    MindlinOfNormal {
        mu: f64,
        share: f64,
    },
}

/// Kind of rolling resistance, `siloflow::dem::contact::rolling::RollingKind`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RollingKind {
    Spring,
    Elastic,
    Torque,
}

/// Stiffness (N/m), damping and coefficient of rolling resistance.
#[derive(Clone, Copy, Debug)]
pub struct Rolling {
    pub k: f64,
    pub damping: Damping,
    pub mu: f64,
    pub kind: RollingKind,
}

#[derive(Clone, Copy, Debug)]
pub enum Adhesion {
    Force(f64),
    Dmt(f64),
    Area(f64),
}

#[derive(Clone, Copy, Debug)]
pub struct Law {
    pub normal: Normal,
    pub adhesion: Option<Adhesion>,
    pub friction: Option<Friction>,
    pub rolling: Option<Rolling>,
    /// Twisting resistance, a spring and a dashpot like `RollingKind::Spring`; in solid space only.
    pub twisting: Option<Rolling>,
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
            Normal::Jkr { restitution, pulls, work } => {
                (format!("Hertz(restitution: {restitution:?}, adhesion: Jkr({work:?})"), pulls)
            }
        };
        let tangential = self.friction.map_or(String::new(), |friction| match friction {
            Friction::Dashpot { damping, mu } => {
                format!(", tangential: Dashpot(damping: {}, friction: {mu:?})", damping.ron())
            }
            Friction::Spring { k, damping, mu } => {
                format!(", tangential: Spring(k: {k:?}, damping: {}, friction: {mu:?})", damping.ron())
            }
            Friction::Mindlin { mu } => format!(", tangential: Mindlin(friction: {mu:?})"),
            Friction::MindlinOfNormal { mu, share } => {
                format!(", tangential: Mindlin(friction: {mu:?}, damping: OfNormal({share:?}))")
            }
        });
        let rolling = self.rolling.map_or(String::new(), |Rolling { k, damping, mu, kind }| match kind {
            RollingKind::Spring => format!(", rolling: (k: {k:?}, damping: {}, friction: {mu:?})", damping.ron()),
            RollingKind::Elastic => {
                format!(", rolling: (kind: Elastic, damping: {}, friction: {mu:?})", damping.ron())
            }
            RollingKind::Torque => format!(", rolling: (kind: Torque, friction: {mu:?})"),
        });
        let lever = if self.at_point { "ContactPoint" } else { "Radius" };
        let twisting = self.twisting.map_or(String::new(), |Rolling { k, damping, mu, .. }| {
            format!(", twisting: (k: {k:?}, damping: {}, friction: {mu:?})", damping.ron())
        });
        let adhesion = self.adhesion.map_or(String::new(), |adhesion| format!(", adhesion: {adhesion:?}"));
        format!("{head}, attraction: {}{tangential}{rolling}{twisting}{adhesion}, lever: {lever})", attraction(pulls))
    }

    /// Returns all numbers of the law with their names.
    pub fn numbers(&mut self) -> Vec<(&'static str, &mut f64)> {
        let mut all = match &mut self.normal {
            Normal::Assignment { k, b } => vec![("k", k), ("b", b)],
            Normal::Linear { k, damping, .. } => vec![("k", k), damping.number()],
            Normal::Hertz { restitution, .. } => vec![("e", restitution)],
            Normal::Jkr { restitution, work, .. } => vec![("e", restitution), ("w", work)],
        };
        match &mut self.friction {
            None => {}
            Some(Friction::Dashpot { damping, mu }) => all.extend([damping.number(), ("mu", mu)]),
            Some(Friction::Spring { k, damping, mu }) => all.extend([("k_t", k), damping.number(), ("mu", mu)]),
            Some(Friction::Mindlin { mu }) => all.push(("mu", mu)),
            Some(Friction::MindlinOfNormal { mu, share }) => all.extend([("mu", mu), ("share of c", share)]),
        }
        if let Some(Rolling { k, damping, mu, .. }) = &mut self.twisting {
            all.extend([("k_w", k), damping.number(), ("mu_w", mu)]);
        }
        match &mut self.adhesion {
            None => {}
            Some(Adhesion::Force(force)) => all.push(("pull", force)),
            Some(Adhesion::Dmt(work)) => all.push(("w", work)),
            Some(Adhesion::Area(density)) => all.push(("q", density)),
        }
        if let Some(Rolling { k, damping, mu, kind }) = &mut self.rolling {
            all.push(("mu_r", mu));
            if *kind != RollingKind::Torque {
                all.push(damping.number());
            }
            if *kind == RollingKind::Spring {
                all.push(("k_r", k));
            }
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
            Normal::Hertz { restitution, pulls } | Normal::Jkr { restitution, pulls, .. } => {
                damping_ratio(restitution, pulls)
            }
            _ => 0.0,
        };
        let normal = |m: Material| (1.0 - m.poisson * m.poisson) / m.young;
        let shear = |m: Material| (2.0 - m.poisson) * 2.0 * (1.0 + m.poisson) / m.young;
        let [a, b] = materials;
        Self { law, zeta, moduli: [1.0 / (normal(a) + normal(b)), 1.0 / (shear(a) + shear(b))] }
    }

    /// Returns the spring force at an overlap (m); zero across a gap.
    pub fn spring(&self, reduced: Reduced, overlap: f64) -> f64 {
        if let Normal::Jkr { work, .. } = self.law.normal {
            // Twice the pull-off force is counted with the pull.
            let modulus = self.moduli[0];
            let a = self.contact_radius(reduced, overlap);
            return 4.0 / 3.0 * modulus * a.powi(3) / reduced.radius - (8.0 * PI * work * modulus * a.powi(3)).sqrt()
                + 3.0 * PI * work * reduced.radius;
        }
        let overlap = overlap.max(0.0);
        match self.law.normal {
            Normal::Assignment { k, .. } | Normal::Linear { k, .. } => k * overlap,
            Normal::Hertz { .. } | Normal::Jkr { .. } => {
                4.0 / 3.0 * self.moduli[0] * (reduced.radius * overlap).sqrt() * overlap
            }
        }
    }

    /// Returns the contact radius of Johnson, Kendall and Roberts at an overlap (m), m, by bisection. The overlap grows with the
    /// radius from where the contact breaks on.
    fn contact_radius(&self, reduced: Reduced, overlap: f64) -> f64 {
        let Normal::Jkr { work, .. } = self.law.normal else { return (reduced.radius * overlap.max(0.0)).sqrt() };
        let of = |a: f64| a * a / reduced.radius - (2.0 * PI * work * a / self.moduli[0]).sqrt();
        let mut low = (PI * work * reduced.radius.powi(2) / (8.0 * self.moduli[0])).cbrt();
        if overlap + self.range(reduced) <= 0.0 {
            return low;
        }
        let mut high = 4.0 * low + 2.0 * (reduced.radius * overlap.max(0.0)).sqrt();
        for _ in 0..80 {
            let middle = 0.5 * (low + high);
            if of(middle) < overlap { low = middle } else { high = middle }
        }
        high
    }

    /// Returns the mean of spring and pull over the overlaps from `low` to `high`, m, N. Overlap and integral of the force are
    /// polynomials in the root q of the contact radius, so that q_high - q_low cancels in their quotient.
    pub fn mean_spring(&self, reduced: Reduced, [low, high]: [f64; 2]) -> f64 {
        let Normal::Jkr { work, .. } = self.law.normal else { return 0.0 };
        let modulus = self.moduli[0];
        let radius = reduced.radius;
        let [q, p] = [low, high].map(|overlap| self.contact_radius(reduced, overlap).sqrt());
        let slope = |power: i32| {
            let terms = (0..power).map(|of_p| p.powi(of_p) * q.powi(power - 1 - of_p));
            terms.sum::<f64>()
        };
        let energy = 8.0 / 15.0 * modulus * slope(10) / radius.powi(2)
            - 4.0 / 3.0 * (2.0 * PI * work * modulus).sqrt() * slope(7) / radius
            + PI * work * slope(4);
        energy / (slope(4) / radius - (2.0 * PI * work / modulus).sqrt())
    }

    /// Returns the range of a contact beyond touch, m.
    pub fn range(&self, reduced: Reduced) -> f64 {
        let Normal::Jkr { work, .. } = self.law.normal else { return 0.0 };
        3.0 * (PI * work * reduced.radius.powi(2) / (8.0 * self.moduli[0])).cbrt().powi(2) / reduced.radius
    }

    /// Whether contacts exist beyond touch.
    pub fn reaches(&self) -> bool {
        matches!(self.law.normal, Normal::Jkr { .. })
    }

    /// Returns the pull at an overlap (m), N. The part that acts from touch on acts in `share` of a step.
    pub fn pull(&self, reduced: Reduced, overlap: f64, share: f64) -> f64 {
        if let Normal::Jkr { work, .. } = self.law.normal {
            return share * 3.0 * PI * work * reduced.radius;
        }
        match self.law.adhesion {
            None => 0.0,
            Some(Adhesion::Force(force)) => share * force,
            Some(Adhesion::Dmt(work)) => share * work * 2.0 * PI * reduced.radius,
            Some(Adhesion::Area(density)) => density * 2.0 * PI * reduced.radius * overlap.max(0.0),
        }
    }

    /// Returns the damping coefficient c at an overlap, N s/m.
    pub fn drag(&self, reduced: Reduced, overlap: f64) -> f64 {
        let Reduced { mass, radius } = reduced;
        match self.law.normal {
            Normal::Assignment { b, .. } => b,
            Normal::Linear { k, damping: Damping::Restitution(_), .. } => 2.0 * self.zeta * (k * mass).sqrt(),
            Normal::Linear { damping, .. } => damping.drag(mass, 0.0),
            Normal::Hertz { .. } | Normal::Jkr { .. } => {
                let a = if self.reaches() {
                    self.contact_radius(reduced, overlap)
                } else {
                    (radius * overlap.max(0.0)).sqrt()
                };
                let stiffness = 2.0 * self.moduli[0] * a;
                2.0 * (5.0f64 / 6.0).sqrt() * self.zeta * (stiffness * mass).sqrt()
            }
        }
    }

    /// Returns the smallest allowed normal force, N.
    pub fn floor(&self) -> f64 {
        match self.law.normal {
            Normal::Linear { pulls: false, .. }
            | Normal::Hertz { pulls: false, .. }
            | Normal::Jkr { pulls: false, .. } => 0.0,
            _ => f64::NEG_INFINITY,
        }
    }

    /// Returns k_t, c_t and mu at an overlap and a normal damping coefficient; `None` without friction.
    pub fn tangential(&self, reduced: Reduced, overlap: f64, normal_drag: f64) -> Option<[f64; 3]> {
        Some(match self.law.friction? {
            Friction::Dashpot { damping, mu } => [0.0, damping.drag(reduced.mass, normal_drag), mu],
            Friction::Spring { k, damping, mu } => [k, damping.drag(reduced.mass, normal_drag), mu],
            Friction::Mindlin { mu } => {
                let k = 8.0 * self.moduli[1] * self.contact_radius(reduced, overlap);
                [k, 2.0 * (5.0f64 / 6.0).sqrt() * self.zeta * (k * reduced.mass).sqrt(), mu]
            }
            Friction::MindlinOfNormal { mu, share } => {
                let k = 8.0 * self.moduli[1] * self.contact_radius(reduced, overlap);
                [k, share * self.drag(reduced, overlap), mu]
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
            Some(Friction::MindlinOfNormal { share, .. }) => normal.map(|mean| mean * share),
            Some(Friction::Mindlin { .. }) => normal.map(|mean| mean * (4.0 * self.moduli[1] / self.moduli[0]).sqrt()),
        }
    }

    /// Returns k and c of rolling resistance in a step of `dt` (s), at a tangential stiffness (N/m).
    pub fn rolling(&self, reduced: Reduced, tangential: f64, dt: f64) -> [f64; 2] {
        let Some(Rolling { k, damping, kind, .. }) = self.law.rolling else { return [0.0; 2] };
        match kind {
            RollingKind::Spring => [k, damping.drag(reduced.mass, 0.0)],
            RollingKind::Elastic => [tangential, damping.drag(reduced.mass, 0.0)],
            RollingKind::Torque => [0.0, 0.05 * reduced.mass / dt],
        }
    }

    /// Whether the tangential stiffness changes while a contact lasts.
    pub fn stiffness_varies(&self) -> bool {
        matches!(self.law.friction, Some(Friction::Mindlin { .. } | Friction::MindlinOfNormal { .. }))
    }

    /// Whether the tangential force has a memory.
    pub fn has_spring(&self) -> bool {
        matches!(self.law.friction, Some(Friction::Spring { .. })) || self.stiffness_varies()
    }
}

/// Returns the damping ratio below 1 with restitution `e`, by bisection (e falls with the ratio).
fn damping_ratio(e: f64, pulls: bool) -> f64 {
    let restitution = |zeta: f64| {
        let frequency = (1.0 - zeta * zeta).sqrt();
        let angle = if pulls { PI } else { PI - (2.0 * zeta * frequency).atan2(frequency * frequency - zeta * zeta) };
        (-zeta / frequency * angle).exp()
    };
    let mut low = 0.0;
    let mut high = 1.0;
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if restitution(middle) > e { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}
