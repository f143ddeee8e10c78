//! The settings of the runs of an estimate: those of each rung, also with half of the step and for a larger silo.

use crate::cli::SceneArgs;
use crate::scene::loaded::AnyScene;
use crate::studies::estimate::softening::Softening;
use crate::studies::estimate::variant::{Change, Variant};
use crate::studies::sweep::design::Point;
use siloflow_text::fault::Fault;
use siloflow_text::source::Source;

/// The scene key that makes up for overlaps.
pub(super) const GROWTH: &str = "growth";

/// A key and its value, as RON.
pub(super) type Setting = (String, String);

/// The points of an estimate.
#[derive(Default)]
pub(super) struct Points {
    /// The keys that they set.
    pub keys: Vec<String>,
    /// Their values. The points of the ladder come first, in its order.
    pub list: Vec<Point>,
    /// The kinds of their runs.
    pub variants: Vec<Variant>,
}

/// The scene and the options from which the points are made.
pub(super) struct Ingredients<'a> {
    pub args: &'a SceneArgs,
    pub source: &'a Source,
    pub softening: Option<&'a Softening>,
    /// The softness of each rung.
    pub softness: &'a [f64],
    /// The step of each rung, s; none of a lattice gas.
    pub steps: &'a [f64],
    /// The growth that the scene itself asks for, if radii of softer grains are to make up for overlaps.
    pub growth: Option<f64>,
    /// The settings of a larger silo.
    pub larger: &'a [Setting],
}

impl Ingredients<'_> {
    /// Makes the points. The larger silo is loaded for the step of each rung.
    ///
    /// # Errors
    /// If a key of the larger silo is not in the scene, or if a scene is refused.
    pub(super) fn points(&self) -> Result<Points, Fault> {
        let own = self.own()?;
        let mut all = Points::default();
        self.add(&mut all, Change::Nothing, &own, self.steps);
        if !self.steps.is_empty() {
            self.add(&mut all, Change::HalfStep, &own, self.steps);
        }
        if !self.larger.is_empty() {
            self.add(&mut all, Change::Larger, self.larger, &self.steps_of_larger()?);
        }
        if self.growth.is_some() {
            let softest = self.softness.len() - 1;
            let point = all.list[softest].clone();
            all.list.push(point);
            all.variants.push(Variant { rung: softest, change: Change::Overlaps });
        }
        Ok(all)
    }

    /// The scene's own values of the keys of the larger silo.
    fn own(&self) -> Result<Vec<Setting>, Fault> {
        let own = |(key, _): &Setting| {
            let message = || format!("`--size` changes `{key}`, but the scene does not have this key");
            let value = self.source.value_of(key).ok_or_else(|| {
                Fault::new("estimate::size", message())
                    .help("name a key that is written in the scene, for example one of its `parameters`")
            })?;
            Ok((key.clone(), value.to_owned()))
        };
        self.larger.iter().map(own).collect()
    }

    /// The settings of a rung without its step.
    fn settings(&self, softness: f64, size: &[Setting]) -> Vec<Setting> {
        // Pictures and frames change no figure.
        let mut settings = vec![("pictures".to_owned(), "None".to_owned())];
        if !self.steps.is_empty() {
            settings.push(("data_frames".to_owned(), "None".to_owned()));
        }
        settings.extend(self.softening.iter().flat_map(|softening| softening.settings(softness)));
        settings.extend(size.iter().cloned());
        settings
    }

    /// The steps of the larger silo at all rungs, s; none of a lattice gas.
    fn steps_of_larger(&self) -> Result<Vec<f64>, Fault> {
        let mut steps = Vec::new();
        for &softness in self.softness {
            if let AnyScene::Grains(loaded) = self.args.load_with(&self.settings(softness, self.larger))? {
                steps.push(loaded.step());
            }
        }
        Ok(steps)
    }

    /// Adds a point for each rung.
    fn add(&self, all: &mut Points, change: Change, size: &[Setting], steps: &[f64]) {
        for (rung, &softness) in self.softness.iter().enumerate() {
            let mut settings = self.settings(softness, size);
            let share = if change == Change::HalfStep { 0.5 } else { 1.0 };
            settings.extend(steps.get(rung).map(|step| ("step".to_owned(), format!("Fixed({:e})", share * step))));
            settings.extend(self.growth.map(|growth| (GROWTH.to_owned(), format!("{growth}"))));
            let merged = merged(self.args.set.iter().cloned().chain(settings));
            all.keys = merged.iter().map(|(key, _)| key.clone()).collect();
            all.list.push(Point { values: merged.into_iter().map(|(_, value)| value).collect() });
            all.variants.push(Variant { rung, change });
        }
    }
}

/// Returns the last value of each key, at the place of its first one.
fn merged(settings: impl Iterator<Item = Setting>) -> Vec<Setting> {
    let mut all: Vec<Setting> = Vec::new();
    for (key, value) in settings {
        match all.iter_mut().find(|(other, _)| *other == key) {
            Some(found) => found.1 = value,
            None => all.push((key, value)),
        }
    }
    all
}
