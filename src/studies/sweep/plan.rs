//! The sweep file: a scene, the values of its keys, seeds, figures and a fit.
//!
//! Values of keys are RON, as they would stand in the scene: numbers, choices such as `Fixed(0.01)`, texts.

use std::collections::{BTreeMap, HashSet};
use std::fmt;
use std::path::{Path, PathBuf};

use ron::value::RawValue;
use serde::de::{SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use siloflow_figures::statistics::fit::Law;
use siloflow_text::fault::Fault;
use siloflow_text::file;
use siloflow_text::source::Source;

/// Most runs of a sweep.
pub const MOST_RUNS: usize = 100_000;

/// The keys of a sweep file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "Plan")]
pub struct SweepPlan {
    /// Path of the scene, relative to the directory of the sweep file.
    pub scene: PathBuf,
    /// Keys of the scene that have one value in all runs.
    #[serde(default)]
    pub set: BTreeMap<String, Box<RawValue>>,
    /// Keys of the scene with their values. The points are all combinations of their values.
    #[serde(default)]
    pub axes: Vec<Axis>,
    /// Keys of the scene whose values are drawn together.
    #[serde(default)]
    pub latin_hypercube: Option<LatinHypercube>,
    /// Units of keys with several values, for the axes and legends of figures and the groups of fits.
    #[serde(default)]
    pub units: BTreeMap<String, String>,
    /// Seeds of the runs of each point, or a number n for the seeds 1 to n.
    pub seeds: Seeds,
    /// Paths of numbers in `summary.json`, or other figures.
    pub figures: Vec<String>,
    /// A law that is fitted to the means of a figure.
    #[serde(default)]
    pub fit: Option<FitPlan>,
}

/// A key of the scene and its values.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Axis {
    /// Given values.
    Values {
        /// The key.
        key: String,
        /// The values.
        values: Vec<Box<RawValue>>,
    },
    /// Numbers from one end of a range to the other.
    Range {
        /// The key.
        key: String,
        /// The first number, in the unit of the key.
        from: f64,
        /// The last number, in the unit of the key.
        to: f64,
        /// Count of numbers, at least 2.
        count: usize,
        /// Spacing of the numbers.
        #[serde(default)]
        spacing: Spacing,
    },
}

/// Spacing of numbers in a range.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub enum Spacing {
    /// Equal differences.
    #[default]
    Linear,
    /// Equal ratios.
    Log,
}

/// A Latin hypercube: each key's range is cut into as many equal parts as there are samples, and each part holds one sample.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LatinHypercube {
    /// Number of samples.
    pub samples: usize,
    /// Seed of the random numbers of the samples. Default 1.
    #[serde(default = "one")]
    pub seed: u64,
    /// The keys and their ranges.
    pub keys: Vec<Interval>,
}

/// A key of the scene and the range of its values.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Interval {
    /// The key.
    pub key: String,
    /// Lower end, in the unit of the key.
    pub low: f64,
    /// Upper end, in the unit of the key.
    pub high: f64,
    /// Whether numbers or their logarithms are uniform.
    #[serde(default)]
    pub spacing: Spacing,
}

/// Seeds: a list, or a count `n` for the seeds 1 to n.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Seeds(Vec<u64>);

/// A law that is fitted to the means of a figure.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FitPlan {
    /// The figure, one of `figures`.
    pub figure: String,
    /// The key of the scene that it depends on.
    pub against: String,
    /// The law.
    pub law: Law,
}

fn one() -> u64 {
    1
}

impl Seeds {
    /// The seeds.
    #[must_use]
    pub fn list(&self) -> &[u64] {
        &self.0
    }
}

impl<'de> Deserialize<'de> for Seeds {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = Seeds;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a list of seeds, or a number of seeds")
            }

            fn visit_u64<E>(self, count: u64) -> Result<Seeds, E> {
                // More are refused by the rules; a long list is not made first.
                Ok(Seeds((1..=count.min(1 + MOST_RUNS as u64)).collect()))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Seeds, A::Error> {
                let mut seeds = Vec::new();
                while let Some(seed) = list.next_element()? {
                    seeds.push(seed);
                }
                Ok(Seeds(seeds))
            }
        }
        deserializer.deserialize_any(Either)
    }
}

impl Axis {
    /// The key of the scene.
    #[must_use]
    pub fn key(&self) -> &str {
        match self {
            Self::Values { key, .. } | Self::Range { key, .. } => key,
        }
    }

    /// Number of values.
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Values { values, .. } => values.len(),
            Self::Range { count, .. } => *count,
        }
    }
}

/// Reads the text of a sweep file.
pub(super) fn read_source(path: &Path) -> Result<Source, Fault> {
    let text = file::read_text(path, file::SCENE_BYTES).map_err(|error| {
        Fault::new("sweep::unreadable", format!("could not read {}: {error}", path.display()))
            .help(file::remedy(&error, "give the path of a sweep file, a RON file such as scenes/sweeps/beverloo.ron"))
    })?;
    let name = path.file_stem().map_or_else(|| "sweep".to_owned(), |stem| stem.to_string_lossy().into_owned());
    let source = Source::new(&path.display().to_string(), &name, Path::new(""), text);
    let is_scene = source.value_of("until").is_some() && source.value_of("axes").is_none();
    let begins_well = source.text.trim_start().starts_with(['(', '#', '/']);
    if is_scene || !begins_well {
        let what = if is_scene { "a scene" } else { "no RON text that begins with `(`" };
        return Err(Fault::new("sweep::not_a_sweep", format!("{} is no sweep file: it is {what}", path.display()))
            .help("a sweep file names a scene: `(scene: \"silo.ron\", axes: [...], seeds: 3, figures: [...])`"));
    }
    Ok(source)
}

impl SweepPlan {
    /// Returns the plan of a sweep whose points do not come from a file.
    pub(super) fn without_axes(scene: &Path) -> Self {
        Self {
            scene: scene.to_owned(),
            set: BTreeMap::new(),
            axes: Vec::new(),
            latin_hypercube: None,
            units: BTreeMap::new(),
            seeds: Seeds(Vec::new()),
            figures: Vec::new(),
            fit: None,
        }
    }

    /// Parses a sweep file and checks its rules.
    pub(super) fn parse(source: &mut Source) -> Result<Self, Fault> {
        let plan: Self = source.parse(&[])?;
        plan.check_axes(source)?;
        plan.check_hypercube(source)?;
        plan.check_keys(source)?;
        plan.check_results(source)?;
        plan.check_size(source)?;
        Ok(plan)
    }

    /// Returns the keys of the scene that differ between points: those of the axes, then those of the hypercube.
    pub fn keys(&self) -> impl Iterator<Item = &str> {
        let drawn = self.latin_hypercube.iter().flat_map(|cube| &cube.keys);
        self.axes.iter().map(Axis::key).chain(drawn.map(|interval| interval.key.as_str()))
    }

    /// Returns a key, and its unit if the file names one.
    #[must_use]
    pub fn label(&self, key: &str) -> String {
        self.units.get(key).map_or_else(|| key.to_owned(), |unit| format!("{key}, {unit}"))
    }

    fn check_axes(&self, source: &Source) -> Result<(), Fault> {
        let fault =
            |key: String, message: String, help: &str| Err(source.fault("sweep::axis", &key, message).help(help));
        for (n, axis) in self.axes.iter().enumerate() {
            let place = |key: &str| format!("axes[{n}].{key}");
            match axis {
                Axis::Values { values, .. } => {
                    let mut seen = HashSet::new();
                    if values.is_empty() {
                        return fault(place("values"), "the axis has no values".to_owned(), "give at least one value");
                    }
                    for (m, value) in values.iter().enumerate() {
                        if !seen.insert(value.trim().get_ron()) {
                            let message = format!("the value {} stands here twice", value.trim().get_ron());
                            return fault(format!("axes[{n}].values[{m}]"), message, "remove one of the two");
                        }
                    }
                }
                Axis::Range { from, to, count, spacing, .. } => {
                    if *count < 2 {
                        return fault(
                            place("count"),
                            "a range needs at least 2 values".to_owned(),
                            "for example `count: 5`",
                        );
                    }
                    check_range(source, Ends { low: *from, high: *to }, *spacing, &place("from"))?;
                }
            }
        }
        Ok(())
    }

    fn check_hypercube(&self, source: &Source) -> Result<(), Fault> {
        let Some(cube) = &self.latin_hypercube else { return Ok(()) };
        if cube.samples == 0 || cube.keys.is_empty() {
            let key = if cube.samples == 0 { "latin_hypercube.samples" } else { "latin_hypercube.keys" };
            return Err(source
                .fault("sweep::axis", key, "a Latin hypercube needs at least one sample and one key")
                .help("for example `(samples: 20, keys: [(key: \"gravity.1\", low: -10.0, high: -9.0)])`"));
        }
        for (n, Interval { low, high, spacing, .. }) in cube.keys.iter().enumerate() {
            check_range(source, Ends { low: *low, high: *high }, *spacing, &format!("latin_hypercube.keys[{n}].low"))?;
        }
        Ok(())
    }

    /// A key has one place in the file, and the seed is no key of an axis.
    fn check_keys(&self, source: &Source) -> Result<(), Fault> {
        let of_axes = (0..self.axes.len()).map(|n| format!("axes[{n}].key"));
        let drawn = self.latin_hypercube.iter().flat_map(|cube| 0..cube.keys.len());
        let places = of_axes.chain(drawn.map(|n| format!("latin_hypercube.keys[{n}].key")));
        let mut seen: HashSet<&str> = self.set.keys().map(String::as_str).collect();
        if seen.contains("seed") {
            return Err(source
                .fault("sweep::axis", "set", "the seed is no key of `set`")
                .help("write `seeds: [1, 2, 3]`"));
        }
        for (place, key) in places.zip(self.keys()) {
            if key == "seed" {
                return Err(source
                    .fault("sweep::axis", &place, "seeds are no axis: results are averaged over them")
                    .help("write `seeds: [1, 2, 3]`"));
            }
            if !seen.insert(key) {
                return Err(source
                    .fault("sweep::axis", &place, format!("the key `{key}` has its values in two places"))
                    .help("remove one of the two; keys that change together are expressions of one parameter"));
            }
        }
        let other = self.units.keys().find(|key| !self.keys().any(|own| own == *key));
        other.map_or(Ok(()), |key| Err(self.no_such_key(source, "units", key)))
    }

    /// The fault of a key that has no axis.
    fn no_such_key(&self, source: &Source, place: &str, key: &str) -> Fault {
        let keys = self.keys().collect::<Vec<_>>().join(", ");
        source
            .fault("sweep::no_such_key", place, format!("`{key}` is no key of an axis of this file"))
            .help(format!("the keys are: {keys}"))
    }

    fn check_results(&self, source: &Source) -> Result<(), Fault> {
        let distinct = |names: &[String]| names.iter().collect::<HashSet<_>>().len() == names.len();
        if self.figures.is_empty() || !distinct(&self.figures) {
            return Err(source
                .fault("sweep::figure", "figures", "expected at least one figure, and each only once")
                .help("for example `figures: [\"discharge.rate_per_s\"]`: paths of numbers in summary.json"));
        }
        let Some(fit) = &self.fit else { return Ok(()) };
        if !self.figures.contains(&fit.figure) {
            return Err(source
                .fault("sweep::fit", "fit.figure", format!("`{}` is none of the figures of this file", fit.figure))
                .help(format!("the figures are: {}", self.figures.join(", "))));
        }
        if !self.keys().any(|key| key == fit.against) {
            return Err(self.no_such_key(source, "fit.against", &fit.against));
        }
        fit.law.check().map_err(|(key, message)| {
            source.fault("sweep::fit", &format!("fit.law.{key}"), message).help("give a positive number, in SI units")
        })
    }

    fn check_size(&self, source: &Source) -> Result<(), Fault> {
        let distinct = self.seeds.0.iter().collect::<HashSet<_>>().len() == self.seeds.0.len();
        if self.seeds.0.is_empty() || !distinct {
            return Err(source
                .fault("sweep::seeds", "seeds", "expected at least one seed, and each only once")
                .help("for example `seeds: [1, 2, 3]`, or `seeds: 3`"));
        }
        let samples = self.latin_hypercube.as_ref().map_or(1, |cube| cube.samples);
        let counts = self.axes.iter().map(Axis::len).chain([samples, self.seeds.0.len()]);
        match counts.clone().try_fold(1usize, usize::checked_mul) {
            Some(count) if count <= MOST_RUNS => Ok(()),
            _ => {
                let key = if self.axes.is_empty() { "latin_hypercube" } else { "axes" };
                let message = format!("this file asks for more than {MOST_RUNS} runs");
                Err(source.fault("sweep::size", key, message).help("give fewer values, samples or seeds"))
            }
        }
    }
}

/// The ends of a range.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ends {
    pub low: f64,
    pub high: f64,
}

/// Checks the ends of a range.
fn check_range(source: &Source, Ends { low, high }: Ends, spacing: Spacing, key: &str) -> Result<(), Fault> {
    let message = if !(low.is_finite() && high.is_finite()) {
        "the ends of a range must be finite"
    } else if low >= high {
        "the lower end of a range must be below its upper end"
    } else if spacing == Spacing::Log && low <= 0.0 {
        "a logarithmic range must be positive"
    } else {
        return Ok(());
    };
    Err(source.fault("sweep::axis", key, message).help("for example `from: 0.1, to: 0.8`"))
}
