//! Contact forces as bonds. A bond starts at the grain and ends at the centre of its partner, or at the nearest point of a wall. A
//! bond through a periodic side extends beyond that side.

use super::grains::Grains;
use super::point;
use super::style::Style;
use glam::{DVec2, DVec3};
use siloflow_figures::colour::Rgb;
use siloflow_files::frames::{Frame, Header, Table};

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
        if force > 0.0 && is_in_view {
            let width = (force / full).min(1.0) * style.smallest_radius;
            bonds.shapes.push((ends[0], ends[1], width, COLOURS[usize::from(is_sliding)]));
            bonds.kinds[usize::from(is_sliding)] = true;
        }
    };
    if let Some(table) = frame.table("contacts") {
        each(table, "partner", |_, grain, partner, force, is_sliding| {
            let (Some(grain), Some(partner)) = (grains.of_id(grain), grains.of_id(partner)) else { return };
            if grain.is_shown && partner.is_shown {
                let to = grain.position + nearest_image(header, partner.position - grain.position);
                add(grain.position, to, force, is_sliding);
            }
        });
    }
    if let Some(table) = frame.table("wall_contacts") {
        let points = table.floats("point").unwrap_or_default();
        each(table, "wall", |row, grain, _, force, is_sliding| {
            let (Some(grain), Some(to)) = (grains.of_id(grain), point(points, header.dimension, row)) else { return };
            if grain.is_shown {
                add(grain.position, to, force, is_sliding);
            }
        });
    }
    bonds
}

/// Calls `visit` for every contact of a table, with its row, grain, partner, normal force (N) and whether it slides.
fn each(table: &Table, partner: &str, mut visit: impl FnMut(usize, i64, i64, f64, bool)) {
    let (Some(grains), Some(partners), Some(forces), Some(sliding)) =
        (table.whole("grain"), table.whole(partner), table.floats("normal_force"), table.whole("sliding"))
    else {
        return;
    };
    for row in 0..table.rows {
        visit(row, grains[row], partners[row], forces[row], sliding[row] != 0);
    }
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
