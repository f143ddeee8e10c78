//! Contact laws in the words of LAMMPS: `pair_style` and the law of `fix wall/gran/region`.
//!
//! | siloflow | LAMMPS |
//! |---|---|
//! | `Linear`, damping and friction `PerMass`, no rolling, one law for all pairs | `gran/hooke`, with springs `gran/hooke/history` |
//! | other `Linear` | `granular` with `hooke k` |
//! | `Assignment` | `granular` with `hooke k`, drag on the whole velocity, grains that do not turn |
//! | `Hertz` | `granular` with `hertz k`, k = 4/3 E* |
//! | damping `B`, `PerMass` | `damping velocity`, `damping mass_velocity` |
//! | damping `Restitution`, and `Hertz` | `damping tsuji`: c = a(e) sqrt(k m_eff), with the e that gives our c |
//! | friction `Dashpot`, `Spring`, `Mindlin` | `linear_nohistory`, `linear_history`, `mindlin_rescale/force` with k_t = 8 G* |
//! | `rolling` | `rolling sds` |
//! | attraction `Forbidden` | `limit_damping` |
//! | `adhesion`, `twisting`, `rolling` of other kinds than `Spring` | refused |
//!
//! In LAMMPS, c_t is a share of the normal c, and a(e) is the polynomial of Tsuji, Tanaka and Ishida (Powder Technology 71, 239, 1992).
//! The file `laws/tsuji.rs` inverts it, so that c is equal to round-off for every pair of masses. `mindlin_rescale/force` treats a changing stiffness as
//! [`Mindlin`](siloflow_dem::contact::hertz::Mindlin) does: a stiffening spring keeps its force, a softening one its displacement.
//!
//! Limits: `pair granular` lets friction turn two grains with the arm R - delta/2 and computes the sliding velocity with R; the classic
//! styles and walls use R in both places. Source: LAMMPS 29 Sep 2021 and 22 Jul 2025, measured.

mod tsuji;

use std::fmt::Write as _;

use crate::lammps::laws::tsuji::tsuji;
use crate::lammps::quantities::all_grains;
use crate::lammps::{number, refused};
use crate::scene::loaded::Loaded;
use siloflow_dem::contact::config::{Contact, Friction, HertzFriction};
use siloflow_dem::contact::damping::{Attraction, Damping};
use siloflow_dem::contact::hertz::Material;
use siloflow_dem::contact::hertz::MindlinDamping;
use siloflow_dem::contact::rolling::{RollingDamping, RollingKeys};
use siloflow_dem::contact::tangential::{Lever, TangentialDamping};
use siloflow_text::fault::Fault;

/// Friction coefficient of the drag in the assignment's law, which has no cap.
const NO_CAP: f64 = 1e30;

/// A law as LAMMPS knows it.
#[derive(Clone, Debug, PartialEq)]
struct Model {
    /// Normal force, such as `hooke 1e5`.
    normal: String,
    /// Coefficient of the damping model.
    damping: f64,
    /// Damping model.
    drag_kind: &'static str,
    /// Tangential force, such as `linear_history 3e4 0.5 0.4`.
    tangential: String,
    /// Rolling resistance with the word before it, or nothing.
    rolling: String,
    /// `limit_damping` with a space before it, or nothing.
    limit: &'static str,
}

impl Model {
    /// The law as arguments of `pair_coeff` and of `fix wall/gran/region granular`.
    fn words(&self) -> String {
        let Self { normal, damping, drag_kind, tangential, rolling, limit } = self;
        format!("{normal} {} tangential {tangential}{rolling} damping {drag_kind}{limit}", number(*damping))
    }
}

/// The laws of a scene.
#[derive(Debug)]
pub(super) struct Laws {
    /// `pair_style` and `pair_coeff`.
    pub lines: String,
    /// Law of each species of grains with each species of walls, as arguments of `fix wall/gran/region`.
    walls: Vec<Vec<String>>,
    /// Whether the pair style lets friction act at R - delta/2.
    pub shortens_arm: bool,
    /// Whether friction has springs.
    pub has_springs: bool,
}

impl Laws {
    /// The law between grains of a species and walls of another.
    pub(super) fn wall(&self, grain: usize, wall: u8) -> &str {
        let row = &self.walls[grain.min(self.walls.len() - 1)];
        &row[usize::from(wall).min(row.len() - 1)]
    }

    /// Number of species with laws of their own.
    pub(super) fn species(&self) -> usize {
        self.walls.len()
    }
}

/// Translates the laws of a scene.
///
/// # Errors
/// If a term has no counterpart.
pub(super) fn laws(loaded: &Loaded) -> Result<Laws, Fault> {
    let contacts = loaded.contacts();
    let species = contacts.species;
    let masses = Masses::of(loaded);
    let mut lines = String::new();
    let mut walls = vec![Vec::new(); species];
    let usual = contacts.usual;
    let classic = if species == 1 { classic(&usual) } else { None };
    let shortens_arm = classic.is_none() && usual.spins();
    match &classic {
        Some(style) => {
            let _ = writeln!(lines, "pair_style {style}\npair_coeff * *");
        }
        None => lines.push_str("pair_style granular\n"),
    }
    for (a, row) in walls.iter_mut().enumerate() {
        for b in 0..species {
            let pair = [a, b].map(|species| u8::try_from(species).unwrap_or(u8::MAX));
            let contact = contacts.contact_of(pair[0], pair[1]);
            let key = key_of(loaded, pair);
            let materials = (!contacts.materials.is_empty()).then(|| contacts.materials(pair[0], pair[1]));
            let of = |masses: Option<f64>| model(loaded, &contact, materials, &key, masses);
            row.push(format!("granular {}", of(masses.alone)?.words()));
            if classic.is_none() && a <= b {
                let types = if species == 1 { "* *".to_owned() } else { format!("{} {}", a + 1, b + 1) };
                let _ = writeln!(lines, "pair_coeff {types} {}", of(masses.of_pair())?.words());
            }
        }
    }
    let has_springs = matches!(usual, Contact::Linear { tangential: Some(Friction::Spring { .. }), .. })
        || matches!(usual, Contact::Hertz { tangential: Some(_), .. });
    Ok(Laws { lines, walls, shortens_arm, has_springs })
}

/// The key of the law between two species.
fn key_of(loaded: &Loaded, [a, b]: [u8; 2]) -> String {
    let named = loaded.scene.pairs.iter().position(|pair| pair.species == (a, b) || pair.species == (b, a));
    named.map_or_else(|| "contact".to_owned(), |number| format!("pairs[{number}].contact"))
}

/// The mass of the grains, if all are equal.
struct Masses {
    alone: Option<f64>,
    has_fixed: bool,
}

impl Masses {
    fn of(loaded: &Loaded) -> Self {
        let mut masses = all_grains(loaded).map(|grain| grain.mass);
        let first = masses.next();
        // Masses that differ by rounding are equal.
        let alone = first.filter(|first| masses.all(|mass| (mass / first - 1.0).abs() < 1e-12));
        let has_fixed = !loaded.fixed.is_empty() || loaded.fixed_radii().next().is_some();
        Self { alone, has_fixed }
    }

    /// The effective mass of two grains, if it is the same in every contact of grains, fixed ones included.
    fn of_pair(&self) -> Option<f64> {
        self.alone.filter(|_| !self.has_fixed).map(|mass| 0.5 * mass)
    }
}

/// The classic style of a law, which is equal to siloflow's in all terms, if there is one.
fn classic(contact: &Contact) -> Option<String> {
    let &Contact::Linear {
        k,
        damping: Damping::PerMass(normal),
        attraction,
        tangential: Some(friction),
        rolling: None,
        ..
    } = contact
    else {
        return None;
    };
    let per_mass = |damping: TangentialDamping| match damping {
        TangentialDamping::PerMass(gamma) => Some(gamma.get()),
        TangentialDamping::OfNormal(share) => Some(share.get() * normal.get()),
        TangentialDamping::B(b) => (b.get() <= 0.0).then_some(0.0),
    };
    let (style, stiffness, damping, friction) = match friction {
        Friction::Dashpot { damping, friction } => ("gran/hooke", 0.0, damping, friction),
        Friction::Spring { k, damping, friction } => ("gran/hooke/history", k.get(), damping, friction),
    };
    let [k, stiffness, normal, damping, friction] =
        [k.get(), stiffness, normal.get(), per_mass(damping)?, friction.get()].map(number);
    Some(format!("{style} {k} {stiffness} {normal} {damping} {friction} 1{}", limit(attraction)))
}

fn limit(attraction: Attraction) -> &'static str {
    match attraction {
        Attraction::Allowed => "",
        Attraction::Forbidden => " limit_damping",
    }
}

/// Translates one law. `mass` is the effective mass of every contact that it is for, if that is one number.
fn model(
    loaded: &Loaded,
    contact: &Contact,
    materials: Option<[Material; 2]>,
    key: &str,
    mass: Option<f64>,
) -> Result<Model, Fault> {
    let refuse = |term: &str, why: &str, help: &str| Err(refused(loaded, &format!("{key}.{term}"), why).help(help));
    match *contact {
        Contact::Linear { twisting: Some(_), .. } => refuse("Linear.twisting", TWISTING, TWISTING_HELP),
        Contact::Hertz { twisting: Some(_), .. } => refuse("Hertz.twisting", TWISTING, TWISTING_HELP),
        Contact::Linear { adhesion: Some(_), .. } => refuse("Linear.adhesion", ADHESION, ADHESION_HELP),
        Contact::Hertz { adhesion: Some(_), .. } => refuse("Hertz.adhesion", ADHESION, ADHESION_HELP),
        Contact::Assignment { k, b } => Ok(Model {
            normal: format!("hooke {}", number(k.get())),
            damping: b.get(),
            drag_kind: "velocity",
            tangential: format!("linear_nohistory 1.0 {NO_CAP:e}"),
            rolling: String::new(),
            limit: "",
        }),
        Contact::Linear { lever: Lever::ContactPoint, tangential: Some(_), .. } => {
            refuse("Linear.lever", CONTACT_POINT, "export with `lever: Radius`")
        }
        Contact::Hertz { lever: Lever::ContactPoint, tangential: Some(_), .. } => {
            refuse("Hertz.lever", CONTACT_POINT, "export with `lever: Radius`")
        }
        Contact::Linear { k, damping, attraction, tangential, rolling, .. } => {
            let (damping, drag_kind) = match damping {
                Damping::B(b) => (b.get(), "velocity"),
                Damping::PerMass(gamma) => (gamma.get(), "mass_velocity"),
                Damping::Restitution(e) => match tsuji(2.0 * attraction.damping_ratio(e)) {
                    Some(damping) => damping,
                    None => return refuse("Linear.damping", TOO_DAMPED, TOO_DAMPED_HELP),
                },
            };
            let tangential = match tangential {
                None => "linear_nohistory 0.0 0.0".to_owned(),
                Some(term) => {
                    let (given, friction, spring) = match term {
                        Friction::Dashpot { damping, friction } => (damping, friction, None),
                        Friction::Spring { k, damping, friction } => (damping, friction, Some(k)),
                    };
                    let Some(share) = share_of_normal(given, damping, drag_kind) else {
                        return refuse("Linear.tangential.damping", OTHER_KIND, OTHER_KIND_HELP);
                    };
                    let style = spring.map_or_else(
                        || "linear_nohistory".to_owned(),
                        |k| format!("linear_history {}", number(k.get())),
                    );
                    format!("{style} {} {}", number(share), number(friction.get()))
                }
            };
            let rolling = rolling_words(loaded, rolling.as_ref(), mass, &format!("{key}.Linear.rolling"))?;
            let normal = format!("hooke {}", number(k.get()));
            Ok(Model { normal, damping, drag_kind, tangential, rolling, limit: limit(attraction) })
        }
        Contact::Hertz { restitution, attraction, tangential, rolling, .. } => {
            let Some(materials) = materials else { unreachable!("the rules require materials with Hertz's law") };
            let [a, b] = materials;
            let modulus = a.effective_modulus(b);
            let shear = a.effective_shear_modulus(b);
            // c = 2 sqrt(5/6) zeta sqrt(S_n m_eff), and S_n is 3/2 of the k sqrt(R* delta) that LAMMPS takes here.
            let Some((damping, drag_kind)) = tsuji(5.0f64.sqrt() * attraction.damping_ratio(restitution)) else {
                return refuse("Hertz.restitution", TOO_DAMPED, TOO_DAMPED_HELP);
            };
            let tangential = match tangential {
                None => "linear_nohistory 0.0 0.0".to_owned(),
                Some(HertzFriction::Mindlin { friction, damping }) => {
                    let share = match damping {
                        None => (4.0 * shear / modulus).sqrt(),
                        Some(MindlinDamping::OfNormal(share)) => share.get(),
                    };
                    let [k, share, friction] = [8.0 * shear, share, friction.get()].map(number);
                    format!("mindlin_rescale/force {k} {share} {friction}")
                }
            };
            let rolling = rolling_words(loaded, rolling.as_ref(), mass, &format!("{key}.Hertz.rolling"))?;
            let normal = format!("hertz {}", number(4.0 / 3.0 * modulus));
            Ok(Model { normal, damping, drag_kind, tangential, rolling, limit: limit(attraction) })
        }
    }
}

const TWISTING: &str = "`twisting sds` of LAMMPS has one torque stiffness for all radii";
const TWISTING_HELP: &str = "export without `twisting`";
const ADHESION: &str = "adhesion is not translated: LAMMPS caps friction and limits damping in another way";
const ADHESION_HELP: &str = "export without `adhesion`";
const CONTACT_POINT: &str =
    "LAMMPS computes the sliding velocity with the radii as arms, not with arms to the contact point";
const TOO_DAMPED: &str = "`damping tsuji` of LAMMPS cannot damp as much as this restitution needs";
const TOO_DAMPED_HELP: &str = "export with a restitution of 0.27 or more, or with `Linear` and `damping: PerMass(...)`";
const OTHER_KIND: &str =
    "LAMMPS takes the drag of friction as a share of the normal drag, and these two are of different kinds";
const OTHER_KIND_HELP: &str =
    "give both as B or both as PerMass with a normal damping above 0, or this one as OfNormal(share)";

/// The drag of friction as a share of the normal drag, if it is one.
fn share_of_normal(given: TangentialDamping, normal: f64, model: &str) -> Option<f64> {
    match given {
        TangentialDamping::OfNormal(share) => Some(share.get()),
        TangentialDamping::B(b) | TangentialDamping::PerMass(b) if b.get() <= 0.0 => Some(0.0),
        TangentialDamping::B(b) => (model == "velocity" && normal > 0.0).then(|| b.get() / normal),
        TangentialDamping::PerMass(gamma) => (model == "mass_velocity" && normal > 0.0).then(|| gamma.get() / normal),
    }
}

fn rolling_words(
    loaded: &Loaded,
    rolling: Option<&RollingKeys>,
    mass: Option<f64>,
    key: &str,
) -> Result<String, Fault> {
    let Some(keys) = rolling else { return Ok(String::new()) };
    let Some(rolling) = keys.spring() else {
        return Err(refused(
            loaded,
            &format!("{key}.kind"),
            &format!("LAMMPS has no rolling resistance of the kind `{:?}`", keys.kind),
        )
        .help("export with `kind: Spring`"));
    };
    let drag = match (rolling.damping, mass) {
        (RollingDamping::B(b), _) => b.get(),
        (RollingDamping::PerMass(gamma), _) if gamma.get() <= 0.0 => 0.0,
        (RollingDamping::PerMass(gamma), Some(mass)) => gamma.get() * mass,
        (RollingDamping::PerMass(_), None) => {
            return Err(refused(
                loaded,
                &format!("{key}.damping"),
                "`rolling sds` of LAMMPS has one drag for all masses, and masses differ here",
            )
            .help("give it as B(...), or export grains of one mass without fixed discs"));
        }
    };
    let [k, drag, friction] = [rolling.k.get(), drag, rolling.friction.get()].map(number);
    Ok(format!(" rolling sds {k} {drag} {friction}"))
}
