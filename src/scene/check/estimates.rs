//! Numbers that are estimated from a scene before a run.

use crate::scene::TimeStep;
use crate::scene::check::automatic;
use crate::scene::check::bed::{carried_at_the_bottom, impact_speed};
use crate::scene::check::free_walls::pressed_by_free_walls;
use crate::scene::check::quantities::Estimates;
use crate::scene::check::species_pairs::{self, SpeciesPair};
use crate::scene::loaded::Loaded;
use siloflow_dem::contact::Bounce;
use siloflow_dem::integrate::Integrator;

impl Estimates {
    /// Estimates for a scene; `None` if it has no grains.
    #[must_use]
    pub fn of(loaded: &Loaded) -> Option<Self> {
        Self::with(loaded, loaded.scene.integrator)
    }

    /// Whether `Centred` lets springs follow the positions at this step ([`siloflow_dem::contact::centred::velocity_prediction`]).
    #[must_use]
    pub fn has_exact_springs(&self) -> bool {
        self.relaxation.is_finite() && self.dt > self.relaxation
    }

    /// Estimates for a scene with another scheme; `None` if it has no grains.
    #[must_use]
    pub fn with(loaded: &Loaded, scheme: Integrator) -> Option<Self> {
        let (radius, largest) = loaded.grain_radii()?;
        let scene = &loaded.scene;
        let heaviest =
            loaded.grains.iter().map(|grain| grain.mass).fold(scene.mass.map_or(0.0, |law| law.of(largest)), f64::max);
        let lightest = loaded.grains.iter().map(|grain| grain.mass).fold(f64::INFINITY, f64::min);
        let mass = scene.mass.map_or(f64::INFINITY, |law| law.of(radius)).min(lightest);
        // Estimates ask for no directions: the law in the plane answers for both spaces.
        let law = loaded.contacts().any().0;
        let impact_speed = impact_speed(loaded);
        // If no grain falls, a speed of the order that a grain's own weight causes.
        let slow = 0.1 * (scene.gravity.padded().length() * radius).sqrt();
        let speed = impact_speed.max(slow).max(1e-6);
        let pairs = species_pairs::all(loaded, speed);
        // The reduced mass of the two lightest grains, or of a single grain and a wall.
        let lightest = pairs.iter().map(|pair| pair.bounce.reduced_mass).fold(f64::INFINITY, f64::min);
        let reduced_mass = if lightest.is_finite() { lightest } else { mass };
        let bounce = Bounce { reduced_mass, reduced_radius: 0.5 * radius, speed };
        let least = |of: &dyn Fn(&SpeciesPair) -> f64| pairs.iter().map(of).fold(f64::INFINITY, f64::min);
        let shortest = least(&|pair| pair.law.0.contact_duration(&pair.bounce));
        let relaxation = least(&SpeciesPair::relaxation);
        let mut estimates = Self {
            dt: f64::NAN,
            scheme,
            contact: scene.contact,
            shortest_swing: least(&SpeciesPair::shortest_swing),
            radius,
            mass,
            contact_duration: if pairs.is_empty() { law.contact_duration(&bounce) } else { shortest },
            restitution: law.restitution(&bounce),
            lowest_restitution: least(&|pair| pair.law.0.restitution(&pair.bounce)).min(1.0),
            pair_limit: least(&|pair| pair.lone_limit(scheme)),
            bed_limit: least(&|pair| pair.bed_limit(scheme, scene.space, relaxation)),
            damping_rates: [0, 1].map(|way| pairs.iter().map(|pair| pair.damping_rates()[way]).fold(0.0, f64::max)),
            relaxation,
            impact_speed,
            impact_overlap: law.deepest(&Bounce { speed: impact_speed, ..bounce }) / radius,
            static_overlap: (carried_at_the_bottom(loaded, radius) + pressed_by_free_walls(loaded, radius))
                / law.stiffness(&bounce)
                / radius,
            caught_overlap: heaviest * scene.gravity.padded().length() / law.stiffness(&bounce) / radius,
            stiffness: law.stiffness(&bounce),
            adhesive_overlap: pairs.iter().map(SpeciesPair::adhesive_overlap).fold(0.0, f64::max),
        };
        estimates.dt = match scene.step {
            TimeStep::Fixed(dt) => dt.get(),
            TimeStep::Auto { error } => automatic::automatic(&estimates, error.get()).dt,
        };
        Some(estimates)
    }
}

impl Loaded {
    /// The time step, s. Without grains an automatic step is `until`.
    #[must_use]
    pub fn step(&self) -> f64 {
        match self.scene.step {
            TimeStep::Fixed(dt) => dt.get(),
            TimeStep::Auto { .. } => Estimates::of(self).map_or(self.scene.until.get(), |estimates| estimates.dt),
        }
    }
}

/// The pair whose single normal contact has the lowest stability limit, and that limit, s. Beyond it the contact is
/// unstable whatever surrounds it. An unstable tangential or rolling motion is bounded by its cap.
#[must_use]
pub fn hardest(loaded: &Loaded) -> Option<(SpeciesPair, f64)> {
    let speed = impact_speed(loaded);
    let all = species_pairs::all(loaded, speed).into_iter().map(|pair| {
        let limit = pair.normal_limit(loaded.scene.integrator);
        (pair, limit)
    });
    all.min_by(|a, b| a.1.total_cmp(&b.1))
}
