//! The law of a scene as a type: the only place that selects the laws for which the force pass is compiled.

use std::sync::Arc;

use crate::contact::adhesion::{Adhesion, Adhesive};
use crate::contact::assignment::Assignment;
use crate::contact::batch_law::AnyLaw;
use crate::contact::composite::{Composite, Normal};
use crate::contact::config::{Contact, Friction, HertzFriction, PairOfSpecies};
use crate::contact::hertz::{Hertz, Material, Mindlin, MindlinDamping};
use crate::contact::jkr::{Jkr, JkrFriction};
use crate::contact::law::{LawRequirements, PairLaw};
use crate::contact::linear::LinearNormal;
use crate::contact::rolling::{AnyRolling, NoRolling, RollingResistance};
use crate::contact::table::PairTable;
use crate::contact::tangential::{ConstantStiffness, Dashpot, Lever, NoFriction, SpringSlider};
use crate::space::{Plane, Space};

/// The contact laws of a scene, checked by the rules of the scene.
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
pub trait LawReceiver<V: Space> {
    /// The result.
    type Output;

    /// Receives the law.
    fn receive<L: PairLaw<V> + LawRequirements>(self, law: L) -> Self::Output;
}

struct Erase;

impl<V: Space> LawReceiver<V> for Erase {
    type Output = AnyLaw<V>;

    fn receive<L: PairLaw<V> + LawRequirements>(self, law: L) -> AnyLaw<V> {
        AnyLaw(Arc::new(law))
    }
}

/// Holds because the rules of the scene reject scenes with different kinds.
const SAME_KIND: &str = "all pairs have the same kind of law";

impl Contacts<'_> {
    /// Passes the law of the scene to `receiver`. This is the only place that selects the laws for which the force pass is compiled.
    pub fn pass_to<V: Space, R: LawReceiver<V>>(&self, receiver: R) -> R::Output {
        match self.usual {
            Contact::Assignment { .. } => receiver.receive(self.table(|a, b| self.assignment(a, b))),
            Contact::Linear { .. } if self.usual.is_general() => {
                receiver.receive(self.table(|a, b| self.general_linear(a, b)))
            }
            Contact::Hertz { adhesion: Some(Adhesion::Jkr(_)), .. } => {
                receiver.receive(self.table(|a, b| self.jkr(a, b)))
            }
            Contact::Hertz { .. } if self.usual.is_general() => {
                receiver.receive(self.table(|a, b| self.general_hertz(a, b)))
            }
            Contact::Linear { tangential: None, .. } => {
                receiver.receive(self.table(|a, b| frictionless(self.linear(a, b).normal)))
            }
            Contact::Linear { tangential: Some(Friction::Dashpot { .. }), .. } => {
                receiver.receive(self.table(|a, b| self.dashpot(a, b)))
            }
            Contact::Linear { rolling: None, .. } => {
                receiver.receive(self.table(|a, b| self.spring_friction(a, b, NoRolling)))
            }
            Contact::Linear { .. } => {
                receiver.receive(self.table(|a, b| self.spring_friction(a, b, self.rolling(a, b))))
            }
            Contact::Hertz { tangential: None, .. } => {
                receiver.receive(self.table(|a, b| frictionless(self.hertz(a, b))))
            }
            Contact::Hertz { rolling: None, .. } => receiver.receive(self.table(|a, b| self.mindlin(a, b, NoRolling))),
            Contact::Hertz { .. } => receiver.receive(self.table(|a, b| self.mindlin(a, b, self.rolling(a, b)))),
        }
    }

    /// Returns the law as a trait object, for estimates before a run, which are the same in both spaces.
    #[must_use]
    pub fn any(&self) -> AnyLaw<Plane> {
        self.pass_to(Erase)
    }

    /// Returns the law of a single species pair, as [`Self::any`] does.
    #[must_use]
    pub fn between(&self, a: u8, b: u8) -> AnyLaw<Plane> {
        Self { usual: self.contact_of(a, b), pairs: &[], species: 1, only: Some((a, b)), ..*self }.any()
    }

    fn table<L>(&self, of: impl Fn(u8, u8) -> L) -> PairTable<L> {
        match self.only {
            Some((a, b)) => PairTable::new(1, |_, _| of(a, b)),
            None => PairTable::new(self.species, of),
        }
    }

    /// Returns the scene's law for a species pair.
    #[must_use]
    pub fn contact_of(&self, a: u8, b: u8) -> Contact {
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
        self.any().0.largest_range(reduced_radius)
    }

    /// Returns the materials of two species.
    #[must_use]
    pub fn materials(&self, a: u8, b: u8) -> [Material; 2] {
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
            Some(MindlinDamping::OfNormal(share)) => usual.with_dashpot_share(share.get()),
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
