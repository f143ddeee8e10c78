//! What can be told before a run: estimates from the scene, and warnings where they promise trouble.
//!
//! * The step: for one contact, velocity Verlet with its drag half a step old is stable for
//!   dt < (2/w0) (sqrt(1 + zeta^2) - zeta); in a bed, each grain with six equal neighbours,
//!   w0^2 -> sum_j k (1/m_i + 1/m_j), so w0 and zeta grow by sqrt(6). The lightest grain decides.
//! * The walls: a grain that fell all the way carries m v^2/2; to squeeze between two neighbouring wall grains takes
//!   2 (k/2) (R + R_w - d/2)^2 at half their distance d. And is there a way out for a grain as if all were hard
//!   ([`leaks`])?
//! * The bed: its weight over its width is a pressure p (N/m); a contact that carries 2 R p is compressed by 2 R p/k.
//! * The path: faster than a wall is thick in one step, and a grain may pass unseen.

pub mod leaks;

use std::fmt;

use crate::scene::load::Loaded;
use crate::walls::outline::Outline;

/// A warning: what to expect, and what to do.
#[derive(Clone, Debug, PartialEq)]
pub struct Warning {
    /// A stable code, `check::what`.
    pub code: &'static str,
    /// What to expect.
    pub message: String,
    /// What to do.
    pub help: String,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}; {}", self.code, self.message, self.help)
    }
}

/// Estimates of a scene with grains, SI.
#[derive(Clone, Copy, Debug)]
pub struct Estimates {
    /// The time step, s.
    pub dt: f64,
    /// Radius of the smallest grain, m.
    pub radius: f64,
    /// Its mass, kg.
    pub mass: f64,
    /// Duration of a contact of two of the smallest grains, s.
    pub contact_duration: f64,
    /// Its restitution.
    pub restitution: f64,
    /// Largest stable step of one contact, s.
    pub pair_limit: f64,
    /// Largest stable step in a dense bed, s.
    pub bed_limit: f64,
    /// Speed of a grain at the lowest point that it can fall to, m/s.
    pub impact_speed: f64,
    /// Overlap over radius of two of the smallest grains that meet at that speed, undamped.
    pub impact_overlap: f64,
    /// Overlap over radius at the bottom of the bed, from its weight.
    pub static_overlap: f64,
}

impl Estimates {
    /// Estimates for a scene; `None` if it has no grains.
    #[must_use]
    pub fn of(loaded: &Loaded) -> Option<Self> {
        let (radius, _) = loaded.grain_radii()?;
        let scene = &loaded.scene;
        let lightest = loaded.grains.iter().map(|grain| grain.mass).fold(f64::INFINITY, f64::min);
        let mass = scene.mass.map_or(f64::INFINITY, |law| law.of(radius)).min(lightest);
        let law = scene.contact.law();
        let reduced = 0.5 * mass;
        let (w0, zeta) = (law.frequency(reduced), law.damping_ratio(reduced));
        let six = 6f64.sqrt();
        let impact_speed = impact_speed(loaded);
        Some(Self {
            dt: scene.step.seconds(),
            radius,
            mass,
            contact_duration: law.contact_duration(reduced),
            restitution: law.restitution(reduced),
            pair_limit: verlet_limit(w0, zeta),
            bed_limit: verlet_limit(six * w0, six * zeta),
            impact_speed,
            impact_overlap: impact_speed / w0 / radius,
            static_overlap: 2.0 * bed_pressure(loaded) / law.stiffness(),
        })
    }
}

/// Largest stable step of velocity Verlet with lagged drag, s.
#[must_use]
pub fn verlet_limit(w0: f64, zeta: f64) -> f64 {
    2.0 / w0 * ((1.0 + zeta * zeta).sqrt() - zeta)
}

/// Speed at the lowest point of the walls, after a fall from where grains start, m/s.
fn impact_speed(loaded: &Loaded) -> f64 {
    let floor = lowest_point(loaded);
    let g = loaded.scene.gravity.get().length();
    let fall = |height: f64, speed: f64| (speed * speed + 2.0 * g * (height - floor).max(0.0)).sqrt();
    let start = loaded.grains.iter().map(|grain| fall(grain.position.y, grain.velocity.length()));
    let released = loaded.scene.spawner.iter().map(|s| fall(s.point.get().y, s.velocity.get().length()));
    start.chain(released).fold(0.0, f64::max)
}

fn lowest_point(loaded: &Loaded) -> f64 {
    use crate::walls::surfaces::Surface;
    let discs = loaded.wall_discs().into_iter().map(|disc| disc.centre.y);
    let surfaces = loaded.surfaces().into_iter().map(|surface| match surface {
        Surface::HalfPlane { point, .. } => point.y,
        Surface::Segment { from, to } => from.y.min(to.y),
    });
    let lowest = discs.chain(surfaces).fold(f64::INFINITY, f64::min);
    let grains = loaded.grains.iter().map(|grain| grain.position.y).fold(f64::INFINITY, f64::min);
    if lowest.is_finite() { lowest } else { grains.min(loaded.scene.cull.map_or(0.0, |cull| cull.below.get())) }
}

/// Weight of all grains over the width of the walls, N/m; 0 without walls that have a width.
fn bed_pressure(loaded: &Loaded) -> f64 {
    let outline = Outline::new(&loaded.wall_discs(), &loaded.silo.door, &loaded.surfaces(), 0.0);
    let Some([low, high]) = outline.bounds().filter(|[low, high]| high.x > low.x) else { return 0.0 };
    let start: f64 = loaded.grains.iter().map(|grain| grain.mass).sum();
    let released: f64 = loaded
        .scene
        .spawner
        .iter()
        .zip(loaded.scene.mass)
        .map(|(spawner, law)| {
            let (smallest, largest) = spawner.radius.range();
            f64::from(spawner.count) * 0.5 * (law.of(smallest) + law.of(largest))
        })
        .sum();
    (start + released) * loaded.scene.gravity.get().length() / (high.x - low.x)
}

/// What to expect of this scene that its author may not want.
#[must_use]
pub fn warnings(loaded: &Loaded) -> Vec<Warning> {
    let Some(estimates) = Estimates::of(loaded) else { return Vec::new() };
    let mut warnings = Vec::new();
    step(&estimates, &mut warnings);
    softness(loaded, &estimates, &mut warnings);
    if let Some(place) = leaks::way_out(loaded) {
        warnings.push(Warning {
            code: "check::leaky_walls",
            message: format!(
                "a grain of radius {} m finds a way out of the walls near ({:.2}, {:.2}) m",
                estimates.radius, place.x, place.y
            ),
            help: "close the gap, or release larger grains".to_owned(),
        });
    }
    if let Some(spawner) = &loaded.scene.spawner {
        let (t, g) = (spawner.interval.get(), loaded.scene.gravity.get());
        let way = (spawner.velocity.get() * t + 0.5 * t * t * g).length();
        let (_, largest) = spawner.radius.range();
        if way < 2.0 * largest && spawner.count > 1 {
            warnings.push(Warning {
                code: "check::releases_wait",
                message: format!(
                    "a grain moves {way:.3} m between releases and is up to {:.3} m wide: releases will wait",
                    2.0 * largest
                ),
                help: "release less often, or faster grains".to_owned(),
            });
        }
    }
    warnings
}

fn step(estimates: &Estimates, warnings: &mut Vec<Warning>) {
    let Estimates { dt, pair_limit, bed_limit, .. } = *estimates;
    if dt >= bed_limit {
        let (code, what, limit) = if dt >= pair_limit {
            ("check::unstable_step", "of a single contact", pair_limit)
        } else {
            ("check::unstable_bed", "of a dense bed, six neighbours a grain", bed_limit)
        };
        warnings.push(Warning {
            code,
            message: format!(
                "the step of {dt:.3e} s is beyond the stability limit {what}, {limit:.3e} s: energy will grow"
            ),
            help: format!("lower `step` below {bed_limit:.2e} s, or soften the contacts"),
        });
    }
}

fn softness(loaded: &Loaded, estimates: &Estimates, warnings: &mut Vec<Warning>) {
    let stiffness = loaded.scene.contact.law().stiffness();
    let carried = 0.5 * estimates.mass * estimates.impact_speed.powi(2);
    if let Some(barrier) = weakest_link(loaded, estimates.radius, stiffness).filter(|&barrier| barrier < carried) {
        warnings.push(Warning {
            code: "check::soft_walls",
            message: format!(
                "a grain arrives with up to {carried:.2} J ({:.1} m/s), and {barrier:.2} J squeeze it between two wall \
                 grains: grains will pass through the walls",
                estimates.impact_speed
            ),
            help: format!(
                "raise the stiffness, now {stiffness} N/m, about {:.0} times; is its unit right?",
                (carried / barrier).ceil()
            ),
        });
    }
    if estimates.static_overlap > 0.3 {
        warnings.push(Warning {
            code: "check::soft_bed",
            message: format!(
                "the weight of the grains presses those at the bottom together by {:.2} of their radius",
                estimates.static_overlap
            ),
            help: "raise the stiffness: the contact law is meant for small overlaps".to_owned(),
        });
    }
    let thickness = estimates.radius + loaded.wall_discs().iter().map(|disc| disc.radius).fold(f64::INFINITY, f64::min);
    let way = estimates.impact_speed * estimates.dt;
    if thickness.is_finite() && way > thickness {
        warnings.push(Warning {
            code: "check::fast_grains",
            message: format!(
                "a grain moves up to {way:.3} m in a step, and may pass a wall of {thickness:.3} m unseen"
            ),
            help: "lower `step`".to_owned(),
        });
    }
}

/// The least energy that takes a grain of radius `radius` between two neighbouring wall or door grains, J.
fn weakest_link(loaded: &Loaded, radius: f64, stiffness: f64) -> Option<f64> {
    let mut discs = loaded.wall_discs();
    discs.extend(&loaded.silo.door);
    let thinnest = discs.iter().map(|disc| disc.radius).fold(f64::INFINITY, f64::min);
    let outline = Outline::new(&discs, &[], &[], radius);
    let barrier = |distance: f64| stiffness * (radius + thinnest - 0.5 * distance).max(0.0).powi(2);
    outline.links().iter().map(|link| barrier(link.from.distance(link.to))).min_by(f64::total_cmp)
}
