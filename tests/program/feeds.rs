//! Feeds and random fills: rates, distributions, places without overlap, and reports of what found no place.

use std::f64::consts::{PI, TAU};
use std::fs;
use std::num::NonZeroUsize;
use std::path::Path;
use std::process::Command;

use siloflow::dem::persist::unregistered;
use siloflow::dem::space::Solid;
use siloflow::energy::EnergyFlows;
use siloflow::grains::feed::{FeedFigure, FeedFigures};
use siloflow::measure::totals;
use siloflow::prelude::*;
use siloflow::scene::check;
use siloflow::text::fault::Fault;

use crate::command_line::text;
use crate::{hash, simulation};

fn loaded(text: &str) -> Result<Loaded, Fault> {
    load::from_text("a.ron", "a", Path::new(""), text.to_owned(), &[])
}

fn run_until_end(text: &str) -> (End, Simulation) {
    let mut run = simulation(&loaded(text).unwrap(), 1);
    (run.run(), run)
}

fn figure(run: &Simulation) -> FeedFigure {
    run.world().resource::<FeedFigures>().0[0]
}

/// Positions and radii of all grains, in the order of their ids.
fn grains<V: Space>(run: &mut Simulation) -> Vec<(V, f64)> {
    let world = run.world_mut();
    let mut query = world.query_filtered::<(&GrainId, &Position<V>, &Radius), With<Grain>>();
    let mut all: Vec<_> = query.iter(world).map(|(id, x, r)| (*id, (x.0, r.0))).collect();
    all.sort_by_key(|(id, _)| *id);
    all.into_iter().map(|(_, grain)| grain).collect()
}

/// The statistic of Pearson over `bins` equal bins for numbers that should be uniform in 0..1, less its mean and in units of its standard
/// deviation.
fn excess(numbers: &[f64], bins: usize) -> f64 {
    let mut counts = vec![0.0; bins];
    for u in numbers {
        counts[((u * bins as f64) as usize).min(bins - 1)] += 1.0;
    }
    let expected = numbers.len() as f64 / bins as f64;
    let square: f64 = counts.iter().map(|count| (count - expected).powi(2) / expected).sum();
    let degrees = bins as f64 - 1.0;
    (square - degrees) / (2.0 * degrees).sqrt()
}

/// Mean, and variance about zero, of numbers.
fn moments(numbers: &[f64]) -> (f64, f64) {
    let n = numbers.len() as f64;
    (numbers.iter().sum::<f64>() / n, numbers.iter().map(|x| x * x).sum::<f64>() / n)
}

/// Asserts that numbers are Gaussian with this mean and standard deviation, to five standard errors.
fn assert_gaussian(numbers: &[f64], mean: f64, deviation: f64) {
    let scaled: Vec<_> = numbers.iter().map(|x| (x - mean) / deviation).collect();
    let (first, second) = moments(&scaled);
    let (_, fourth) = moments(&scaled.iter().map(|x| x * x).collect::<Vec<_>>());
    let n = numbers.len() as f64;
    for (moment, expected, variance) in [(first, 0.0, 1.0), (second, 1.0, 2.0), (fourth, 3.0, 96.0)] {
        assert!((moment - expected).abs() < 5.0 * f64::sqrt(variance / n), "{moment} for {expected}");
    }
}

/// Points that do not touch each other, without gravity: places, velocities and spins stay as they were at the entry.
const GAS: &str = "(gravity: (0.0, 0.0, 0.0), space: Solid, mass: Sphere(1000.0), integrator: Verlet, step: Fixed(1.0e-4), until: 0.02, neighbours: VerletList(skin: 0.01),
    contact: Linear(k: 1.0e-5, damping: Restitution(0.5), tangential: Spring(k: 3.0e-6, damping: OfNormal(0.5), friction: 0.5)), pictures: None,
    feed: [(region: REGION, rate: Grains(4.0e5), total: Grains(4000), radius: Fixed(1.0e-5), velocity: (0.1, 0.0, -0.2),
        agitation: (0.002, 0.001, 0.0), spin: 3.0)])";

#[test]
fn places_are_uniform_in_each_region() {
    let u = |region: &str, to_unit: fn(Solid) -> [f64; 3]| {
        let (_, mut run) = run_until_end(
            &GAS.replace("REGION", region).replace("velocity: (0.1, 0.0, -0.2)", "velocity: (0.0, 0.0, 0.0)"),
        );
        let all: Vec<_> = grains::<Solid>(&mut run).into_iter().map(|(x, _)| to_unit(x)).collect();
        assert_eq!(all.len(), 4000);
        for axis in 0..3 {
            let along: Vec<_> = all.iter().map(|u| u[axis]).collect();
            assert!(excess(&along, 50) < 5.0, "{region}: axis {axis}");
            // Pairs of coordinates: squares of a grid.
            let grid: Vec<_> = all.iter().map(|u| ((u[axis] * 8.0).floor() + u[(axis + 1) % 3]) / 8.0).collect();
            assert!(excess(&grid, 64) < 5.0, "{region}: axes from {axis} on");
        }
    };
    u("Box(low: (-1.0, 2.0, 0.0), high: (1.0, 5.0, 0.5))", |x| [0.5 * (x.x + 1.0), (x.y - 2.0) / 3.0, x.z / 0.5]);
    u("Disc(centre: (1.0, -1.0, 0.5), radius: 2.0, height: 0.25)", |place| {
        let x = place.x - 1.0;
        let y = place.y + 1.0;
        [(x * x + y * y) / 4.0, (y.atan2(x) / TAU).rem_euclid(1.0), (place.z - 0.5) / 0.25]
    });
}

#[test]
fn the_places_drawn_in_a_step_bound_the_grains_that_enter() {
    let scene = GAS
        .replace("REGION", "Box(low: (0.0, 0.0, 0.0), high: (1.0, 1.0, 1.0))")
        .replace("rate: Grains(4.0e5), total: Grains(4000)", "rate: Mass(1.0e300), total: Grains(250)");
    let scene = loaded(&scene).unwrap();
    let codes: Vec<_> = check::warnings(&scene).into_iter().map(|warning| warning.code).collect();
    assert!(codes.contains(&"check::feed_too_fast"), "{codes:?}");
    let mut run = simulation(&scene, 1);
    for (steps, entered) in [(1, 200), (2, 250), (3, 250)] {
        // Step zero comes before step 1.
        assert_eq!(run.run_steps(steps), None);
        assert_eq!(figure(&run).grains, entered);
    }
}

#[test]
fn velocities_and_spins_are_gaussian_and_their_energy_is_counted() {
    let (_, mut run) = run_until_end(&GAS.replace("REGION", "Box(low: (0.0, 0.0, 0.0), high: (1.0, 1.0, 0.0))"));
    let world = run.world_mut();
    let mut query = world.query::<(&Velocity<Solid>, &Spin<Solid>, &Mass, &Inertia)>();
    let all: Vec<_> = query.iter(world).map(|(v, w, m, i)| (v.0, w.0, m.0, i.0)).collect();
    let of = |f: &dyn Fn(&(Solid, Solid, f64, f64)) -> f64| all.iter().map(f).collect::<Vec<_>>();
    assert_gaussian(&of(&|g| g.0.x), 0.1, 0.002);
    assert_gaussian(&of(&|g| g.0.y), 0.0, 0.001);
    assert!(all.iter().all(|g| g.0.z == -0.2));
    for axis in 0..3 {
        assert_gaussian(&of(&|g| g.1[axis]), 0.0, 3.0);
    }
    // Velocity and spin of a grain are independent.
    let (product, _) = moments(&of(&|g| (g.0.x - 0.1) / 0.002 * g.1.z / 3.0));
    assert!(product.abs() < 5.0 / 4000f64.sqrt(), "{product}");
    let energy: f64 = of(&|g| 0.5 * g.2 * g.0.length_squared() + 0.5 * g.3 * g.1.length_squared()).iter().sum();
    let flows = *world.resource::<EnergyFlows>();
    assert!((flows.released / energy - 1.0).abs() < 1e-12, "{} {energy}", flows.released);
}

/// Grains that fall from a flat region onto a floor between two walls.
fn rain(feed: &str, more: &str) -> String {
    format!(
        "(gravity: (0.0, -9.81), contact: Linear(k: 2.0e4, damping: Restitution(0.5)), mass: Disc(20.0), integrator: Verlet,
        step: Fixed(1.0e-4), pictures: None, series: (interval: 0.5),
        walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0)), HalfPlane(point: (-0.5, 0.0), normal: (1.0, 0.0)),
            HalfPlane(point: (0.5, 0.0), normal: (-1.0, 0.0))],
        feed: [(region: Box(low: (-0.45, 1.0), high: (0.45, 1.0)), velocity: (0.0, -1.0), {feed})], {more})"
    )
}

#[test]
fn the_rate_is_that_of_the_scene_in_grains_and_in_mass() {
    let (_, run) = run_until_end(&rain("rate: Grains(150.0), radius: Fixed(0.01)", "until: 0.5"));
    let result = figure(&run);
    // One at t = 0, and 74 up to the beginning of the last step, t = 0.4999 s.
    assert_eq!((result.grains, result.shortfall, result.waited), (75, 0.0, 0));
    assert!((result.mass_kg / (75.0 * 20.0 * PI * 1e-4) - 1.0).abs() < 1e-12);
    let mixture = "radius: Mixture([(0.012, 0.25), (0.008, 0.75)])";
    let (_, run) = run_until_end(&rain(&format!("rate: Mass(0.8), {mixture}, from: 0.1"), "until: 0.6"));
    let result = figure(&run);
    // The mass that enters is at most one grain ahead of 0.8 kg/s for half a second.
    let ahead = result.mass_kg - 0.4;
    assert!((0.0..=20.0 * PI * 0.012f64.powi(2)).contains(&ahead) && result.shortfall == 0.0, "{result:?}");
}

#[test]
fn a_total_ends_the_feed_and_keeps_the_shares_of_a_mixture() {
    let feed = |total: &str| {
        let mixture = "radius: Mixture([(0.012, 0.25), (0.008, 0.75)]), species: 1";
        run_until_end(&rain(&format!("rate: Grains(400.0), total: {total}, {mixture}"), "until: 0.2")).1
    };
    let mut run = feed("Grains(40)");
    let radii: Vec<_> = grains::<Plane>(&mut run).into_iter().map(|(_, radius)| radius).collect();
    assert_eq!((radii.len(), radii.iter().filter(|radius| **radius == 0.012).count()), (40, 10));
    let world = run.world_mut();
    let species: Vec<_> =
        world.query_filtered::<&Species, With<Grain>>().iter(world).map(|species| species.0).collect();
    assert!(species.contains(&1) && species.contains(&2) && !species.contains(&0));
    // 0.25 (0.012 m)^2 + 0.75 (0.008 m)^2 = 8.4e-5 m^2: a mean mass of 5.278 g.
    assert_eq!(figure(&feed("Mass(0.1)")).grains, 19);
}

/// A closed region without gravity, periodic along x, that is fed faster than it has room.
fn crowd(more: &str) -> String {
    format!(
        "(gravity: (0.0, 0.0), contact: Linear(k: 2.0e3, damping: Restitution(0.5)), mass: Disc(20.0), integrator: Verlet,
        step: Fixed(1.0e-4), periodic: (x: (-0.5, 0.5)), until: 1.0, pictures: None,
        walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0)), Disc(centre: (0.1, 0.3), radius: 0.1)],
        feed: [(region: Box(low: (-0.5, 0.0), high: (0.5, 0.6)), rate: Grains(4.0e3), radius: Uniform(0.01, 0.02),
            velocity: (0.0, 0.0), {more}),
            (region: Box(low: (0.0, 0.5), high: (0.6, 0.8)), rate: Grains(2.0e3), radius: Fixed(0.01), velocity: (0.0, 0.0), timeout: 9.0)])"
    )
}

/// The smallest gap between grains, in a box that is periodic along x with length 1 m.
fn smallest_gap(all: &[(Vector, f64)]) -> f64 {
    let gap = |&(a, r): &(Vector, f64), &(b, s): &(Vector, f64)| {
        let across = a.x - b.x - (a.x - b.x).round();
        f64::hypot(across, a.y - b.y) - r - s
    };
    let pairs = all.iter().enumerate().flat_map(|(n, a)| all[..n].iter().map(move |b| gap(a, b)));
    pairs.fold(f64::INFINITY, f64::min)
}

#[test]
fn no_grain_enters_with_an_overlap_and_a_full_region_is_reported() {
    let (end, mut run) = run_until_end(&crowd("timeout: 0.05"));
    let End::Failed(failure @ Failure::FeedBlocked { feed: 0, waited_s, .. }) = end else { panic!("{end:?}") };
    assert!(waited_s > 0.05 && waited_s < 0.0502, "{waited_s}");
    assert!(failure.to_string().contains("`feed[0]` found no free place"), "{failure}");
    let all = grains::<Plane>(&mut run);
    assert!(smallest_gap(&all) >= 0.0, "{}", smallest_gap(&all));
    let wall_gap = |&(x, r): &(Vector, f64)| x.y.min(x.distance(Vector::new(0.1, 0.3)) - 0.1) - r;
    assert!(all.iter().map(wall_gap).fold(f64::INFINITY, f64::min) >= 0.0);
    // Nothing touches, so nothing has moved, and there is no energy.
    let flows = *run.world().resource::<EnergyFlows>();
    assert_eq!((totals::of_world(run.world()).energy(), flows.released, flows.dissipated), (0.0, 0.0, 0.0));
    // At random about half of an area is filled, and the rest of the grains due is missing.
    let area: f64 = all.iter().map(|(_, r)| PI * r * r).sum();
    assert!((0.3..0.6).contains(&(area / (0.8 - PI * 0.01))), "{area}");
    let result = figure(&run);
    // Grains enter at the beginning of a step.
    let due = 4.0e3 * (run.world().resource::<Clock>().time() - 1.0e-4);
    assert!(
        (result.shortfall - (due - f64::from(result.grains)) / due).abs() < 1e-9 && result.shortfall > 0.1,
        "{result:?}"
    );
    assert!(result.waited > 0, "{result:?}");
}

#[test]
fn a_late_feed_catches_up_and_the_energy_balance_closes() {
    // The grains of one step of the rate do not fit into the line at once; those before must fall out of it first.
    let feed = "rate: Grains(3.0e3), total: Grains(120), radius: Uniform(0.01, 0.015), agitation: (0.1, 0.1)";
    let scene = rain(feed, "until: 1.0");
    let (_, mut run) = run_until_end(&scene);
    let result = figure(&run);
    assert!(result.grains == 120 && result.waited > 10 && result.shortfall == 0.0, "{result:?}");
    assert!(result.longest_wait_s > 0.0 && result.longest_wait_s < 0.2, "{result:?}");
    let flows = *run.world().resource::<EnergyFlows>();
    let error = totals::of_world(run.world_mut()).energy() - flows.expected();
    // The bound of the scheme, as in `scenes.rs`: the share (w0 dt)^2/6 of what is dissipated, for the lightest pair.
    let estimates = check::Estimates::of(&loaded(&scene).unwrap()).unwrap();
    let w0 = (estimates.stiffness / (0.5 * estimates.mass)).sqrt();
    let bound = (w0 * estimates.dt).powi(2) / 6.0 * flows.dissipated;
    assert!(error.abs() < bound, "{error} J, bound {bound} J, of {flows:?}");
}

#[test]
fn the_run_does_not_depend_on_threads_nor_on_an_interruption() {
    let feed = "rate: Grains(3.0e3), total: Grains(120), radius: Uniform(0.01, 0.015), agitation: (0.1, 0.1)";
    let loaded = loaded(&rain(feed, "until: 0.3")).unwrap();
    let [one, three] = [1, 3].map(|threads| {
        let mut run = simulation(&loaded, threads);
        run.run();
        (hash(&mut run), figure(&run))
    });
    assert_eq!(one, three);
    // While a grain waits.
    let mut first = simulation(&loaded, 1);
    first.run_steps(200);
    assert!(figure(&first).shortfall > 0.1);
    let unsaved = unregistered(first.world_mut());
    assert!(unsaved.is_empty(), "{unsaved:?}");
    let saved = first.save().unwrap();
    let mut second = Simulation::restored(&loaded, &Registry::default(), NonZeroUsize::MIN, &saved).unwrap();
    second.run();
    assert_eq!((hash(&mut second), figure(&second)), one);
}

#[test]
fn keys_that_do_not_fit_are_refused() {
    let good = "rate: Grains(10.0), radius: Fixed(0.01)";
    let spawner =
        "spawner: (point: (0.0, 0.8), velocity: (0.0, 0.0), interval: 1.0, count: 1, radius: Fixed(0.01)), until: 1.0";
    let rest = "rest: (speed: 2.0e-3, energy: 1.0e-6, hold: 0.1), until: 1.0";
    for (feed, more, code, key) in [
        (good.to_owned(), spawner, "scene::two_sources", "feed[0]"),
        (good.to_owned(), rest, "scene::endless_feed", "feed[0].total"),
        (format!("{good}, total: Grains(0)"), "until: 1.0", "scene::out_of_range", "feed[0].total"),
        (format!("{good}, total: Mass(1.0e9)"), "until: 1.0", "scene::out_of_range", "feed[0].total"),
        (format!("{good}, tries: 10001"), "until: 1.0", "scene::out_of_range", "feed[0].tries"),
        (format!("{good}, spin: 1.0"), "until: 1.0", "scene::no_spin", "feed[0].spin"),
        (format!("{good}, agitation: (0.1, 0.1, 0.1)"), "until: 1.0", "scene::dimension", "feed[0].agitation"),
        ("rate: Grains(0.0), radius: Fixed(0.01)".to_owned(), "until: 1.0", "scene::out_of_range", "feed[0].rate.0"),
        ("rate: Grains(1.0), radius: Mixture([])".to_owned(), "until: 1.0", "scene::out_of_range", "feed[0].radius"),
    ] {
        let fault = loaded(&rain(&feed, more)).unwrap_err();
        assert_eq!((fault.code(), fault.scene_key()), (code, Some(key)), "{fault}");
    }
    for (from, to, code, key) in [
        ("mass: Disc(20.0), ", "", "scene::missing_key", "mass"),
        ("low: (-0.45", "low: (0.46", "scene::empty_box", "feed[0].region"),
        (
            "Box(low: (-0.45, 1.0), high: (0.45, 1.0))",
            "Disc(centre: (0.0, 1.0), radius: 0.1)",
            "scene::dimension",
            "feed[0].region",
        ),
    ] {
        let fault = loaded(&rain(good, "until: 1.0").replace(from, to)).unwrap_err();
        assert_eq!((fault.code(), fault.scene_key()), (code, Some(key)), "{fault}");
    }
}

#[test]
fn a_run_reports_its_feeds() {
    let here = tempfile::tempdir().unwrap();
    let feed = "rate: Grains(3.0e3), radius: Uniform(0.01, 0.015), timeout: 0.004";
    fs::write(here.path().join("a.ron"), rain(feed, "until: 1.0")).unwrap();
    let output =
        Command::new(env!("CARGO_BIN_EXE_siloflow")).args(["run", "a.ron"]).current_dir(here.path()).output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("found no free place for grain"), "{}", text(&output.stderr));
    let summary: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(here.path().join("out/a/summary.json")).unwrap()).unwrap();
    let feed = &summary["feed"][0];
    assert!(feed["grains"].as_u64().unwrap() > 20 && feed["shortfall"].as_f64().unwrap() > 0.1, "{feed}");
    assert!(text(&output.stdout).contains("% short of the rate"), "{}", text(&output.stdout));
    // Scenes without feeds have no such system, resource or key.
    let plain =
        Command::new(env!("CARGO_BIN_EXE_siloflow")).arg("explain").arg(crate::scene("silo1.ron")).output().unwrap();
    assert!(plain.status.success() && !text(&plain.stdout).contains("feed"), "{}", text(&plain.stdout));
}

/// A scene with a random fill beside other grains and walls.
fn random_fill(count: u32) -> String {
    format!(
        "(gravity: (0.0, -9.81), contact: Linear(k: 2.0e4, damping: Restitution(0.5)), mass: Disc(20.0), integrator: Verlet,
        step: Fixed(1.0e-4), until: 1.0, periodic: (x: (-0.5, 0.5)),
        walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0)), Disc(centre: (0.1, 0.3), radius: 0.1)],
        fill: [
            (low: (-0.5, 0.5), high: (0.5, 0.6), spacing: 0.05, radius: Fixed(0.02)),
            (low: (-0.6, 0.0), high: (0.4, 1.0), place: Random, count: {count}, radius: Uniform(0.005, 0.02), agitation: (0.1, 0.0)),
        ])"
    )
}

#[test]
fn a_random_fill_has_no_overlaps_and_follows_the_seed() {
    let scene = loaded(&random_fill(300)).unwrap();
    let all: Vec<_> = scene.grains.iter().map(|grain| (grain.position.truncate(), grain.radius)).collect();
    assert_eq!(all.len(), 40 + 300);
    assert!(smallest_gap(&all) >= 0.0, "{}", smallest_gap(&all));
    for &(x, r) in &all[40..] {
        assert!(x.x - r >= -0.6 && x.x + r <= 0.4 && x.y - r >= 0.0 && x.y + r <= 1.0, "{x}");
        assert!(x.y >= r && x.distance(Vector::new(0.1, 0.3)) >= 0.1 + r, "{x}");
    }
    assert!(scene.grains[40..].iter().all(|grain| grain.velocity.x.abs() <= 0.1 && grain.velocity.y == 0.0));
    let again = |seed: &str| loaded(&random_fill(300).replacen('(', &format!("(seed: {seed}, "), 1)).unwrap().grains;
    assert_eq!(again("0"), scene.grains);
    assert_ne!(again("1"), scene.grains);
}

/// Places beyond a periodic side are those that they enter at, also for walls.
#[test]
fn a_random_fill_across_a_periodic_side_leaves_walls_free() {
    let wall = "Segment(from: (0.42, 0.3), to: (0.42, 0.9))";
    let scene = random_fill(200).replace("Disc(centre: (0.1, 0.3), radius: 0.1)", wall);
    let grains = loaded(&scene).unwrap().grains;
    let gap = |x: Solid, radius: f64| (x.x - (x.x - 0.42).round() - 0.42).hypot(x.y - x.y.clamp(0.3, 0.9)) - radius;
    let least = grains[40..].iter().map(|grain| gap(grain.position, grain.radius)).fold(f64::INFINITY, f64::min);
    assert!(grains.len() == 240 && least >= 0.0, "{least}");
}

/// Radii 1:20, side by side and one after the other: neither a feed nor a random fill places overlapping grains.
#[test]
fn grains_of_very_different_sizes_do_not_overlap_when_they_enter() {
    let scene = |more: &str| {
        format!(
        "(gravity: (0.0, 0.0), contact: Linear(k: 2.0e3, damping: Restitution(0.5)), mass: Disc(20.0), integrator: Verlet,
        step: Fixed(1.0e-4), periodic: (x: (-0.5, 0.5)), until: 0.1, pictures: None, {more})"
    )
    };
    let feed = |total: u32, radius: &str| {
        format!(
            "(region: Box(low: (-0.5, 0.0), high: (0.5, 1.0)), rate: Grains(1.0e4), total: Grains({total}), velocity: (0.0, 0.0),
            radius: {radius})"
        )
    };
    let fill = |count: u32, radius: &str| {
        format!("(low: (-0.5, 0.0), high: (0.5, 1.0), place: Random, count: {count}, radius: {radius})")
    };
    let [large, middle] = [fill(3, "Fixed(0.1)"), fill(3, "Fixed(0.06)")];
    for more in [
        format!("feed: [{}, {}]", feed(4, "Fixed(0.1)"), feed(350, "Uniform(0.005, 0.01)")),
        format!("fill: [{large}, {middle}, {}]", fill(310, "Uniform(0.005, 0.02)")),
        format!("fill: [{large}], feed: [{}]", feed(350, "Fixed(0.005)")),
    ] {
        let mut run = simulation(&loaded(&scene(&more)).unwrap(), 1);
        run.run();
        let all = grains::<Plane>(&mut run);
        let large = all.iter().filter(|(_, radius)| *radius == 0.1).count();
        assert!(all.len() > 300 && large > 2, "{more}: {} grains, {large} large", all.len());
        assert!(smallest_gap(&all) >= 0.0, "{more}: {}", smallest_gap(&all));
    }
}

#[test]
fn random_fills_are_uniform() {
    let scene = "(gravity: (0.0, 0.0, 0.0), space: Solid, contact: Linear(k: 2.0e4, damping: Restitution(0.5)), mass: Sphere(2000.0),
        step: Fixed(1.0e-6), until: 1.0, fill: [(low: (1.0, 0.0, -1.0), high: (2.0, 3.0, 0.0), place: Random, count: 4000, radius: Fixed(1.0e-3))])";
    let scene = loaded(scene).unwrap();
    for (axis, low, size) in [(0, 1.0, 1.0), (1, 0.0, 3.0), (2, -1.0, 1.0)] {
        let along: Vec<_> = scene.grains.iter().map(|g| (g.position[axis] - low - 1e-3) / (size - 2e-3)).collect();
        assert!(excess(&along, 50) < 5.0 && along.iter().all(|u| (0.0..=1.0).contains(u)));
    }
}

#[test]
fn a_random_fill_that_does_not_fit_states_the_number_that_it_reached() {
    // Equal discs in an empty box reach about 0.547 of the area; fewer stand at its sides.
    let scene = random_fill(5000)
        .replace("(low: (-0.5, 0.5), high: (0.5, 0.6), spacing: 0.05, radius: Fixed(0.02)),", "")
        .replace("Uniform(0.005, 0.02)", "Fixed(0.01)")
        .replace(", Disc(centre: (0.1, 0.3), radius: 0.1)", "")
        .replace("point: (0.0, 0.0)", "point: (0.0, -1.0)");
    let fault = loaded(&scene).unwrap_err();
    assert_eq!((fault.code(), fault.scene_key()), ("scene::no_room", Some("fill[0].count")));
    let reached: f64 = fault.to_string().split(" and ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    let share = reached * PI * 1e-4 / 0.98f64.powi(2);
    assert!((0.52..0.56).contains(&share), "{share}: {fault}");
    for (from, to, code, key) in [
        ("spacing: 0.05, ", "", "scene::missing_key", "fill[0].spacing"),
        ("count: 300, ", "", "scene::missing_key", "fill[1].count"),
        ("count: 300, ", "count: 300, spacing: 0.1, ", "scene::no_lattice", "fill[1].spacing"),
        ("count: 300, ", "count: 300, jitter: 0.1, ", "scene::no_lattice", "fill[1].jitter"),
        ("count: 300, ", "count: 300, fixed: true, ", "scene::no_lattice", "fill[1].fixed"),
    ] {
        let fault = loaded(&random_fill(300).replace(from, to)).unwrap_err();
        assert_eq!((fault.code(), fault.scene_key()), (code, Some(key)), "{fault}");
    }
}
