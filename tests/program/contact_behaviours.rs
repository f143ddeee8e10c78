//! Behaviours that read contacts, and that add forces, numbers per contact, and components. In both spaces.

use std::marker::PhantomData;
use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::Arc;

use serde::Deserialize;
use siloflow::dem::contact::AnyLaw;
use siloflow::dem::contact::centred::velocity_prediction::VelocityPredictionPlugin;
use siloflow::dem::contact::composite::Composite;
use siloflow::dem::contact::damping::{Attraction as Pull, Damping};
use siloflow::dem::contact::linear::LinearNormal;
use siloflow::dem::contact::rolling::NoRolling;
use siloflow::dem::contact::tangential::NoFriction;
use siloflow::energy::EnergyFlows;
use siloflow::measure::totals;
use siloflow::prelude::*;

const SPACES: [(Dimension, &str); 2] = [(Dimension::Plane, "0.0, 0.0"), (Dimension::Solid, "0.0, 0.0, 0.0")];

/// Returns a scene of two grains of 4 cm and 0.16 kg on the x axis, without walls. The first is at rest at 0, the
/// second at `x` with velocity `v`.
fn two((space, zero): (Dimension, &str), x: f64, v: f64, more: &str) -> Loaded {
    let directory = tempfile::tempdir().unwrap();
    let rows = format!("id,radius,mass,x,y,z,vx,vy,vz\n1,0.04,0.16,0,0,0,0,0,0\n2,0.04,0.16,{x},0,0,{v},0,0\n");
    std::fs::write(directory.path().join("two.csv"), rows).unwrap();
    let text = format!(
        "(space: {space:?}, gravity: ({zero}), step: Fixed(1.0e-4), until: 0.3, grains: (file: \"two.csv\"), pictures: None, {more})"
    );
    load::from_text("two.ron", "two", directory.path(), text, &[]).unwrap()
}

fn run<T: Behaviour + serde::de::DeserializeOwned>(loaded: &Loaded) -> Simulation {
    let mut registry = Registry::default();
    registry.register::<T>("it");
    Simulation::new(loaded, &registry, NonZeroUsize::MIN).unwrap()
}

/// Constant attraction, N, in addition to the scene's law.
#[derive(Deserialize, Clone, Copy, Resource)]
struct Attraction(f64);

fn attract<V: Space>(attraction: Res<Attraction>, mut contacts: PairForces<V>) {
    contacts.add(|contact| contact.normal() * -attraction.0);
}

impl Behaviour for Attraction {
    fn lives_in(&self, _: Dimension) -> bool {
        true
    }
    fn build(self: Box<Self>, app: &mut App) {
        let space = Dimension::of_world(app.world());
        app.insert_resource(*self);
        match space {
            Dimension::Plane => app.add_systems(Step, attract::<Plane>.in_set(ForceStage::Added)),
            Dimension::Solid => app.add_systems(Step, attract::<Solid>.in_set(ForceStage::Added)),
        };
    }
}

#[test]
fn added_attraction_holds_two_grains_at_their_equilibrium_overlap() {
    for space in SPACES {
        for integrator in ["Centred", "Verlet"] {
            let law = "contact: Linear(k: 1.0e4, damping: B(20.0), attraction: Allowed)";
            let more = format!("{law}, integrator: {integrator}, behaviours: {{\"it\": (2.0)}}");
            let mut run = run::<Attraction>(&two(space, 0.0799, 0.0, &more));
            assert_eq!(run.run(), End::TimeReached);
            let world = run.world_mut();
            let error = totals::of_world(world).energy() - world.resource::<EnergyFlows>().expected();
            assert!(error.abs() < 1e-6, "{error}");
            let overlap = match space.0 {
                Dimension::Plane => world.run_system_cached(deepest::<Plane>),
                Dimension::Solid => world.run_system_cached(deepest::<Solid>),
            };
            let overlap = overlap.unwrap();
            assert!((overlap / (2.0 / 1.0e4) - 1.0).abs() < 1e-9, "{overlap}");
        }
    }
}

fn deepest<V: Space>(contacts: ContactView<V>) -> f64 {
    contacts.iter().map(|contact| contact.overlap()).fold(0.0, f64::max)
}

/// Duration of each contact, once in a map and once in the contact history of the law.
#[derive(Deserialize, Resource, Default)]
struct Ages {
    #[serde(skip)]
    of: PairMap<f64>,
    /// Number of contacts and their total duration, s, in each step.
    #[serde(skip)]
    noted: Vec<(usize, f64)>,
}

/// A spring that accumulates the duration of its contact.
struct TimedSpring;

impl<V: Space> PairLaw<V> for TimedSpring {
    fn force(&self, pair: &Pair<V>, memory: &mut Memory) -> PairForce<V> {
        memory.numbers[0] += pair.dt;
        PairForce::new(pair.normal * (1.0e4 * pair.overlap), V::ZERO)
    }
    fn elastic_energy(&self, pair: &Pair<V>, _: &Memory) -> f64 {
        0.5e4 * pair.overlap * pair.overlap
    }
    fn stiffness(&self, _: &Bounce) -> f64 {
        1.0e4
    }
    fn damping(&self, _: &Bounce) -> f64 {
        0.0
    }
    fn contact_duration(&self, bounce: &Bounce) -> f64 {
        std::f64::consts::PI * (bounce.reduced_mass / 1.0e4).sqrt()
    }
    fn restitution(&self, _: &Bounce) -> f64 {
        1.0
    }
}

impl LawRequirements for TimedSpring {
    const MEMORY: &'static [MemoryVariable] = &[MemoryVariable::number("age", Parity::Even)];
}

fn age<V: Space>(contacts: ContactView<V>, clock: Res<Clock>, mut ages: ResMut<Ages>) {
    let Ages { of, noted } = &mut *ages;
    of.visit(&contacts, |contact, age| {
        *age += clock.dt;
        let remembered = contact.memory().numbers[0];
        assert!((remembered - *age).abs() < 1e-12, "{remembered} {age}");
    });
    let now = (of.len(), contacts.iter().filter_map(|contact| of.get(contact.grain(), contact.with())).sum());
    noted.push(now);
}

impl Behaviour for Ages {
    fn lives_in(&self, _: Dimension) -> bool {
        true
    }
    fn brings_contact_law(&self) -> bool {
        true
    }
    fn build(self: Box<Self>, app: &mut App) {
        app.insert_resource(*self);
        match Dimension::of_world(app.world()) {
            Dimension::Plane => app
                .add_plugins(ContactPlugin::<Plane, _>::new(Arc::new(TimedSpring)))
                .add_systems(Step, age::<Plane>.in_set(Phase::Observe)),
            Dimension::Solid => app
                .add_plugins(ContactPlugin::<Solid, _>::new(Arc::new(TimedSpring)))
                .add_systems(Step, age::<Solid>.in_set(Phase::Observe)),
        };
    }
}

#[test]
fn number_per_contact_lasts_as_long_as_the_contact() {
    for space in SPACES {
        let law = "contact: Linear(k: 1.0e4, damping: B(0.0)), behaviours: {\"it\": ()}";
        let mut run = run::<Ages>(&two(space, 0.081, -1.0, law));
        assert_eq!(run.run(), End::TimeReached);
        let ages = run.world().resource::<Ages>();
        let lasting: Vec<_> = ages.noted.iter().filter(|&&(count, _)| count > 0).collect();
        // Half a period, pi sqrt(m_eff/k), in steps of 0.1 ms.
        let expected = std::f64::consts::PI * f64::sqrt(0.08 / 1.0e4) / 1.0e-4;
        assert!((lasting.len() as f64 - expected).abs() < 1.5, "{} {expected}", lasting.len());
        assert!((lasting.last().unwrap().1 - 1.0e-4 * lasting.len() as f64).abs() < 1e-12, "{lasting:?}");
        assert!(ages.of.is_empty() && ages.of.get(GrainId::grain(1).unwrap(), Touched::Wall(1)).is_none());
    }
}

/// Copy of the grain's id in a component of the behaviour.
#[derive(Component)]
struct Label(GrainId);

#[derive(Deserialize)]
struct Labels();

fn label(mut commands: Commands, new: Query<(Entity, &GrainId), (With<Grain>, Without<Label>)>) {
    for (grain, &id) in &new {
        commands.entity(grain).insert(Label(id));
    }
}

fn nudge<V: Space>(mut grains: Query<(&Label, &GrainId, &mut Force<V>)>) {
    for (label, id, mut force) in &mut grains {
        assert_eq!(label.0, *id);
        force.0 = force.0 * 1.01;
    }
}

impl Behaviour for Labels {
    fn lives_in(&self, _: Dimension) -> bool {
        true
    }
    fn build(self: Box<Self>, app: &mut App) {
        let space = Dimension::of_world(app.world());
        app.add_systems(Step, label.in_set(Phase::Spawn));
        match space {
            Dimension::Plane => app.add_systems(Step, nudge::<Plane>.in_set(ForceStage::Added)),
            Dimension::Solid => app.add_systems(Step, nudge::<Solid>.in_set(ForceStage::Added)),
        };
    }
}

/// Returns a scene of many grains that fall and mix while further grains enter, so that table rows are sorted.
fn pouring((space, _): (Dimension, &str)) -> Loaded {
    let (gravity, floor, point, jitter, low, high) = match space {
        Dimension::Plane => ("0.0, -9.81", "0.0, 1.0", "0.5, 2.5", "0.4, 0.0", "0.0, 0.1", "1.0, 2.0"),
        Dimension::Solid => {
            ("0.0, 0.0, -9.81", "0.0, 0.0, 1.0", "0.2, 0.2, 2.5", "0.1, 0.1, 0.0", "0.0, 0.0, 0.1", "0.4, 0.4, 1.0")
        }
    };
    let origin = "0.0, ".repeat(space.count());
    let still = "0.0, ".repeat(space.count());
    let text = format!(
        "(space: {space:?}, gravity: ({gravity}), step: Fixed(1.0e-4), until: 0.2, pictures: None, on_loss: Continue, \
          contact: Linear(k: 1.0e4, damping: B(5.0)), mass: Sphere(1000.0), walls: [HalfPlane(point: ({origin}), normal: ({floor}))], \
          fill: [(low: ({low}), high: ({high}), spacing: 0.05, radius: Fixed(0.02), count: 700, agitation: ({jitter}))], \
          spawner: (point: ({point}), jitter: ({jitter}), velocity: ({still}), interval: 0.002, count: 60, radius: Fixed(0.02)), \
          behaviours: {{\"it\": ()}})"
    );
    load::from_text("pouring.ron", "pouring", Path::new(""), text, &[]).unwrap()
}

#[test]
fn component_can_be_added_to_grains_as_they_enter() {
    for space in SPACES {
        let mut run = run::<Labels>(&pouring(space));
        assert_eq!(run.run(), End::TimeReached);
        let world = run.world_mut();
        let labelled = world.query::<(&Label, &GrainId)>().iter(world).filter(|(label, id)| label.0 == **id).count();
        let grains = world.query_filtered::<(), With<Grain>>().iter(world).count();
        // More than the grains of the start.
        assert!(labelled == grains && grains > 700, "{labelled} {grains}");
    }
}

/// Compares contacts read one by one with the view of all contacts. Returns their number.
fn compare<V: Space>(contacts: ContactView<V>, law: Res<AnyLaw<V>>) -> usize {
    let all = contacts.all();
    let order = |contact: &ContactState<V>| (contact.with != Touched::Wall(1), contact.grain, contact.with);
    assert!(all.iter().map(order).is_sorted_by(|a, b| (!a.0, a.1, a.2) < (!b.0, b.1, b.2)));
    let mut seen = 0;
    for contact in contacts.iter() {
        seen += 1;
        let (grain, with) = match contact.with() {
            Touched::Particle(partner) if partner < contact.grain() => (partner, Touched::Particle(contact.grain())),
            with => (contact.grain(), with),
        };
        let at = all.iter().position(|state| (state.grain, state.with) == (grain, with)).unwrap();
        let state = &all[at];
        let sign = if grain == contact.grain() { 1.0 } else { -1.0 };
        assert_eq!(
            (state.overlap, state.normal, state.to_partner),
            (contact.overlap(), contact.normal() * sign, contact.to_partner() * sign)
        );
        let force = contact.force();
        assert_eq!(
            (state.normal_force, state.friction),
            (force.normal.dot(contact.normal()), force.resistance.friction * sign)
        );
        // The tangential spring is all of the memory.
        assert_eq!(state.memory.numbers, contact.memory().numbers.map(|number| number * sign));
        let moved_on = Pair { dt: 1.0e-4, ..*contact.pair() };
        assert_eq!(state.is_sliding, law.0.force(&moved_on, &mut contact.memory()).resistance.is_sliding);
    }
    assert_eq!(seen, all.len());
    seen
}

#[test]
fn contacts_read_one_by_one_equal_the_view_of_all() {
    let frictional =
        "Linear(k: 1.0e4, damping: B(5.0), tangential: Some(Spring(k: 2.0e3, damping: B(1.0), friction: 0.3)))";
    let mut loaded = pouring(SPACES[0]);
    for contact in ["Linear(k: 1.0e4, damping: B(5.0))", frictional] {
        let text = loaded.source.text.replace("Linear(k: 1.0e4, damping: B(5.0))", contact);
        loaded = load::from_text("pouring.ron", "pouring", Path::new(""), text, &[]).unwrap();
        let mut run = run::<Labels>(&loaded);
        run.run_steps(1500);
        let seen = run.world_mut().run_system_cached(compare::<Plane>).unwrap();
        assert!(seen > 20, "{seen}");
    }
}

/// The linear spring-dashpot of the library as a law of another crate, k = 1e4 N/m and c = 20 N s/m, which may pull. With
/// `true` its contacts are centred.
#[derive(Deserialize)]
struct OwnDashpot(bool);

#[derive(Clone, Copy)]
struct Wrapped(Composite<LinearNormal, NoFriction, NoRolling>);

impl LawRequirements for Wrapped {
    const RADII: bool = false;
}

impl PairLaw for Wrapped {
    fn force(&self, pair: &Pair, memory: &mut Memory) -> PairForce {
        self.0.force(pair, memory)
    }
    fn centred(&self, pair: &Pair, memory: &mut Memory) -> PairForce {
        self.0.centred(pair, memory)
    }
    fn elastic_energy(&self, pair: &Pair, memory: &Memory) -> f64 {
        self.0.elastic_energy(pair, memory)
    }
    fn stiffness(&self, bounce: &Bounce) -> f64 {
        PairLaw::<Plane>::stiffness(&self.0, bounce)
    }
    fn damping(&self, bounce: &Bounce) -> f64 {
        PairLaw::<Plane>::damping(&self.0, bounce)
    }
    fn contact_duration(&self, bounce: &Bounce) -> f64 {
        PairLaw::<Plane>::contact_duration(&self.0, bounce)
    }
    fn restitution(&self, bounce: &Bounce) -> f64 {
        PairLaw::<Plane>::restitution(&self.0, bounce)
    }
}

impl Behaviour for OwnDashpot {
    fn brings_contact_law(&self) -> bool {
        true
    }
    fn build(self: Box<Self>, app: &mut App) {
        let damping = Damping::B(20.0.try_into().unwrap());
        let normal = LinearNormal::new(1.0e4.try_into().unwrap(), damping, Pull::Allowed);
        let law = Composite { normal, tangential: NoFriction, rolling: NoRolling };
        app.add_plugins(ContactPlugin::plane(Arc::new(Wrapped(law))));
        if self.0 {
            // Two grains of 0.16 kg: c/(2 m) with the reduced mass of 0.08 kg.
            let damping_rates = [20.0 / (2.0 * 0.08), 0.0];
            app.add_plugins(VelocityPredictionPlugin::<Plane> {
                damping_rates,
                springs_exact: true,
                space: PhantomData,
            });
        }
    }
}

#[test]
fn a_law_of_another_crate_moves_grains_like_the_same_law_of_the_scene_with_either_scheme() {
    for (integrator, centred) in [("Centred", true), ("Verlet", false)] {
        let law = "contact: Linear(k: 1.0e4, damping: B(20.0), attraction: Allowed)";
        let ends = [String::new(), format!(", behaviours: {{\"it\": ({centred})}}")].map(|more| {
            let more = format!("{law}, integrator: {integrator}{more}");
            let mut run = run::<OwnDashpot>(&two(SPACES[0], 0.081, -1.0, &more));
            assert_eq!(run.run(), End::TimeReached);
            let mut grains = run.world_mut().query_filtered::<(&Position, &Velocity), With<Grain>>();
            grains.iter(run.world()).map(|(x, v)| (x.0, v.0)).collect::<Vec<_>>()
        });
        assert_eq!(ends[0], ends[1], "{integrator}");
        assert!(ends[0].iter().any(|(_, v)| v.x > -0.9 && v.x < 0.0), "the grains have not met");
    }
}
