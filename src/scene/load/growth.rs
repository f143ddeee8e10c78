//! The scene key `growth`: larger radii at the same masses, to make up for the overlaps of soft contacts.
//!
//! A scene with softer contacts than those of real grains needs fewer steps, but its grains overlap more, so that its bed is one of slightly smaller
//! grains. With the growth g every radius R becomes R (1 + g). The masses stay: densities of `mass` are divided by (1 + g)^2, that of
//! `Sphere` by (1 + g)^3. Two grains whose overlap is g (R_1 + R_2) are then as far apart as hard grains that touch. So the growth that
//! makes up for the mean overlap of a bed is half of `mean_overlap_ratio` in `series.csv`.
//!
//! Limits: the growth corrects distances between grains on average. Grains still overlap walls that they are pressed against. Impacts
//! last as long as without growth, and a soft bed packs otherwise than a hard one. Sizes of a grain file and of fixed grains stay as
//! they are. docs/explanation/estimate.md has measured effects.

use crate::grains::mass::MassLaw;
use crate::grains::sizes::RadiusLaw;
use crate::scene::Scene;
use crate::scene::loaded::Loaded;
use siloflow_dem::values::Share;
use siloflow_text::fault::Fault;

impl Loaded {
    /// Lets the grains of all sources grow.
    pub(super) fn grow(&mut self) -> Result<(), Fault> {
        let Some(growth) = self.scene.growth.map(Share::get).filter(|growth| *growth > 0.0) else {
            return Ok(());
        };
        let scene = &self.scene;
        let own = std::iter::once(("contact.adhesion".to_owned(), scene.contact.adhesion()));
        let pairs = scene.pairs.iter().enumerate();
        let pairs = pairs.map(|(n, pair)| (format!("pairs[{n}].contact.adhesion"), pair.contact.adhesion()));
        if let Some((key, _)) = own.chain(pairs).find(|(_, adhesion)| adhesion.is_some()) {
            return Err(self
                .fault("scene::growth", "growth", format!("`growth` has no rule for contacts with `{key}`"))
                .help("leave out `growth`: it makes up for overlaps that weight causes, not for those of adhesion"));
        }
        grow_sources(&mut self.scene, 1.0 + growth);
        Ok(())
    }
}

/// Multiplies the radii of all sources, whose shapes are resolved, and lets their masses stay.
fn grow_sources(scene: &mut Scene, factor: f64) {
    let lighter = |law: &mut Option<MassLaw>| *law = law.map(|law| law.at_radii_times(factor));
    let larger = |radius: &mut RadiusLaw| *radius = radius.times(|_| factor);
    lighter(&mut scene.mass);
    for fill in scene.fill.iter_mut().filter(|fill| !fill.fixed) {
        larger(&mut fill.radius);
        lighter(&mut fill.mass);
    }
    for feed in &mut scene.feed {
        larger(&mut feed.radius);
        lighter(&mut feed.mass);
    }
    if let Some(spawner) = &mut scene.spawner {
        larger(&mut spawner.radius);
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::scene::load;
    use crate::scene::loaded::Loaded;
    use siloflow_text::fault::Fault;

    fn loaded(growth: &str, more: &str) -> Result<Loaded, Fault> {
        let text = format!(
            "(space: Solid, gravity: (0.0, 0.0, -9.81), contact: Linear(k: 1.0e4, damping: Restitution(0.5), {more}), step: Fixed(1.0e-5), \
             mass: Sphere(2500.0), walls: [], until: 1.0, growth: {growth}, fill: [ \
             (low: (0.0, 0.0, 0.0), high: (0.1, 0.1, 0.1), spacing: 0.02, count: 20, radius: Uniform(0.005, 0.007)), \
             (low: (0.1, 0.0, 0.0), high: (0.2, 0.1, 0.1), spacing: 0.02, count: 20, mass: Disc(9.0), radius: Mixture([(0.005, 0.5), (0.007, 0.5)]))])"
        );
        load::from_text("a.ron", "a", Path::new(""), text, &[])
    }

    #[test]
    fn radii_grow_at_the_same_masses() {
        let usual = loaded("0.0", "").unwrap();
        let grown = loaded("0.25", "").unwrap();
        assert!(usual.grains.len() == 40 && grown.grains.len() == 40);
        for (a, b) in usual.grains.iter().zip(&grown.grains) {
            // Sums, products and quotients of a few rounded numbers.
            let is_same = |x: f64, y: f64| (x / y - 1.0).abs() < 10.0 * f64::EPSILON;
            assert!(is_same(1.25 * a.radius, b.radius) && is_same(a.mass, b.mass), "{a:?} {b:?}");
            assert_eq!((a.position, a.species), (b.position, b.species));
        }
    }

    #[test]
    fn growth_is_refused_with_adhesion() {
        let adhesion = "tangential: Spring(k: 3.0e3, damping: OfNormal(0.5), friction: 0.4), adhesion: Force(1.0e-4)";
        let fault = loaded("0.1", adhesion).unwrap_err();
        assert_eq!(fault.code(), "scene::growth");
    }
}
