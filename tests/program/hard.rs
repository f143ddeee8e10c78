//! Hard cases, `scenes/hard`: the property that each case must have, and how it ends. docs/explanation/hard-cases.md lists them.
//!
//! In all cases every number stays finite and every grain is inside, out, or reported as lost. Energy does not grow
//! beyond the error of the scheme. Otherwise the run is refused, or stops with a message that names step and grain.

use std::f64::consts::PI;
use std::fs;

use crate::command_line::{siloflow, text};
use crate::{hash, load, root, simulation};
use siloflow::dem::walls::surfaces::Surfaces;
use siloflow::energy::EnergyFlows;
use siloflow::measure::totals::{self, Totals};
use siloflow::prelude::*;
use siloflow::studies::diff::where_they_part;

const DEEP: (&str, &str) = ("watchdog", "(overlap: None)");

fn run(name: &str, settings: &[(&str, &str)]) -> (Simulation, End) {
    let loaded = load(&format!("hard/{name}.ron"), settings);
    let mut run = simulation(&loaded, 1);
    let end = run.run();
    assert_finite_and_accounted(&mut run);
    (run, end)
}

/// Like [`run`], but asserts that the run reaches its end time.
fn through(name: &str, settings: &[(&str, &str)]) -> Simulation {
    let (run, end) = run(name, settings);
    assert_eq!(end, End::TimeReached, "{name} with {settings:?}");
    run
}

fn assert_finite_and_accounted(run: &mut Simulation) {
    let energies = totals::of_world(run.world());
    assert!(energies.energy().is_finite() && energies.largest_speed.is_finite(), "{energies:?}");
    let ledger = run.world().resource::<Ledger>();
    let lost = ledger.lost.iter().map(|loss| loss.grain).collect::<std::collections::HashSet<_>>();
    assert_eq!(lost.len(), ledger.lost.len(), "a grain is lost once");
    assert_eq!(ledger.released, ledger.inside() + ledger.out() + ledger.lost());
}

/// Returns the totals, the energy flows, and the measured energy less the expected energy, J.
fn balance(run: &Simulation) -> (Totals, EnergyFlows, f64) {
    let totals = totals::of_world(run.world());
    let flows = *run.world().resource::<EnergyFlows>();
    (totals, flows, totals.energy() - flows.expected())
}

/// Returns position, velocity and mass of all grains, sorted by id.
fn grains<V: Space>(run: &mut Simulation) -> Vec<(V, V, f64)> {
    let world = run.world_mut();
    let mut query = world.query_filtered::<(&GrainId, &Position<V>, &Velocity<V>, &Mass), With<Grain>>();
    let mut rows: Vec<_> = query.iter(world).map(|(id, x, v, m)| (*id, (x.0, v.0, m.0))).collect();
    rows.sort_unstable_by_key(|row| row.0);
    rows.into_iter().map(|row| row.1).collect()
}

fn planar(run: &mut Simulation) -> Vec<(Vector, Vector, f64)> {
    grains::<Plane>(run)
}

// Limits of the time step.

/// w0 of the compressed grain, 1/s: two springs of k = 1e5 N/m on 0.05 kg.
const PRESSED: f64 = 2000.0;

/// Returns a step at this share of the limit, with the damping coefficient `b` of each spring, N s/m.
fn pressed(share: f64, b: f64) -> (f64, [(&'static str, String); 2]) {
    let zeta = b / (0.05 * PRESSED);
    let dt = share * 2.0 / PRESSED * ((1.0 + zeta * zeta).sqrt() - zeta);
    (dt, [("step", format!("Fixed({dt:e})")), ("contact.damping", format!("B({b:e})"))])
}

fn settings<'a>(owned: &'a [(&'static str, String)]) -> Vec<(&'a str, &'a str)> {
    owned.iter().map(|(key, value)| (*key, value.as_str())).collect()
}

#[test]
fn below_the_limit_undamped_motion_is_the_closed_form_of_the_scheme() {
    for share in [0.5, 0.9] {
        let (dt, owned) = pressed(share, 0.0);
        let mut run = simulation(&load("hard/step-at-the-limit.ron", &settings(&owned)), 1);
        // From rest, x_n = A cos(n theta) with cos theta = 1 - (w0 dt)^2/2.
        let theta = (1.0 - 0.5 * (PRESSED * dt).powi(2)).acos();
        let mut largest = 0.0f64;
        for n in 1..=500 {
            run.run_steps(n);
            let x = planar(&mut run)[0].0.y;
            // Overlaps are differences of numbers of 0.02 m, and their round-off enters in each step. Where theta is
            // not near 0 or pi the recursion carries each error on without growth: at worst n errors, times 1/sin
            // theta.
            let bound = 4.0 * n as f64 * 0.02 * f64::EPSILON * (PRESSED * dt).powi(2) / theta.sin();
            let error = (x - 1e-4 * (n as f64 * theta).cos()).abs();
            assert!(error < bound, "{share} of the limit, step {n}: {error} > {bound}");
            largest = largest.max(x.abs());
        }
        assert!(largest > 0.99e-4);
    }
}

#[test]
fn at_the_limit_undamped_motion_alternates_its_sign() {
    // w0 dt = 2: x_n = (-1)^n A from rest, and round-off grows no faster than n^2. The program may also refuse this
    // step.
    let (_, owned) = pressed(1.0, 0.0);
    let Some(mut run) = accepted(&owned) else { return };
    run.run_steps(100);
    let x = planar(&mut run)[0].0.y;
    assert!((x - 1e-4).abs() < 1e4 * 4.0 * 0.02 * f64::EPSILON, "{x}");
}

#[test]
fn damped_motion_decays_below_the_limit_of_the_closed_form() {
    for b in [50.0, 100.0, 300.0] {
        for share in [0.5, 0.9] {
            let (_, owned) = pressed(share, b);
            let mut run = simulation(&load("hard/step-at-the-limit.ron", &settings(&owned)), 1);
            run.run_steps(2000);
            let (x, v, _) = planar(&mut run)[0];
            // The slowest mode is the overdamped one, with a time of 2 zeta/w0 = 3 ms, 20 steps, at zeta = 3. Near the
            // limit each other mode decays at least as 0.9^n.
            assert!(x.y.abs() < 1e-15 && v.y.abs() < 1e-12, "b = {b}, {share} of the limit: {x:?} {v:?}");
            assert!(balance(&run).1.dissipated > 0.0);
        }
    }
}

/// Like [`pressed`], for centred contacts: (4 - a)(1 + b) = 8 B with a = (w0 dt)^2, B = zeta w0 dt of both springs and
/// b = B/2 of one.
fn pressed_centred(share: f64, b: f64) -> [(&'static str, String); 3] {
    let zeta = b / (0.05 * PRESSED);
    let excess = |x: f64| (4.0 - x * x) * (1.0 + 0.5 * zeta * x) - 8.0 * zeta * x;
    let mut low = 0.0;
    let mut high = 2.0;
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if excess(middle) > 0.0 { low = middle } else { high = middle }
    }
    let step = format!("Fixed({:e})", share * low / PRESSED);
    [("integrator", "Centred".to_owned()), ("step", step), ("contact.damping", format!("B({b:e})"))]
}

#[test]
fn centred_limit_is_the_closed_form_and_causes_a_warning() {
    for b in [50.0, 100.0, 300.0] {
        for share in [0.5, 0.9, 1.1] {
            let owned = pressed_centred(share, b);
            let loaded = load("hard/step-at-the-limit.ron", &settings(&owned));
            let codes: Vec<_> = siloflow::scene::check::warnings(&loaded).iter().map(|warning| warning.code).collect();
            assert_eq!(codes, if share < 1.0 { &[][..] } else { &["check::unstable_bed"] }, "b = {b}, {share}");
            let mut run = simulation(&loaded, 1);
            if share < 1.0 {
                run.run_steps(2000);
                let (x, v, _) = planar(&mut run)[0];
                // As with damping evaluated half a step late.
                assert!(x.y.abs() < 1e-15 && v.y.abs() < 1e-12, "b = {b}, {share} of the limit: {x:?} {v:?}");
            } else if let End::Failed(failure) = run.run() {
                let message = failure.to_string();
                assert!(message.starts_with("step ") && message.contains("grain 1"), "{message}");
            } else {
                // An oscillation that opens contacts is one of a single contact for some time, which is stable here at
                // zeta = 0.5. It grows to a tenth of the radius and stays there.
                assert!(b < 100.0 && planar(&mut run)[0].0.y.abs() > 2e-4, "b = {b}: {:?}", planar(&mut run)[0]);
            }
        }
    }
}

/// Returns a simulation, or `None` if a step beyond the limit is refused at loading.
fn accepted(owned: &[(&'static str, String)]) -> Option<Simulation> {
    let settings: Vec<_> = owned.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect();
    match load::load(&crate::scene("hard/step-at-the-limit.ron"), &settings) {
        Ok(loaded) => Some(simulation(&loaded, 1)),
        Err(fault) => {
            assert_eq!(fault.scene_key(), Some("step"), "{fault}");
            None
        }
    }
}

#[test]
fn run_beyond_the_limit_is_refused_or_stops_and_names_the_grain() {
    for b in [0.0, 50.0, 100.0, 300.0] {
        let (_, owned) = pressed(1.1, b);
        let Some(mut run) = accepted(&owned) else { continue };
        let End::Failed(failure) = run.run() else { panic!("b = {b}: {:?}", balance(&run)) };
        let message = failure.to_string();
        assert!(message.starts_with("step ") && message.contains("grain 1"), "{message}");
        assert!(message.contains("lower `step`") || message.contains("through a wall surface"), "{message}");
    }
}

#[test]
fn unstable_bed_is_refused_or_stops_and_names_a_grain() {
    // Stable for one contact, w0 dt = 1.8, unstable in a bed.
    let settings = [("step", "Fixed(0.0005)"), ("until", "0.5")].map(|(k, v)| (k.to_owned(), v.to_owned()));
    let Ok(loaded) = load::load(&crate::scene("hard/all-at-once.ron"), &settings) else { return };
    let mut run = simulation(&loaded, 1);
    let End::Failed(failure) = run.run() else { panic!("{:?}", balance(&run)) };
    let message = failure.to_string();
    assert!(message.starts_with("step ") && message.contains("grain "), "{message}");
}

// Large ratios.

#[test]
fn contact_a_million_times_stiffer_carries_its_load() {
    let mut run = through("stiffness-ratio", &[]);
    let rows = planar(&mut run);
    let weight = 0.16 * 9.81;
    let overlaps = [0.04 - rows[0].0.y, 0.08 - (rows[1].0.y - rows[0].0.y)];
    // Remaining oscillation: e = 0.3 has zeta = 0.36 or more for a free pair. The lower grain is held, so w0 =
    // sqrt(k/m) = 25/s and beta = 0.36 w0/sqrt 2 = 6.3/s.
    let left = 0.02 * (-6.3 * 3.0f64).exp();
    for (overlap, expected) in overlaps.into_iter().zip([2.0 * weight / 1e8, weight / 1e2]) {
        assert!((overlap - expected).abs() < left + 1e-15, "{overlap} {expected}");
    }
}

#[test]
fn step_limit_of_a_stiff_floor_uses_the_grains_on_it() {
    let with = |step: &str| {
        let settings = [("step".to_owned(), format!("Fixed({step})"))];
        load::load(&crate::scene("hard/stiffness-ratio.ron"), &settings)
    };
    // 2/w0 = 2 sqrt(0.16/1e8) s for a single grain on the floor. With another grain on top the limit is lower, which
    // causes a warning.
    let codes: Vec<_> =
        siloflow::scene::check::warnings(&with("7.9e-5").unwrap()).iter().map(|warning| warning.code).collect();
    assert_eq!(codes, ["check::unstable_bed", "check::deep_impacts"]);
    assert_eq!(with("8.1e-5").unwrap_err().code(), "scene::unstable_step");
}

#[test]
fn grain_a_million_times_lighter_leaves_with_twice_the_speed() {
    let mut run = through("mass-ratio", &[]);
    let [(_, heavy, big), (_, light, small)] = planar(&mut run)[..] else { panic!("two grains") };
    let expected = 2.0 * big / (big + small);
    // The energy error of an undamped bounce is the error of the potential at entry and exit: at most (w0 dt)^2/4 of it
    // each, 0.8 %. The error of the speed is half of that.
    let w0_dt = (1e5 / small).sqrt() * 1.3e-5;
    assert!((light.x / expected - 1.0).abs() < 0.25 * w0_dt * w0_dt, "{} {expected}", light.x);
    // Momentum is exact up to the round-off of a thousand steps.
    assert!((big * heavy.x + small * light.x - big).abs() < 1e3 * big * f64::EPSILON);
    assert_eq!((heavy.y, light.y), (0.0, 0.0));
}

/// The energy error may be (w0 dt)^2/6 of the dissipation of damped bounces plus (w0 dt)^2/4 of the elastic energy.
fn assert_energy_error_of_the_scheme(run: &Simulation, w0_dt: f64) {
    let (totals, flows, error) = balance(run);
    let bound = w0_dt * w0_dt * (flows.dissipated / 6.0 + totals.elastic / 4.0);
    assert!(error.abs() < bound, "{error} J of {flows:?}, bound {bound}");
}

#[test]
fn energy_balance_of_grains_under_a_much_larger_one_closes() {
    let run = through("size-ratio", &[]);
    assert_eq!(run.world().resource::<Ledger>().inside(), 243);
    // Two small grains: the reduced mass is half their mass.
    assert_energy_error_of_the_scheme(&run, (1e6 / 2e-4f64).sqrt() * 3e-6);
}

/// Small grains between large ones, radii 1:20. The pair of the highest frequency is that of two small grains.
#[test]
fn small_grains_caught_between_large_ones_are_neither_lost_nor_heated() {
    let frictionless = ("contact.tangential", "None");
    for (scheme, more) in
        [("Centred", &[][..]), ("Verlet", &[]), ("Verlet", &[frictionless]), ("SymplecticEuler", &[frictionless])]
    {
        let run = through("caught", &[&[("integrator", scheme)], more].concat());
        let ledger = run.world().resource::<Ledger>();
        assert_eq!((ledger.inside(), ledger.lost()), (409, 0), "{scheme}");
        let w0_dt = (4e5 / 1.25e-3f64).sqrt() * 1e-5;
        if scheme == "SymplecticEuler" {
            // First order in the step.
            let (totals, flows, error) = balance(&run);
            let bound = w0_dt * (flows.dissipated + totals.elastic);
            assert!(error.abs() < bound, "{error} J, bound {bound} J");
        } else {
            assert_energy_error_of_the_scheme(&run, w0_dt);
        }
    }
}

/// A grain of 1 cm between two of 20 cm between a floor and a lid, all pressed by 1 mm; `u` is its velocity, m/s.
fn sandwich(scheme: &str, dt: f64, u: f64) -> Loaded {
    let text = format!(
        "(gravity: (0.0, 0.0), contact: Linear(k: 1.0e5, damping: B(0.0)), mass: ArealSquare(100.0), integrator: {scheme},
        step: Fixed({dt:e}), until: 1.0, pictures: None, watchdog: None,
        walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0)), HalfPlane(point: (0.0, 0.816), normal: (0.0, -1.0))],
        fill: [(low: (-0.2, -0.001), high: (0.2, 0.399), spacing: 0.4, radius: Fixed(0.2)),
            (low: (-0.01, 0.398), high: (0.01, 0.418), spacing: 0.02, radius: Fixed(0.01), velocity: (0.0, {u:e})),
            (low: (-0.2, 0.417), high: (0.2, 0.817), spacing: 0.4, radius: Fixed(0.2))])"
    );
    load::from_text("a.ron", "a", std::path::Path::new(""), text, &[]).unwrap()
}

/// The largest distance of the small grain from the middle in 1000 steps, m; endless if its contacts opened.
fn swing(scheme: &str, dt: f64, u: f64) -> f64 {
    let mut run = simulation(&sandwich(scheme, dt, u), 1);
    let mut most = 0.0f64;
    for n in 1..=1000 {
        run.run_steps(n);
        most = most.max((planar(&mut run)[1].0.y - 0.408).abs());
    }
    most
}

/// The motion of the small grain m against both large ones M, each with two springs, has (2 k - M w^2)(2 k - m w^2) = 2 k^2.
#[test]
fn check_bounds_the_step_of_a_grain_caught_between_large_ones() {
    let k = 1e5f64;
    let [m, big] = [0.01f64, 4.0];
    let sum = 2.0 * k / m + 2.0 * k / big;
    let product = 2.0 * k * k / (m * big);
    let w = (0.5 * (sum + (sum * sum - 4.0 * product).sqrt())).sqrt();
    let u = 0.01;
    for scheme in ["Centred", "Verlet", "SymplecticEuler"] {
        let stated = siloflow::scene::check::Estimates::of(&sandwich(scheme, 1e-5, u)).unwrap().bed_limit;
        assert!(stated < 2.0 / w && stated > 1.0 / w, "{scheme}: {stated} {}", 2.0 / w);
        // From the middle, x_n = u dt sin(n theta)/sin theta with cos theta = 1 - (w dt)^2/2. The slow motion of the large grains adds
        // less than the same again.
        for dt in [0.95 * stated, 0.97 * 2.0 / w] {
            let theta = (1.0 - 0.5 * (w * dt).powi(2)).acos();
            let most = swing(scheme, dt, u);
            assert!(most > 0.5 * u * dt && most < 2.0 * u * dt / theta.sin(), "{scheme}, {dt} s: {most} m");
        }
        // Beyond, the motion grows until contacts open, at 1 mm.
        assert!(swing(scheme, 1.03 * 2.0 / w, u) > 5e-4, "{scheme}");
    }
}

#[test]
fn explicit_euler_drives_a_caught_grain_out_with_a_warning_before() {
    let loaded = sandwich("ExplicitEuler", 2e-5, 0.01);
    let codes: Vec<_> = siloflow::scene::check::warnings(&loaded).iter().map(|warning| warning.code).collect();
    assert!(codes.contains(&"check::unstable_step"), "{codes:?}");
    let end = simulation(&loaded, 1).run();
    assert!(matches!(end, End::Failed(_)), "{end:?}");
}

#[test]
fn a_large_grain_that_crushes_the_small_one_below_it_causes_a_warning() {
    // 4 kg on k presses a grain of 0.01 m by 0.3 of its radius with k = 39.24 N/0.003 m = 13080 N/m.
    for (k, is_too_soft) in [("13000.0", true), ("13160.0", false)] {
        let text = format!(
            "(gravity: (0.0, -9.81), contact: Linear(k: {k}, damping: Restitution(0.5)), mass: ArealSquare(100.0), step: Fixed(1.0e-4),
            until: 0.1, walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0))],
            fill: [(low: (-0.2, 0.0), high: (0.2, 0.02), spacing: 0.02, radius: Fixed(0.01)),
                (low: (-0.2, 0.02), high: (0.2, 0.42), spacing: 0.4, radius: Fixed(0.2))])"
        );
        let loaded = load::from_text("a.ron", "a", std::path::Path::new(""), text, &[]).unwrap();
        let warnings = siloflow::scene::check::warnings(&loaded);
        let found = warnings.iter().find(|warning| warning.code == "check::caught_grains");
        assert_eq!(found.is_some(), is_too_soft, "{k}: {warnings:?}");
        assert!(found.is_none_or(|warning| warning.message.contains("by 0.30 of its radius")), "{warnings:?}");
    }
}

// Columns and symmetry.

#[test]
fn wave_in_a_column_of_a_thousand_grains_has_the_speed_of_a_chain() {
    let mut run = through("tall-column", &[]);
    let rows = planar(&mut run);
    assert!(rows.len() == 1000 && rows.iter().all(|(x, v, _)| x.x == 0.0 && v.x == 0.0));
    assert_energy_error_of_the_scheme(&run, (1e6 / 0.08f64).sqrt() * 5e-5);
    // w0 t = 250 grains. In a chain the influence of the floor passes from neighbour to neighbour. In front of the wave
    // the deviation from free fall begins with (w0 t)^2n/(2n)! g/w0^2, below (e w0 t/2n)^2n. From n = e w0 t on that is
    // below 4^-n.
    let front = (1e6 / 0.16f64).sqrt() * 0.1 * std::f64::consts::E;
    let t = 0.1;
    assert!(front < 700.0);
    for (n, (x, v, _)) in rows.iter().enumerate().filter(|(n, _)| *n as f64 > front) {
        let x0 = 0.04 + 0.08 * n as f64;
        let dv = v.y + 9.81 * t;
        let dx = 0.5 * 9.81 * t * t;
        // Two thousand sums of speeds of 1 m/s and of heights of 80 m. Grains that just touch may overlap by round-off,
        // 1e-14 m. Their spring with w0 = 2500/s then gives them a speed of 2e-11 m/s.
        assert!(dv.abs() < 1e-10 && (x.y - (x0 - dx)).abs() < 1e-10, "grain {n}: {dv} {}", x.y - (x0 - dx));
    }
    // Far behind the front, as in a bar stopped at its end, each grain keeps the speed that the wave gave it, -g n/w0.
    // The front is (w0 t)^(1/3), six grains, wide, and the hundredth grain is 150 grains behind it.
    let behind_wave = -9.81 * 100.5 / 2500.0;
    assert!((rows[100].1.y / behind_wave - 1.0).abs() < 0.01, "{} {behind_wave}", rows[100].1.y);
}

#[test]
fn grains_in_an_exact_column_block_the_release_and_are_named() {
    let (mut run, end) = run("one-column", &[]);
    let End::Failed(Failure::ReleaseBlocked { grain, blocker, .. }) = &end else { panic!("{end:?}") };
    assert!(blocker.starts_with("grain ") && grain.number() > 8, "{end:?}");
    assert!(planar(&mut run).iter().all(|(x, v, _)| x.x == 0.0 && v.x == 0.0));
}

#[test]
fn symmetric_stack_stays_symmetric_to_the_last_bit() {
    let mut run = simulation(&load("hard/symmetric-stack.ron", &[]), 1);
    for n in (0..=10_000).step_by(100) {
        run.run_steps(n);
        let rows = planar(&mut run);
        let mirror = |v: Vector| Vector::new(-v.x, v.y);
        assert_eq!((rows[0].0, rows[0].1), (mirror(rows[1].0), mirror(rows[1].1)), "step {n}");
        assert_eq!((rows[2].0.x, rows[2].1.x), (0.0, 0.0), "step {n}");
    }
    let rows = planar(&mut run);
    assert!(rows[2].0.y < 0.119 && rows[1].0.x > 0.0425, "the upper one has pushed the others apart: {rows:?}");
}

// Grains that start inside each other, and tunnelling.

fn too_deep(name: &str) -> (u64, u32, String, f64) {
    let (_, end) = run(name, &[]);
    let End::Failed(Failure::TooDeep { step, grain, partner, ratio, .. }) = end else { panic!("{name}: {end:?}") };
    (step, grain.number(), partner, ratio)
}

#[test]
fn grains_that_start_too_deep_are_named_in_step_zero() {
    assert_eq!(too_deep("coincident"), (0, 1, "grain 2".to_owned(), 2.0));
    let (step, grain, partner, ratio) = too_deep("inside");
    // 0.11 m less 0.01 m, over 0.01 m.
    assert_eq!((step, grain, partner.as_str()), (0, 1, "grain 2"));
    assert!((ratio - 10.0).abs() < 1e-13, "{ratio}");
}

#[test]
fn coincident_grains_separate_along_a_direction_derived_from_their_ids() {
    let mut first = through("coincident", &[DEEP]);
    let mut again = through("coincident", &[DEEP, ("neighbours", "AllPairs")]);
    assert_eq!(hash(&mut first), hash(&mut again));
    let [(a, va, m), (b, vb, _)] = planar(&mut first)[..] else { panic!("two grains") };
    // k (2 R)^2/2 = m v^2 for the two together. The motion starts at the turning point, so the scheme errs at the exit
    // only: (w0 dt)^2/4 of the energy with w0 of the pair.
    let speed = 0.08 * (1e4 / (2.0 * m)).sqrt();
    let w0_dt = (2.0 * 1e4 / m).sqrt() * 1.3e-4;
    for v in [va, vb] {
        assert!((v.length() / speed - 1.0).abs() < 0.25 * w0_dt * w0_dt, "{v:?} {speed}");
    }
    assert!((va + vb).length() < 1e-12 && (a + b - 2.0 * Vector::new(0.3, 0.7)).length() < 1e-12);
    // The grains separate along the normal that they were given. Its direction is known to the round-off of the first
    // separation, a dt^2/2 each, at 0.7 m.
    let condition = 4.0 * 0.7 * f64::EPSILON / (1e4 * 0.08 / m * 1.3e-4f64.powi(2));
    let apart = a - b;
    let parting = va - vb;
    let sine = apart.perp_dot(parting) / apart.length() / parting.length();
    assert!(sine.abs() < condition && apart.dot(parting) > 0.0, "{sine} {condition}");
}

#[test]
fn grain_inside_another_is_driven_out() {
    let mut run = through("inside", &[DEEP]);
    let [(a, va, big), (b, vb, small)] = planar(&mut run)[..] else { panic!("two grains") };
    assert!((a - b).length() > 0.11);
    let reduced = big * small / (big + small);
    let speed = (1e3 / reduced).sqrt() * 0.1;
    let w0_dt = (1e3 / reduced).sqrt() * 1e-4;
    assert!(((va - vb).length() / speed - 1.0).abs() < 0.25 * w0_dt * w0_dt, "{} {speed}", (va - vb).length());
    assert!((big * va + small * vb).length() < 1e-13);
}

#[test]
fn grain_that_crosses_a_wall_in_one_step_is_detected_in_that_step() {
    let half_plane = ("walls", "[HalfPlane(point: (0.5, 0.0), normal: (-1.0, 0.0))]");
    let disc = ("walls", "[Disc(centre: (0.5, -0.03), radius: 0.03), Disc(centre: (0.5, 0.03), radius: 0.03)]");
    for settings in [&[][..], &[half_plane], &[disc]] {
        let (_, end) = run("bullet", settings);
        let End::Failed(failure) = end else { panic!("{settings:?}: {end:?}") };
        let message = failure.to_string();
        assert!(message.starts_with("step 1: grain 1"), "{message}");
        assert!(message.contains("1.0000 m in one step: lower `step`") || message.contains("overlap by"), "{message}");
    }
    let (mut run, end) = run("bullet", &[("on_loss", "Continue")]);
    assert_eq!(end, End::Empty);
    let ledger = run.world().resource::<Ledger>();
    assert_eq!((ledger.lost(), ledger.lost[0].grain, ledger.lost[0].step), (1, 1, 1));
    assert_eq!(planar(&mut run)[0].1, Vector::new(1000.0, 0.0), "a contact changed its velocity");
}

#[test]
fn deep_overlap_with_a_wall_that_creates_energy_stops_the_run() {
    // After one step the grain is half a metre inside a half-plane, and the spring adds k delta^2/2 without a source.
    // Schemes that can be stable are refused at this step size.
    let settings = [
        ("walls", "[HalfPlane(point: (0.5, 0.0), normal: (-1.0, 0.0))]"),
        ("contact.k", "1.0e6"),
        ("integrator", "ExplicitEuler"),
        ("on_loss", "Continue"),
        DEEP,
    ];
    let (_, end) = run("bullet", &settings);
    let End::Failed(Failure::EnergyGrew { grain, created_j, put_in_j, .. }) = end else { panic!("{end:?}") };
    assert_eq!(grain.number(), 1);
    assert!(created_j > 0.1 * put_in_j, "{created_j} {put_in_j}");
}

// A bed under pressure.

#[test]
fn door_opens_under_a_bed_with_overlaps_of_thirty_percent() {
    let mut run = simulation(&load("hard/pressed-door.ron", &[]), 1);
    run.run_steps(4990);
    let before = totals::of_world(run.world());
    assert!((0.25..0.4).contains(&before.largest_overlap_ratio), "{before:?}");
    let held = before.elastic;
    assert_eq!(run.run(), End::Empty);
    assert_finite_and_accounted(&mut run);
    let ledger = run.world().resource::<Ledger>();
    assert_eq!((ledger.out(), ledger.lost()), (756, 0));
    let (_, flows, error) = balance(&run);
    assert!(flows.removed != 0.0 && held > 0.0);
    // (w0 dt)^2/6 of the dissipation, and the half-kick of the removed door, k dt^2/(4 m) of the energy in its
    // contacts. That energy is less than all elastic energy.
    let m = 2500.0 * 4.0 / 3.0 * PI * 0.0099f64.powi(3);
    let w2 = 1300.0 / m * 2e-4f64.powi(2);
    assert!(error.abs() < 2.0 * w2 / 6.0 * flows.dissipated + 0.25 * w2 * held, "{error} of {flows:?}");
}

// Positions far from the origin, and small boxes.

#[test]
fn motion_a_thousand_kilometres_away_is_the_same() {
    let far = planar(&mut through("far-away", &[]))[0];
    let near = [
        ("walls", "[HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0))]"),
        ("fill[0].low", "(-0.04, 0.5)"),
        ("fill[0].high", "(0.04, 0.58)"),
    ];
    let near = planar(&mut through("far-away", &near))[0];
    // Positions are rounded to 1.2e-10 m in each of 10^4 steps, at random or, at worst, in one direction. A bounce
    // turns a displacement dx into a velocity difference of g dx/v, less than w0 dx.
    let rounded = 1e6 * f64::EPSILON * 1e4;
    let dx = far.0 - Vector::splat(1e6) - near.0;
    let dv = far.1 - near.1;
    assert!(dx.length() < rounded && dv.length() < 250.0 * rounded, "{dx:?} {dv:?}");
    assert!(near.1.y.abs() > 0.1, "it does not bounce");
}

#[test]
fn smallest_periodic_box_gives_equal_bits_for_all_searches_and_conserves() {
    let mut reference = through("small-box", &[("neighbours", "AllPairs")]);
    for neighbours in ["VerletList(skin: 0.01)", "VerletList(skin: 0.5)", "Cells(size: 0.08)", "Cells(size: 0.16)"] {
        let mut other = through("small-box", &[("neighbours", neighbours)]);
        let part = || {
            let start = |neighbours| simulation(&load("hard/small-box.ron", &[("neighbours", neighbours)]), 1);
            where_they_part(start(neighbours), start("AllPairs"), u64::MAX)
        };
        assert_eq!(hash(&mut other), hash(&mut reference), "{neighbours}: {}", part());
    }
    let momentum: Vector = planar(&mut reference).iter().map(|(_, v, m)| *m * *v).sum();
    let start: Vector = {
        let mut fresh = simulation(&load("hard/small-box.ron", &[]), 1);
        fresh.run_steps(0);
        planar(&mut fresh).iter().map(|(_, v, m)| *m * *v).sum()
    };
    assert!((momentum - start).length() < 1e-12, "{momentum:?} {start:?}");
    let (_, flows, error) = balance(&reference);
    // A contact that opens or closes a share s of a step before its end errs by (w0 dt)^2 s (1 - s) of its energy,
    // which is at most the total energy.
    let w0_dt = (1e4 / 0.08f64).sqrt() * 1e-4;
    let bound = 0.25 * w0_dt * w0_dt * f64::from(contact_changes("hard/small-box.ron", 10_000)) * flows.released;
    assert!(error.abs() < bound, "{error} {bound}");
    let smaller = [("periodic.x".to_owned(), "(0.0, 0.16)".to_owned())];
    let fault = load::load(&crate::scene("hard/small-box.ron"), &smaller).unwrap_err();
    assert_eq!(fault.code(), "scene::box_too_small");
}

/// Returns the number of contacts that open or close in `steps` steps, if no two do so in one step.
fn contact_changes(name: &str, steps: u64) -> u32 {
    let mut run = simulation(&load(name, &[]), 1);
    let mut before = 0.0;
    let mut changes = 0;
    for n in 0..=steps {
        run.run_steps(n);
        let now = totals::of_world(run.world()).coordination;
        changes += u32::from(now != before);
        before = now;
    }
    assert!(changes > 4, "too few contacts");
    changes
}

// Extreme coefficients.

#[test]
fn restitution_one_conserves_energy() {
    let run = through("restitution-one", &[]);
    let (totals, _, error) = balance(&run);
    // A contact that opens or closes a share s of a step before its end errs by (w0 dt)^2 s (1 - s) of the energy, with
    // either sign. For random phases the difference of two such errors has the standard deviation sqrt(2/180) = 0.105.
    // The bound is three of them.
    let energy = 0.16 * 9.81 * 0.5;
    let bound = 3.0 * 0.105 * 94f64.sqrt() * (250.0f64 * 3.7e-4).powi(2) * energy;
    assert!(error.abs() < bound, "{error} of {energy}, bound {bound}");
    assert!(totals.largest_speed > 0.0);
}

/// Returns the speed along the incline (m/s) and of rotation (rad/s) after one second, with this friction.
fn rolled(friction: f64) -> (f64, f64) {
    let friction = format!("{friction:e}");
    let mut run = through("incline", &[("contact.tangential.friction", &friction)]);
    let velocity = planar(&mut run)[0].1;
    let world = run.world_mut();
    (velocity.x, world.query::<&Spin<f64>>().single(world).unwrap().0)
}

#[test]
fn disc_rolls_above_and_slides_below_the_friction_threshold() {
    let g = 9.81;
    let sin = 0.5;
    let cos = 0.75f64.sqrt();
    let radius = 0.04;
    let threshold = sin / cos / 3.0;
    for mu in [1.1 * threshold, 1.0, 1e3] {
        let (v, spin) = rolled(mu);
        // The start stretches the tangential spring, which oscillates about its load m g sin/3 until it is damped out.
        // The remaining error is the way v dt of one step.
        assert!((v - 2.0 / 3.0 * g * sin).abs() < 1e-3 && (v + spin * radius).abs() < 1e-3, "{mu}: {v} {spin}");
    }
    for mu in [0.0, 0.5 * threshold, 0.9 * threshold] {
        let (v, spin) = rolled(mu);
        let expected = g * (sin - mu * cos);
        let turning = -2.0 * mu * g * cos / radius;
        // Until the spring reaches its cap, mu m g cos/k = 1e-5 m, the friction is smaller: for about a millisecond.
        let start = 1e-3 * mu * g * cos;
        assert!((v - expected).abs() <= 1e-9 + start, "{mu}: {v} {expected}");
        assert!((spin - turning).abs() <= 1e-9 + 2.0 * start / radius, "{mu}: {spin} {turning}");
    }
}

// Very few and very many grains.

#[test]
fn scene_without_grains_runs() {
    let run = through("no-grains", &[]);
    let (totals, flows, error) = balance(&run);
    assert_eq!((totals.grains, totals.energy(), flows.expected(), error), (0, 0.0, 0.0, 0.0));
    let here = tempfile::tempdir().unwrap();
    let path = crate::scene("hard/no-grains.ron").display().to_string();
    let output = siloflow(here.path(), &["run", &path, "--json"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let summary = fs::read_to_string(here.path().join("out/no-grains/summary.json")).unwrap();
    let _: serde_json::Value = serde_json::from_str(&summary).unwrap();
    for command in ["check", "explain"] {
        assert!(siloflow(here.path(), &[command, &path]).status.success(), "{command}");
    }
}

#[test]
fn one_grain_follows_a_parabola() {
    let mut run = through("one-grain", &[]);
    let (x, v, _) = planar(&mut run)[0];
    // A thousand sums of numbers of order 1 to 10.
    assert!((x - Vector::new(3.0, 4.0 - 0.5 * 9.81)).length() < 1e-11, "{x:?}");
    assert!((v - Vector::new(3.0, 4.0 - 9.81)).length() < 1e-11, "{v:?}");
}

#[test]
fn fixed_particles_exert_no_force_on_each_other() {
    let mut run = through("all-fixed", &[]);
    let (totals, flows, _) = balance(&run);
    assert_eq!((totals.energy(), totals.largest_overlap_ratio, flows.expected()), (0.0, 0.0, 0.0));
    let world = run.world_mut();
    assert!(world.query::<&Force>().iter(world).all(|force| force.0 == Vector::ZERO));
    assert!(world.resource::<Surfaces>().loads.iter().all(|load| load.force == Vector::ZERO));
}

#[test]
fn touching_grains_at_rest_without_gravity_do_not_move() {
    let mut run = simulation(&load("hard/no-gravity.ron", &[]), 1);
    run.run_steps(0);
    let before = planar(&mut run);
    assert_eq!(run.run(), End::TimeReached);
    assert_eq!(planar(&mut run), before);
    assert!(before.len() == 16 && before[1].0 - before[0].0 == Vector::new(0.125, 0.0), "the grains do not just touch");
}

#[test]
fn energy_balance_of_thousands_of_grains_released_at_once_closes() {
    let run = through("all-at-once", &[("energy_balance_every", "1")]);
    let ledger = run.world().resource::<Ledger>();
    assert_eq!((ledger.released, ledger.inside()), (5000, 5000));
    let m = 2500.0 * 4.0 / 3.0 * PI * 3e-3f64.powi(3);
    assert_energy_error_of_the_scheme(&run, (2.0 * 1e4 / m).sqrt() * 2e-5);
}

#[test]
fn a_sphere_that_blocks_a_funnel_comes_to_rest_on_its_axis() {
    for start in ["funnel.csv", "funnel-beside.csv"] {
        for integrator in ["Verlet", "Centred"] {
            let file = format!("{start:?}");
            let mut run = through("funnel", &[("grains.file", &file), ("integrator", integrator)]);
            let (x, v, mass) = grains::<Solid>(&mut run)[0];
            // The slope of 45 degrees is sqrt(2) times as far above its apex, 5 mm below the hole, as its distance from the
            // centre: R less the overlap of the weight, m g sqrt(2)/k.
            let height = 2f64.sqrt() * (0.01 - mass * 9.81 * 2f64.sqrt() / 1e4) - 0.005;
            assert!(x.truncate().length() < 1e-6 && (x.z - height).abs() < 1e-6, "{start}, {integrator}: {x}");
            assert!(v.length() < 1e-2, "{start}, {integrator}: {v}");
            let (_, _, error) = balance(&run);
            assert!(error.abs() < 1e-3 * mass * 9.81 * 0.021, "{start}, {integrator}: {error:e} J");
        }
    }
}

/// Asserts that more than `least` grains have been released, and that all of them are inside.
fn assert_all_inside(run: &Simulation, least: u32, integrator: &str) {
    let ledger = run.world().resource::<Ledger>();
    assert!(ledger.inside() == ledger.released && ledger.released > least, "{integrator}: {ledger:?}");
}

#[test]
fn a_turning_bowl_holds_all_grains_and_does_the_work_that_the_balance_says() {
    for integrator in ["Verlet", "Centred"] {
        let mut run = through("bowl", &[("integrator", integrator)]);
        assert_all_inside(&run, 30, integrator);
        let grains = grains::<Solid>(&mut run);
        let lightest = grains.iter().map(|(_, _, mass)| *mass).fold(f64::INFINITY, f64::min);
        assert_energy_error_of_the_scheme(&run, (2.0 * 1e4 / lightest).sqrt() * 2e-5);
    }
}

#[test]
fn a_sphere_that_blocks_the_hole_of_a_bowl_comes_to_rest_on_its_axis() {
    for integrator in ["Verlet", "Centred"] {
        let mut run = through("bowl", &[("integrator", integrator), ("fill", "[]"), ("walls[0].spin", "0.0")]);
        let (x, v, mass) = grains::<Solid>(&mut run)[0];
        // The hole is a circle of radius 3.16 mm, 49.9 mm below the centre. The one contact carries the whole weight: its overlap is m g R/(k z), with z
        // the height of the sphere above the edge.
        let radius = 0.005f64;
        let below = 0.0499f64;
        let hole = (0.05f64.powi(2) - below.powi(2)).sqrt();
        let above = (radius * radius - hole * hole).sqrt();
        let overlap = mass * 9.81 * radius / (1e4 * above);
        let height = ((radius - overlap).powi(2) - hole * hole).sqrt() - below;
        assert!(x.truncate().length() < 1e-6 && (x.z - height).abs() < 1e-6, "{integrator}: {x}, not {height}");
        assert!(v.length() < 1e-2, "{integrator}: {v}");
    }
}

#[test]
fn grains_leave_through_holes_in_round_walls_and_none_is_lost() {
    for integrator in ["Verlet", "Centred"] {
        let shut = through("holes", &[("integrator", integrator), ("doors", "[]"), ("until", "0.5")]);
        assert_all_inside(&shut, 400, integrator);
        let mut run = simulation(&load("hard/holes.ron", &[("integrator", integrator)]), 1);
        run.run_steps(24_990);
        let side = run.world().resource::<Ledger>().out();
        assert!(side >= 10, "{integrator}: {side} have left through the side");
        run.run();
        assert_finite_and_accounted(&mut run);
        let ledger = run.world().resource::<Ledger>();
        assert!(ledger.out() >= side + 20 && ledger.lost() == 0, "{integrator}: {ledger:?}");
        // The lightest grain, and two contacts with it.
        assert_energy_error_of_the_scheme(
            &run,
            (2.0 * 1e4 / (4.0 / 3.0 * PI * 2500.0 * 4e-3f64.powi(3))).sqrt() * 2e-5,
        );
    }
}

#[test]
fn a_needle_falls_through_a_slot_and_another_stays_across_a_gap() {
    for integrator in ["Verlet", "Centred"] {
        let mut run = through("needle", &[("integrator", integrator)]);
        let ledger = run.world().resource::<Ledger>();
        // A grain that falls past all walls is lost, once; one that lies across a gap is not.
        assert_eq!((ledger.inside(), ledger.lost()), (1, 1), "{integrator}: {ledger:?}");
        assert_eq!(ledger.lost[0].grain, 1, "{integrator}");
        let [(through, ..), (across, v, _)] = planar(&mut run)[..] else { panic!("two needles") };
        // The first has fallen freely past the slot; the second lies on both edges, with its axis half a diameter above them.
        assert!(through.y < -0.1 && through.x.abs() < 5e-4, "{integrator}: {through}");
        assert!((across.y - 0.005).abs() < 1e-4 && v.length() < 1e-3, "{integrator}: {across} {v}");
        let (_, flows, error) = balance(&run);
        assert!(error.abs() < 1e-3 * flows.dissipated.max(1.0), "{integrator}: {error} of {flows:?}");
    }
}

#[test]
fn grains_pass_fixed_crosses_and_leave_when_the_gate_of_bars_moves() {
    for integrator in ["Verlet", "Centred"] {
        let (mut run, end) = {
            let mut run = simulation(&load("hard/fixed-shapes.ron", &[("integrator", integrator)]), 1);
            run.run_steps(15_999);
            let ledger = run.world().resource::<Ledger>();
            assert_eq!((ledger.released, ledger.inside()), (200, 200), "{integrator}: the gate is shut until 0.4 s");
            let end = run.run();
            (run, end)
        };
        assert_eq!(end, End::TimeReached, "{integrator}");
        assert_finite_and_accounted(&mut run);
        let ledger = run.world().resource::<Ledger>();
        // A grain may lie in the fork of a cross.
        assert!(ledger.lost() == 0 && ledger.out() >= 190, "{integrator}: {ledger:?}");
        // The end of a rod of 2.6 g has a quarter of its mass, with another such end it meets the springs of two grains.
        assert_energy_error_of_the_scheme(&run, (2.0 * 1e4 / (0.25 * 2.6e-3_f64)).sqrt() * 2.5e-5);
    }
}

#[test]
fn clumps_of_two_sizes_stay_in_a_corner() {
    for integrator in ["Verlet", "Centred"] {
        let mut run = through("clumps-in-corner", &[("integrator", integrator)]);
        assert_all_inside(&run, 65, integrator);
        let lowest = grains::<Solid>(&mut run).iter().map(|(x, ..)| x.min_element()).fold(f64::INFINITY, f64::min);
        assert!(lowest > 5e-4, "{integrator}: a grain is in a wall, {lowest} m from it");
        let (_, flows, error) = balance(&run);
        assert!(error.abs() < 1e-3 * flows.released.abs(), "{integrator}: {error} of {flows:?}");
        assert!(flows.dissipated > 0.1 * flows.released.abs(), "{integrator}: {flows:?}");
    }
}

#[test]
fn walls_that_cross_the_sides_of_a_periodic_box_hold_all_grains() {
    for integrator in ["Verlet", "Centred"] {
        let mut run = through("sides", &[("integrator", integrator)]);
        assert_all_inside(&run, 200, integrator);
        let grains = grains::<Solid>(&mut run);
        // Grains stand on the floor, on its images and on the overlap, and none sinks into a gap or is thrown out.
        let lowest = grains.iter().map(|(x, ..)| x.z).fold(f64::INFINITY, f64::min);
        assert!((0.0038..0.0061).contains(&lowest), "{integrator}: {lowest}");
        let walls = run.world().resource::<Surfaces<Solid>>();
        assert!(walls.loads.len() == 4 && walls.all.len() > 8, "{} surfaces", walls.all.len());
        // The lightest grain, and two contacts with it.
        assert_energy_error_of_the_scheme(
            &run,
            (2.0 * 1e4 / (4.0 / 3.0 * PI * 2500.0 * 4e-3f64.powi(3))).sqrt() * 2e-5,
        );
    }
}

#[test]
fn grains_leave_a_funnel_whose_plug_is_drawn_and_stay_in_a_box_that_rocks() {
    for integrator in ["Verlet", "Centred"] {
        let mut run = simulation(&load("hard/plug.ron", &[("integrator", integrator)]), 1);
        run.run_steps(34_950);
        let released = run.world().resource::<Ledger>().released;
        assert!(released > 200, "{released}");
        assert_eq!(
            run.world().resource::<Ledger>().inside(),
            released,
            "{integrator}: all are inside until the plug is drawn"
        );
        let flows = balance(&run).1;
        // Box and stirrer move at up to 1 m/s among grains of 0.25 kg.
        assert!(flows.wall_work > 1.0, "{integrator}: {flows:?}");
        let load = run.world().resource::<Surfaces<Plane>>().loads[4].force;
        assert!(load.y < -1.0, "{integrator}: the plug carries {load} N");
        run.run();
        assert_finite_and_accounted(&mut run);
        let ledger = run.world().resource::<Ledger>();
        assert!(ledger.out() > 100 && ledger.lost() == 0, "{integrator}: {ledger:?}");
        // The lightest grain, and two contacts with it.
        assert_energy_error_of_the_scheme(&run, (2.0 * 1e5 / (PI * 1.0e3 * 8e-3f64.powi(2))).sqrt() * 2e-5);
    }
}

#[test]
fn a_vessel_of_triangles_holds_all_grains_and_their_energy() {
    for integrator in ["Verlet", "Centred"] {
        let mut run = through("facets", &[("integrator", integrator)]);
        assert_all_inside(&run, 100, integrator);
        let grains = grains::<Solid>(&mut run);
        let below = grains.iter().filter(|(x, ..)| x.z < 0.066).count();
        assert!(below > 20 && below < grains.len() - 5, "{integrator}: {below} have passed the slot");
        assert_energy_error_of_the_scheme(&run, (2.0 * 1e4 / grains[0].2).sqrt() * 2e-5);
    }
}

#[test]
fn moving_walls_hold_all_grains_and_do_the_work_that_the_balance_says() {
    for integrator in ["Verlet", "Centred"] {
        let mut run = through("moving-walls", &[("integrator", integrator)]);
        assert_all_inside(&run, 60, integrator);
        let mass = planar(&mut run).iter().map(|(.., m)| *m).fold(f64::INFINITY, f64::min);
        assert_energy_error_of_the_scheme(&run, (2.0 * 1e5 / mass).sqrt() * 2e-5);
        let (_, flows, _) = balance(&run);
        // The paddle moves at up to 50/s 0.07 m = 3.5 m/s through 80 grains of 0.25 kg.
        assert!(flows.wall_work > 1.0, "{flows:?}");
    }
}

// The watchdog.

#[test]
fn grains_that_come_too_deep_are_named() {
    // At 30 m/s and more, k = 1e4 N/m stops two grains of 0.16 kg after v/w0 = 8 cm: twice their radius.
    let (_, end) = run("small-box", &[("fill[0].agitation", "(40.0, 40.0)")]);
    let End::Failed(failure @ Failure::TooDeep { step, ratio, .. }) = end else { panic!("{end:?}") };
    // The watchdog stops the run in the step that exceeds the limit. The overlap has grown by less than one step's
    // motion since.
    assert!(step > 0 && ratio > 1.0 && ratio < 1.0 + 2.0 * 2f64.sqrt() * 40.0 * 1e-4 / 0.04, "{failure}");
    let message = failure.to_string();
    assert!(message.contains(" and grain ") && message.contains("stiffen the contacts"), "{message}");
}

#[test]
fn watchdog_does_not_stop_valid_scenes() {
    // A hundredth of the default share, checked ten times as often.
    let strict = ("watchdog", "(every: 50, energy: 1.0e-3)");
    let scenes: [(&str, &[(&str, &str)]); 5] = [
        ("silo1.ron", &[("spawner.count", "100"), ("until", "8.0"), strict]),
        ("silo1-mixture.ron", &[("spawner.count", "100"), ("until", "8.0"), strict]),
        ("slip-to-roll.ron", &[("until", "0.05"), strict]),
        ("couette.ron", &[("until", "0.05"), strict]),
        ("hard/size-ratio.ron", &[strict]),
    ];
    for (name, settings) in scenes {
        let mut settings = settings.to_vec();
        settings.push(("pictures", "None"));
        assert_eq!(simulation(&load(name, &settings), 1).run(), End::TimeReached, "{name}");
    }
}

#[test]
fn watchdog_keeps_written_results_and_exits_with_1() {
    let here = tempfile::tempdir().unwrap();
    let path = crate::scene("hard/coincident.ron").display().to_string();
    let output = siloflow(here.path(), &["run", &path]);
    assert_eq!(output.status.code(), Some(1));
    let said = text(&output.stderr);
    assert!(
        said.contains("step 0: grain 1 and grain 2 overlap by 2.00") && said.contains("watchdog.overlap"),
        "{said}"
    );
    let run = here.path().join("out/coincident");
    for file in ["summary.json", "state.csv", "series.csv", "scene.ron"] {
        assert!(run.join(file).exists(), "{file}");
    }
    assert_eq!(fs::read_to_string(run.join("series.csv")).unwrap().lines().count(), 2, "the row of step 0");
    let output = siloflow(here.path(), &["run", &path, "--force", "--set", "watchdog=None"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let output = siloflow(here.path(), &["run", &path, "--set", "watchdog=(energy: 0.0)"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("greater than 0"), "{}", text(&output.stderr));
}

#[test]
fn every_hard_scene_has_a_test() {
    let tests = include_str!("hard.rs");
    for entry in fs::read_dir(root().join("scenes/hard")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        if path.extension().is_some_and(|ending| ending == "ron") && name != "undamped-drift" {
            assert!(tests.contains(&format!("\"{name}\"")) || tests.contains(&format!("hard/{name}.ron")), "{name}");
        }
    }
    // The scene that takes minutes must be valid and conserve energy for its first two seconds.
    let run = through("undamped-drift", &[("until", "2.0")]);
    let (totals, flows, error) = balance(&run);
    // (w0 dt)^2/4 of the elastic energy, and as much of the energy that the few bounces in that time have carried.
    let w0_dt = (1e4 / 0.08f64).sqrt() * 4e-4;
    assert!(error.abs() < w0_dt * w0_dt / 4.0 * (totals.elastic + flows.released), "{error}");
}

#[test]
fn a_chain_hangs_by_adhesion_below_its_pull_off_force_and_falls_above() {
    let mut run = through("hanging-chain", &[]);
    let lowest = planar(&mut run).iter().map(|grain| grain.0.y).fold(0.0, f64::min);
    // The contacts hold at a gap of up to 5 um each.
    assert!(lowest > -0.15 - 8.0 * 5.0e-6, "{lowest}");
    let (totals, _, error) = balance(&run);
    assert!(totals.elastic < 0.0 && error.abs() < 1e-4 * totals.elastic.abs(), "{error:e} J of {totals:?}");
    // At rest up to the swing that is left after forty periods.
    let load = run.world().resource::<Surfaces>().loads[0].force.y;
    assert!((load / (8.0 * 1.0e-3 * -0.67) - 1.0).abs() < 0.2, "{load} N");
    let mut run = through("hanging-chain", &[("gravity", "(0.0, -1.9)")]);
    let heights: Vec<_> = planar(&mut run).iter().map(|grain| grain.0.y).collect();
    // They fall from rest after the contact has opened, which takes some periods.
    assert!(heights[0] > -0.011 && heights[1..].iter().all(|&y| y < -0.1), "{heights:?}");
}

#[test]
fn a_lid_that_loses_its_bed_stops() {
    for (mass, name) in [("8.0", "heavy"), ("0.05", "light")] {
        let (run, end) = run("lid-loses-bed", &[("free_walls[0].mass", mass)]);
        assert_eq!(end, End::Empty, "{name}");
        let ledger = run.world().resource::<Ledger>();
        assert_eq!((ledger.out(), ledger.lost()), (ledger.released, 0), "{name}");
        let lid = *run.world().resource::<Surfaces<Plane>>().free().next().unwrap().1;
        assert_eq!((lid.coordinate, lid.rate, lid.hits), (-0.8, 0.0, 1), "{name}: {lid:?}");
        let (_, flows, error) = balance(&run);
        // (w0 dt)^2/6 of the dissipation, with w0^2 = 6 k/m of a small grain in a bed: 6 2e5/0.13 4e-10/6 = 6e-4.
        assert!(error.abs() < 1e-3 * flows.dissipated, "{name}: {error} of {flows:?}");
    }
}
