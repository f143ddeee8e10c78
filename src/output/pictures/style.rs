//! The style of a scene's pictures.

use crate::scene::loaded::Loaded;
use crate::scene::outputs::{Colour, Pictures};
use crate::scene::view;
use siloflow_dem::math;
use siloflow_dem::space::{Dimension, Plane, Solid, Space};
use siloflow_dem::values::{Finite, Positive};
use siloflow_results::pictures::style::{Colouring, Style};

/// Returns the colours that a key of the scene asks for.
fn colouring(colour: &Colour) -> Colouring {
    match colour {
        Colour::Species => Colouring::Species,
        Colour::Speed(top) => Colouring::Speed(top.get()),
        Colour::Pressure(top) => Colouring::Pressure(top.get()),
        Colour::Column(name, from, to) => Colouring::Column { name: name.clone(), from: from.get(), to: to.get() },
    }
}

/// Returns the style of a scene's pictures. `pictures` is its section of that name, maybe changed.
#[must_use]
pub fn style(loaded: &Loaded, pictures: &Pictures) -> Style {
    let scene = &loaded.scene;
    let intervals = [
        scene.pictures.as_ref().map(|own| own.interval.get()),
        loaded.scene.data_frames.as_ref().and_then(|frames| Some(frames.interval?.get())),
    ];
    let interval = intervals.into_iter().flatten().fold(f64::INFINITY, f64::min);
    // Enough decimals to distinguish the times of successive pictures.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    let decimals = (1.0 - math::log10(interval).floor()).clamp(2.0, 9.0) as usize;
    Style {
        width: pictures.width.get(),
        colour: colouring(&pictures.colour),
        network: pictures.network.map(Positive::get),
        camera: view::camera(loaded, pictures),
        cut: pictures.cut.map(Finite::get),
        view: view::of(loaded, pictures),
        smallest_radius: loaded.grain_radii().map_or(0.0, |(smallest, _)| smallest),
        decimals,
        endless: match scene.space {
            Dimension::Plane => endless::<Plane>(loaded),
            Dimension::Solid => endless::<Solid>(loaded),
        },
    }
}

fn endless<V: Space>(loaded: &Loaded) -> Vec<u32> {
    let surfaces = loaded.surfaces::<V>();
    let endless = surfaces.iter().filter(|wall| wall.surface.bounds().is_none());
    endless.map(|wall| u32::try_from(wall.number + 1).unwrap_or(u32::MAX)).collect()
}
