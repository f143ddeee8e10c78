//! The scene of an estimate: its rungs, and the keys of a sweep that make them.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::cli::SceneArgs;
use crate::scene::check::{self, Estimates};
use crate::scene::loaded::{AnyScene, Loaded};
use crate::studies::estimate::growth::Growth;
use crate::studies::estimate::softening::Softening;
use crate::studies::estimate::softness::{DEEPEST_AT_REST, DEEPEST_IMPACT, powers, softnesses};
use crate::studies::figures::figure::Figure;
use crate::studies::sweep::Sweep;
use crate::studies::sweep::design::Point;
use siloflow_dem::values::Share;
use siloflow_figures::statistics::extrapolation::{Ladder, Powers};
use siloflow_text::fault::Fault;

/// The scene key that makes up for overlaps.
const GROWTH: &str = "growth";

/// The scene of an estimate.
pub(super) struct Subject {
    pub name: String,
    pub ladder: Ladder,
    /// Why the contacts are not made softer.
    pub not_softened: Option<String>,
    pub keys: Vec<String>,
    /// The points of all runs: the rungs, the rungs with half of their step, and with growth the softest rung without it.
    pub points: Vec<Point>,
    /// Whether softer grains have larger radii.
    pub grows: bool,
    /// Their growth, once it is known.
    pub growth: Option<Growth>,
    /// The growth that the scene itself asks for.
    own_growth: f64,
    /// The power of the softness with which overlaps grow.
    power: f64,
    pub is_lattice: bool,
    pub seed: u64,
}

impl Subject {
    /// Finds the rungs of a scene. Each of them is loaded once.
    ///
    /// With `grows`, radii of softer grains are to make up for their overlaps.
    pub(super) fn of(args: &SceneArgs, scene: &AnyScene, figure: &Figure, grows: bool) -> Self {
        let source = scene.source();
        let mut common = args.set.clone();
        // Pictures and frames change no figure.
        common.push(("pictures".to_owned(), "None".to_owned()));
        let (seed, powers, softening, own_growth) = match scene {
            AnyScene::Grains(loaded) => {
                common.push(("data_frames".to_owned(), "None".to_owned()));
                let growth = loaded.scene.growth.map_or(0.0, Share::get);
                (loaded.scene.seed, powers(&loaded.scene.contact), Softening::of(source), growth)
            }
            AnyScene::Lattice(loaded) => {
                let powers = Powers { low: 1.0, usual: 1.0, high: 1.0 };
                (loaded.scene.seed, powers, Err("a lattice gas has no stiffness".to_owned()), 0.0)
            }
        };
        let softening = softening.and_then(|softening| {
            if figure.is_probability() {
                Err("a probability is counted, not extrapolated".to_owned())
            } else {
                Ok(softening)
            }
        });
        let mut not_softened = softening.as_ref().err().cloned();
        let softening = softening.ok();
        // The steps of the rungs, s; none in a lattice gas.
        let mut steps = match scene {
            AnyScene::Grains(loaded) => vec![loaded.step()],
            AnyScene::Lattice(_) => Vec::new(),
        };
        let softness = softening.as_ref().map_or_else(
            || vec![1.0],
            |softening| {
                softnesses(|softness| {
                    let loaded = softer(args, softening, softness)?;
                    steps.push(loaded.step());
                    Estimates::of(&loaded)
                })
            },
        );
        if softness.len() == 1 && not_softened.is_none() {
            not_softened = Some(format!(
                "with softer contacts grains would overlap by more than {DEEPEST_AT_REST} of their radius at rest, or {DEEPEST_IMPACT} in an impact"
            ));
        }
        let mut keys: Vec<String> = common.iter().map(|(key, _)| key.clone()).collect();
        keys.extend(softening.iter().flat_map(|it| it.paths().map(str::to_owned)));
        let mut points = Vec::new();
        for &softness in &softness {
            let mut values: Vec<String> = common.iter().map(|(_, value)| value.clone()).collect();
            values.extend(softening.iter().flat_map(|it| it.values(softness)));
            points.push(Point { values });
        }
        if !steps.is_empty() {
            keys.push("step".to_owned());
            let with_step = |share: f64| {
                let point = |(point, step): (&Point, &f64)| {
                    let values = [point.values.as_slice(), &[format!("Fixed({:e})", share * step)]].concat();
                    Point { values }
                };
                points.iter().zip(&steps).map(point).collect::<Vec<_>>()
            };
            points = [with_step(1.0), with_step(0.5)].concat();
        }
        let grows = grows && softness.len() > 1;
        if grows {
            points.push(points[softness.len() - 1].clone());
            keys.push(GROWTH.to_owned());
            for point in &mut points {
                point.values.push(format!("{own_growth}"));
            }
        }
        Self {
            name: source.name.clone(),
            ladder: Ladder::new(softness, powers),
            not_softened,
            keys,
            points,
            grows,
            growth: None,
            own_growth,
            power: powers.usual,
            is_lattice: matches!(scene, AnyScene::Lattice(_)),
            seed,
        }
    }

    /// The number of the point that measures overlaps: the softest rung without growth.
    pub(super) fn first_point(&self) -> usize {
        self.points.len() - 1
    }

    /// Lets the radii of all rungs make up for the mean overlap at rest of the first point.
    pub(super) fn grow(&mut self, overlap: f64) {
        let rungs = self.ladder.softness();
        let softness = rungs[rungs.len() - 1];
        let growth = Growth { overlap, softness, power: self.power, own: self.own_growth };
        for (number, point) in self.points[..2 * rungs.len()].iter_mut().enumerate() {
            if let Some(value) = point.values.last_mut() {
                *value = format!("{}", growth.at(rungs[number % rungs.len()]));
            }
        }
        self.growth = Some(growth);
    }

    /// The sweep whose points are the rungs.
    pub(super) fn sweep(&self, args: &SceneArgs) -> Result<Sweep, Fault> {
        let mut text = format!(
            "// The scene of this estimate, and the changes of its keys.\n(\n    scene: {:?},\n    set: {{\n",
            args.scene.display().to_string()
        );
        for (key, value) in &args.set {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "        {key:?}: {value:?},");
        }
        let grows = if self.grows { "\n    grows: true," } else { "" };
        let _ = writeln!(text, "    }},\n    softness: {:?},{grows}\n)", self.ladder.softness());
        Sweep::of_points(self.name.clone(), &args.scene, text, "estimate.ron", self.keys.clone(), self.points.clone())
    }

    /// Logs the warnings of the scene.
    pub(super) fn warn(&self, scene: &AnyScene) {
        let mut told = BTreeMap::new();
        let AnyScene::Grains(loaded) = scene else { return };
        for warning in check::warnings(loaded) {
            told.entry(warning.code).or_insert_with(|| warning.to_string());
        }
        for warning in told.into_values() {
            tracing::warn!("{}: {warning}", self.name);
        }
    }
}

/// Returns the scene with softer contacts; `None` if it is refused.
fn softer(args: &SceneArgs, softening: &Softening, softness: f64) -> Option<Box<Loaded>> {
    let values: Vec<_> = softening.paths().map(str::to_owned).zip(softening.values(softness)).collect();
    match args.load_with(&values) {
        Ok(AnyScene::Grains(loaded)) => Some(loaded),
        _ => None,
    }
}
