//! Names of species: the radii of the grains that a scene releases.

use crate::grains::sizes::RadiusLaw;
use crate::scene::loaded::Loaded;

/// Returns the names of the species that the first source of grains releases.
pub(in crate::output) fn names(loaded: &Loaded) -> Vec<String> {
    let feed = loaded.scene.feed.first().map(|feed| &feed.radius);
    match loaded.scene.spawner.as_ref().map(|spawner| &spawner.radius).or(feed) {
        Some(RadiusLaw::Fixed(radius)) => vec![format!("R = {} m", radius.get())],
        Some(RadiusLaw::Uniform(low, high)) => vec![format!("R = {} to {} m", low.get(), high.get())],
        Some(RadiusLaw::Mixture(sizes)) => sizes.iter().map(|(radius, _)| format!("R = {} m", radius.get())).collect(),
        None => Vec::new(),
    }
}
