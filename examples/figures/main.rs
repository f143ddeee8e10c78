//! Draws the figures of the documentation, from new runs or from a table (`scaling`):
//!
//! ```text
//! cargo run --release --example figures              # writes docs/figures/{free-fall,step-error,scaling}.{svg,png}
//! cargo run --release --example figures -- scaling   # this figure only
//! ```

mod scaling;

use std::f64::consts::PI;
use std::num::NonZeroUsize;
use std::path::Path;

use siloflow::figures::diagram::{Axis, Curve, figure};
use siloflow::figures::png;
use siloflow::grains::file::GrainRow;
use siloflow::prelude::*;

const G: f64 = 9.81;
const V0: Vector = Vector::new(3.0, 2.0);

fn simulation(keys: &str, grains: Vec<GrainRow>) -> Simulation {
    let text = format!("({keys}, pictures: None)");
    let mut loaded = load::from_text("figure.ron", "figure", Path::new(""), text, &[]).expect("our own scene");
    loaded.grains = grains;
    Simulation::new(&loaded, &Registry::default(), NonZeroUsize::MIN).expect("our own scene")
}

fn grain(id: u32, position: Vector, velocity: Vector) -> GrainRow {
    let id = GrainId::grain(id).expect("a small number");
    GrainRow {
        id,
        radius: 0.04,
        mass: 0.16,
        position: position.extend(0.0),
        velocity: velocity.extend(0.0),
        spin: Solid::ZERO,
        posture: None,
        species: Species(0),
    }
}

fn positions(simulation: &mut Simulation) -> Vec<(Vector, Vector)> {
    let world = simulation.world_mut();
    let mut grains = world.query::<(&GrainId, &Position, &Velocity)>();
    let mut rows: Vec<_> = grains.iter(world).map(|(id, x, v)| (*id, x.0, v.0)).collect();
    rows.sort_by_key(|row| row.0);
    rows.into_iter().map(|(_, x, v)| (x, v)).collect()
}

/// Returns the path of a thrown grain during 1 s.
fn path(integrator: &str, steps: u32) -> Vec<(f64, f64)> {
    let keys = format!(
        "gravity: (0.0, -{G}), contact: Linear(k: 1.0, damping: B(0.0)), integrator: {integrator}, step: Fixed({:?}), until: 2.0",
        1.0 / f64::from(steps)
    );
    let mut simulation = simulation(&keys, vec![grain(1, Vector::ZERO, V0)]);
    (0..=u64::from(steps))
        .map(|step| {
            simulation.run_steps(step);
            let x = positions(&mut simulation)[0].0;
            (x.x, x.y)
        })
        .collect()
}

fn free_fall() -> String {
    let exact = |t: f64| (V0.x * t, V0.y * t - 0.5 * G * t * t);
    let curve = |name: &str, colour, points, has_line, has_dots| Curve {
        name: name.to_owned(),
        colour,
        points,
        has_line,
        has_dots,
        ..Curve::default()
    };
    let paths = vec![
        curve("parabola", "#222222", (0..=50).map(|i| exact(f64::from(i) / 50.0)).collect(), true, false),
        curve("Verlet, dt = 0.1 s", "#0072b2", path("Verlet", 10), false, true),
        curve("explicit Euler, dt = 0.1 s", "#d55e00", path("ExplicitEuler", 10), false, true),
        curve("explicit Euler, dt = 0.02 s", "#e69f00", path("ExplicitEuler", 50), false, true),
    ];
    let steps = [10, 30, 100, 300, 1000, 3000];
    let errors = |integrator: &str| -> Vec<(f64, f64)> {
        steps
            .iter()
            .map(|&n| {
                let end = path(integrator, n)[n as usize];
                let truth = exact(1.0);
                let error = (end.0 - truth.0).hypot(end.1 - truth.1);
                (1.0 / f64::from(n), error.max(1e-16))
            })
            .collect()
    };
    let second = vec![
        curve("Verlet: round-off", "#0072b2", errors("Verlet"), true, true),
        curve("explicit Euler: order 1", "#d55e00", errors("ExplicitEuler"), true, true),
    ];
    let x = Axis { label: "x, m".into(), from: 0.0, to: 3.2, is_log: false, ticks: vec![0.0, 1.0, 2.0, 3.0] };
    let y = Axis { label: "y, m".into(), from: -3.5, to: 2.0, is_log: false, ticks: vec![-3.0, -2.0, -1.0, 0.0, 1.0] };
    let dt = Axis { label: "time step, s".into(), from: 2e-4, to: 0.2, is_log: true, ticks: vec![1e-3, 1e-2, 1e-1] };
    let error = Axis {
        label: "position error at t = 1 s, m".into(),
        from: 1e-16,
        to: 1e4,
        is_log: true,
        ticks: vec![1e-15, 1e-12, 1e-9, 1e-6, 1e-3, 1.0],
    };
    figure(&[("A grain thrown at 3 and 2 m/s", x, y, paths), ("Error against the time step", dt, error, second)])
}

/// Returns the rms error of the restitution of a bounce over 40 phases, with `n` steps per contact.
fn bounce_error(e: f64, n: f64) -> f64 {
    const PHASES: u32 = 40;
    let k = 1.0e5;
    let m = 0.08f64;
    // exp(-pi zeta/sqrt(1 - zeta^2)) = e, attraction allowed.
    let zeta = -e.ln() / PI.hypot(e.ln());
    let duration = PI / ((k / m).sqrt() * (1.0 - zeta * zeta).sqrt());
    let dt = duration / n;
    let keys = format!(
        "gravity: (0.0, 0.0), contact: Linear(k: {k:?}, damping: Restitution({e:?}), attraction: Allowed), \
         step: Fixed({dt:?}), until: 1.0"
    );
    let square = |phase: u32| {
        let gap = dt * (1.0 + f64::from(phase) / f64::from(PHASES));
        let pair = vec![grain(1, Vector::ZERO, Vector::ZERO), grain(2, Vector::new(0.08 + gap, 0.0), -Vector::X)];
        let mut simulation = simulation(&keys, pair);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small positive number")]
        simulation.run_steps((1.2 * n).ceil() as u64 + 6);
        let after = positions(&mut simulation);
        (after[1].1.x - after[0].1.x - e).powi(2)
    };
    ((0..PHASES).map(square).sum::<f64>() / f64::from(PHASES)).sqrt()
}

fn step_error() -> String {
    let colours = ["#222222", "#0072b2", "#009e73", "#d55e00"];
    let curves = [1.0, 0.9, 0.5, 0.2].into_iter().zip(colours).map(|(e, colour)| {
        let steps = [5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0].map(|n| n + PI / 8.0);
        let points: Vec<_> = steps.iter().map(|&n| (n, bounce_error(e, n))).collect();
        let order = (points[3].1 / points[6].1).ln() / (points[6].0 / points[3].0).ln();
        Curve {
            name: format!("e = {e}: order {order:.2}"),
            colour,
            points,
            has_line: true,
            has_dots: true,
            ..Curve::default()
        }
    });
    let x = Axis {
        label: "cost: steps per contact, t_c/dt".into(),
        from: 4.0,
        to: 1500.0,
        is_log: true,
        ticks: vec![5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0],
    };
    let y = Axis {
        label: "rms error of the restitution".into(),
        from: 1e-7,
        to: 10.0,
        is_log: true,
        ticks: vec![1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0],
    };
    figure(&[("Velocity Verlet: a head-on bounce, 40 contact phases", x, y, curves.collect())])
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/figures");
    let figures: [(&str, fn() -> Result<String, Box<dyn std::error::Error>>); 3] =
        [("free-fall", || Ok(free_fall())), ("step-error", || Ok(step_error())), ("scaling", scaling::figure)];
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    for (name, draw) in figures.into_iter().filter(|(name, _)| wanted.is_empty() || wanted.iter().any(|w| w == name)) {
        let svg = draw()?;
        let path = directory.join(format!("{name}.svg"));
        std::fs::write(path.with_extension("png"), png::encode(&svg)?)?;
        std::fs::write(&path, svg)?;
    }
    Ok(())
}
