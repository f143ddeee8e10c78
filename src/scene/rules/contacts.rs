//! Rules between contact laws, materials and pairs of species.

use crate::scene::loaded::Loaded;
use siloflow_dem::contact::Contact;
use siloflow_dem::contact::adhesion::Adhesion;
use siloflow_dem::contact::config::{Friction, PairOfSpecies};
use siloflow_dem::contact::rolling::{RollingKeys, RollingKind};
use siloflow_dem::integrate::Integrator;
use siloflow_dem::neighbours::Neighbours;
use siloflow_dem::space::Dimension;
use siloflow_text::fault::Fault;

/// A law of a pair must have the same terms as the scene's law, and all parameters that a law needs must be given.
pub(super) fn contacts(loaded: &Loaded) -> Result<(), Fault> {
    let scene = &loaded.scene;
    for (index, pair) in scene.pairs.iter().enumerate() {
        let is_same = |other: &PairOfSpecies| {
            let (a, b) = other.species;
            pair.species == (a, b) || pair.species == (b, a)
        };
        if scene.pairs[..index].iter().any(is_same) {
            return Err(loaded
                .fault("scene::pair_twice", &format!("pairs[{index}].species"), "this pair stands here twice")
                .help("(0, 1) and (1, 0) are the same pair; remove one"));
        }
        if pair.contact.kind() != scene.contact.kind() {
            let message = format!("this is {}, but `contact` is {}", pair.contact.kind(), scene.contact.kind());
            return Err(loaded
                .fault("scene::kind_of_law", &format!("pairs[{index}].contact"), message)
                .help("all pairs have the same kind of law with other numbers; friction may be 0"));
        }
    }
    let of_pairs =
        (0..).zip(&scene.pairs).map(|(index, pair): (usize, _)| (format!("pairs[{index}].contact"), pair.contact));
    for (key, law) in of_pairs.chain([("contact".to_owned(), scene.contact)]) {
        let rolls_without_sticking = match law {
            Contact::Linear { tangential, rolling: Some(_), .. } => {
                !matches!(tangential, Some(Friction::Spring { .. }))
            }
            Contact::Hertz { tangential: None, rolling: Some(_), .. } => true,
            _ => false,
        };
        let sticks = matches!(
            law,
            Contact::Linear { tangential: Some(Friction::Spring { .. }), .. }
                | Contact::Hertz { tangential: Some(_), .. }
        );
        let adhesion = law.adhesion();
        if adhesion.is_some() && !sticks {
            return Err(loaded
                .fault("scene::adhesion_alone", &format!("{key}.adhesion"), "adhesion needs friction with memory")
                .help(
                    "add `tangential: Spring(k: ..., damping: ..., friction: ...)`, with Hertz `Mindlin(friction: ...)`; the friction may \
                     be 0",
                ));
        }
        if let Some(rolling) = law.rolling() {
            keys_of_rolling(loaded, &key, &rolling)?;
        }
        if matches!((law, adhesion), (Contact::Linear { .. }, Some(Adhesion::Jkr(_)))) {
            return Err(loaded
                .fault(
                    "scene::adhesion",
                    &format!("{key}.adhesion"),
                    "the law of Johnson, Kendall and Roberts needs elastic spheres",
                )
                .help("use it with `Hertz`; with `Linear` choose `Force`, `Dmt` or `Area`"));
        }
        if law.twisting().is_some() && !sticks {
            return Err(loaded
                .fault("scene::twisting_alone", &format!("{key}.twisting"), "twisting resistance needs friction with memory")
                .help("add `tangential: Spring(k: ..., damping: ..., friction: ...)`, with Hertz `Mindlin(friction: ...)`"));
        }
        if law.twisting().is_some() && scene.space == Dimension::Plane {
            return Err(loaded
                .fault(
                    "scene::dimension",
                    &format!("{key}.twisting"),
                    "discs of the plane cannot twist about their normal",
                )
                .help("remove it, or choose `space: Solid`"));
        }
        if rolls_without_sticking {
            return Err(loaded
                .fault("scene::rolling_alone", &format!("{key}.rolling"), "rolling resistance needs friction with memory")
                .help("add `tangential: Spring(k: ..., damping: ..., friction: ...)`, with Hertz `Mindlin(friction: ...)`"));
        }
    }
    if matches!(scene.contact, Contact::Hertz { .. }) && scene.materials.is_empty() {
        return Err(loaded
            .fault("scene::missing_key", "materials", "Hertz's law needs to know the elastic materials")
            .help("add for example `materials: [(young: 1.0e9, poisson: 0.2)]`, in Pa, one for each species"));
    }
    range_beyond_touch(loaded)?;
    if scene.contact.spins() && matches!(scene.integrator, Integrator::ExplicitEuler | Integrator::SymplecticEuler) {
        return Err(loaded
            .fault("scene::integrator", "integrator", "the Euler schemes do not turn grains")
            .help("use `Centred` or `Verlet`, or leave `tangential` out of the contact law"));
    }
    if scene.materials.len() > 1 && loaded.largest_species() >= scene.materials.len() {
        let message =
            format!("there are {} materials, but species go up to {}", scene.materials.len(), loaded.largest_species());
        return Err(loaded
            .fault("scene::missing_material", "materials", message)
            .help("give one material for all, or one for each species from 0 on"));
    }
    if scene.inertia.is_some() && !scene.contact.spins() {
        return Err(loaded
            .fault("scene::no_spin", "inertia", "without a tangential force grains do not spin")
            .help("remove `inertia`, or add `tangential` to the contact law"));
    }
    Ok(())
}

/// Contacts beyond touch must be short against the grains and against the skin of a Verlet list.
fn range_beyond_touch(loaded: &Loaded) -> Result<(), Fault> {
    let range = loaded.adhesive_range();
    let Some((smallest, _)) = loaded.grain_radii().filter(|_| range > 0.0) else { return Ok(()) };
    if range > 0.09 * smallest {
        let message =
            format!("contacts would hold across a gap of {range:.2e} m, and the smallest radius is {smallest:.2e} m");
        return Err(loaded
            .fault("scene::long_range", "contact.adhesion", message)
            .help("lower the work of adhesion, or raise Young's modulus: the law is meant for short gaps"));
    }
    match loaded.neighbours() {
        Neighbours::VerletList { skin } if skin.get() < 2.0 * range => Err(loaded
            .fault(
                "scene::long_range",
                "neighbours",
                format!("contacts may hold across a gap of {range:.2e} m, and the skin is {:.2e} m", skin.get()),
            )
            .help(format!("choose a skin above {:.2e} m", 2.0 * range))),
        _ => Ok(()),
    }
}

/// Each kind of rolling resistance has keys of its own.
fn keys_of_rolling(loaded: &Loaded, law: &str, rolling: &RollingKeys) -> Result<(), Fault> {
    let missing = |key: &str, example: &str| {
        Err(loaded
            .fault("scene::missing_key", &format!("{law}.rolling"), format!("the kind `Spring` needs `{key}`"))
            .help(format!("add for example `{key}: {example}`, or choose `kind: Elastic` or `kind: Torque`")))
    };
    let unused = |key: &str, help: &str| {
        Err(loaded
            .fault(
                "scene::unused_key",
                &format!("{law}.rolling.{key}"),
                format!("the kind `{:?}` has no `{key}`", rolling.kind),
            )
            .help(help))
    };
    match (rolling.kind, rolling.k, rolling.damping) {
        (RollingKind::Spring, None, _) => missing("k", "1.0e4"),
        (RollingKind::Spring, _, None) => missing("damping", "B(0.1)"),
        (RollingKind::Elastic, Some(_), _) => {
            unused("k", "remove it: the stiffness is that of friction; or choose `kind: Spring`")
        }
        (RollingKind::Torque, Some(_), _) => unused("k", "remove it: the torque is constant; or choose `kind: Spring`"),
        (RollingKind::Torque, _, Some(_)) => {
            unused("damping", "remove it: the torque is constant; or choose `kind: Spring`")
        }
        _ => Ok(()),
    }
}
