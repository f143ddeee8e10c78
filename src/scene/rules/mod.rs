//! Rules between keys, which the range of a single number cannot express.

mod contacts;
mod cuts;
mod directions;
mod doors;
mod fields;
mod free_walls;
mod grains;
mod images;
mod motions;
mod outflow;
mod outputs;
mod slopes;
mod space;
mod stop;
mod walls;

pub use self::grains::fill;
pub use self::space::space;

use self::contacts::contacts;
use self::directions::is_box;
use self::grains::{feed, ids, spawner};
use crate::scene::check;
use crate::scene::loaded::Loaded;
use crate::scene::{Scene, TimeStep};
use siloflow_dem::contact::Contact;
use siloflow_dem::integrate::Integrator;
use siloflow_dem::neighbours::Neighbours;
use siloflow_dem::space::Solid;
use siloflow_text::fault::Fault;

/// Checks a scene whose files have been read.
///
/// # Errors
/// The first broken rule, with the key at fault.
pub fn check(loaded: &Loaded) -> Result<(), Fault> {
    contacts(loaded)?;
    ids(loaded)?;
    walls::shapes(loaded)?;
    cuts::cuts(loaded)?;
    walls::discs(loaded)?;
    walls::names(loaded)?;
    periodic(loaded)?;
    spawner(loaded)?;
    feed(loaded)?;
    motions::motions(loaded)?;
    free_walls::free_walls(loaded)?;
    doors::doors(loaded)?;
    images::images(loaded)?;
    rest(loaded)?;
    stop::stop(loaded)?;
    energy_balance(loaded)?;
    cells(loaded)?;
    profiles(loaded)?;
    outputs::wall_bands(loaded)?;
    outputs::bins(loaded)?;
    fields::fields(loaded)?;
    outflow::outflow(loaded)?;
    slopes::slopes(loaded)?;
    flow(loaded)?;
    view_and_bed(loaded)?;
    outputs::pictures(loaded)?;
    outputs::data_frames(loaded)?;
    // Last, because the estimates rely on keys that the other rules check.
    step(loaded)?;
    outputs::volume(loaded)
}

/// A fixed step must be stable for every pair that can meet; an automatic step needs a scheme that supports it.
fn step(loaded: &Loaded) -> Result<(), Fault> {
    let scheme = loaded.scene.integrator;
    let is_explicit = scheme == Integrator::ExplicitEuler;
    match loaded.scene.step {
        TimeStep::Auto { .. } if is_explicit => Err(loaded
            .fault("scene::auto_step", "step", "no step makes explicit Euler stable without drag")
            .help("give `Fixed(...)`, in s, to see it fail, or use `Centred`")),
        TimeStep::Fixed(dt) if is_known(loaded) => {
            let Some((meeting, limit)) = check::hardest(loaded).filter(|&(_, limit)| dt.get() > limit) else {
                return Ok(());
            };
            let (a, b) = meeting.species;
            let message = format!(
                "with a step of {:.3e} s a contact of {} is unstable under `{scheme:?}`: the limit is {limit:.3e} s",
                dt.get(),
                match (meeting.is_wall, a.max(b)) {
                    (false, 0) => "the two lightest grains".to_owned(),
                    (true, 0) => "the lightest grain with a wall".to_owned(),
                    (false, _) => format!("the lightest grains of species {a} and {b}"),
                    (true, _) => format!("the lightest grain of species {a} with a wall of species {b}"),
                }
            );
            Err(loaded
                .fault("scene::unstable_step", "step", message)
                .help("lower the step, soften the contacts, or let `Auto(error: 1.0e-3)` choose"))
        }
        TimeStep::Auto { .. } if !loaded.step().is_normal() => Err(loaded
            .fault("scene::auto_step", "step", "no step can be estimated for contacts and grains of this kind")
            .help("are masses, radii and stiffness in SI units? Or give `Fixed(...)`, in s")),
        _ => Ok(()),
    }
}

/// Whether the stiffness of contacts is certain before the run. Hertz's stiffness depends on speeds, and a behaviour may
/// bring its own law or masses. Explicit Euler is meant to fail; there `check` warns.
fn is_known(loaded: &Loaded) -> bool {
    let Scene { integrator, contact, behaviours, .. } = &loaded.scene;
    *integrator != Integrator::ExplicitEuler && !matches!(contact, Contact::Hertz { .. }) && behaviours.is_empty()
}

fn profiles(loaded: &Loaded) -> Result<(), Fault> {
    for (index, profile) in loaded.scene.profiles.iter().enumerate() {
        let key = |name: &str| format!("profiles[{index}].{name}");
        let (code, key, message) = if profile.axis.number() >= loaded.scene.space.count() {
            ("scene::dimension", key("axis"), "the plane has no z")
        } else if profile.low.get() >= profile.high.get() {
            ("scene::empty_box", key("high"), "the first bin must begin below the end of the last one")
        } else if !(1..=10_000).contains(&profile.bins) {
            ("scene::out_of_range", key("bins"), "expected 1 to 10000 bins")
        } else if profile.section.is_none() && loaded.periodic_section(profile).is_none() {
            ("scene::missing_key", key("section"), "a packing fraction needs to know the section of the bins")
        } else {
            continue;
        };
        return Err(loaded.fault(code, &key, message).help(
            "give the area at right angles to the axis, m^2 (in the plane its length, m), `low` and `high` in m",
        ));
    }
    Ok(())
}

/// The window of the discharge must begin before it ends, and the scene must have an outlet.
fn flow(loaded: &Loaded) -> Result<(), Fault> {
    let Some(flow) = loaded.scene.flow else { return Ok(()) };
    if flow.from >= flow.to {
        let message = format!("the window is empty: it begins at {} and ends at {}", flow.from.get(), flow.to.get());
        return Err(loaded
            .fault("scene::out_of_range", "flow.to", message)
            .help("`from` and `to` are shares of the released grains that are out, for example 0.05 and 0.4"));
    }
    if flow.from.get() > 0.0 && loaded.silo.door.is_empty() {
        return Err(loaded
            .fault("scene::no_door", "flow", "no grain will ever be out: no silo file announces door grains")
            .help(
                "give a silo file whose first line has a second count above 0, or sample all along with `from: 0.0`",
            ));
    }
    Ok(())
}

/// In a periodic box a grain must not touch another grain twice, nor itself.
fn periodic(loaded: &Loaded) -> Result<(), Fault> {
    for (name, side) in ["x", "y", "z"].into_iter().zip(loaded.scene.periodic.axes()) {
        let Some((low, high)) = side else { continue };
        // A grain must not touch its own image, nor another grain twice.
        let reach = loaded.largest_reach();
        let needed = 2.0 * loaded.contact_range().max(if loaded.shapes.is_empty() { 0.0 } else { 2.0 * reach });
        let length = high - low;
        if !(length.is_finite() && length > needed) {
            let message = format!(
                "the box is {length} m long, but grains touch at up to {} m: one could touch another twice",
                0.5 * needed
            );
            return Err(loaded
                .fault("scene::box_too_small", &format!("periodic.{name}"), message)
                .help(format!("give (low, high) in m, more than {needed} m apart")));
        }
    }
    Ok(())
}

fn rest(loaded: &Loaded) -> Result<(), Fault> {
    let Scene { rest, gravity, .. } = &loaded.scene;
    if rest.is_some() && gravity.padded() == Solid::ZERO {
        return Err(loaded
            .fault("scene::no_gravity", "rest", "rest is measured in units of sqrt(g R) and m g R, but gravity is zero")
            .help("remove `rest`, or give `gravity`"));
    }
    Ok(())
}

/// The watchdog's energy limit and the interval of samples need the energy balance.
fn energy_balance(loaded: &Loaded) -> Result<(), Fault> {
    if loaded.scene.energy_balance_every.is_some() && !loaded.scene.energy_balance {
        return Err(loaded
            .fault(
                "scene::no_energy_balance",
                "energy_balance_every",
                "the key bounds the steps between two samples of the energy balance, and the scene has no energy balance",
            )
            .help("remove `energy_balance: false`, or leave out `energy_balance_every`"));
    }
    let key = "watchdog.energy";
    let asks = loaded.source.value_of(key).is_some_and(|value| value != "None");
    if asks && !loaded.scene.energy_balance {
        return Err(loaded
            .fault(
                "scene::no_energy_balance",
                key,
                "the watchdog finds created energy by the energy balance, and the scene has none",
            )
            .help("remove `energy_balance: false`, or leave out `watchdog.energy`"));
    }
    Ok(())
}

/// The search visits a grain's own cell and its neighbours. Centres farther apart than the cell width L can be two cells
/// apart, so L must be at least the largest centre distance of a contact.
fn cells(loaded: &Loaded) -> Result<(), Fault> {
    let largest = loaded.grain_radii().map_or(0.0, |(_, largest)| largest);
    let (key, size) = match loaded.scene.neighbours {
        Some(Neighbours::Cells { size }) => ("neighbours.size", size.get()),
        Some(Neighbours::CellsOfRange { range }) => ("neighbours.rng", range.get() * largest),
        _ => return Ok(()),
    };
    let needed = loaded.contact_range();
    if size < needed {
        let message = format!(
            "cells of {size} m are too small: particles touch at up to {needed} m, and a grain looks only one cell far, \
             so contacts would be missed"
        );
        return Err(loaded
            .fault("scene::cells_too_small", key, message)
            .help(format!("give at least {needed} m, the sum of the two largest radii that can meet")));
    }
    Ok(())
}

fn view_and_bed(loaded: &Loaded) -> Result<(), Fault> {
    let scene = &loaded.scene;
    let view = scene.pictures.as_ref().and_then(|pictures| pictures.view);
    let bed = scene.bed.map(|bed| (bed.low, bed.high));
    for (key, corners) in [("pictures.view", view), ("bed", bed)] {
        if let Some((low, high)) = corners
            && !is_box(low, high)
        {
            return Err(loaded
                .fault("scene::empty_box", key, "the lower left corner must be below and left of the upper right one")
                .help("corners are (x, y) in m"));
        }
    }
    if scene.bed.is_some() && scene.rest.is_none() {
        return Err(loaded
            .fault("scene::missing_key", "rest", "the bed is measured at rest, but nothing detects rest")
            .help("add `rest: (speed: 2.0e-3, energy: 1.0e-6, hold: 0.1)`, or remove `bed`"));
    }
    Ok(())
}
