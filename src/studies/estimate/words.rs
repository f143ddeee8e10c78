//! The answer of an estimate in words.

use std::fmt::Write as _;

use super::results::{Estimate, GrowthFigures, LawFigures, SizeFigures, Tighter};
use siloflow_figures::statistics::digits::{digits, short};

/// A part of the answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    /// Name of the part, such as `value`.
    pub name: &'static str,
    /// The part in words.
    pub words: String,
}

impl Estimate {
    /// Returns the figure and the scene in words.
    #[must_use]
    pub fn title(&self) -> String {
        format!("{} of {}", self.figure, self.scene)
    }

    /// Returns the answer in words.
    #[must_use]
    pub fn in_words(&self) -> String {
        let refused = self.refused.iter().map(|why| Line { name: "refused", words: why.clone() });
        let lines = self.lines().into_iter().chain(refused);
        let lines = lines.map(|Line { name, words }| format!("{name:<12} {words}\n"));
        std::iter::once(self.title() + "\n").chain(lines).collect()
    }

    /// Returns the parts of the answer. The reason of a refusal stands apart.
    #[must_use]
    pub fn lines(&self) -> Vec<Line> {
        let mut lines = Vec::new();
        let mut add = |name: &'static str, words: String| lines.push(Line { name, words });
        let share = |half: f64| {
            let of = self.value.filter(|value| *value != 0.0).map(|value| 100.0 * (half / value).abs());
            of.map_or_else(String::new, |percent| format!(" ({} %)", digits(percent, 2)))
        };
        add("value", self.value_in_words(&share));
        if let Some(sources) = self.sources {
            let mut words = format!("chance {}{}", digits(sources.chance, 2), share(sources.chance));
            // Writing to a string cannot fail.
            if self.law.is_some() {
                let _ = write!(words, ", stiffness {}{}", digits(sources.stiffness, 2), share(sources.stiffness));
            }
            if let (Some(step), Some(error)) = (sources.step, sources.step_error) {
                let _ = write!(words, "; half of the step changes it by {} ± {}", digits(step, 2), digits(error, 2));
            }
            add("error", words);
        }
        if let Some(spread) = self.spread {
            add("one run", format!("scatters by {}{}", digits(spread, 2), share(spread)));
        }
        if let Some(LawFigures { power, power_range: [low, high], factor, softest }) = self.law {
            let value = short(self.value.unwrap_or(f64::NAN));
            let sign = if factor < 0.0 { '-' } else { '+' };
            let law = format!("figure = {value} {sign} {} (s^{power:.2} - 1)", short(factor.abs()));
            add("law", format!("{law} up to softness s = {softest}; powers from {low:.2} to {high:.2} count"));
        }
        if let Some(GrowthFigures { overlap, softness }) = self.growth {
            let words = "radii make up for the overlaps of a bed at rest";
            add("growth", format!("{words}, {overlap:.4} of the radius on average at s = {softness}"));
        }
        if let Some(SizeFigures { settings, change, error, is_significant }) = &self.size {
            let with = settings.join(", ");
            let words = match change.zip(*error) {
                Some((change, error)) => {
                    let verdict = if *is_significant { "more than chance" } else { "no more than chance" };
                    let [change, error, part] = [digits(change, 2), digits(error, 2), share(change)];
                    format!("{with} changes it by {change} ± {error}{part}: {verdict}")
                }
                None => format!("{with} was not compared"),
            };
            add("size", words);
        }
        if let Some(why) = &self.not_softened {
            add("stiffness", format!("that of the scene in all runs: {why}"));
        }
        let runs = self.runs.len();
        if self.is_conditional {
            let missing = self.missing;
            add(
                "note",
                format!("{missing} of {runs} runs do not have the figure: the value is the mean of the others"),
            );
        }
        add("cost", format!("{runs} runs, {:.1} s on their cores, {:.1} s in all", self.core_s, self.wall_s));
        if let Some(Tighter { half_width, wall_s: Some(seconds) }) = self.tighter {
            let half = digits(half_width, 2);
            add("tighter", format!("± {half}{} would take about {seconds:.0} s more", share(half_width)));
        }
        lines
    }

    /// The value and its interval. `share` writes a width as a share of the value.
    fn value_in_words(&self, share: &impl Fn(f64) -> String) -> String {
        match (self.value.map(short), self.interval) {
            (Some(value), _) if self.is_certain => format!("{value}: every seed gives the same run"),
            (Some(value), Some([low, high])) => {
                let half = 0.5 * (high - low);
                let percent = 100.0 * self.confidence;
                let ends = format!("between {} and {}", short(low), short(high));
                format!("{value}, {ends}: ± {}{}, {percent:.0} % confidence", digits(half, 2), share(half))
            }
            _ => "none".to_owned(),
        }
    }
}
