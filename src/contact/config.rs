//! The contact section of a scene, and the only place where it selects the law that the kernel is compiled for.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::contact::adhesion::{Adhesion, Adhesive};
use crate::contact::assignment::Assignment;
use crate::contact::composite::{Composite, Normal};
use crate::contact::damping::{Attraction, Damping};
use crate::contact::hertz::{Hertz, Material, Mindlin, MindlinDamping};
use crate::contact::jkr::{Jkr, JkrFriction};
use crate::contact::linear::LinearNormal;
use crate::contact::rolling::{AnyRolling, NoRolling, RollingKeys, RollingKind, RollingResistance};
use crate::contact::table::PairTable;
use crate::contact::tangential::{ConstantStiffness, Dashpot, Lever, NoFriction, SpringSlider, TangentialDamping};
use crate::contact::twisting::TwistingKeys;
use crate::contact::{AnyLaw, LawRequirements, PairLaw};
use crate::space::{Plane, Space};
use crate::values::{NonNegative, Positive, Restitution};

/// The scene's `contact`: the law between grains, and between grains and walls.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Contact {
    /// The law of the assignment, [`Assignment`].
    Assignment {
        /// Spring stiffness k, N/m.
        k: Positive,
        /// Drag b on the full relative velocity, N s/m.
        b: NonNegative,
    },
    /// The linear spring-dashpot along the normal, [`LinearNormal`], with optional friction.
    Linear {
        /// Spring stiffness k_n, N/m.
        k: Positive,
        /// Damping of the normal velocity.
        damping: Damping,
        /// Whether the normal force may pull.
        #[serde(default)]
        attraction: Attraction,
        /// Friction. Without it, the default, grains do not spin.
        tangential: Option<Friction>,
        /// Rolling resistance; only together with `Spring` friction.
        rolling: Option<RollingKeys>,
        /// Point at which friction acts.
        #[serde(default)]
        lever: Lever,
        /// Adhesion; only together with friction with memory.
        #[serde(skip_serializing_if = "Option::is_none")]
        adhesion: Option<Adhesion>,
        /// Twisting resistance; only in solid space, together with friction with memory.
        #[serde(skip_serializing_if = "Option::is_none")]
        twisting: Option<TwistingKeys>,
    },
    /// Hertz's law, [`Hertz`], between the scene's `materials`.
    Hertz {
        /// Restitution e, the same at every speed.
        restitution: Restitution,
        /// Whether the normal force may pull.
        #[serde(default)]
        attraction: Attraction,
        /// Friction. Without it, the default, grains do not spin.
        tangential: Option<HertzFriction>,
        /// Rolling resistance; only together with friction.
        rolling: Option<RollingKeys>,
        /// Point at which friction acts.
        #[serde(default)]
        lever: Lever,
        /// Adhesion; only together with friction with memory.
        #[serde(skip_serializing_if = "Option::is_none")]
        adhesion: Option<Adhesion>,
        /// Twisting resistance; only in solid space, together with friction with memory.
        #[serde(skip_serializing_if = "Option::is_none")]
        twisting: Option<TwistingKeys>,
    },
}

/// The tangential term of the linear law.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Friction {
    /// A dashpot without memory, capped at mu |F_n|: [`Dashpot`].
    Dashpot {
        /// Damping of the sliding velocity.
        damping: TangentialDamping,
        /// Coefficient mu.
        friction: NonNegative,
    },
    /// A spring with memory and a dashpot, capped at mu |F_n|: [`SpringSlider`].
    Spring {
        /// Stiffness k_t, N/m.
        k: Positive,
        /// Damping of the sliding velocity.
        damping: TangentialDamping,
        /// Coefficient mu.
        friction: NonNegative,
    },
}

/// The tangential term of Hertz's law.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum HertzFriction {
    /// Mindlin's no-slip stiffness, capped at mu |F_n|: [`Mindlin`].
    Mindlin {
        /// Coefficient mu.
        friction: NonNegative,
        /// Tangential damping. By default, the damping ratio of the normal force.
        #[serde(skip_serializing_if = "Option::is_none")]
        damping: Option<MindlinDamping>,
    },
}

/// One of the scene's `pairs`: the law parameters of a species pair.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct PairOfSpecies {
    /// The two species.
    pub species: (u8, u8),
    /// The law between the two species, of the same kind as `contact`.
    pub contact: Contact,
}

impl Contact {
    /// Returns the kind of the law: its terms. The laws of all species pairs must be of the same kind.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Assignment { .. } => "Assignment",
            Self::Linear { adhesion: Some(_), .. } => "Linear with adhesion",
            Self::Hertz { adhesion: Some(Adhesion::Jkr(_)), .. } => "Hertz with adhesion beyond touch",
            Self::Hertz { adhesion: Some(_), .. } => "Hertz with adhesion",
            Self::Linear { .. } if self.is_general() => {
                "Linear with twisting, or rolling of the kind Elastic or Torque"
            }
            Self::Hertz { .. } if self.is_general() => "Hertz with twisting, or rolling of the kind Elastic or Torque",
            Self::Linear { tangential: None, .. } => "Linear",
            Self::Linear { tangential: Some(Friction::Dashpot { .. }), .. } => "Linear with Dashpot",
            Self::Linear { tangential: Some(_), rolling: None, .. } => "Linear with Spring",
            Self::Linear { .. } => "Linear with Spring and rolling",
            Self::Hertz { tangential: None, .. } => "Hertz",
            Self::Hertz { rolling: None, .. } => "Hertz with Mindlin",
            Self::Hertz { .. } => "Hertz with Mindlin and rolling",
        }
    }

    /// Returns the twisting resistance.
    #[must_use]
    pub fn twisting(&self) -> Option<TwistingKeys> {
        let (Self::Linear { twisting, .. } | Self::Hertz { twisting, .. }) = self else { return None };
        *twisting
    }

    /// Returns the rolling resistance.
    #[must_use]
    pub fn rolling(&self) -> Option<RollingKeys> {
        let (Self::Linear { rolling, .. } | Self::Hertz { rolling, .. }) = self else { return None };
        *rolling
    }

    /// Returns the adhesion.
    #[must_use]
    pub fn adhesion(&self) -> Option<Adhesion> {
        let (Self::Linear { adhesion, .. } | Self::Hertz { adhesion, .. }) = self else { return None };
        *adhesion
    }

    /// Returns whether the law has a term whose kind is a number of the kernel: one kernel serves all such linear laws, and one
    /// all such laws of Hertz.
    fn is_general(&self) -> bool {
        self.adhesion().is_some()
            || self.twisting().is_some()
            || self.rolling().is_some_and(|rolling| rolling.kind != RollingKind::Spring)
    }

    /// Returns whether the forces depend on positions alone. The centred scheme then changes nothing.
    #[must_use]
    pub fn is_elastic(&self) -> bool {
        match self {
            Self::Assignment { b, .. } => b.get() <= 0.0,
            Self::Linear { damping, tangential: None, .. } => match damping {
                Damping::B(b) | Damping::PerMass(b) => b.get() <= 0.0,
                Damping::Restitution(e) => e.get() >= 1.0,
            },
            Self::Hertz { restitution, tangential: None, .. } => restitution.get() >= 1.0,
            Self::Linear { .. } | Self::Hertz { .. } => false,
        }
    }

    /// Returns whether grains spin under this law.
    #[must_use]
    pub fn spins(&self) -> bool {
        matches!(self, Self::Linear { tangential: Some(_), .. } | Self::Hertz { tangential: Some(_), .. })
    }
}

/// The contact laws of a scene, checked by [`crate::scene::rules`].
#[derive(Clone, Copy, Debug)]
pub struct Contacts<'a> {
    /// The scene's `contact`: the law of every species pair without an entry in `pairs`.
    pub usual: Contact,
    /// The scene's `pairs`.
    pub pairs: &'a [PairOfSpecies],
    /// The scene's `materials`.
    pub materials: &'a [Material],
    /// Number of species.
    pub species: usize,
    /// If set, the law is built for this species pair alone.
    pub only: Option<(u8, u8)>,
}

/// Receives the law of a scene with its concrete type.
pub trait LawVisitor<V: Space> {
    /// The result of the visit.
    type Output;

    /// Receives the law.
    fn take<L: PairLaw<V> + LawRequirements>(self, law: L) -> Self::Output;
}

struct Erase;

impl<V: Space> LawVisitor<V> for Erase {
    type Output = AnyLaw<V>;

    fn take<L: PairLaw<V> + LawRequirements>(self, law: L) -> AnyLaw<V> {
        AnyLaw(Arc::new(law))
    }
}

/// Holds because [`crate::scene::rules`] rejects scenes with different kinds.
const SAME_KIND: &str = "all pairs have the same kind of law";

impl Contacts<'_> {
    /// Passes the law of the scene to `visitor`. This is the only place that selects the law types of compiled kernels.
    pub fn visit<V: Space, R: LawVisitor<V>>(&self, visitor: R) -> R::Output {
        match self.usual {
            // A single species needs no table.
            Contact::Assignment { k, b } if self.species == 1 => visitor.take(Assignment::new(k, b)),
            Contact::Assignment { .. } => visitor.take(self.table(|a, b| self.assignment(a, b))),
            Contact::Linear { .. } if self.usual.is_general() => {
                visitor.take(self.table(|a, b| self.general_linear(a, b)))
            }
            Contact::Hertz { adhesion: Some(Adhesion::Jkr(_)), .. } => visitor.take(self.table(|a, b| self.jkr(a, b))),
            Contact::Hertz { .. } if self.usual.is_general() => {
                visitor.take(self.table(|a, b| self.general_hertz(a, b)))
            }
            Contact::Linear { tangential: None, .. } if self.species == 1 => {
                visitor.take(frictionless(self.linear(0, 0).normal))
            }
            Contact::Linear { tangential: None, .. } => {
                visitor.take(self.table(|a, b| frictionless(self.linear(a, b).normal)))
            }
            Contact::Linear { tangential: Some(Friction::Dashpot { .. }), .. } => {
                visitor.take(self.table(|a, b| self.dashpot(a, b)))
            }
            Contact::Linear { rolling: None, .. } if self.species == 1 => {
                visitor.take(self.spring_friction(0, 0, NoRolling))
            }
            Contact::Linear { rolling: None, .. } => {
                visitor.take(self.table(|a, b| self.spring_friction(a, b, NoRolling)))
            }
            Contact::Linear { .. } => visitor.take(self.table(|a, b| self.spring_friction(a, b, self.rolling(a, b)))),
            Contact::Hertz { tangential: None, .. } => visitor.take(self.table(|a, b| frictionless(self.hertz(a, b)))),
            Contact::Hertz { rolling: None, .. } => visitor.take(self.table(|a, b| self.mindlin(a, b, NoRolling))),
            Contact::Hertz { .. } => visitor.take(self.table(|a, b| self.mindlin(a, b, self.rolling(a, b)))),
        }
    }

    /// Returns the law as a trait object, for code that is not performance-critical.
    #[must_use]
    pub fn any<V: Space>(&self) -> AnyLaw<V> {
        self.visit(Erase)
    }

    /// Returns the law of a single species pair.
    #[must_use]
    pub fn between<V: Space>(&self, a: u8, b: u8) -> AnyLaw<V> {
        Self { usual: self.contact_of(a, b), pairs: &[], species: 1, only: Some((a, b)), ..*self }.any()
    }

    fn table<L>(&self, of: impl Fn(u8, u8) -> L) -> PairTable<L> {
        match self.only {
            Some((a, b)) => PairTable::new(1, |_, _| of(a, b)),
            None => PairTable::new(self.species, of),
        }
    }

    /// Returns the scene's law for a species pair.
    pub(crate) fn contact_of(&self, a: u8, b: u8) -> Contact {
        let named = self.pairs.iter().find(|pair| pair.species == (a, b) || pair.species == (b, a));
        named.map_or(self.usual, |pair| pair.contact)
    }

    fn assignment(&self, a: u8, b: u8) -> Assignment {
        let Contact::Assignment { k, b } = self.contact_of(a, b) else { unreachable!("{SAME_KIND}") };
        Assignment::new(k, b)
    }

    fn linear(&self, a: u8, b: u8) -> LinearTerms {
        let Contact::Linear { k, damping, attraction, tangential, lever, .. } = self.contact_of(a, b) else {
            unreachable!("{SAME_KIND}")
        };
        LinearTerms { normal: LinearNormal::new(k, damping, attraction), tangential, lever }
    }

    fn dashpot(&self, a: u8, b: u8) -> Composite<LinearNormal, Dashpot, NoRolling> {
        let LinearTerms { normal, tangential: Some(Friction::Dashpot { damping, friction }), lever } =
            self.linear(a, b)
        else {
            unreachable!("{SAME_KIND}")
        };
        Composite {
            normal,
            tangential: Dashpot { damping: damping.into(), friction: friction.get(), lever },
            rolling: NoRolling,
        }
    }

    fn spring_friction<R>(
        &self,
        a: u8,
        b: u8,
        rolling: R,
    ) -> Composite<LinearNormal, SpringSlider<ConstantStiffness>, R> {
        let LinearTerms { normal, tangential: Some(Friction::Spring { k, damping, friction }), lever } =
            self.linear(a, b)
        else {
            unreachable!("{SAME_KIND}")
        };
        let modulus = ConstantStiffness { k: k.get(), damping: damping.into() };
        Composite { normal, tangential: SpringSlider { modulus, friction: friction.get(), lever }, rolling }
    }

    fn rolling(&self, a: u8, b: u8) -> RollingResistance {
        self.contact_of(a, b)
            .rolling()
            .and_then(|rolling| rolling.spring())
            .unwrap_or_else(|| unreachable!("{SAME_KIND}"))
    }

    fn general_rolling(&self, a: u8, b: u8, tangential: Option<f64>, fades: bool) -> AnyRolling {
        let contact = self.contact_of(a, b);
        AnyRolling::new(contact.rolling(), contact.twisting(), tangential, fades)
    }

    fn general_linear(
        &self,
        a: u8,
        b: u8,
    ) -> Composite<Adhesive<LinearNormal>, SpringSlider<ConstantStiffness>, AnyRolling> {
        let Composite { normal, tangential, .. } = self.spring_friction(a, b, NoRolling);
        let rolling = self.general_rolling(a, b, Some(tangential.modulus.k), true);
        Composite { normal: Adhesive::new(normal, self.contact_of(a, b).adhesion()), tangential, rolling }
    }

    fn general_hertz(&self, a: u8, b: u8) -> Composite<Adhesive<Hertz>, SpringSlider<Mindlin>, AnyRolling> {
        let Composite { normal, tangential, .. } = self.mindlin(a, b, NoRolling);
        let rolling = self.general_rolling(a, b, None, true);
        Composite { normal: Adhesive::new(normal, self.contact_of(a, b).adhesion()), tangential, rolling }
    }

    fn jkr(&self, a: u8, b: u8) -> Composite<Jkr, SpringSlider<JkrFriction>, AnyRolling> {
        let Contact::Hertz {
            restitution,
            attraction,
            tangential: Some(HertzFriction::Mindlin { friction, damping }),
            adhesion: Some(Adhesion::Jkr(work)),
            lever,
            ..
        } = self.contact_of(a, b)
        else {
            unreachable!("{SAME_KIND}")
        };
        let materials = self.materials(a, b);
        let normal = Jkr::new(materials, restitution, attraction, work);
        let share = damping.map(|MindlinDamping::OfNormal(share)| share.get());
        let tangential =
            SpringSlider { modulus: JkrFriction::new(materials, normal, share), friction: friction.get(), lever };
        Composite { normal, tangential, rolling: self.general_rolling(a, b, None, false) }
    }

    /// Returns the largest range of a contact beyond touch at a reduced radius (m), m.
    #[must_use]
    pub fn range(&self, reduced_radius: f64) -> f64 {
        self.any::<Plane>().0.range_at(reduced_radius)
    }

    pub(crate) fn materials(&self, a: u8, b: u8) -> [Material; 2] {
        [a, b].map(|species| self.materials[usize::from(species).min(self.materials.len() - 1)])
    }

    fn hertz(&self, a: u8, b: u8) -> Hertz {
        let Contact::Hertz { restitution, attraction, .. } = self.contact_of(a, b) else { unreachable!("{SAME_KIND}") };
        Hertz::new(self.materials(a, b), restitution, attraction)
    }

    fn mindlin<R>(&self, a: u8, b: u8, rolling: R) -> Composite<Hertz, SpringSlider<Mindlin>, R> {
        let Contact::Hertz { tangential: Some(HertzFriction::Mindlin { friction, damping }), lever, .. } =
            self.contact_of(a, b)
        else {
            unreachable!("{SAME_KIND}")
        };
        let normal = self.hertz(a, b);
        let usual = Mindlin::new(self.materials(a, b), normal);
        let modulus = match damping {
            None => usual,
            Some(MindlinDamping::OfNormal(share)) => usual.with_drag_share(share.get()),
        };
        Composite { normal, tangential: SpringSlider { modulus, friction: friction.get(), lever }, rolling }
    }
}

/// The parameters of the linear law for one species pair.
struct LinearTerms {
    normal: LinearNormal,
    tangential: Option<Friction>,
    lever: Lever,
}

fn frictionless<N: Normal>(normal: N) -> Composite<N, NoFriction, NoRolling> {
    Composite { normal, tangential: NoFriction, rolling: NoRolling }
}
