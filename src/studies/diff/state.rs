//! The states of two runs, and their first difference.

use std::collections::BTreeMap;

use bevy_ecs::prelude::*;

use crate::studies::diff::report::{Difference, Quantity, Value};
use siloflow_dem::particle::{Force, GrainId, Mass, Position, Radius, Velocity};
use siloflow_dem::space::{Dimension, Plane, Solid, Space};
use siloflow_dem::spin::{Spin, Torque};
use siloflow_lattice::gas::Gas;
use siloflow_lattice::sites::Sites;

/// The quantities of a particle, in the order in which a step computes them.
const QUANTITIES: [Quantity; 7] = [
    Quantity::Radius,
    Quantity::Mass,
    Quantity::Position,
    Quantity::Force,
    Quantity::Torque,
    Quantity::Velocity,
    Quantity::Spin,
];

/// Index of the position in [`QUANTITIES`].
const POSITION: usize = 2;

/// Values of the [`QUANTITIES`] of a particle; `None` for a quantity that it does not have.
type Values = [Option<Value>; QUANTITIES.len()];

/// Returns the first difference of two worlds of grains.
pub(super) fn of_grains(worlds: [&World; 2]) -> Option<Difference> {
    let [first, second] = worlds.map(|world| match Dimension::of_world(world) {
        Dimension::Plane => particles::<Plane>(world),
        Dimension::Solid => particles::<Solid>(world),
    });
    // If all rows are equal, there is no difference. For most steps of most pairs this check is sufficient.
    if first == second {
        return None;
    }
    let [first, second] = [first, second].map(|rows| rows.into_iter().collect::<BTreeMap<_, _>>());
    let only_in_second = second.keys().filter(|id| !first.contains_key(id));
    let differing: Vec<_> = first
        .keys()
        .chain(only_in_second)
        .filter_map(|id| {
            let (quantity, values) = of_particle(first.get(id), second.get(id))?;
            Some((quantity, *id, values))
        })
        .collect();
    let particles = differing.len();
    let earliest = differing.into_iter().min_by_key(|(quantity, id, _)| (*quantity, *id));
    earliest.map(|(quantity, particle, values)| Difference::Particle { particle, quantity, values, particles })
}

/// Returns the first quantity of a particle in which two runs differ, among the quantities that both have.
fn of_particle(first: Option<&Values>, second: Option<&Values>) -> Option<(Quantity, [Option<Value>; 2])> {
    let (Some(a), Some(b)) = (first, second) else {
        return Some((Quantity::Presence, [first, second].map(|values| values.and_then(|values| values[POSITION]))));
    };
    let differs = |i: &usize| a[*i].is_some() && b[*i].is_some() && a[*i] != b[*i];
    (0..QUANTITIES.len()).find(differs).map(|i| (QUANTITIES[i], [a[i], b[i]]))
}

/// Returns all particles, including wall grains, in the order of the table rows.
fn particles<V: Space>(world: &World) -> Vec<(GrainId, Values)> {
    let Some(mut rows) = world.try_query_filtered::<EntityRef, With<GrainId>>() else { return Vec::new() };
    let row = |particle: EntityRef| {
        let id = *particle.get::<GrainId>()?;
        let force = particle.get::<Force<V>>().filter(|_| !id.is_wall());
        let values = [
            particle.get::<Radius>().map(|radius| Value::of(radius.0)),
            particle.get::<Mass>().map(|mass| Value::of(mass.0)),
            particle.get::<Position<V>>().map(|x| Value::of(x.0)),
            force.map(|force| Value::of(force.0)),
            particle.get::<Torque<V::Spin>>().map(|torque| Value::of(torque.0)),
            particle.get::<Velocity<V>>().map(|v| Value::of(v.0)),
            particle.get::<Spin<V::Spin>>().map(|spin| Value::of(spin.0)),
        ];
        Some((id, values))
    };
    rows.iter(world).filter_map(row).collect()
}

/// Returns whether two worlds have the same lattice sites; `true` unless both have a lattice.
pub(super) fn have_same_sites(worlds: [&World; 2]) -> bool {
    let [first, second] = worlds.map(|world| world.get_resource::<Sites>());
    match (first, second) {
        (Some(a), Some(b)) => {
            let origins = [a, b].map(|sites| Value::of(sites.position(0)));
            a.spacing.to_bits() == b.spacing.to_bits()
                && (a.stride, &a.runs, &a.doorway) == (b.stride, &b.runs, &b.doorway)
                && origins[0] == origins[1]
        }
        _ => true,
    }
}

/// Returns the first difference of two lattice gases on the same sites.
pub(super) fn of_gas(worlds: [&World; 2]) -> Option<Difference> {
    let [first, second] = worlds.map(|world| world.resource::<Gas>().states());
    if first == second {
        return None;
    }
    let sites = worlds[0].resource::<Sites>();
    let differing: Vec<_> = sites.fluid().filter(|&site| first[site] != second[site]).collect();
    let site = *differing.first()?;
    let place = Value::of(sites.position(site));
    Some(Difference::Site { place, values: [first[site], second[site]], sites: differing.len() })
}
