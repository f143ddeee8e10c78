//! `siloflow explain`: lists what a scene will model, the memory it takes, and the key that asks for each part.

mod shapes;

use std::collections::BTreeMap;
use std::fmt::Write as _;

use bevy_ecs::prelude::*;
use bevy_ecs::schedule::ScheduleLabel;

use crate::assembly::AskedBy;
use crate::behaviour::Registry;
use crate::cli::exit_status::ExitStatus;
use crate::cli::{ONE_THREAD, SceneArgs, say};
use crate::lattice_silo::loaded::LoadedLattice;
use crate::scene::loaded::{AnyScene, Loaded};
use crate::simulation::{Caller, Simulation};
use siloflow_dem::particle::Grain;
use siloflow_dem::step::Step;
use siloflow_dem::store::{DeferredKick, Renumber, path_in_siloflow};
use siloflow_dem::walls::config::Wall;
use siloflow_lattice::rules::Rules;
use siloflow_lattice::sites::Sites;
use siloflow_text::fault::Fault;

pub(super) fn explain(args: &SceneArgs, registry: &Registry) -> Result<ExitStatus, Fault> {
    match args.load()? {
        AnyScene::Grains(loaded) => explain_grains(&loaded, registry),
        AnyScene::Lattice(loaded) => explain_lattice(&loaded, registry),
    }
}

fn explain_lattice(loaded: &LoadedLattice, registry: &Registry) -> Result<ExitStatus, Fault> {
    let simulation = Simulation::of_lattice(loaded, registry, ONE_THREAD)?;
    let sites = simulation.world().resource::<Sites>();
    let Rules { spacing, p, q, b, k, g, h, walls } = loaded.rules;
    let mut text = format!(
        "{}, a lattice gas: p = {}, q = {}, b = {}, k = {}, g = {}, h = {}, walls {walls:?}\n\
         {} sites {} m apart, each 2 bytes of state and 9 of what a step needs; no grain, so no component\n\n",
        loaded.source.name,
        p.get(),
        q.get(),
        b.get(),
        k.get(),
        g.get(),
        h.get(),
        sites.fluid_count(),
        spacing.get()
    );
    describe_parameters(&loaded.scene.parameters, &mut text);
    describe_systems(simulation.world(), &mut text);
    // Writing to a string cannot fail.
    let _ = write!(text, "\n`run` adds\n  a row of series.csv every {} steps", loaded.scene.series.interval);
    if loaded.scene.flow.is_some() {
        text.push_str("\n  flow.csv, the mean velocity in cells over a part of the discharge");
    }
    let _ = match &loaded.scene.pictures {
        Some(pictures) => writeln!(text, "\n  a picture every {} steps", pictures.interval),
        None => writeln!(text),
    };
    say(&text);
    Ok(ExitStatus::Done)
}

fn explain_grains(loaded: &Loaded, registry: &Registry) -> Result<ExitStatus, Fault> {
    let caller = Caller::CommandLine;
    let mut simulation = Simulation::with(loaded, registry, ONE_THREAD, caller, Box::new(|_| Ok(())), None)?;
    // Step zero releases the first grain and writes no file. Then the world shows the components of a grain.
    simulation.step_zero();
    let mut text = format!(
        "{}, space {:?}\nintegrator {:?}, contact {:?},\nneighbours {:?}\n",
        loaded.source.name,
        loaded.scene.space,
        loaded.scene.integrator,
        loaded.scene.contact,
        loaded.neighbours()
    );
    // Writing to a string cannot fail.
    describe_parameters(&loaded.scene.parameters, &mut text);
    for pair in &loaded.scene.pairs {
        let _ = writeln!(text, "species {:?}: {:?}", pair.species, pair.contact);
    }
    for (species, material) in loaded.scene.materials.iter().enumerate() {
        let _ = writeln!(text, "material of species {species}: {material:?}");
    }
    text.push('\n');
    shapes::describe(loaded, &mut text);
    describe_grain(simulation.own_world(), &mut text);
    describe_systems(simulation.world(), &mut text);
    describe_outputs(loaded, &mut text);
    say(&text);
    Ok(ExitStatus::Done)
}

/// Lists the parameters of a scene with their values. Writing to a string cannot fail.
fn describe_parameters(parameters: &BTreeMap<String, f64>, text: &mut String) {
    for (name, value) in parameters {
        let _ = writeln!(text, "parameter {name} = {value}");
    }
}

/// Lists the components of the first grain. Writing to a string cannot fail.
fn describe_grain(world: &mut World, text: &mut String) {
    let first = world.query_filtered::<Entity, With<Grain>>().iter(world).next();
    let Some(components) = first.and_then(|grain| world.inspect_entity(grain).ok()) else {
        text.push_str("no grain at the start, so nothing to show of its components\n\n");
        return;
    };
    let mut rows: Vec<_> =
        components.map(|(_, info)| (short(&info.name().to_string()), info.layout().size())).collect();
    rows.sort();
    let total: usize = rows.iter().map(|(_, size)| size).sum();
    let _ = writeln!(text, "components of a grain: {total} bytes");
    for (name, size) in rows {
        let _ = writeln!(text, "  {name:<24} {size:>3} B");
    }
    text.push('\n');
}

fn describe_systems(world: &World, text: &mut String) {
    let (Some(schedules), Some(asked_by)) = (world.get_resource::<Schedules>(), world.get_resource::<AskedBy>()) else {
        return;
    };
    let parts = [
        (Step.intern(), "systems of a step, in order, and the key that asks for each:"),
        (
            DeferredKick.intern(),
            "where a system reads velocities between two steps, else together with the next drift:",
        ),
        (Renumber.intern(), "when particles enter or leave:"),
    ];
    for (label, heading) in parts {
        let Some(Ok(systems)) = schedules.get(label).map(Schedule::systems) else { continue };
        let _ = writeln!(text, "{heading}");
        for (key, system) in systems {
            // Systems that no key asked for belong to the ECS: they apply commands and update messages.
            if let Some(asked) = asked_by.0.get(&(label, key)) {
                let _ = writeln!(text, "  {:<52} {asked}", short_path(&system.name().to_string()));
            }
        }
    }
}

fn describe_outputs(loaded: &Loaded, text: &mut String) {
    let scene = &loaded.scene;
    let _ = write!(text, "\n`run` adds\n  a row of series.csv every {} s", scene.series.interval.get());
    text.push_str("\n  rows of losses.csv, as often, if more than a hundred grains are lost");
    if scene.walls.iter().any(Wall::is_surface) {
        text.push_str("\n  the mean forces on wall surfaces, as often, in walls.csv");
    }
    if scene.walls.iter().any(|wall| wall.name().is_some()) {
        text.push_str("\n  the mean forces on walls of one name, as often, in wall_groups.csv");
    }
    if !scene.free_walls.is_empty() {
        text.push_str("\n  coordinates, rates and forces of free walls, as often, in free_walls.csv");
    }
    if !scene.wall_bands.is_empty() {
        text.push_str("\n  pressure and friction on walls by height, in wall_bands.csv");
    }
    if !scene.slopes.is_empty() {
        text.push_str("\n  slopes of the free surface, as often as series.csv, in slopes.csv");
    }
    if !scene.profiles.is_empty() {
        text.push_str(
            "\n  profiles.csv, and the centres of mass of the species, as often as series.csv, in centres.csv",
        );
    }
    for field in &scene.fields {
        let _ = write!(text, "\n  a field in fields.csv, sampled every {} s", field.sample.get());
    }
    if let Some(outflow) = scene.outflow {
        let _ = write!(text, "\n  figures of the outflow from {} to {} in summary.json", outflow.from, outflow.to);
    }
    if let Some(flow) = scene.flow {
        let from = 100.0 * flow.from.get();
        let to = 100.0 * flow.to.get();
        let _ = write!(
            text,
            "\n  the mean velocity in cells of {} m, every {} s while {from} to {to} % are out, in flow.csv",
            flow.cell.get(),
            flow.sample.get()
        );
    }
    if let Some((_, times)) = loaded.data_frames() {
        let _ = write!(text, "\n  a frame of data every {}, in frames.bin", times.words());
    }
    let _ = match &scene.pictures {
        Some(pictures) => writeln!(text, "\n  a picture every {} s", pictures.interval.get()),
        None => writeln!(text),
    };
}

/// The last part of a path, without generic arguments.
fn short(name: &str) -> String {
    let path = name.split('<').next().unwrap_or(name);
    path.rsplit("::").next().unwrap_or(path).to_owned()
}

/// A path without the crate's name and without generic arguments: space and law are printed above.
fn short_path(name: &str) -> String {
    let path = name.split('<').next().unwrap_or(name);
    path_in_siloflow(path).unwrap_or(path).to_owned()
}
