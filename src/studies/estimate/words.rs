//! The answer of an estimate in words.

use std::fmt::Write as _;

use super::results::{Estimate, Tighter};
use siloflow_figures::statistics::digits::{digits, short};

impl Estimate {
    /// Returns the answer in words.
    #[must_use]
    pub fn in_words(&self) -> String {
        // Writing to a string cannot fail.
        let mut text = format!("{} of {}\n", self.figure, self.scene);
        let share = |half: f64| {
            let of = self.value.filter(|value| *value != 0.0).map(|value| 100.0 * (half / value).abs());
            of.map_or_else(String::new, |percent| format!(" ({} %)", digits(percent, 2)))
        };
        match (self.value, self.interval) {
            (Some(value), _) if self.is_certain => {
                let _ = writeln!(text, "value        {}: every seed gives the same run", short(value));
            }
            (Some(value), Some([low, high])) => {
                let half = 0.5 * (high - low);
                let percent = 100.0 * self.confidence;
                let _ = writeln!(
                    text,
                    "value        {}, between {} and {}: ± {}{}, {percent:.0} % confidence",
                    short(value),
                    short(low),
                    short(high),
                    digits(half, 2),
                    share(half)
                );
            }
            _ => text += "value        none\n",
        }
        if let Some(sources) = self.sources {
            let _ = write!(text, "error        chance {}{}", digits(sources.chance, 2), share(sources.chance));
            if self.law.is_some() {
                let _ = write!(text, ", stiffness {}{}", digits(sources.stiffness, 2), share(sources.stiffness));
            }
            if let (Some(step), Some(error)) = (sources.step, sources.step_error) {
                let _ = write!(text, "; half of the step changes it by {} ± {}", digits(step, 2), digits(error, 2));
            }
            text += "\n";
        }
        if let Some(spread) = self.spread {
            let _ = writeln!(text, "one run      scatters by {}{}", digits(spread, 2), share(spread));
        }
        if let Some(law) = self.law {
            let _ = writeln!(
                text,
                "law          figure = {} + {} (s^{:.2} - 1) up to softness s = {}; powers from {:.2} to {:.2} count",
                short(self.value.unwrap_or(f64::NAN)),
                short(law.factor),
                law.power,
                law.softest,
                law.power_range[0],
                law.power_range[1]
            );
        }
        if let Some(growth) = self.growth {
            let _ = writeln!(
                text,
                "growth       radii make up for the overlaps of a bed at rest, {:.4} of the radius on average at s = {}",
                growth.overlap, growth.softness
            );
        }
        if let Some(why) = &self.not_softened {
            let _ = writeln!(text, "stiffness    that of the scene in all runs: {why}");
        }
        if self.is_conditional {
            let _ = writeln!(
                text,
                "note         {} of {} runs do not have the figure: the value is the mean of the others",
                self.missing,
                self.runs.len()
            );
        }
        let _ = writeln!(
            text,
            "cost         {} runs, {:.1} s on their cores, {:.1} s in all",
            self.runs.len(),
            self.core_s,
            self.wall_s
        );
        if let Some(Tighter { half_width, wall_s: Some(seconds) }) = self.tighter {
            let _ = writeln!(
                text,
                "tighter      ± {}{} would take about {seconds:.0} s more",
                digits(half_width, 2),
                share(half_width)
            );
        }
        if let Some(why) = &self.refused {
            let _ = writeln!(text, "refused      {why}");
        }
        text
    }
}
