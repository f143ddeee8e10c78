//! Compares the step with the stability limit of the overlaps at the start.
//!
//! Deep overlaps are stiff in laws that stiffen with the overlap, and a grain may have far more of them than a bed allows. Where there
//! are any, the step has a limit L of its own: 1/L^2 = max_i sum_j 1/L_ij^2, over the contacts j of a grain i at the start. L_ij is the limit of
//! the contact alone at its overlap ([`SpeciesPair::lone_limit`]). For equal masses m and normal springs k without drag, L is
//! 2/sqrt(max_i (2/m) sum_j k_ij), and Gershgorin's theorem says that no motion of the grains is faster than this root.

use rustc_hash::FxHashMap;

use crate::scene::check::lightest;
use crate::scene::check::quantities::Estimates;
use crate::scene::check::species_pairs::SpeciesPair;
use crate::scene::check::start::{Body, touching};
use crate::scene::loaded::Loaded;
use siloflow_dem::budget::Budget;
use siloflow_dem::space::Space;
use siloflow_dem::walls::surfaces::Surfaces;
use siloflow_text::fault::Warning;

/// Adds the warning about the step.
pub(super) fn examine<V: Space>(
    loaded: &Loaded,
    estimates: &Estimates,
    bodies: &[Body],
    surfaces: &Surfaces<V>,
    budget: &Budget,
    warnings: &mut Vec<Warning>,
) {
    // 1/L^2 of each grain, 1/s^2.
    let mut rates: FxHashMap<u32, f64> = FxHashMap::default();
    let mut add = |grains: &[&Body], partners: [(u8, lightest::Body); 2], overlap: f64| {
        let limit = SpeciesPair::pressed(loaded, partners, overlap).lone_limit(estimates.scheme);
        for (_, id) in grains.iter().filter_map(|body| body.grain) {
            *rates.entry(id).or_default() += limit.powi(-2);
        }
    };
    let _ = touching(bodies, "the stability limit of all overlaps at the start", budget, |a, b, distance| {
        // Wall grains come first, so the second body is the grain.
        if b.grain.is_some() {
            add(&[a, b], [b.partner(), a.partner()], a.radius + b.radius - distance);
        }
    });
    for body in bodies.iter().filter(|body| body.grain.is_some()).take_while(|_| !budget.is_spent()) {
        let x = V::narrow(body.centre);
        let near = surfaces.near(x, body.radius);
        for wall in near.iter().take_while(|_| !budget.is_spent()).map(|number| &surfaces.all[number]) {
            let overlap = body.radius - wall.surface.distance(x);
            let flat = lightest::Body::sphere(f64::INFINITY, f64::INFINITY);
            if overlap > 0.0 {
                add(&[body], [body.partner(), (wall.species.0, flat)], overlap);
            }
        }
    }
    let Some((id, rate)) = rates.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)) else { return };
    let dt = estimates.dt;
    let limit = rate.sqrt().recip();
    if dt >= limit {
        warnings.push(Warning {
            code: "check::unstable_start",
            message: format!(
                "the step of {dt:.3e} s is beyond the stability limit of the overlaps at the start, {limit:.3e} s at grain {id}: energy may \
                 grow"
            ),
            help: format!("move the grains apart, or lower `step` below {limit:.2e} s"),
        });
    }
}
