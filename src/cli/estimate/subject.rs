//! The scene of an estimate: its rungs, and the sweep that makes them.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::cli::SceneArgs;
use crate::cli::estimate::points::{GROWTH, Ingredients, Points, Setting};
use crate::scene::check::{self, Estimates};
use crate::scene::loaded::AnyScene;
use crate::studies::estimate::growth::Growth;
use crate::studies::estimate::softening::Softening;
use crate::studies::estimate::softness::{DEEPEST_AT_REST, DEEPEST_IMPACT, powers, softnesses};
use crate::studies::estimate::variant::{Change, Variant};
use crate::studies::figures::figure::Figure;
use crate::studies::sweep::Sweep;
use siloflow_dem::values::Share;
use siloflow_figures::statistics::extrapolation::{Ladder, Powers};
use siloflow_text::fault::Fault;

/// The scene of an estimate.
pub(super) struct Subject {
    pub name: String,
    pub ladder: Ladder,
    /// Why the contacts are not made softer.
    pub not_softened: Option<String>,
    /// The points of all runs.
    pub points: Points,
    /// Whether softer grains have larger radii.
    pub grows: bool,
    /// Their growth, once it is known.
    pub growth: Option<Growth>,
    /// The growth that the scene itself asks for.
    own_growth: f64,
    /// The power of the softness with which overlaps grow.
    power: f64,
    /// The settings of the larger silo, in words.
    pub larger: Vec<String>,
    pub seed: u64,
}

/// Options of an estimate that change its runs.
pub(super) struct Wishes<'a> {
    /// Whether radii of softer grains are to make up for their overlaps.
    pub grows: bool,
    /// Keys and values of a larger silo.
    pub larger: &'a [Setting],
}

impl Subject {
    /// Finds the rungs of a scene. Each rung is loaded once, and the larger silo once for each rung.
    ///
    /// # Errors
    /// If a key of the larger silo is not in the scene, or if that silo is refused.
    pub(super) fn of(args: &SceneArgs, scene: &AnyScene, figure: &Figure, wishes: &Wishes) -> Result<Self, Fault> {
        let source = scene.source();
        let (seed, powers, softening, own_growth) = match scene {
            AnyScene::Grains(loaded) => {
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
        // The steps of the rungs, s; none of a lattice gas.
        let mut steps = match scene {
            AnyScene::Grains(loaded) => vec![loaded.step()],
            AnyScene::Lattice(_) => Vec::new(),
        };
        let softness = softening.as_ref().map_or_else(
            || vec![1.0],
            |softening| {
                softnesses(|softness| {
                    let Ok(AnyScene::Grains(loaded)) = args.load_with(&softening.settings(softness)) else {
                        return None;
                    };
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
        let grows = wishes.grows && softness.len() > 1;
        let ingredients = Ingredients {
            args,
            source,
            softening: softening.as_ref(),
            softness: &softness,
            steps: &steps,
            growth: grows.then_some(own_growth),
            larger: wishes.larger,
        };
        let points = ingredients.points()?;
        Ok(Self {
            name: source.name.clone(),
            ladder: Ladder::new(softness, powers),
            not_softened,
            points,
            grows,
            growth: None,
            own_growth,
            power: powers.usual,
            larger: wishes.larger.iter().map(|(key, value)| format!("{key} = {value}")).collect(),
            seed,
        })
    }

    /// Returns the number of the point of a rung with a change; `None` if the scene has no such point.
    pub(super) fn point(&self, variant: Variant) -> Option<usize> {
        self.points.variants.iter().position(|other| *other == variant)
    }

    /// Lets the radii of all rungs make up for the mean overlap at rest of the softest one.
    pub(super) fn grow(&mut self, overlap: f64) {
        let rungs = self.ladder.softness();
        let softness = rungs[rungs.len() - 1];
        let growth = Growth { overlap, softness, power: self.power, own: self.own_growth };
        let Points { keys, list, variants } = &mut self.points;
        if let Some(place) = keys.iter().position(|key| key == GROWTH) {
            for (point, variant) in list.iter_mut().zip(variants).filter(|it| it.1.change != Change::Overlaps) {
                point.values[place] = format!("{}", growth.at(rungs[variant.rung]));
            }
        }
        self.growth = Some(growth);
    }

    /// The sweep of all points.
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
        let larger = if self.larger.is_empty() { String::new() } else { format!("\n    larger: {:?},", self.larger) };
        let _ = writeln!(text, "    }},\n    softness: {:?},{grows}{larger}\n)", self.ladder.softness());
        Sweep::of_points(
            self.name.clone(),
            &args.scene,
            text,
            "estimate.ron",
            self.points.keys.clone(),
            self.points.list.clone(),
        )
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
