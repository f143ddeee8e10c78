//! Estimates from a scene before a run, and warnings where they predict trouble.
//!
//! * The step ([`step`]): over all pairs of species that can meet ([`species_pairs`]), the lowest stability limit of a single
//!   contact and of a dense bed, along the normal, along the tangent and in rolling. Hertz's stiffness is taken at the
//!   deepest point of the fastest impact.
//! * The walls: a grain that fell all the way has the energy m v^2/2. Squeezing it between two wall grains at distance d
//!   takes 2 (k/2) (R + R_w - d/2)^2. [`leaks`] searches for gaps between rigid walls.
//! * The bed: its weight over its base area is a pressure p. A contact at the bottom carries 2 R p (in solid space 4 R^2 p)
//!   and is compressed by that force over k.
//! * Adhesion: the overlap that it causes in two bodies that touch at rest.
//! * The door: without wall discs on both sides it has no orifice through which a grain could count as out.
//! * The path: a grain that moves farther than a wall is thick, or than a grain is wide, in one step may pass it undetected.
//! * The start (`check/start.rs`) and the fall (`check/falling.rs`): overlaps, places inside and outside of walls, grains that fall for ever.
//! * The output: a warning if the run would write more than [`MOST_BYTES`] up to `until`.

pub mod automatic;
pub mod crowd;
mod falling;
pub mod leaks;
mod meshes;
pub mod species_pairs;
mod start;
pub mod step;

use crate::contact::{Bounce, Contact};
use crate::door::DoorMotion;
use crate::fault::Warning;
use crate::integrate::Integrator;
use crate::scene::check::species_pairs::SpeciesPair;
use crate::scene::expected;
use crate::scene::load::Loaded;
use crate::scene::{Scene, TimeStep};
use crate::space::{Dimension, Plane, Solid};
use crate::stop::StopCondition;
use crate::walls::config::Wall;
use crate::walls::motion::Motion;
use crate::walls::outline::Outline;
use crate::watchdog::LARGE_OVERLAP;
use crate::writers::volume::{self, MOST_BYTES};

/// Estimates of a scene with grains, SI.
#[derive(Clone, Copy, Debug)]
pub struct Estimates {
    /// The time step, s.
    pub dt: f64,
    /// The scheme.
    pub scheme: Integrator,
    /// The scene's contact law.
    pub contact: Contact,
    /// The shortest contact duration, or half period of a contact's tangential or rolling spring in units of that of its normal
    /// spring, times the duration of that contact, s.
    pub shortest_swing: f64,
    /// Lowest restitution of a head-on impact of any pair.
    pub lowest_restitution: f64,
    /// Radius of the smallest grain, m.
    pub radius: f64,
    /// Mass of the smallest grain, kg.
    pub mass: f64,
    /// Duration of the shortest contact, s.
    pub contact_duration: f64,
    /// Restitution of an impact of two smallest grains.
    pub restitution: f64,
    /// Largest stable step of every single contact, s; infinite if no two bodies can meet.
    pub pair_limit: f64,
    /// Largest stable step in a dense bed, s.
    pub bed_limit: f64,
    /// Largest damping rates of any contact: c/(2 m) along the normal, and of sliding or rolling, 1/s.
    pub damping_rates: [f64; 2],
    /// Numerical damping that tangential and rolling springs need so that a bed without dashpots gains no energy, s.
    pub spring_damping: f64,
    /// Speed of a grain after a fall to the lowest point of the scene, m/s.
    pub impact_speed: f64,
    /// Overlap over radius in an undamped impact of two smallest grains at that speed.
    pub impact_overlap: f64,
    /// Overlap over radius at the bottom of the bed, from its weight.
    pub static_overlap: f64,
    /// Overlap over radius of a smallest grain that alone carries the heaviest one.
    pub caught_overlap: f64,
    /// Stiffness of a contact at that overlap, N/m.
    pub stiffness: f64,
    /// Largest overlap over radius that adhesion alone causes, in two bodies that touch at rest.
    pub adhesive_overlap: f64,
}

impl Estimates {
    /// Estimates for a scene; `None` if it has no grains.
    #[must_use]
    pub fn of(loaded: &Loaded) -> Option<Self> {
        Self::with(loaded, loaded.scene.integrator)
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
        let law = loaded.contacts().any::<Plane>().0;
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
            bed_limit: least(&|pair| pair.bed_limit(scheme, scene.space)),
            damping_rates: [0, 1].map(|way| pairs.iter().map(|pair| pair.damping_rates()[way]).fold(0.0, f64::max)),
            spring_damping: f64::NAN,
            impact_speed,
            impact_overlap: law.deepest(&Bounce { speed: impact_speed, ..bounce }) / radius,
            static_overlap: carried_at_the_bottom(loaded, radius) / law.stiffness(&bounce) / radius,
            caught_overlap: heaviest * scene.gravity.padded().length() / law.stiffness(&bounce) / radius,
            stiffness: law.stiffness(&bounce),
            adhesive_overlap: pairs.iter().map(SpeciesPair::adhesive_overlap).fold(0.0, f64::max),
        };
        estimates.dt = match scene.step {
            TimeStep::Fixed(dt) => dt.get(),
            TimeStep::Auto { error } => automatic::automatic(&estimates, error.get()).dt,
        };
        let damping = |pair: &SpeciesPair| pair.spring_damping(estimates.dt);
        estimates.spring_damping = pairs.iter().map(damping).fold(0.0, f64::max);
        Some(estimates)
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

/// Speed at the lowest point of the walls, after a fall from where grains start, m/s.
fn impact_speed(loaded: &Loaded) -> f64 {
    let floor = lowest_point(loaded);
    let g = loaded.scene.gravity.padded().length();
    let up = up(loaded);
    let fall = |height: f64, speed: f64| (speed * speed + 2.0 * g * (height - floor).max(0.0)).sqrt();
    let start = loaded.grains.iter().map(|grain| fall(grain.position[up], grain.velocity.length()));
    let released = loaded.scene.spawner.iter().map(|s| fall(s.point.padded()[up], s.velocity.padded().length()));
    let fed = loaded.scene.feed.iter().map(|feed| {
        // Few of the Gaussian velocities exceed three standard deviations.
        let agitation = feed.agitation.map_or(0.0, |agitation| 3.0 * agitation.padded().length());
        fall(feed.region.bounds().1[up], feed.velocity.padded().length() + agitation)
    });
    start.chain(released).chain(fed).fold(0.0, f64::max)
}

/// The axis that points up: the axis along which gravity is strongest, or the last axis without gravity.
fn up(loaded: &Loaded) -> usize {
    let gravity = loaded.scene.gravity.padded();
    (0..loaded.scene.space.count()).max_by(|&a, &b| gravity[a].abs().total_cmp(&gravity[b].abs())).unwrap_or(0)
}

fn lowest_point(loaded: &Loaded) -> f64 {
    let up = up(loaded);
    let discs = loaded.wall_discs().into_iter().map(|disc| disc.centre[up.min(1)]);
    let surfaces = loaded.scene.walls.iter().filter_map(|wall| match wall {
        Wall::HalfPlane { point, .. } => Some(point.padded()[up]),
        _ => wall.bounds().map(|[low, _]| low[up]),
    });
    let lowest = discs.chain(surfaces).fold(f64::INFINITY, f64::min);
    let grains = loaded.grains.iter().map(|grain| grain.position[up]).fold(f64::INFINITY, f64::min);
    if lowest.is_finite() { lowest } else { grains.min(loaded.scene.cull.map_or(0.0, |cull| cull.below.get())) }
}

/// Load of a contact at the bottom of the bed, N: the weight of all grains over their base area, times the base area of
/// one grain; 0 if the area is unknown.
fn carried_at_the_bottom(loaded: &Loaded, radius: f64) -> f64 {
    let ground: Option<f64> = match loaded.scene.space {
        Dimension::Plane => {
            let outline = Outline::new(&loaded.wall_discs(), &loaded.silo.door, &loaded.surfaces(), 0.0);
            outline.bounds().map(|[low, high]| high.x - low.x).or_else(|| extent(loaded, 0))
        }
        Dimension::Solid => extent(loaded, 0).zip(extent(loaded, 1)).map(|(x, y)| x * y),
    };
    let axes = i32::try_from(loaded.scene.space.count()).unwrap_or(2) - 1;
    let Some(ground) = ground.filter(|&ground| ground > 0.0) else { return 0.0 };
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
    let fed = loaded.scene.feed.iter().zip(loaded.scene.mass.iter().cycle());
    let fed: f64 = fed.map(|(feed, &law)| feed.count(law).unwrap_or(0.0) * feed.mean_mass(law)).sum();
    (start + released + fed) * loaded.scene.gravity.padded().length() / ground * (2.0 * radius).powi(axes)
}

/// Extent of the scene along a horizontal axis, m: the periodic length, or the distance from the first to the last grain
/// at the start.
fn extent(loaded: &Loaded, axis: usize) -> Option<f64> {
    if let Some((low, high)) = loaded.scene.periodic.axes()[axis] {
        return Some(high - low);
    }
    let ends = loaded.grains.iter().map(|g| (g.position[axis] - g.radius, g.position[axis] + g.radius));
    ends.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).map(|(low, high)| high - low)
}

/// Warnings about effects that the author of the scene may not want.
#[must_use]
pub fn warnings(loaded: &Loaded) -> Vec<Warning> {
    let mut warnings = loaded.source.unused_parameters();
    renamed_keys(loaded, &mut warnings);
    stop(loaded, &mut warnings);
    let estimates = Estimates::of(loaded);
    start::examine(loaded, estimates.as_ref(), &mut warnings);
    meshes::examine(loaded, &mut warnings);
    let Some(estimates) = estimates else { return warnings };
    step(&estimates, &mut warnings);
    feeds(loaded, estimates.dt, &mut warnings);
    softness(loaded, &estimates, &mut warnings);
    fast(loaded, &estimates, &mut warnings);
    falling::examine(loaded, &mut warnings);
    output(loaded, &estimates, &mut warnings);
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
    if let Some(width) = door_width(loaded, estimates.radius).filter(|&width| width < 2.0 * estimates.radius) {
        warnings.push(Warning {
            code: "check::narrow_door",
            message: format!(
                "the door is {width:.3} m wide, and the smallest grain {:.3} m: no grain can leave",
                2.0 * estimates.radius
            ),
            help: "widen the door, or release smaller grains".to_owned(),
        });
    }
    if !has_orifice(loaded, estimates.radius) {
        warnings.push(Warning {
            code: "check::no_orifice",
            message: "the door has no wall disc of the silo file on each side, so it has no orifice: grains that leave count as lost"
                .to_owned(),
            help: "add to the silo file a wall disc at each end of the door".to_owned(),
        });
    }
    if let Some(spawner) = &loaded.scene.spawner {
        let (t, g) = (spawner.interval.get(), loaded.scene.gravity.padded());
        let way = (spawner.velocity.padded() * t + 0.5 * t * t * g).length();
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

/// The free width of the narrowest door, m: between the wall discs that flank it, or of a surface; `None` without a door.
fn door_width(loaded: &Loaded, radius: f64) -> Option<f64> {
    let surfaces =
        loaded.scene.walls.iter().filter(|wall| loaded.scene.door_of(wall).is_some()).filter_map(|wall| match wall {
            Wall::Panel { along, across, .. } => Some(along.padded().length().min(across.padded().length())),
            Wall::Annulus { outer, .. } => Some(2.0 * outer.get()),
            Wall::Segment { from, to, .. } => Some(to.padded().distance(from.padded())),
            // The smallest extent is the thickness: about zero, or the height of a cap.
            Wall::Polygon { .. } | Wall::Mesh { .. } | Wall::SphericalZone { .. } => {
                wall.bounds().map(|[low, high]| {
                    let mut extents = (high - low).to_array();
                    extents.sort_unstable_by(f64::total_cmp);
                    extents[1]
                })
            }
            Wall::Cylinder { from, to, radius, .. } => {
                Some((2.0 * radius.get()).min(to.padded().distance(from.padded())))
            }
            Wall::Cone { from, to, radii, .. } => {
                Some((2.0 * radii.0.get().max(radii.1.get())).min(to.padded().distance(from.padded())))
            }
            _ => None,
        });
    let discs = loaded.wall_discs();
    let orifice = if loaded.silo.door.is_empty() {
        None
    } else {
        Outline::new(&discs, &loaded.silo.door, &loaded.surfaces(), radius).orifice()
    };
    let radius_at = |x| discs.iter().find(|disc| disc.centre == x).map_or(0.0, |disc| disc.radius);
    let between = orifice.map(|link| link.from.distance(link.to) - radius_at(link.from) - radius_at(link.to));
    surfaces.chain(between).reduce(f64::min)
}

/// Whether a door of discs is flanked by wall discs, or there is no such door.
fn has_orifice(loaded: &Loaded, radius: f64) -> bool {
    loaded.silo.door.is_empty()
        || Outline::new(&loaded.wall_discs(), &loaded.silo.door, &loaded.surfaces(), radius).orifice().is_some()
}

/// Conditions of `stop` that the grains of the scene cannot fulfil. Behaviours may release further grains.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the rules bound the count of a feed")]
fn stop(loaded: &Loaded, warnings: &mut Vec<Warning>) {
    let Scene { stop, spawner, feed, mass, behaviours, .. } = &loaded.scene;
    let start = u32::try_from(loaded.grains.len()).unwrap_or(u32::MAX);
    let all = spawner.iter().fold(start, |sum, spawner| sum.saturating_add(spawner.count));
    let fed = feed.iter().filter_map(|feed| feed.count((*mass)?)).map(|count| count as u32);
    let all = fed.fold(all, u32::saturating_add);
    let is_endless = feed.iter().any(|feed| feed.total.is_none());
    for condition in stop {
        if let StopCondition::Out(count) = *condition
            && count > all
            && !is_endless
            && behaviours.is_empty()
        {
            warnings.push(Warning {
                code: "check::stop_out_of_reach",
                message: format!("`stop` waits for {count} grains to leave, and the scene has {all}"),
                help: "the run ends when the silo is empty, or at `until`: lower the number".to_owned(),
            });
        }
    }
}

/// Feeds that would have to release more grains in a step than they may.
fn feeds(loaded: &Loaded, dt: f64, warnings: &mut Vec<Warning>) {
    let Some(mass) = loaded.scene.mass else { return };
    for (index, feed) in loaded.scene.feed.iter().enumerate() {
        let per_step = feed.grains_per_second(mass) * dt;
        if per_step > f64::from(feed.tries) {
            warnings.push(Warning {
                code: "check::feed_too_fast",
                message: format!(
                    "`feed[{index}]` is to release {per_step:.3e} grains in a step, and tries {} places",
                    feed.tries
                ),
                help: format!("lower `feed[{index}].rate`, or raise `feed[{index}].tries`"),
            });
        }
    }
}

/// Keys that still have an old name.
fn renamed_keys(loaded: &Loaded, warnings: &mut Vec<Warning>) {
    if loaded.source.value_of("energy_books").is_some() {
        warnings.push(Warning {
            code: "check::renamed_key",
            message: "the key `energy_books` is now called `energy_balance`".to_owned(),
            help: "write `energy_balance`: the next release does not know the old name".to_owned(),
        });
    }
}

fn step(estimates: &Estimates, warnings: &mut Vec<Warning>) {
    let Estimates { dt, pair_limit, bed_limit, .. } = *estimates;
    if dt >= bed_limit.min(pair_limit) {
        let (code, what, limit) = if dt >= pair_limit {
            ("check::unstable_step", "of a single contact", pair_limit)
        } else {
            ("check::unstable_bed", "of a dense bed", bed_limit)
        };
        warnings.push(Warning {
            code,
            message: format!(
                "the step of {dt:.3e} s is beyond the stability limit {what}, {limit:.3e} s: energy may grow"
            ),
            help: format!("lower `step` below {:.2e} s, or soften the contacts", bed_limit.min(pair_limit)),
        });
    }
}

fn softness(loaded: &Loaded, estimates: &Estimates, warnings: &mut Vec<Warning>) {
    let stiffness = estimates.stiffness;
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
    if estimates.impact_overlap > LARGE_OVERLAP {
        warnings.push(Warning {
            code: "check::deep_impacts",
            message: format!(
                "a grain that arrives at {:.1} m/s overlaps by up to {:.2} of its radius; the contact law is meant for small \
                 overlaps",
                estimates.impact_speed, estimates.impact_overlap
            ),
            help: "raise the stiffness, or let grains fall less far, if the impacts matter to you".to_owned(),
        });
    }
    if estimates.adhesive_overlap > LARGE_OVERLAP {
        warnings.push(Warning {
            code: "check::strong_adhesion",
            message: format!(
                "two bodies that touch at rest are pulled together by {:.2} of their radius; the contact law is meant for small overlaps",
                estimates.adhesive_overlap
            ),
            help: "raise the stiffness, or lower `contact.adhesion`".to_owned(),
        });
    }
    if estimates.static_overlap > LARGE_OVERLAP {
        warnings.push(Warning {
            code: "check::soft_bed",
            message: format!(
                "the weight of the grains presses those at the bottom together by {:.2} of their radius",
                estimates.static_overlap
            ),
            help: "raise the stiffness: the contact law is meant for small overlaps".to_owned(),
        });
    } else if estimates.caught_overlap > LARGE_OVERLAP {
        warnings.push(Warning {
            code: "check::caught_grains",
            message: format!(
                "the weight of the heaviest grain on a single smallest grain, of radius {} m, presses it together by {:.2} of \
                 its radius",
                estimates.radius, estimates.caught_overlap
            ),
            help: "raise the stiffness, or let sizes differ less: small grains that are caught between large ones may slip through"
                .to_owned(),
        });
    }
}

/// Returns the largest speed of a wall that moves, m/s. Walls without ends do not turn, so all others have bounds.
fn fastest_wall(loaded: &Loaded) -> f64 {
    let speed = |motion: &Motion| {
        let walls = loaded.scene.walls.iter().filter(|wall| wall.name() == Some(&motion.walls));
        let about = motion.rotate.as_ref().map_or(Solid::ZERO, |turn| turn.about.padded());
        let corners = walls.filter_map(Wall::bounds).map(|[low, high]| (high - about).abs().max((low - about).abs()));
        motion.fastest(corners.map(Solid::length).fold(0.0, f64::max))
    };
    let doors = loaded.scene.door_controls().into_iter().map(|(_, _, control)| match control.how {
        DoorMotion::Move { speed, .. } | DoorMotion::Slide(speed) => speed.get(),
        DoorMotion::Remove => 0.0,
    });
    loaded.scene.motions.iter().map(speed).chain(doors).fold(0.0, f64::max)
}

/// Warns of grains and walls that may pass each other within one step.
fn fast(loaded: &Loaded, estimates: &Estimates, warnings: &mut Vec<Warning>) {
    // For a wall surface: the distance of a centre from first touch to the other side.
    let flat = loaded.scene.walls.iter().any(Wall::is_surface).then_some(0.0);
    let discs = loaded.fixed_radii();
    let thickness = estimates.radius + discs.chain(flat).fold(f64::INFINITY, f64::min);
    let driven = loaded.fixed.iter().map(|grain| grain.velocity.length()).fold(fastest_wall(loaded), f64::max);
    let way = (estimates.impact_speed + driven) * estimates.dt;
    if thickness.is_finite() && way > thickness {
        warnings.push(Warning {
            code: "check::fast_grains",
            message: format!(
                "a grain moves up to {way:.3} m in a step, and may pass a wall of {thickness:.3} m unseen"
            ),
            help: "lower `step`".to_owned(),
        });
    } else if loaded.grains.len() > 1 && 2.0 * way > 2.0 * estimates.radius {
        warnings.push(Warning {
            code: "check::fast_grains",
            message: format!(
                "two grains approach by up to {:.3} m in a step, and may pass each other unseen: a grain is {:.3} m wide",
                2.0 * way,
                2.0 * estimates.radius
            ),
            help: "lower `step`".to_owned(),
        });
    }
}

/// Warns if a run that lasts to `until` would write very much. Shorter runs are judged by the rules.
fn output(loaded: &Loaded, estimates: &Estimates, warnings: &mut Vec<Warning>) {
    let steps = loaded.scene.until.get() / estimates.dt;
    let bytes = volume::total(&expected::outputs(loaded, estimates.dt), steps).bytes;
    if bytes > MOST_BYTES {
        warnings.push(Warning {
            code: "check::much_output",
            message: format!("a run that lasts to `until` would write about {:.1e} GB", bytes / 1e9),
            help: "lengthen `pictures.interval` or `series.interval`, or lower `until`".to_owned(),
        });
    }
}

/// The least energy, J, that squeezes a grain of this radius (m) between two neighbouring wall or door grains.
fn weakest_link(loaded: &Loaded, radius: f64, stiffness: f64) -> Option<f64> {
    let mut discs = loaded.wall_discs();
    discs.extend(&loaded.silo.door);
    let thinnest = discs.iter().map(|disc| disc.radius).fold(f64::INFINITY, f64::min);
    let outline = Outline::new(&discs, &[], &[], radius);
    let barrier = |distance: f64| stiffness * (radius + thinnest - 0.5 * distance).max(0.0).powi(2);
    outline.links().iter().map(|link| barrier(link.from.distance(link.to))).min_by(f64::total_cmp)
}
