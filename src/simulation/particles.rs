//! The particles at the start of a simulation.

use bevy_ecs::prelude::*;

use crate::grains::file::GrainRow;
use crate::scene::loaded::Loaded;
use siloflow_dem::messages::GrainReleased;
use siloflow_dem::particle::{Door, Force, GrainBundle, GrainId, Species, wall_grain};
use siloflow_dem::periodic::Periodic;
use siloflow_dem::space::{Linear, Space};
use siloflow_dem::spin::{InertiaLaw, Spin, Torque};
use siloflow_dem::store::ParticleStore;
use siloflow_dem::table_sort::sort_newcomers;
use siloflow_dem::walls::config::WallGrain;
use siloflow_dem::walls::conveyor::Conveyed;
use siloflow_dem::walls::leaving::WallIndex;
use siloflow_dem::walls::silo_file::Disc;
use siloflow_dem::walls::surfaces::Surfaces;

/// Spawns wall grains, door grains, wall surfaces and the grains of the start. With `has_loads` grains get forces and torques as
/// components at once: tables keep their memory when all grains leave them for such a component later.
pub(super) fn spawn_particles<V: Space>(world: &mut World, loaded: &Loaded, has_loads: bool) {
    let mut discs = 0;
    let mut next_id = || {
        discs += 1;
        GrainId::wall(discs)
    };
    let at_rest = V::ZERO;
    let silo = loaded.scene.silo.as_ref().map_or(Species(0), |silo| Species(silo.species));
    // A particle that starts outside a periodic box is replaced by its image inside.
    let periodic = Periodic::<V>::new(&loaded.scene.periodic);
    let in_box = |x: V| periodic.map_or(x, |periodic| periodic.wrapped(x));
    let centre = |disc: &Disc| in_box(V::narrow(disc.centre.spread()));
    for disc in &loaded.silo.wall {
        world.spawn(wall_grain(next_id(), centre(disc), disc.radius, at_rest, silo));
    }
    for disc in &loaded.silo.door {
        world.spawn((wall_grain(next_id(), centre(disc), disc.radius, at_rest, silo), Door(0)));
    }
    for wall in &loaded.scene.walls {
        if let Some(WallGrain { centre, radius, species }) = wall.wall_grain() {
            world.spawn(wall_grain(next_id(), in_box(centre.get::<V>()), radius, at_rest, species));
        }
    }
    for grain in &loaded.fixed {
        let x = in_box(V::narrow(grain.position));
        let v = V::narrow(grain.velocity);
        let mut spawned = world.spawn(wall_grain(next_id(), x, grain.radius, v, grain.species));
        if v != V::ZERO {
            spawned.insert(Conveyed);
        }
    }
    let doors: Vec<_> = world.resource::<Surfaces<V>>().all.iter().map(|wall| wall.door).collect();
    for (index, door) in doors.into_iter().enumerate() {
        let mut entity = world.spawn(WallIndex(index));
        if let Some(number) = door {
            entity.insert(Door(number));
        }
    }
    world.write_message_batch(loaded.grains.iter().map(|grain| GrainReleased { id: grain.id }));
    let newcomer = |row: &GrainRow| {
        let mut grain = row.bundle::<V>();
        grain.particle.position.0 = in_box(grain.particle.position.0);
        (grain, V::narrow_spin(row.spin))
    };
    let is_shaped = |row: &&GrainRow| row.posture.is_some();
    let shaped: Vec<_> = loaded.grains.iter().filter(is_shaped).collect();
    let mut newcomers: Vec<_> = loaded.grains.iter().filter(|row| !is_shaped(row)).map(newcomer).collect();
    sort_newcomers(&mut newcomers);
    let newcomers = newcomers.into_iter();
    // Step zero evaluates them.
    let force = Force(V::ZERO);
    let torque = Torque(V::Spin::ZERO);
    let turning =
        |law: InertiaLaw, grain: &GrainBundle<V>, spin| law.turning::<V>(grain.mass.0, grain.particle.radius.0, spin);
    for row in shaped {
        let (grain, spin) = newcomer(row);
        let posture = row.posture.map(|posture| posture.components::<V>()).expect("only shaped grains");
        let mut spawned = world.spawn((grain, Spin(spin), posture));
        if has_loads {
            spawned.insert((torque, force));
        }
    }
    // Spawned in one batch, so that tables are allocated once.
    match (world.resource::<ParticleStore<V>>().inertia, has_loads) {
        (None, false) => world.spawn_batch(newcomers.map(|(grain, _)| grain)).for_each(drop),
        (None, true) => world.spawn_batch(newcomers.map(move |(grain, _)| (force, grain))).for_each(drop),
        (Some(law), false) => {
            let turning = move |(grain, spin)| (turning(law, &grain, spin), grain);
            world.spawn_batch(newcomers.map(turning)).for_each(drop);
        }
        (Some(law), true) => {
            let turning = move |(grain, spin)| (turning(law, &grain, spin), torque, force, grain);
            world.spawn_batch(newcomers.map(turning)).for_each(drop);
        }
    }
}
