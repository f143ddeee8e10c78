//! Systems that read components, through each kind of access of the ECS.

use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::schedule::ScheduleLabel;
use bevy_ecs::world::DeferredWorld;
use siloflow::dem::space::Space;
use siloflow::measure::{due, observe_every};
use siloflow::prelude::*;

use super::{SCENES, scene, state_and_flows, with};

/// Number of particles that systems have read.
#[derive(Resource, Default)]
struct Seen(u64);

type Now<V> = (
    Entity,
    &'static Slot,
    (&'static Position<V>, &'static Velocity<V>, &'static Force<V>),
    Option<(&'static Spin<<V as Space>::Spin>, &'static Torque<<V as Space>::Spin>)>,
);

/// Free particles only: these systems have no order relative to the library's systems that move walls in the same
/// phase.
type Free = Without<Fixed>;

/// Asserts that components equal the values of the store, and returns the number of particles compared.
fn compare<V: Space>(motion: &Motion<V>, particles: &Query<Now<V>, Free>) -> u64 {
    let mut seen = 0;
    for (entity, slot, (x, v, force), turning) in particles {
        let row = slot.index();
        if row >= motion.len() {
            continue;
        }
        assert_eq!((motion.entity(row), x.0, v.0), (entity, motion.position(row), motion.velocity(row)));
        assert_eq!(force.0, motion.force(row));
        if let Some((spin, torque)) = turning {
            assert_eq!(spin.0, motion.spin(row));
            assert_eq!(torque.0, motion.store().loads.torque.of(row));
        }
        seen += 1;
    }
    seen
}

fn compare_all<V: Space>(motion: Motion<V>, particles: Query<Now<V>, Free>, mut seen: ResMut<Seen>) {
    seen.0 += compare(&motion, &particles);
}

/// Like [`compare_all`], but with access to the whole world.
fn compare_in_world<V: Space>(world: &mut World) {
    world.run_system_cached(compare_all::<V>).unwrap();
}

#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
struct Nested;

const PHASES: [Phase; 8] = [
    Phase::Spawn,
    Phase::Drift,
    Phase::Neighbours,
    Phase::Forces,
    Phase::Kick,
    Phase::Control,
    Phase::Cull,
    Phase::Observe,
];

fn nothing<V: Space>(_: &mut App) {}

/// Reads components in every phase.
fn queries<V: Space>(app: &mut App) {
    app.init_resource::<Seen>();
    for phase in PHASES {
        app.add_systems(Step, compare_all::<V>.in_set(phase));
    }
}

/// Reads in exclusive systems, and in systems of a schedule that exclusive systems run.
fn exclusive<V: Space>(app: &mut App) {
    app.init_resource::<Seen>().init_schedule(Nested).add_systems(Nested, compare_all::<V>);
    app.add_systems(Step, compare_in_world::<V>.in_set(Phase::Forces));
    app.add_systems(Step, (|world: &mut World| world.run_schedule(Nested)).in_set(Phase::Kick));
    app.add_systems(Step, (|world: &mut World| world.run_schedule(Nested)).in_set(Phase::Neighbours));
}

fn every_third_step(clock: Res<Clock>) -> bool {
    clock.steps.is_multiple_of(3)
}

/// A run condition that reads components and has a state. It must be evaluated once per step.
fn every_other_time<V: Space>(motion: Motion<V>, particles: Query<Now<V>, Free>, mut times: Local<u64>) -> bool {
    compare(&motion, &particles);
    *times += 1;
    times.is_multiple_of(2)
}

/// Readers with run conditions, known and unknown, on single systems and on a set.
fn conditional<V: Space>(app: &mut App) {
    app.init_resource::<Seen>();
    observe_every::<Seen>(app, 0.007);
    app.add_systems(
        Step,
        (
            compare_all::<V>.in_set(ObserveStage::Write).run_if(due::<Seen>),
            compare_all::<V>.in_set(Phase::Cull).run_if(every_third_step),
            compare_all::<V>.in_set(Phase::Kick).run_if(every_other_time::<V>),
        ),
    );
    app.add_systems(Step, (compare_all::<V>, no_op).chain().in_set(Phase::Control).run_if(every_third_step));
}

fn no_op() {}

/// Marker that a command inserts, which triggers observers and hooks.
#[derive(Component, Clone, Copy)]
struct Marked;

#[derive(Component)]
#[component(storage = "SparseSet", on_add = hooked)]
struct Hooked;

fn hooked(mut world: DeferredWorld, context: HookContext) {
    if let (Some(x), Some(slot)) =
        (world.get::<Position>(context.entity).copied(), world.get::<Slot>(context.entity).copied())
        && let Some(store) = world.get_resource::<siloflow::dem::store::ParticleStore>()
        && let Some(body) = store.body.get(slot.index())
    {
        assert_eq!(x.0, body.position);
        world.resource_mut::<Seen>().0 += 1;
    }
}

fn mark(mut commands: Commands, grains: Query<Entity, With<Grain>>) {
    for grain in grains.iter().take(3) {
        commands.entity(grain).insert(Marked).remove::<Marked>();
        commands.entity(grain).insert(Hooked).remove::<Hooked>();
    }
}

/// Observers and hooks, which appear in no access list.
fn observers<V: Space>(app: &mut App) {
    app.init_resource::<Seen>();
    let watch = |_: On<Add<Marked>>, motion: Motion<V>, particles: Query<Now<V>, Free>, mut seen: ResMut<Seen>| {
        seen.0 += compare(&motion, &particles);
    };
    app.add_observer(watch);
    app.add_systems(Step, (mark.in_set(Phase::Control), mark.in_set(Phase::Drift), mark.in_set(Phase::Spawn)));
}

type Touched<V> = (
    (&'static mut Position<V>, &'static mut Velocity<V>, &'static mut Force<V>),
    Option<(&'static mut Spin<<V as Space>::Spin>, &'static mut Torque<<V as Space>::Spin>)>,
);

/// Writes the current value to all components.
fn touch<V: Space>(mut particles: Query<Touched<V>, Free>, mut seen: ResMut<Seen>) {
    for ((mut x, mut v, mut force), turning) in &mut particles {
        (x.0, v.0, force.0) = (x.0, v.0, force.0);
        if let Some((mut spin, mut torque)) = turning {
            (spin.0, torque.0) = (spin.0, torque.0);
        }
        seen.0 += 1;
    }
}

/// Mutable access that changes no value.
fn idle_writers<V: Space>(app: &mut App) {
    app.init_resource::<Seen>();
    for phase in PHASES {
        app.add_systems(Step, touch::<V>.in_set(phase));
    }
}

/// A write that bypasses change detection does not count. It is not copied to the store, and the next refresh of the
/// component overwrites it.
fn bypassing<V: Space>(app: &mut App) {
    let write = |mut grains: Query<(&mut Position<V>, &mut Velocity<V>), Free>, mut seen: ResMut<Seen>| {
        for (mut x, mut v) in &mut grains {
            let away = x.0 + v.0 + v.0;
            (x.bypass_change_detection().0, v.bypass_change_detection().0) = (away, away);
            seen.0 += 1;
        }
    };
    app.init_resource::<Seen>().add_systems(Step, write.in_set(Phase::Control));
}

/// Reads fixed particles only.
fn walls<V: Space>(app: &mut App) {
    let read = |motion: Motion<V>, walls: Query<Now<V>, With<Fixed>>, mut seen: ResMut<Seen>| {
        for (_, slot, (x, v, force), _) in walls.iter().filter(|(_, slot, ..)| slot.index() < motion.len()) {
            let row = slot.index();
            assert_eq!((x.0, v.0, force.0), (motion.position(row), motion.velocity(row), motion.force(row)));
            seen.0 += 1;
        }
    };
    app.init_resource::<Seen>().add_systems(Step, (read.in_set(Phase::Control), read.in_set(Phase::Neighbours)));
}

/// One kind of access, in the plane and in solid space.
struct Access {
    name: &'static str,
    planar: fn(&mut App),
    solid: fn(&mut App),
    /// Whether it reads particles in every step.
    is_busy: bool,
}

macro_rules! accesses {
    ($($access:ident: $is_busy:expr),*) => {
        [$(Access { name: stringify!($access), planar: $access::<Plane>, solid: $access::<Solid>, is_busy: $is_busy }),*]
    };
}

#[test]
fn every_kind_of_access_reads_the_store_and_changes_no_bit() {
    let accesses = accesses![
        nothing: false, queries: true, exclusive: true, conditional: false, observers: false, idle_writers: true,
        bypassing: true, walls: false
    ];
    for (name, settings, steps) in SCENES {
        let loaded = scene(name, settings);
        let run = |access: fn(&mut App)| {
            let mut run = with(&loaded, access);
            run.run_steps(steps);
            let seen = run.world().get_resource::<Seen>().map_or(0, |seen| seen.0);
            (state_and_flows(&mut run), seen)
        };
        let (unseen, _) = run(|_| {});
        for access in &accesses {
            let (found, seen) = run(if loaded.scene.space == Dimension::Plane { access.planar } else { access.solid });
            assert_eq!(found, unseen, "{name}: {}", access.name);
            assert!(!access.is_busy || seen > 10 * steps, "{name}: {} has seen {seen}", access.name);
        }
    }
}

#[test]
fn observers_hooks_and_conditional_readers_do_run() {
    let loaded = scene(SCENES[1].0, SCENES[1].1);
    for (access, times) in [(observers::<Plane> as fn(&mut App), 3 * 2 * 200), (conditional::<Plane>, 100)] {
        let mut run = with(&loaded, access);
        run.run_steps(200);
        assert!(run.world().resource::<Seen>().0 >= times);
    }
}

/// Number of changed positions according to the change detection of the ECS.
#[derive(Resource, Default)]
struct Changes(usize);

#[test]
fn refresh_of_a_component_is_no_change() {
    fn count(changed: Query<(), (Changed<Position>, With<Grain>)>, mut changes: ResMut<Changes>, clock: Res<Clock>) {
        if clock.steps > 10 {
            changes.0 += changed.iter().count();
        }
    }
    let push = |clock: Res<Clock>, mut grains: Query<&mut Position, With<Grain>>| {
        if clock.steps == 20 {
            grains.iter_mut().take(2).for_each(|mut x| x.0.x += 1e-9);
        }
    };
    let mut run = with(&scene("couette.ron", &[]), |app| {
        app.init_resource::<Changes>().add_systems(Step, (push, count).chain().in_set(Phase::Control));
    });
    run.run_steps(30);
    assert_eq!(run.world().resource::<Changes>().0, 2);
}

#[test]
fn components_equal_the_store_after_every_step() {
    let mut run = with(&scene("chute3d.ron", &[]), |_| {});
    for _ in 0..20 {
        run.step();
        let world = run.world();
        let body = &world.resource::<siloflow::dem::store::ParticleStore<Solid>>().body;
        let mut shown = world.try_query::<(&Slot, &Position<Solid>, &Velocity<Solid>)>().unwrap();
        let up_to_date = shown.iter(world).filter(|(slot, x, v)| {
            let body = &body[slot.index()];
            (x.0, v.0) == (body.position, body.velocity)
        });
        assert_eq!(up_to_date.count(), body.len());
    }
}
