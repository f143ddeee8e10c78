//! Behaviours defined outside the library, which use its public API only.

use std::num::NonZeroUsize;
use std::process::ExitCode;
use std::sync::Arc;

use serde::Deserialize;
use siloflow::dem::contact::ContactPlugin;
use siloflow::energy::EnergyFlows;
use siloflow::grains::file::GrainRow;
use siloflow::measure::totals;
use siloflow::prelude::*;

#[path = "../../examples/vibrating_wall.rs"]
mod vibrating_wall;

use vibrating_wall::VibratingWall;

pub fn registry() -> Registry {
    let mut registry = Registry::default();
    registry
        .register::<VibratingWall>("vibrating_wall")
        .register::<Wind>("wind")
        .register::<Clumsy>("clumsy")
        .register::<Constant>("constant")
        .register::<Remover>("remover");
    registry
}

fn example(settings: &[(&str, &str)]) -> Result<Loaded, siloflow::text::fault::Fault> {
    let settings: Vec<_> = settings.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
    load::load(&crate::root().join("examples/vibrating_wall.ron"), &settings)
}

#[test]
fn example_wall_vibrates_and_its_work_is_counted() {
    let loaded = example(&[("pictures", "None"), ("until", "6.0")]).unwrap();
    let mut run = Simulation::new(&loaded, &registry(), NonZeroUsize::MIN).unwrap();
    assert_eq!(run.run(), End::TimeReached);
    let world = run.world_mut();
    let wall =
        world.query_filtered::<&Position, With<Fixed>>().iter(world).map(|x| x.0.x).fold(f64::INFINITY, f64::min);
    let expected = -1.3 + 0.002 * (std::f64::consts::TAU * 20.0 * 6.0).sin();
    assert!((wall - expected).abs() < 1e-12, "{wall} {expected}");
    let flows = *world.resource::<EnergyFlows>();
    assert!(flows.wall_work.abs() > 0.01, "{flows:?}");
    let error = totals::of_world(world).energy() - flows.expected();
    // As for the silo: (w0 dt)^2/6 of the dissipation.
    assert!(error.abs() < 1.0e4 / 0.08 * 1e-6 / 6.0 * flows.dissipated, "{error} of {flows:?}");
}

#[test]
fn example_program_runs_its_scene() {
    let out = tempfile::tempdir().unwrap();
    let arguments = ["siloflow", "run", "examples/vibrating_wall.ron", "--until", "0.5", "--quiet", "--out"];
    let arguments = arguments.map(|argument| match argument {
        "examples/vibrating_wall.ron" => crate::root().join(argument).into_os_string(),
        other => other.into(),
    });
    let arguments = arguments.into_iter().chain([out.path().join("run").into_os_string()]);
    assert_eq!(siloflow::cli::run_with(&registry(), arguments), ExitCode::SUCCESS);
    assert!(out.path().join("run/summary.json").exists());
}

#[test]
fn errors_in_behaviour_keys_report_their_line() {
    for (value, code, key) in [
        ("(amplitude: 0.002)", "scene::missing_key", "behaviours.vibrating_wall.frequency"),
        ("(amplitude: 0.002, frequency: 20.0, phase: 1)", "scene::unknown_key", "behaviours.vibrating_wall.phase"),
        ("(amplitude: \"much\", frequency: 20.0)", "scene::wrong_type", "behaviours.vibrating_wall.amplitude"),
        ("(amplitude: 0.002, frequency: 900.0)", "scene::behaviour", "behaviours.vibrating_wall"),
    ] {
        let loaded = example(&[("behaviours.vibrating_wall", value)]).unwrap();
        let fault = registry().of_scene(&loaded).map(|_| ()).unwrap_err();
        assert_eq!((fault.code(), fault.scene_key()), (code, Some(key)), "{value}: {fault}");
        let line = loaded.source.text.lines().position(|line| line.contains("behaviours:")).unwrap() + 1;
        assert_eq!(fault.line_and_column().unwrap().0, line, "{value}");
    }
}

#[derive(Deserialize)]
struct Wind(f64);

impl Behaviour for Wind {
    fn build(self: Box<Self>, app: &mut App) {
        let force = self.0;
        let blow = move |mut grains: Query<&mut Force, With<Grain>>| {
            grains.iter_mut().for_each(|mut total| total.0.x += force);
        };
        app.add_systems(Step, blow.in_set(ForceStage::Added));
    }
}

/// Pushes with two systems that write the same component without an order between them.
#[derive(Deserialize)]
struct Clumsy();

impl Behaviour for Clumsy {
    fn build(self: Box<Self>, app: &mut App) {
        fn pull(mut grains: Query<&mut Force, With<Grain>>) {
            grains.iter_mut().for_each(|mut total| total.0.x -= 1.0);
        }
        fn push(mut grains: Query<&mut Force, With<Grain>>) {
            grains.iter_mut().for_each(|mut total| total.0.x *= 2.0);
        }
        app.add_systems(Step, (pull, push).in_set(ForceStage::Added));
    }
}

const FREE: &str = "(gravity: (0.0, 0.0), contact: Linear(k: 1.0e5, damping: B(0.0)), step: Fixed(1.0e-3), until: 1.0, \
     grains: (file: \"free-fall.csv\"), pictures: None, behaviours: BEHAVIOURS)";

fn free(behaviours: &str) -> Loaded {
    let text = FREE.replace("BEHAVIOURS", behaviours);
    load::from_text("free.ron", "free", &crate::root().join("scenes"), text, &[]).unwrap()
}

#[test]
fn added_force_accelerates_and_its_work_is_counted() {
    let mut run = Simulation::new(&free("{\"wind\": (0.32)}"), &registry(), NonZeroUsize::MIN).unwrap();
    run.run();
    let world = run.world_mut();
    let (x, v) = world.query::<(&Position, &Velocity)>().single(world).unwrap();
    // m = 0.16 kg, so a = 2 m/s^2 from v = 3 m/s for 1 s; 1000 steps of round-off.
    assert!((v.0.x - 5.0).abs() < 1e-12 && (x.0.x - 4.0).abs() < 1e-12, "{x:?} {v:?}");
    let flows = *world.resource::<EnergyFlows>();
    // Force times distance, 0.32 N x 4 m.
    assert!((flows.added_work - 1.28).abs() < 1e-12, "{flows:?}");
    assert!((totals::of_world(world).energy() - flows.expected()).abs() < 1e-12);
}

#[test]
fn systems_that_conflict_without_an_order_are_an_error() {
    let fault = Simulation::new(&free("{\"clumsy\": ()}"), &registry(), NonZeroUsize::MIN).map(|_| ()).unwrap_err();
    assert_eq!(fault.code(), "behaviour::schedule");
    assert!(fault.to_string().contains("pull") && fault.to_string().contains("push"), "{fault}");
}

#[test]
fn non_finite_force_stops_the_run_and_names_the_grain() {
    let mut run = Simulation::new(&free("{\"wind\": (inf)}"), &registry(), NonZeroUsize::MIN).unwrap();
    let End::Failed(Failure::NotFinite { step, grain, cause, .. }) = run.run() else { panic!("the run did not stop") };
    assert_eq!((step, grain.number()), (1, 1));
    assert!(cause.contains("behaviour"), "{cause}");
}

/// Repulsion of constant strength, N, that replaces the scene's law.
#[derive(Clone, Copy, Deserialize)]
struct Constant(f64);

impl PairLaw for Constant {
    fn force(&self, pair: &Pair, _: &mut Memory) -> PairForce {
        PairForce::new(self.0 * pair.normal, Vector::ZERO)
    }
    fn elastic_energy(&self, pair: &Pair, _: &Memory) -> f64 {
        self.0 * pair.overlap
    }
    fn stiffness(&self, _: &Bounce) -> f64 {
        1.0
    }
    fn damping(&self, _: &Bounce) -> f64 {
        0.0
    }
    fn contact_duration(&self, _: &Bounce) -> f64 {
        1.0
    }
    fn restitution(&self, _: &Bounce) -> f64 {
        1.0
    }
}

impl LawRequirements for Constant {}

impl Behaviour for Constant {
    fn brings_contact_law(&self) -> bool {
        true
    }
    fn build(self: Box<Self>, app: &mut App) {
        app.add_plugins(ContactPlugin::plane(Arc::new(*self)));
    }
}

#[test]
fn contact_law_of_a_behaviour_is_used_by_the_kernel() {
    let mut loaded = free("{\"constant\": (3.0)}");
    let first = loaded.grains[0];
    let second = GrainId::grain(2).unwrap();
    loaded.grains.push(GrainRow { id: second, position: first.position + Solid::new(0.05, 0.0, 0.0), ..first });
    let mut run = Simulation::new(&loaded, &registry(), NonZeroUsize::MIN).unwrap();
    run.run_steps(0);
    let world = run.world_mut();
    let mut forces: Vec<_> = world.query::<&Force>().iter(world).map(|force| force.0.x).collect();
    forces.sort_by(f64::total_cmp);
    assert_eq!(forces, [-3.0, 3.0]);
}

/// Removes all grains from the world in the third step.
#[derive(Deserialize)]
struct Remover();

impl Behaviour for Remover {
    fn build(self: Box<Self>, app: &mut App) {
        fn remove(mut commands: Commands, clock: Res<Clock>, grains: Query<Entity, With<Grain>>) {
            if clock.steps == 3 {
                grains.iter().for_each(|grain| commands.entity(grain).despawn());
            }
        }
        app.add_systems(Step, remove.in_set(Phase::Control));
    }
}

#[test]
fn grain_removed_by_a_behaviour_is_reported_as_lost() {
    let mut run = Simulation::new(&free("{\"remover\": ()}"), &registry(), NonZeroUsize::MIN).unwrap();
    let End::Failed(Failure::GrainLost { grain, way, .. }) = run.run() else { panic!("the loss was not reported") };
    assert_eq!(grain.number(), 1);
    assert!(way.contains("behaviour"), "{way}");
}

/// Lifts every sphere of solid space.
#[derive(Deserialize)]
struct Updraught(f64);

impl Behaviour for Updraught {
    fn lives_in(&self, space: Dimension) -> bool {
        space == Dimension::Solid
    }
    fn build(self: Box<Self>, app: &mut App) {
        let lift = move |mut grains: Query<&mut Force<Solid>, With<Grain>>| {
            for mut force in &mut grains {
                force.0.z += self.0;
            }
        };
        app.add_systems(Step, lift.in_set(ForceStage::Added));
    }
}

#[test]
fn behaviour_is_refused_in_a_space_that_it_does_not_support() {
    let mut registry = registry();
    registry.register::<Updraught>("updraught");
    let load = |behaviour: &str| {
        let settings = [("pictures", "None"), ("until", "0.01"), ("behaviours", behaviour)];
        let settings: Vec<_> = settings.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
        load::load(&crate::scene("slip-to-roll.ron"), &settings).unwrap()
    };
    let planar = Simulation::new(&load("{\"wind\": (1.0)}"), &registry, NonZeroUsize::MIN).map(|_| ()).unwrap_err();
    assert_eq!((planar.code(), planar.scene_key()), ("scene::behaviour", Some("behaviours.wind")));
    // The force is twice the weight, upwards: the ball leaves the floor with acceleration g.
    let lifted = load("{\"updraught\": (25.506)}");
    let mut run = Simulation::new(&lifted, &registry, NonZeroUsize::MIN).unwrap();
    assert_eq!(run.run(), End::TimeReached);
    let z = run.world_mut().query::<&Velocity<Solid>>().single(run.world()).unwrap().0.z;
    // The spring of the floor pushes for less than a contact, 2 ms, and with at most the weight in addition.
    assert!((z - 9.81 * 0.01).abs() < 9.81 * 0.002, "{z}");
}
