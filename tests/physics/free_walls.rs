//! Walls that forces move, against closed forms, a Runge-Kutta reference, and the conservation of momentum and energy.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::num::NonZeroUsize;
use std::path::Path;

use crate::{grain, motion, simulation};
use siloflow::dem::walls::free::FreeState;
use siloflow::dem::walls::surfaces::Surfaces;
use siloflow::energy::EnergyFlows;
use siloflow::measure::totals;
use siloflow::output::state_hash;
use siloflow::prelude::*;

/// A grain far from everything.
fn far_away() -> Vec<siloflow::grains::file::GrainRow> {
    vec![grain(1, Vector::new(50.0, 50.0), Vector::ZERO, 0.1, 1.0)]
}

fn state(run: &Simulation) -> FreeState {
    *run.world().resource::<Surfaces<Plane>>().free().next().unwrap().1
}

/// A lid of 2 m between two stops.
fn lid(free: &str) -> String {
    format!(
        "walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0)), Segment(from: (-1.0, 0.2), to: (1.0, 0.2), name: \"lid\")],
         free_walls: [(walls: \"lid\", moves: Along((0.0, 1.0)), {free})]"
    )
}

/// The error of the coordinate after `time` at two steps, and the order.
fn order(error: impl Fn(f64) -> f64, dt: f64) -> (f64, f64) {
    let [coarse, fine] = [error(dt), error(0.5 * dt)];
    (coarse, (coarse / fine).abs().log2())
}

#[test]
fn a_wall_on_a_spring_is_an_oscillator_of_second_order() {
    let (mass, stiffness, rate, time) = (2.0f64, 800.0f64, 0.3f64, 1.0f64);
    let pulse = (stiffness / mass).sqrt();
    let error = |dt: f64| {
        let free = format!("mass: {mass:?}, spring: (stiffness: {stiffness:?}), rate: {rate:?}, stops: (-0.15, 0.5)");
        let keys = format!(
            "gravity: (0.0, 0.0), contact: Linear(k: 1.0e4, damping: B(0.0)), step: Fixed({dt:?}), until: 2.0, {}",
            lid(&free)
        );
        let mut run = simulation(&keys, far_away());
        run.run_steps((time / dt).round() as u64);
        state(&run).coordinate - rate / pulse * (pulse * time).sin()
    };
    let (coarse, order) = order(error, 2e-3);
    // Phase error of Verlet: (w dt)^2/24 per radian.
    assert!(coarse.abs() < rate / pulse * (pulse * 2e-3).powi(2) / 24.0 * pulse * time * 1.1, "{coarse}");
    assert!((order - 2.0).abs() < 0.05, "order {order}");
}

#[test]
fn a_load_that_grows_moves_a_wall_by_the_cube_of_the_time() {
    let mass = 2.0f64;
    // No load until 0.1 s, then a slope of 50 N/s.
    let exact = |time: f64| 50.0 * (time - 0.1).powi(3) / (6.0 * mass);
    let error = |dt: f64| {
        let free = format!("mass: {mass:?}, load: [(0.1, 0.0), (1.1, 50.0)], stops: (-0.15, 5.0)");
        let keys = format!(
            "gravity: (0.0, 0.0), contact: Linear(k: 1.0e4, damping: B(0.0)), step: Fixed({dt:?}), until: 2.0, {}",
            lid(&free)
        );
        let mut run = simulation(&keys, far_away());
        run.run_steps((0.9 / dt).round() as u64);
        state(&run).coordinate - exact(0.9)
    };
    let (coarse, order) = order(error, 2e-3);
    // Verlet sums the acceleration at whole steps: dt^2/12 times the difference of its slopes at the ends, times the time.
    let expected = (2e-3f64).powi(2) / 12.0 * 50.0 / mass * 0.8;
    assert!(coarse.abs() < 2.1 * expected && (order - 2.0).abs() < 0.1, "{coarse} {expected}, order {order}");
}

/// A disc of mass m between the floor and a loaded lid of mass M, in displacements from the state without overlaps: the lid at rest is given a push.
/// `c` is the drag of each contact.
struct Squeezed {
    m: f64,
    big: f64,
    k: f64,
    c: f64,
    load: f64,
    push: f64,
}

impl Squeezed {
    const RADIUS: f64 = 0.1;

    /// Displacements of disc and lid where all forces balance.
    fn rest(&self) -> [f64; 2] {
        [-self.load / self.k, -2.0 * self.load / self.k]
    }

    /// Accelerations of disc and lid.
    fn accelerations(&self, [x, y, v, w]: [f64; 4]) -> [f64; 4] {
        let floor = -self.k * x - self.c * v;
        let above = self.k * (x - y) + self.c * (v - w);
        [v, w, (floor - above) / self.m, (above - self.load) / self.big]
    }

    /// Displacements after a time by the classical Runge-Kutta scheme with 200,000 steps.
    fn exact(&self, time: f64) -> [f64; 2] {
        let [disc, lid] = self.rest();
        let mut state = [disc, lid, 0.0, self.push];
        let step = time / 2e5;
        let ahead = |slope: [f64; 4], share: f64, from: [f64; 4]| -> [f64; 4] {
            std::array::from_fn(|i| from[i] + share * step * slope[i])
        };
        for _ in 0..200_000 {
            let first = self.accelerations(state);
            let second = self.accelerations(ahead(first, 0.5, state));
            let third = self.accelerations(ahead(second, 0.5, state));
            let last = self.accelerations(ahead(third, 1.0, state));
            let mean = |i: usize| (first[i] + 2.0 * second[i] + 2.0 * third[i] + last[i]) / 6.0;
            state = std::array::from_fn(|i| state[i] + step * mean(i));
        }
        [state[0], state[1]]
    }

    fn run(&self, scheme: &str, dt: f64, time: f64) -> Simulation {
        let Self { m, big, k, c, load, push } = *self;
        let [x, y] = self.rest();
        // The lid stands in the scene where it rests.
        let height = 2.0 * Self::RADIUS + y;
        let keys = format!(
            "gravity: (0.0, 0.0), contact: Linear(k: {k:?}, damping: B({c:?})), step: Fixed({dt:?}), until: 10.0, integrator: {scheme},
             walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0)), Segment(from: (-1.0, {height:?}), to: (1.0, {height:?}), name: \"lid\")],
             free_walls: [(walls: \"lid\", moves: Along((0.0, 3.0)), mass: {big:?}, load: {:?}, rate: {push:?}, stops: (-0.1, 0.1))]",
            -load
        );
        let mut run =
            simulation(&keys, vec![grain(1, Vector::new(0.0, Self::RADIUS + x), Vector::ZERO, Self::RADIUS, m)]);
        run.run_steps((time / dt).round() as u64);
        run
    }

    fn error(&self, scheme: &str, dt: f64, time: f64) -> f64 {
        let mut run = self.run(scheme, dt, time);
        let [x, y] = self.exact(time);
        let disc = motion(&mut run)[0].position.y - Self::RADIUS - x;
        let lid = state(&run).coordinate + self.rest()[1] - y;
        disc.hypot(lid)
    }
}

#[test]
fn a_loaded_lid_on_a_grain_moves_as_two_coupled_masses() {
    let elastic = Squeezed { m: 0.5, big: 2.0, k: 1e5, c: 0.0, load: 100.0, push: 0.05 };
    let damped = Squeezed { c: 40.0, ..elastic };
    for (case, scheme, expected) in [(&elastic, "Verlet", 2.0), (&damped, "Centred", 2.0), (&damped, "Verlet", 1.0)] {
        let (coarse, order) = order(|dt| case.error(scheme, dt, 0.1), 1e-4);
        // The motion has an amplitude of about push/w, w^2 = k/M/2.
        let amplitude = case.push / (case.k / case.big / 2.0).sqrt();
        assert!(coarse < 0.05 * amplitude, "{scheme}: {coarse} of {amplitude}");
        assert!((order - expected).abs() < 0.15, "{scheme}: order {order}");
    }
}

/// A disc that sticks to a plate under its weight, or is pressed between two plates. The plates slide along themselves with one another, are begun
/// with a speed, and nothing but the disc acts on them. `c` is the drag along the tangent in each contact, N s/m.
#[derive(Clone, Copy, Debug)]
struct Dragged {
    plates: u32,
    c: f64,
}

impl Dragged {
    const RADIUS: f64 = 0.1;
    const MASS: f64 = 0.5;
    const OF_PLATES: f64 = 2.0;
    const K: f64 = 2e4;
    const SPEED: f64 = 0.01;

    /// The speed of the plates after a time: s'' = -(n k s + n c s')/m for the distance s by which the disc has slid, with the reduced mass m.
    fn exact(self, time: f64) -> f64 {
        // The torques of two plates cancel each other; one plate also turns the disc.
        let turned = if self.plates == 1 { 2.0 } else { 0.0 };
        let reduced = 1.0 / ((1.0 + turned) / Self::MASS + 1.0 / Self::OF_PLATES);
        let springs = f64::from(self.plates);
        let rate = springs * self.c / (2.0 * reduced);
        let pulse = (springs * Self::K / reduced - rate * rate).sqrt();
        let (sin, cos) = (pulse * time).sin_cos();
        let slides = -Self::SPEED * (-rate * time).exp() * (cos - rate / pulse * sin);
        Self::SPEED - reduced / Self::OF_PLATES * (slides + Self::SPEED)
    }

    fn error(self, dt: f64, time: f64) -> f64 {
        let deep = 1e-3;
        let high = Self::RADIUS - deep;
        let (gravity, above) = if self.plates == 1 { (deep * 1e5 / Self::MASS, 1.0) } else { (0.0, high) };
        let keys = format!(
            "gravity: (0.0, -{gravity:?}), step: Fixed({dt:?}), until: 1.0, integrator: Centred,
             contact: Linear(k: 1.0e5, damping: B(20.0), tangential: Spring(k: {:?}, damping: B({:?}), friction: 1.0e3)),
             walls: [Segment(from: (-1.0, -{high:?}), to: (1.0, -{high:?}), name: \"plates\"),
                     Segment(from: (-1.0, {above:?}), to: (1.0, {above:?}), name: \"plates\")],
             free_walls: [(walls: \"plates\", moves: Along((1.0, 0.0)), mass: {:?}, rate: {:?}, stops: (-0.1, 0.1))]",
            Self::K,
            self.c,
            Self::OF_PLATES,
            Self::SPEED
        );
        let mut run = simulation(&keys, vec![grain(1, Vector::ZERO, Vector::ZERO, Self::RADIUS, Self::MASS)]);
        run.run_steps((time / dt).round() as u64);
        state(&run).rate - self.exact(time)
    }
}

#[test]
fn a_plate_that_slides_under_a_disc_drags_it_along() {
    for case in [(1, 0.0), (1, 20.0), (2, 0.0), (2, 20.0)].map(|(plates, c)| Dragged { plates, c }) {
        let (coarse, order) = order(|dt| case.error(dt, 0.02), 1e-4);
        // The plates swing with half their speed or less; w dt is 0.04.
        assert!(coarse.abs() < 2e-3 * Dragged::SPEED, "{case:?}: {coarse}");
        assert!((order - 2.0).abs() < 0.15, "{case:?}: {coarse}, order {order}");
    }
}

#[test]
fn momentum_of_a_grain_and_a_free_wall_is_kept_in_an_impact() {
    let (m, big, v) = (1.0f64, 4.0f64, 2.0f64);
    for (scheme, drag) in [("Verlet", "Restitution(1.0)"), ("Centred", "Restitution(0.5)")] {
        let keys = format!(
            "gravity: (0.0, 0.0), contact: Linear(k: 1.0e5, damping: {drag}), step: Fixed(1.0e-5), until: 0.05, integrator: {scheme}, {}",
            lid(&format!("mass: {big:?}, stops: (-0.05, 10.0)"))
        );
        let mut run = simulation(&keys, vec![grain(1, Vector::new(0.0, 0.1), Vector::new(0.0, v), 0.05, m)]);
        assert_eq!(run.run(), End::TimeReached);
        let grain = motion(&mut run)[0].velocity.y;
        let wall = state(&run);
        // 5,000 steps of round-off.
        assert!((m * grain + big * wall.rate - m * v).abs() < 1e-11, "{scheme}");
        // `Restitution` is that of a wall without motion, whose effective mass is m. With the reduced mass of both the impact is shorter and the same
        // dashpot takes more.
        let e = if scheme == "Verlet" { 1.0 } else { 0.5f64 };
        let log = e.ln();
        let zeta = -log / (std::f64::consts::PI.powi(2) + log * log).sqrt();
        let reduced = zeta * (1.0 + m / big).sqrt();
        let e = (-std::f64::consts::PI * reduced / (1.0 - reduced * reduced).sqrt()).exp();
        let expected = (m - e * big) / (m + big) * v;
        // A linear contact that does not pull ends a little earlier than the half period.
        let tolerance = if scheme == "Verlet" { 1e-4 } else { 0.1 };
        assert!((grain / expected - 1.0).abs() < tolerance, "{scheme}: {grain} {expected}");
        // The wall has gained the energy that the grain has lost.
        let flows = run.world().resource::<EnergyFlows>();
        let kinetic = 0.5 * big * wall.rate * wall.rate;
        assert!((kinetic + flows.wall_work).abs() < 1e-4 * kinetic, "{scheme}: {kinetic} J, {} J", flows.wall_work);
        assert!((totals::of_world(run.world()).energy() - flows.expected()).abs() < 1e-4, "{scheme}");
    }
}

/// The arithmetic-geometric mean.
fn agm(mut a: f64, mut b: f64) -> f64 {
    for _ in 0..20 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    a
}

#[test]
fn a_hanging_flap_swings_as_the_mathematical_pendulum() {
    // Released level: an amplitude of 90 degrees.
    let (inertia, mass, arm, g) = (0.03, 1.5, 0.2, 9.81);
    let period = TAU * f64::sqrt(inertia / (mass * g * arm)) / agm(1.0, (0.5 * FRAC_PI_2).cos());
    let error = |steps: f64| {
        let dt = period / steps;
        let keys = format!(
            "gravity: (0.0, -{g:?}), contact: Linear(k: 1.0e4, damping: B(0.0)), step: Fixed({dt:?}), until: 9.0, on_loss: Continue,
             walls: [Segment(from: (0.0, 1.0), to: (0.4, 1.0), name: \"flap\")],
             free_walls: [(walls: \"flap\", moves: About(point: (0.0, 1.0)), mass: {mass:?}, inertia: {inertia:?}, centre: ({arm:?}, 1.0),
               stops: (-3.2, 0.1))]"
        );
        let mut run = simulation(&keys, far_away());
        run.run_steps((0.5 * steps) as u64);
        let half = state(&run).coordinate + 2.0 * FRAC_PI_2;
        // Energy of the pendulum: the weight has worked.
        let FreeState { rate, work, .. } = state(&run);
        assert!((0.5 * inertia * rate * rate - work).abs() < 1e-4 * mass * g * arm, "{work} J");
        run.run_steps(steps as u64);
        half.hypot(state(&run).coordinate)
    };
    let [coarse, fine] = [error(200.0), error(400.0)];
    // At the turning points the angle has errors of second order in its phase squared, and of second order in its amplitude.
    assert!(coarse < 1e-3 && fine < 0.3 * coarse, "{coarse} {fine}");
}

#[test]
fn a_motor_pulls_with_its_limit_and_then_holds_its_speed() {
    let keys = format!(
        "gravity: (0.0, 0.0), contact: Linear(k: 1.0e4, damping: B(0.0)), step: Fixed(1.0e-3), until: 3.0, {}",
        lid("mass: 2.0, motor: (speed: 0.5, limit: 1.0, gain: 100.0), stops: (-0.1, 9.0)")
    );
    let mut run = simulation(&keys, far_away());
    // 1 N on 2 kg: 0.5 m/s^2, until gain (speed - rate) falls below the limit.
    run.run_steps(900);
    assert!((state(&run).rate - 0.45).abs() < 1e-12 && (state(&run).applied - 1.0).abs() < 1e-15);
    run.run_steps(3000);
    assert!((state(&run).rate - 0.5).abs() < 1e-12 && state(&run).applied.abs() < 1e-9);
    assert!((state(&run).work - 0.25).abs() < 1e-3, "{} J", state(&run).work);
}

#[test]
fn a_falling_lid_rests_on_its_stop_and_the_stop_takes_its_energy() {
    let keys = format!(
        "gravity: (0.0, -9.81), contact: Linear(k: 1.0e4, damping: B(0.0)), step: Fixed(1.0e-4), until: 1.0, on_loss: Continue, {}",
        lid("mass: 2.0, stops: (-0.1, 0.0)")
    );
    let mut run = simulation(&keys, far_away());
    run.run_steps(1000);
    assert!((state(&run).coordinate + 0.5 * 9.81 * 0.01).abs() < 1e-12, "{:?}", state(&run));
    run.run();
    let end = state(&run);
    assert_eq!((end.coordinate, end.rate, end.hits), (-0.1, 0.0, 1));
    // m g h, up to the part of the last step.
    assert!((end.lost / (2.0 * 9.81 * 0.1) - 1.0).abs() < 2e-3 && (end.work / end.lost - 1.0).abs() < 2e-3, "{end:?}");
}

#[test]
fn a_servo_comes_to_the_set_load_without_swinging() {
    let keys = "gravity: (0.0, 0.0), contact: Linear(k: 1.0e5, damping: B(60.0)), step: Fixed(1.0e-5), until: 0.5,
         walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0)), Segment(from: (-1.0, 0.2), to: (1.0, 0.2), name: \"lid\")],
         free_walls: [(walls: \"lid\", moves: Along((0.0, 1.0)), gain: 1.0e-3, load: -50.0, stops: (-0.1, 0.1))]";
    let mut run = simulation(keys, vec![grain(1, Vector::new(0.0, 0.1), Vector::ZERO, 0.1, 0.5)]);
    let mut lowest = 0.0f64;
    while run.step().is_none() {
        lowest = lowest.min(state(&run).coordinate);
    }
    // Two springs in a row.
    let expected = -2.0 * 50.0 / 1e5;
    assert!((state(&run).coordinate / expected - 1.0).abs() < 1e-6, "{:?}", state(&run));
    assert!(lowest > 1.01 * expected, "{lowest}");
    assert!((state(&run).of_grains - 50.0).abs() < 1e-4);
}

/// Twenty discs under a lid that falls on them, which a flap holds at the side.
const PRESS: &str = "(seed: 3, gravity: (0.0, -9.81), mass: Disc(100.0), step: Fixed(5.0e-5), until: 0.4, pictures: None,
    contact: Linear(k: 1.0e5, damping: Restitution(0.5), tangential: Spring(k: 1.0e5, damping: OfNormal(1.0), friction: 0.5)),
    walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0)), HalfPlane(point: (-0.2, 0.0), normal: (1.0, 0.0)),
            Segment(from: (0.2, 0.5), to: (0.2, 0.0), name: \"flap\"), Segment(from: (-0.2, 0.45), to: (0.19, 0.45), name: \"lid\"),
            HalfPlane(point: (0.5, 0.0), normal: (-1.0, 0.0))],
    free_walls: [(walls: \"lid\", moves: Along((0.0, 1.0)), mass: 5.0, load: -20.0, from: 0.05, stops: (-0.4, 0.1)),
                 (walls: \"flap\", moves: About(point: (0.2, 0.5)), inertia: 0.2, mass: 2.0, centre: (0.2, 0.25), spring: (stiffness: 40.0), damping: 0.5,
                  stops: (-0.2, 0.5))],
    fill: [(low: (-0.2, 0.0), high: (0.2, 0.4), spacing: 0.08, jitter: 0.002, radius: Uniform(0.03, 0.037))])";

#[test]
fn grains_between_free_walls_keep_the_balance_and_continue_to_the_same_bits() {
    let loaded = load::from_text("press.ron", "press", Path::new(""), PRESS.to_owned(), &[])
        .unwrap_or_else(|fault| panic!("{fault}"));
    let new = |threads: usize| {
        Simulation::new(&loaded, &Registry::default(), NonZeroUsize::new(threads).unwrap())
            .unwrap_or_else(|fault| panic!("{fault}"))
    };
    let mut whole = new(1);
    assert_eq!(whole.run(), End::TimeReached);
    let expected = state_hash::of_world(whole.world_mut());
    let states: Vec<FreeState> = whole.world().resource::<Surfaces<Plane>>().free().map(|(_, state)| *state).collect();
    let flows = *whole.world().resource::<EnergyFlows>();
    let error = totals::of_world(whole.world()).energy() - flows.expected();
    assert!(error.abs() < 0.01 * flows.dissipated, "{error} of {flows:?}");
    // The walls: what grains and other forces have done is in their motion and in the stops.
    let walls: Vec<_> = whole
        .world()
        .resource::<Surfaces<Plane>>()
        .free()
        .map(|(wall, state)| state.kinetic(wall) - state.work + state.lost)
        .collect();
    let gained: f64 = walls.iter().sum();
    assert!((gained + flows.wall_work).abs() < 0.01 * flows.wall_work.abs(), "{gained} J, {} J", flows.wall_work);
    assert!(states[0].coordinate < -0.02 && states[1].coordinate.abs() > 0.01, "{states:?}");
    let mut threaded = new(2);
    threaded.run();
    assert_eq!(state_hash::of_world(threaded.world_mut()), expected);
    let mut parts = new(1);
    for step in [1, 1500, 4000] {
        parts.run_steps(step);
        let saved = parts.save().unwrap();
        parts = Simulation::restored(&loaded, &Registry::default(), NonZeroUsize::MIN, &saved).unwrap();
    }
    parts.run();
    let again: Vec<FreeState> = parts.world().resource::<Surfaces<Plane>>().free().map(|(_, state)| *state).collect();
    assert_eq!((state_hash::of_world(parts.world_mut()), again), (expected, states));
}

#[test]
fn a_grain_that_passes_a_free_wall_within_a_step_is_lost() {
    let keys = format!(
        "gravity: (0.0, 0.0), contact: Linear(k: 1.0e5, damping: B(0.0)), step: Fixed(1.0e-3), until: 1.0, {}",
        lid("mass: 5.0, rate: -0.5, stops: (-0.15, 1.0)")
    );
    let mut run = simulation(&keys, vec![grain(1, Vector::new(0.0, 0.1), Vector::new(0.0, 500.0), 0.01, 0.1)]);
    let End::Failed(Failure::GrainLost { way, .. }) = run.run() else { panic!("the grain was not lost") };
    assert!(way.contains("through a moving wall"), "{way}");
}
