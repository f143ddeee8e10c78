//! A property: every small scene that is accepted does its steps without a panic, and every number stays finite, unless `check`
//! warns of an unstable step. The scenes are built from choices of sensible and of odd values; most of them are accepted.

use std::num::NonZeroUsize;
use std::path::Path;

use bolero::{TypeGenerator, check};
use siloflow::dem::particle::Grain;
use siloflow::measure::totals;
use siloflow::prelude::*;

/// One choice for each key.
#[derive(Clone, Debug, TypeGenerator)]
struct Choices([u8; 16]);

impl Choices {
    fn of<'a>(&self, key: usize, values: &[&'a str]) -> &'a str {
        values[usize::from(self.0[key]) % values.len()]
    }

    /// One of the values of the scene's space.
    fn pick(&self, key: usize, plane: &[&'static str], solid: &[&'static str]) -> &'static str {
        self.of(key, if self.0[0].is_multiple_of(2) { solid } else { plane })
    }

    /// The keys `fill`, `spawner` and `walls`.
    fn bodies(&self) -> String {
        let keys = [
            self.pick(
                6,
                &[
                    "fill: []",
                    "fill: [(low: (-0.5, 0.0), high: (0.5, 1.0), spacing: 0.1, RADIUS, count: 60, VELOCITY)]",
                    "fill: [(low: (0.0, 0.0), high: (0.3, 0.3), spacing: 0.01, RADIUS, count: 50, VELOCITY)]",
                ],
                &[
                    "fill: []",
                    "fill: [(low: (-0.2, -0.2, 0.0), high: (0.2, 0.2, 0.4), spacing: 0.1, RADIUS, VELOCITY)]",
                    "fill: [(low: (0.0, 0.0, 0.0), high: (0.1, 0.1, 0.1), spacing: 0.02, RADIUS, count: 50, VELOCITY)]",
                ],
            )
            .replace("RADIUS", &format!("radius: {}", self.of(7, RADII)))
            .replace(
                "VELOCITY",
                self.pick(
                    8,
                    &["jitter: 0.0", "jitter: 0.02", "velocity: (100.0, 0.0)", "agitation: (5.0, 5.0)", "fixed: true"],
                    &[
                        "jitter: 0.0",
                        "jitter: 0.02",
                        "velocity: (0.0, 0.0, -1.0e3)",
                        "agitation: (5.0, 5.0, 5.0)",
                        "fixed: true",
                    ],
                ),
            ),
            self.pick(
                9,
                &[
                    "spawner: None",
                    "spawner: (point: (0.0, 2.0), velocity: (0.0, -1.0), interval: 1.0e-5, count: 20, RADIUS)",
                ],
                &[
                    "spawner: None",
                    "spawner: (point: (0.0, 0.0, 2.0), velocity: (0.0, 0.0, 0.0), interval: 0.1, count: 2, RADIUS)",
                ],
            )
            .replace("RADIUS", &format!("radius: {}", self.of(7, RADII))),
            format!(
                "walls: [{}]",
                self.pick(
                    10,
                    &[
                        "",
                        "HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0), velocity: (1.0, 0.0))",
                        "Segment(from: (-1.0, 0.05), to: (1.0, 0.05), species: 3)",
                        "Disc(centre: (0.0, 0.5), radius: 0.3)"
                    ],
                    &[
                        "",
                        "HalfSpace(point: (0.0, 0.0, 0.0), normal: (0.0, 0.1, 1.0))",
                        "Panel(corner: (-1.0, -1.0, 0.1), along: (2.0, 0.0, 0.0), across: (0.0, 2.0, 0.0), door: true)",
                        "Segment(from: (0.0, 0.0, 0.0), to: (0.0, 0.0, 1.0))"
                    ],
                )
            ),
        ];
        keys.join(",\n")
    }

    /// The text of the scene.
    fn text(&self) -> String {
        let contact = self.of(
            1,
            &[
                "Assignment(k: 1.0e4, b: 5.0)",
                "Linear(k: 1.0e5, damping: Restitution(0.5))",
                "Linear(k: 1.0e5, damping: B(0.0), tangential: Spring(k: 5.0e4, damping: B(1.0), friction: 0.5), rolling: (k: 10.0, damping: B(0.0), friction: 0.1))",
                "Linear(k: 1.0e-3, damping: PerMass(1.0e3), tangential: Dashpot(damping: B(1.0), friction: 2.0))",
                "Hertz(restitution: 0.3, tangential: Mindlin(friction: 0.4)), materials: [(young: 1.0e7, poisson: 0.3)]",
                "Hertz(restitution: 1.0), materials: [(young: 1.0e12, poisson: -0.9)]",
            ],
        );
        let keys = [
            self.pick(0, &["space: Plane"], &["space: Solid"]).to_owned(),
            format!("contact: {contact}"),
            format!(
                "gravity: {}",
                self.pick(
                    2,
                    &["(0.0, -9.81)", "(0.0, 0.0)", "(1.0e3, 2.0)"],
                    &["(0.0, 0.0, -9.81)", "(0.0, 0.0, 0.0)", "(5.0, 0.0, 1.0e-9)"]
                )
            ),
            format!("mass: {}", self.of(3, &["Sphere(2500.0)", "Disc(1.0)", "ArealSquare(1.0e6)", "Sphere(1.0e-6)"])),
            format!("integrator: {}", self.of(4, &["Centred", "Verlet", "SymplecticEuler", "ExplicitEuler"])),
            format!("step: {}", self.of(5, &["Auto(error: 1.0e-3)", "Fixed(1.0e-5)", "Fixed(1.0e-3)", "Fixed(1.0)"])),
            self.bodies(),
            format!("periodic: ({})", self.of(11, &["", "", "x: (-0.5, 0.5)", "x: (-0.5, 0.5), y: (0.0, 1.0)"])),
            format!(
                "neighbours: {}",
                self.of(
                    12,
                    &["None", "AllPairs", "Cells(size: 1.0)", "VerletList(skin: 0.001)", "CellsOfRange(rng: 2.5)"]
                )
            ),
            format!("energy_balance: {}", self.of(13, &["true", "false"])),
            self.of(
                14,
                &[
                    "rest: None",
                    "rest: (speed: 2.0e-3, energy: 1.0e-6, hold: 1.0e-4, stop: true)",
                    "cull: (below: 0.2)",
                    "on_loss: Continue",
                ],
            )
            .to_owned(),
            format!("until: {}", self.of(15, &["1.0e-3", "1.0e9", "10.0"])),
            "watchdog: None, pictures: None".to_owned(),
        ];
        format!("({})", keys.join(",\n"))
    }
}

const RADII: &[&str] = &["Fixed(0.04)", "Uniform(0.001, 0.04)", "Mixture([(0.04, 0.5), (0.01, 0.5)])", "Fixed(1.0e-6)"];

/// Most steps of a scene.
const STEPS: u64 = 20;

/// Warnings of a step that is too large.
const UNSTABLE: [&str; 4] =
    ["check::unstable_step", "check::unstable_bed", "check::unstable_start", "check::fast_grains"];

#[test]
fn every_accepted_small_scene_steps_with_finite_numbers() {
    let shown = std::cell::Cell::new([0u32; 2]);
    let counts = std::panic::AssertUnwindSafe(&shown);
    check!().with_type::<Choices>().with_shrink_time(std::time::Duration::ZERO).for_each(|choices| {
        let text = choices.text();
        let [seen, accepted] = counts.get();
        let loaded = load::from_text("small.ron", "small", Path::new(""), text.clone(), &[]);
        counts.set([seen + 1, accepted + u32::from(loaded.is_ok())]);
        let Ok(loaded) = loaded else { return };
        // An unstable step may let speeds grow beyond all numbers. The user is warned of it, and the run stops.
        let is_warned =
            siloflow::scene::check::warnings(&loaded).iter().any(|warning| UNSTABLE.contains(&warning.code));
        let mut run =
            Simulation::new(&loaded, &Registry::default(), NonZeroUsize::MIN).expect("an accepted scene can be built");
        let end = run.run_steps(STEPS);
        if is_warned {
            return;
        }
        assert!(!matches!(end, Some(End::Failed(Failure::NotFinite { .. }))), "{end:?} of\n{text}");
        let totals = totals::of_world(run.world());
        assert!(totals.energy().is_finite() && totals.largest_speed.is_finite(), "{totals:?} of\n{text}");
        let world = run.world_mut();
        let planar = world.query_filtered::<&Position<Plane>, With<Grain>>().iter(world).all(|x| x.0.is_finite());
        let solid = world.query_filtered::<&Position<Solid>, With<Grain>>().iter(world).all(|x| x.0.is_finite());
        assert!(planar && solid, "{text}");
    });
    let [seen, accepted] = shown.get();
    assert!(10 * accepted > seen, "only {accepted} of {seen} scenes were accepted: the property is hardly tested");
}
