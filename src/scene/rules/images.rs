//! Rules on walls in a periodic box: each must have images beyond the sides that it reaches, or be the same in all of them.

use crate::scene::loaded::Loaded;
use siloflow_dem::space::{Dimension, Plane, Solid, Space};
use siloflow_text::fault::Fault;

pub(super) fn images(loaded: &Loaded) -> Result<(), Fault> {
    if loaded.scene.periodic.is_open() {
        return Ok(());
    }
    match loaded.scene.space {
        Dimension::Plane => images_in::<Plane>(loaded),
        Dimension::Solid => images_in::<Solid>(loaded),
    }
}

fn images_in<V: Space>(loaded: &Loaded) -> Result<(), Fault> {
    let largest = loaded.grain_radii().map_or(0.0, |(_, largest)| largest);
    for (index, wall) in loaded.scene.walls.iter().enumerate() {
        loaded.images(wall, &wall.surfaces::<V>(0), largest).map_err(|problem| {
            let message = format!("this wall cannot be repeated beyond the periodic sides: {problem}");
            loaded.fault("scene::wall_at_side", &loaded.key_of_wall(index), message).help(
                "let it end more than a grain's radius before the side, give it a motion along or about the periodic axis, or \
                 leave the side open",
            )
        })?;
    }
    Ok(())
}
