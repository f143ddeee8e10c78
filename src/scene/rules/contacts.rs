//! Rules between contact laws, materials and pairs of species.

use crate::contact::Contact;
use crate::contact::config::{Friction, PairOfSpecies};
use crate::fault::Fault;
use crate::integrate::Integrator;
use crate::scene::load::Loaded;

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
