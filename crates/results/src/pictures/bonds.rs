//! Contact forces as bonds. A bond starts at the grain and ends at the centre of its partner, or at the nearest point of a wall. A
//! bond through a periodic side extends beyond that side. Forces below a tenth of that of the widest bond are left out: most contacts of a bed carry
//! little, and without them the chains are seen that carry the load.

use super::grains::Grains;
use super::point;
use super::style::Style;
use glam::{DVec2, DVec3};
use siloflow_figures::colour::Rgb;
use siloflow_files::frames::{Frame, Header, ParticleKey, Table};

/// The weakest force that is drawn, over the force of the widest bond.
pub(crate) const WEAKEST: f64 = 0.1;

/// Bond colours of sticking and of sliding contacts.
pub(super) const COLOURS: [Rgb; 2] = [[0x1a, 0x1a, 0x1a], [0xf0, 0x6c, 0x00]];

/// The bonds of a frame.
#[derive(Default)]
pub(super) struct Bonds {
    /// Ends, m, width, m, and colour.
    pub shapes: Vec<(DVec2, DVec2, f64, Rgb)>,
    /// Whether there are sticking and sliding contacts among them.
    pub kinds: [bool; 2],
}

pub(super) fn of(header: &Header, frame: &Frame, style: &Style, grains: &Grains) -> Bonds {
    let mut bonds = Bonds::default();
    let Some(full) = style.network else { return bonds };
    let mut add = |from: DVec3, to: DVec3, force: f64, is_sliding: bool| {
        let ends = [from, to].map(|end| style.camera.on_paper(end));
        let (low, high) = style.view;
        let is_in_view = ends[0].max(ends[1]).cmpge(low).all() && ends[0].min(ends[1]).cmple(high).all();
        if force >= WEAKEST * full && is_in_view {
            let width = (force / full).min(1.0) * style.smallest_radius;
            bonds.shapes.push((ends[0], ends[1], width, COLOURS[usize::from(is_sliding)]));
            bonds.kinds[usize::from(is_sliding)] = true;
        }
    };
    if let Some((table, contacts)) = frame.table("contacts").and_then(|table| Some((table, contacts(table)?))) {
        let partners = table.particles("partner", "partner_sphere").unwrap_or_default();
        for (contact, partner) in contacts.iter().zip(partners) {
            let (Some(grain), Some(partner)) = (grains.particle(contact.grain), grains.particle(partner)) else {
                continue;
            };
            if grain.is_shown && partner.is_shown {
                let to = grain.position + nearest_image(header, partner.position - grain.position);
                add(grain.position, to, contact.force, contact.is_sliding);
            }
        }
    }
    if let Some((table, contacts)) = frame.table("wall_contacts").and_then(|table| Some((table, contacts(table)?))) {
        let points = table.floats("point").unwrap_or_default();
        for (row, contact) in contacts.iter().enumerate() {
            let Some((grain, to)) = grains.particle(contact.grain).zip(point(points, header.dimension, row)) else {
                continue;
            };
            if grain.is_shown {
                add(grain.position, to, contact.force, contact.is_sliding);
            }
        }
    }
    bonds
}

/// A contact as seen from its grain.
struct Contact {
    grain: ParticleKey,
    /// Normal force, N.
    force: f64,
    is_sliding: bool,
}

/// Returns the contacts of a table, row by row; `None` if a column is missing.
fn contacts(table: &Table) -> Option<Vec<Contact>> {
    let grains = table.particles("grain", "sphere")?;
    let forces = table.floats("normal_force")?;
    let sliding = table.whole("sliding")?;
    let rows = grains.into_iter().zip(forces).zip(sliding);
    Some(rows.map(|((grain, &force), sliding)| Contact { grain, force, is_sliding: sliding != 0 }).collect())
}

/// Returns the shortest of all images of a separation, m.
fn nearest_image(header: &Header, mut separation: DVec3) -> DVec3 {
    for (axis, side) in header.periodic.iter().enumerate() {
        if let Some((low, high)) = side {
            let length = high - low;
            separation[axis] -= length * (separation[axis] / length).round();
        }
    }
    separation
}
