//! Examines the start of a run: deep overlaps, grains inside walls, wall grains at one place, and the release point.
//!
//! An overlap counts from [`LARGE_OVERLAP`] of the smaller radius on, because a bed at rest has small ones. Pairs that meet
//! through a periodic side are not examined. Where all bodies overlap, all pairs touch; the budget ends the search then, and warnings count what was found.

mod release;
mod stability;

use rustc_hash::FxHashMap;

use crate::ending::watchdog::overlap::LARGE_OVERLAP;
use crate::scene::check::lightest;
use crate::scene::check::quantities::Estimates;
use crate::scene::loaded::Loaded;
use siloflow_dem::budget::Budget;
use siloflow_dem::space::{Dimension, Plane, Solid, Space};
use siloflow_dem::walls::config::Wall;
use siloflow_dem::walls::surfaces::Surfaces;
use siloflow_text::fault::Warning;

/// Warnings of deep overlaps.
const DEEP: [&str; 2] = ["check::overlaps_at_start", "check::starts_in_wall"];

/// A disc or sphere at the start.
struct Body {
    centre: Solid,
    radius: f64,
    species: u8,
    /// Mass (kg) and id of a grain; `None` for a wall grain.
    grain: Option<(f64, u32)>,
}

impl Body {
    /// The body as a partner of a contact.
    fn partner(&self) -> (u8, lightest::Body) {
        let mass = self.grain.map_or(f64::INFINITY, |(mass, _)| mass);
        (self.species, lightest::Body::sphere(mass, self.radius))
    }
}

/// Adds the warnings about the start. A scene without estimates has no grains.
pub(super) fn examine(loaded: &Loaded, estimates: Option<&Estimates>, budget: &Budget, warnings: &mut Vec<Warning>) {
    match loaded.scene.space {
        Dimension::Plane => examine_in::<Plane>(loaded, estimates, budget, warnings),
        Dimension::Solid => examine_in::<Solid>(loaded, estimates, budget, warnings),
    }
}

fn examine_in<V: Space>(loaded: &Loaded, estimates: Option<&Estimates>, budget: &Budget, warnings: &mut Vec<Warning>) {
    let bodies = bodies(loaded);
    let before = warnings.len();
    budget.share(0.5, || pairs(&bodies, budget, warnings));
    let largest = loaded.grain_radii().map_or(0.0, |(_, largest)| largest);
    let surfaces = Surfaces::<V>::new(loaded.surfaces(), largest);
    let grains = bodies.iter().filter(|body| body.grain.is_some());
    let grains = budget.share(0.5, || {
        let examined = grains.map_while(|body| Some((body, distances_within(&surfaces, body, budget)?)));
        let examined: Vec<_> = examined.collect();
        let all = bodies.iter().filter(|body| body.grain.is_some()).count();
        if examined.len() < all {
            budget.give_up(format!("grains in walls at the start, after {} of {all} grains", examined.len()));
        }
        examined
    });
    let mut behind = grains.iter().filter(|(_, [half, _])| *half <= 0.0).map(|(body, _)| *body);
    inside(behind.next(), "behind a half-plane", warnings);
    let pressed = |(body, [half, thin]): &(&Body, [f64; 2])| {
        *half > 0.0 && body.radius - half.min(*thin) > LARGE_OVERLAP * body.radius
    };
    let pressed: Vec<_> = grains.iter().filter(|grain| pressed(grain)).map(|(body, _)| *body).collect();
    if let Some(first) = pressed.first() {
        overlapping(
            &pressed.len().to_string(),
            &format!("{} and a wall surface at {}", name(first), place(first.centre)),
            warnings,
        );
    }
    let is_deep = warnings[before..].iter().any(|warning| DEEP.contains(&warning.code));
    if let Some(estimates) = estimates.filter(|_| is_deep) {
        stability::examine(loaded, estimates, &bodies, &surfaces, budget, warnings);
    }
    let all = 0..surfaces.all.len();
    release::examine(loaded, &bodies, |x| distances(&surfaces, all.clone(), x), warnings);
}

fn bodies(loaded: &Loaded) -> Vec<Body> {
    let disc = |centre: Solid, radius: f64, species: u8| Body { centre, radius, species, grain: None };
    let of_silo = loaded.scene.silo.as_ref().map_or(0, |silo| silo.species);
    let silo = loaded.silo.wall.iter().chain(&loaded.silo.door).map(|d| disc(d.centre.extend(0.0), d.radius, of_silo));
    let own = loaded.scene.walls.iter().filter_map(Wall::wall_grain);
    let own = own.map(|grain| disc(grain.centre.padded(), grain.radius, grain.species.0));
    let fixed = loaded.fixed.iter().map(|grain| disc(grain.position, grain.radius, grain.species.0));
    let grains = loaded.grains.iter().flat_map(|grain| {
        loaded.spheres_of(grain).into_iter().map(|(centre, radius)| Body {
            centre,
            radius,
            species: grain.species.0,
            grain: Some((grain.mass, grain.id.number())),
        })
    });
    silo.chain(own).chain(fixed).chain(grains).collect()
}

fn name(body: &Body) -> String {
    body.grain.map_or("a wall grain".to_owned(), |(_, id)| format!("grain {id}"))
}

fn place(x: Solid) -> String {
    format!("({}, {}, {}) m", x.x, x.y, x.z)
}

/// Least distance (m) to a solid wall, negative inside it, and to a thin wall, of the walls that the body may touch. `None` if the budget ended.
fn distances_within<V: Space>(surfaces: &Surfaces<V>, body: &Body, budget: &Budget) -> Option<[f64; 2]> {
    let near = surfaces.near(V::narrow(body.centre), body.radius);
    let found = distances(surfaces, near.iter().take_while(|_| !budget.is_spent()), body.centre);
    (!budget.is_spent()).then_some(found)
}

/// Least distance (m) to a solid wall, negative inside it, and to a thin wall, of those with these numbers.
fn distances<V: Space>(surfaces: &Surfaces<V>, numbers: impl Iterator<Item = usize>, x: Solid) -> [f64; 2] {
    numbers.map(|number| &surfaces.all[number].surface).fold([f64::INFINITY; 2], |[solid, thin], surface| {
        let distance = surface.distance(V::narrow(x));
        if surface.shape().is_solid() { [solid.min(distance), thin] } else { [solid, thin.min(distance)] }
    })
}

/// Calls `visit` with pairs of bodies that touch, until the budget ends; it is told then what was not examined: `what`. Returns whether all were visited. A body is compared with
/// those in its cell and in the cells around, and a cell is as wide as the largest body.
fn touching<'a>(
    bodies: &'a [Body],
    what: &str,
    budget: &Budget,
    mut visit: impl FnMut(&'a Body, &'a Body, f64),
) -> bool {
    let width = 2.0 * bodies.iter().map(|body| body.radius).fold(0.0, f64::max);
    #[expect(clippy::cast_possible_truncation, reason = "saturates far outside any scene")]
    let cell = |x: Solid| (x / width).floor().to_array().map(|number| number as i64);
    let mut cells: FxHashMap<[i64; 3], Vec<usize>> = FxHashMap::default();
    for (number, body) in bodies.iter().enumerate() {
        let [x, y, z] = cell(body.centre);
        for around in 0..27 {
            let key = [
                x.saturating_add(around % 3 - 1),
                y.saturating_add(around / 3 % 3 - 1),
                z.saturating_add(around / 9 - 1),
            ];
            for &other in cells.get(&key).into_iter().flatten() {
                if budget.is_spent() {
                    break;
                }
                let distance = body.centre.distance(bodies[other].centre);
                // Spheres of one grain do not touch each other.
                let is_one =
                    body.grain.is_some() && body.grain.map(|(_, id)| id) == bodies[other].grain.map(|(_, id)| id);
                if distance < body.radius + bodies[other].radius && !is_one {
                    visit(&bodies[other], body, distance);
                }
            }
        }
        if budget.is_spent() {
            budget.give_up(format!("{what}, after {number} of {} bodies", bodies.len()));
            return false;
        }
        cells.entry([x, y, z]).or_default().push(number);
    }
    true
}

fn pairs(bodies: &[Body], budget: &Budget, warnings: &mut Vec<Warning>) {
    let mut deep = 0;
    let mut deepest = (0.0, String::new());
    let mut within = None;
    let mut doubled = (0, String::new());
    let are_all = touching(bodies, "overlaps at the start", budget, |a, b, distance| {
        let smaller = a.radius.min(b.radius);
        let share = (a.radius + b.radius - distance) / smaller;
        if a.grain.is_none() && b.grain.is_none() {
            if distance <= 1e-6 * smaller {
                doubled.0 += 1;
                if doubled.0 == 1 {
                    doubled.1 = place(a.centre);
                }
            }
        } else if a.grain.is_none() && distance < a.radius {
            // Wall grains come first, so the second body is the grain.
            within = within.or(Some(b));
        } else if share > LARGE_OVERLAP {
            deep += 1;
            if share > deepest.0 {
                deepest = (share, format!("{} and {} at {}", name(a), name(b), place(b.centre)));
            }
        }
    });
    if doubled.0 > 0 {
        warnings.push(Warning {
            code: "check::duplicate_wall_grains",
            message: format!(
                "{} pairs of wall grains stand at one place, one at {}: contacts there count twice",
                doubled.0, doubled.1
            ),
            help: "remove one of the two".to_owned(),
        });
    }
    inside(within, "inside a wall grain", warnings);
    if deep > 0 {
        let count = if are_all { deep.to_string() } else { format!("at least {deep}") };
        overlapping(&count, &deepest.1, warnings);
    }
}

fn inside(first: Option<&Body>, what: &str, warnings: &mut Vec<Warning>) {
    if let Some(first) = first {
        warnings.push(Warning {
            code: "check::starts_in_wall",
            message: format!("the centre of {} starts {what}, at {}", name(first), place(first.centre)),
            help: "move the grain: it will be pushed out at high speed, or through the wall".to_owned(),
        });
    }
}

fn overlapping(count: &str, example: &str, warnings: &mut Vec<Warning>) {
    warnings.push(Warning {
        code: "check::overlaps_at_start",
        message: format!("{count} contacts start with an overlap of more than {LARGE_OVERLAP} of the smaller radius, for example {example}"),
        help: "move them apart: their elastic energy is released at the start".to_owned(),
    });
}
