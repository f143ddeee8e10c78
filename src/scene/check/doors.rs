//! Warnings about doors through which no grain can leave, or be counted.

use std::collections::BTreeMap;

use crate::scene::loaded::Loaded;
use siloflow_dem::space::{Dimension, Solid};
use siloflow_dem::walls::enclosure::Enclosure;
use siloflow_text::fault::Warning;

/// Adds the warnings about doors, for grains of this radius (m) or more.
pub(super) fn examine(loaded: &Loaded, radius: f64, warnings: &mut Vec<Warning>) {
    if let Some(width) = door_width(loaded, radius).filter(|&width| width < 2.0 * radius) {
        warnings.push(Warning {
            code: "check::narrow_door",
            message: format!(
                "the door is {width:.3} m wide, and the smallest grain {:.3} m: no grain can leave",
                2.0 * radius
            ),
            help: "widen the door, or release smaller grains".to_owned(),
        });
    }
    if !has_orifice(loaded, radius) {
        warnings.push(Warning {
            code: "check::no_orifice",
            message: "the door has no wall disc of the silo file on each side, so it has no orifice: grains that leave count as lost"
                .to_owned(),
            help: "add to the silo file a wall disc at each end of the door".to_owned(),
        });
    }
}

/// The free width of the narrowest door, m: between the wall discs that flank it, or of a surface; `None` without a door.
pub(super) fn door_width(loaded: &Loaded, radius: f64) -> Option<f64> {
    let own = loaded.scene.walls.len() - loaded.walls_of_fills.len();
    let doors = loaded.scene.walls[..own].iter().filter(|wall| loaded.scene.door_of(wall).is_some());
    let surfaces = doors.filter_map(|wall| wall.shape.width()).chain(widths_of_fills(loaded, own));
    let discs = loaded.wall_discs();
    let orifice = if loaded.silo.door.is_empty() {
        None
    } else {
        Enclosure::new(&discs, &loaded.silo.door, &loaded.own_surfaces(), radius).orifice()
    };
    let radius_at = |x| discs.iter().find(|disc| disc.centre == x).map_or(0.0, |disc| disc.radius);
    let between = orifice.map(|link| link.from.distance(link.to) - radius_at(link.from) - radius_at(link.to));
    surfaces.chain(between).reduce(f64::min)
}

/// The widths of doors of fixed grains, m: of the box round all spheres of a door. Walls from the number `first` on are such spheres.
fn widths_of_fills(loaded: &Loaded, first: usize) -> impl Iterator<Item = f64> {
    let mut boxes: BTreeMap<u16, [Solid; 2]> = BTreeMap::new();
    for wall in &loaded.scene.walls[first..] {
        if let Some((door, [low, high])) = loaded.scene.door_of(wall).zip(wall.bounds()) {
            let whole = boxes.entry(door).or_insert([low, high]);
            *whole = [whole[0].min(low), whole[1].max(high)];
        }
    }
    // The smallest extent is the thickness; in the plane there is only one other.
    let across = if loaded.scene.space == Dimension::Plane { 2 } else { 1 };
    boxes.into_values().map(move |[low, high]| {
        let mut extents = (high - low).to_array();
        extents.sort_unstable_by(f64::total_cmp);
        extents[across]
    })
}

/// Whether a door of discs is flanked by wall discs, or there is no such door.
fn has_orifice(loaded: &Loaded, radius: f64) -> bool {
    loaded.silo.door.is_empty()
        || Enclosure::new(&loaded.wall_discs(), &loaded.silo.door, &loaded.own_surfaces(), radius).orifice().is_some()
}
