//! Contacts of a frame as bytes: the lines of force chains.
//!
//! | part | content |
//! |---|---|
//! | count | number of contacts |
//! | length, bytes | length of the next part, and for each contact the row of its grain, less that of the contact before |
//! | length, bytes | for each contact the row of its partner, less that of the grain; or in each axis the point of a wall, less the grain's place |
//! | bytes | for each contact twice the level of its normal force (0 to 127), and 1 more if it slides |
//!
//! Contacts are in the order of rows. Those with less than [`WEAKEST`] of the force of the widest line are left out, as in pictures.

use super::bytes::{length, put, put_signed};
use super::grid::Grid;
use super::scale::Scale;
use crate::pictures::bonds::WEAKEST;
use siloflow_files::frames::{Frame, ParticleKey, Table};

/// Highest level of a force.
pub(super) const TOP_FORCE: f64 = 127.0;

/// Finds the row of a particle among the packed rows of a frame.
pub(super) type RowOf<'a> = &'a dyn Fn(ParticleKey) -> Option<u32>;

/// Returns the contacts between particles, and those with walls.
pub(super) fn pack(frame: &Frame, row_of: RowOf, places: &[[u16; 3]], grid: &Grid, forces: Scale) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut between = contacts(frame.table("contacts"), row_of, forces, |table| {
        let partners = table.particles("partner", "partner_sphere")?;
        Some(Box::new(move |row| row_of(*partners.get(row)?)))
    });
    for (first, second, _) in &mut between {
        if first > second {
            std::mem::swap(first, second);
        }
    }
    between.sort_unstable();
    let differences = |target: &mut Vec<u8>, first: u32, second: &u32| put(target, *second - first);
    add(&mut bytes, &between, differences);

    let axes = places_per_point(frame);
    let mut with_walls = contacts(frame.table("wall_contacts"), row_of, forces, |table| {
        let points = table.floats("point")?;
        Some(Box::new(move |row| {
            let mut point = [0.0; 3];
            point.get_mut(..axes)?.copy_from_slice(points.get(row * axes..(row + 1) * axes)?);
            Some(grid.point(point))
        }))
    });
    with_walls.sort_unstable();
    add(&mut bytes, &with_walls, |target, first, point| {
        let place = places.get(first as usize).copied().unwrap_or_default();
        (0..axes).for_each(|axis| put_signed(target, point[axis] - i32::from(place[axis])));
    });
    bytes
}

/// Number of components of a wall's point.
fn places_per_point(frame: &Frame) -> usize {
    let column = frame.table("wall_contacts").and_then(|table| table.column("point"));
    column.map_or(0, |column| usize::from(column.components).min(3))
}

type Target<'a, T> = Box<dyn Fn(usize) -> Option<T> + 'a>;

/// Returns row, partner and force of each contact that can be drawn.
fn contacts<'a, T>(
    table: Option<&'a Table>,
    row_of: RowOf,
    scale: Scale,
    partner: impl FnOnce(&'a Table) -> Option<Target<'a, T>>,
) -> Vec<(u32, T, u8)> {
    let columns = table.and_then(|table| {
        Some((
            table.rows,
            table.particles("grain", "sphere")?,
            table.floats("normal_force")?,
            table.whole("sliding"),
            partner(table)?,
        ))
    });
    let Some((rows, grains, forces, sliding, partner)) = columns else { return Vec::new() };
    let contact = |row: usize| {
        let level = scale.level(forces.get(row)?.abs(), TOP_FORCE);
        // A force that is no number has a level above the highest.
        if f64::from(level) < WEAKEST * TOP_FORCE || f64::from(level) > TOP_FORCE {
            return None;
        }
        let slides = sliding.as_ref().and_then(|sliding| sliding.get(row)).is_some_and(|&slides| slides != 0);
        Some((row_of(*grains.get(row)?)?, partner(row)?, 2 * level + u8::from(slides)))
    };
    (0..rows).filter_map(contact).collect()
}

fn add<T>(bytes: &mut Vec<u8>, contacts: &[(u32, T, u8)], put_partner: impl Fn(&mut Vec<u8>, u32, &T)) {
    let mut rows = Vec::new();
    let mut partners = Vec::new();
    let mut before = 0;
    for (first, partner, _) in contacts {
        put(&mut rows, first - before);
        put_partner(&mut partners, *first, partner);
        before = *first;
    }
    put(bytes, length(contacts.len()));
    for part in [rows, partners] {
        put(bytes, length(part.len()));
        bytes.extend(part);
    }
    bytes.extend(contacts.iter().map(|(_, _, force)| force));
}
