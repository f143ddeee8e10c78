//! The work of a run up to `until`, and the time that it takes on one core, before it begins.
//!
//! time = steps (3 us + n c), with n spheres or discs of all grains that the scene will have, and c = 35 ns in the plane and 90 ns in solid space. These
//! are round numbers of whole runs of shipped scenes on cores of 2024: 20 to 40 ns in the plane; 48 ns (`silo3d`), 105 ns a sphere of a
//! body (`rice-silo`) and 130 ns (`drum`) in solid space. A single run may take a half or twice as long. Most runs end before `until`.

use crate::scene::expected;
use crate::scene::loaded::Loaded;
use siloflow_dem::space::Dimension;

/// Time of a step without grains, s.
const STEP: f64 = 3e-6;

/// Time of a site of the lattice gas in a step, s: 60 million a second (docs/explanation/lattice-gas.md).
const SITE: f64 = 1.0 / 60e6;

/// Expected time from which on a run tells it, s.
const LONG: f64 = 60.0;

/// The work up to `until`.
#[derive(Clone, Copy, Debug)]
pub struct Work {
    /// Steps times spheres or discs of grains; updates of sites of the lattice gas.
    pub updates: f64,
    /// Time on one core, s.
    pub seconds: f64,
}

impl Work {
    /// The work of a scene with this step, s.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "a number of grains")]
    pub fn of_grains(loaded: &Loaded, dt: f64) -> Self {
        let steps = loaded.scene.until.get() / dt;
        let each = match loaded.scene.space {
            Dimension::Plane => 35e-9,
            Dimension::Solid => 90e-9,
        };
        let count = expected::grain_shapes(loaded) as f64;
        Self { updates: steps * count, seconds: steps * (STEP + count * each) }
    }

    /// The work of a scene of the lattice gas with this number of sites.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "numbers of steps and sites")]
    pub fn of_lattice(steps: u64, sites: usize) -> Self {
        let updates = steps as f64 * sites as f64;
        Self { updates, seconds: updates * SITE }
    }

    /// The time in words: `about 40 s`, `about 3 min`, `about 5 h`, `about 12 days`.
    #[must_use]
    pub fn words(&self) -> String {
        let units = [(86_400.0, "days"), (3600.0, "h"), (60.0, "min"), (1.0, "s")];
        // From one and a half of a unit on, so that the number has at least two digits of sense.
        let (unit, name) = units.into_iter().find(|(unit, _)| self.seconds >= 1.5 * unit).unwrap_or((1.0, "s"));
        match self.seconds / unit {
            number if number < 1.0 => "less than 1 s".to_owned(),
            number => format!("about {number:.0} {name}"),
        }
    }

    /// Logs the time before a long run.
    pub fn tell(&self) {
        if self.seconds > LONG {
            tracing::info!("up to `until` this run takes {} on one core; most runs end earlier", self.words());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_told_in_the_unit_that_suits_them() {
        let words = |seconds| Work { updates: 1.0, seconds }.words();
        let expected = ["less than 1 s", "about 1 s", "about 60 s", "about 2 min", "about 2 h", "about 11 days"];
        assert_eq!([0.3, 1.2, 60.0, 95.0, 7000.0, 950_000.0].map(words), expected);
    }
}
