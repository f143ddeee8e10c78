//! The scene keys `contact` and `pairs`.

use serde::{Deserialize, Serialize};

use crate::contact::adhesion::Adhesion;
use crate::contact::damping::{Attraction, Damping};
use crate::contact::hertz::MindlinDamping;
use crate::contact::rolling::{RollingKeys, RollingKind};
use crate::contact::tangential::{Lever, TangentialDamping};
use crate::contact::twisting::TwistingKeys;
use crate::values::{NonNegative, Positive, Restitution};

/// The scene's `contact`: the law between grains, and between grains and walls.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Contact {
    /// The law of the assignment, [`Assignment`](crate::contact::assignment::Assignment): k delta n - b (v_i - v_j).
    Assignment {
        /// Spring stiffness k, N/m.
        k: Positive,
        /// Drag b on the full relative velocity, N s/m.
        b: NonNegative,
    },
    /// The linear spring-dashpot along the normal, [`LinearNormal`](crate::contact::linear::LinearNormal), (k delta - c v_n) n, with optional
    /// friction.
    Linear {
        /// Spring stiffness k_n, N/m.
        k: Positive,
        /// Damping of the normal velocity.
        damping: Damping,
        /// Whether the normal force may pull.
        #[serde(default)]
        attraction: Attraction,
        /// Friction; without it grains do not spin.
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
    /// Hertz's law, [`Hertz`](crate::contact::hertz::Hertz), between the scene's `materials`.
    Hertz {
        /// Restitution e, the same at every speed.
        restitution: Restitution,
        /// Whether the normal force may pull.
        #[serde(default)]
        attraction: Attraction,
        /// Friction; without it grains do not spin.
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
    /// A dashpot without memory, capped at mu |F_n|: [`Dashpot`](crate::contact::tangential::Dashpot).
    Dashpot {
        /// Damping of the sliding velocity.
        damping: TangentialDamping,
        /// Coefficient of friction mu, dimensionless.
        friction: NonNegative,
    },
    /// A spring with memory and a dashpot, capped at mu |F_n|: [`SpringSlider`](crate::contact::tangential::SpringSlider).
    Spring {
        /// Stiffness k_t, N/m.
        k: Positive,
        /// Damping of the sliding velocity.
        damping: TangentialDamping,
        /// Coefficient of friction mu, dimensionless.
        friction: NonNegative,
    },
}

/// The tangential term of Hertz's law.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum HertzFriction {
    /// Mindlin's no-slip stiffness, capped at mu |F_n|: [`Mindlin`](crate::contact::hertz::Mindlin).
    Mindlin {
        /// Coefficient of friction mu, dimensionless.
        friction: NonNegative,
        /// Tangential damping. Default: the damping ratio of the normal force.
        #[serde(skip_serializing_if = "Option::is_none")]
        damping: Option<MindlinDamping>,
    },
}

/// One of the scene's `pairs`: the law parameters of a species pair.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct PairOfSpecies {
    /// The two species, of which both may be the same.
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

    /// Returns whether the law needs a term whose kind is a number ([`AnyRolling`](crate::contact::rolling::AnyRolling)) or adhesion. The force
    /// pass is compiled once for all such linear laws, and once for all such laws of Hertz.
    pub(super) fn is_general(&self) -> bool {
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
