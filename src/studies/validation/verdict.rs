//! Rows of a validation: a figure of siloflow, the published figure, and the rule between them.
//!
//! A rule comes from the publication or from theory. A figure without a published value that could be read is only reported.

use siloflow_figures::statistics::digits::{digits, short};
use siloflow_figures::statistics::mean::Mean;

/// The rule that a figure has to obey.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rule {
    /// At most this share from the published value.
    Within(f64),
    /// At most this far from the published value, in the unit of the figure.
    WithinAbsolute(f64),
    /// Between two values.
    Between(f64, f64),
    /// No rule.
    Reported,
}

/// Whether a figure obeys its rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It does.
    Pass,
    /// It does not, or there is no figure.
    Miss,
    /// It has no rule.
    Reported,
}

impl Verdict {
    /// Word on the page.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Miss => "miss",
            Self::Reported => "reported",
        }
    }
}

/// A row.
#[derive(Clone, Debug, PartialEq)]
pub struct FigureRow {
    /// The quantity.
    pub quantity: String,
    /// Its unit; empty for a pure number.
    pub unit: &'static str,
    /// The figure of siloflow.
    pub found: f64,
    /// Its standard error, if it is known.
    pub error: Option<f64>,
    /// The published figure.
    pub published: Option<f64>,
    /// The rule.
    pub rule: Rule,
    /// Whether the figure is known to miss, for the reason in the remark.
    pub is_known_miss: bool,
    /// A remark for the reader of the row; may be empty.
    pub remark: String,
}

impl FigureRow {
    /// Returns a row without a rule.
    #[must_use]
    pub fn new(quantity: impl Into<String>, unit: &'static str, found: f64) -> Self {
        let quantity = quantity.into();
        Self {
            quantity,
            unit,
            found,
            error: None,
            published: None,
            rule: Rule::Reported,
            is_known_miss: false,
            remark: String::new(),
        }
    }

    /// Returns a row for a mean over runs; without a mean it has no figure.
    #[must_use]
    pub fn of_mean(quantity: impl Into<String>, unit: &'static str, mean: Option<Mean>) -> Self {
        let row = Self::new(quantity, unit, mean.map_or(f64::NAN, |mean| mean.value));
        Self { error: mean.map(|mean| mean.error).filter(|error| *error > 0.0), ..row }
    }

    /// Returns a row for the ratio of two means; without one of them it has no figure.
    #[must_use]
    pub fn of_ratio(quantity: impl Into<String>, above: Option<Mean>, below: Option<Mean>) -> Self {
        let Some((above, below)) = above.zip(below) else { return Self::new(quantity, "", f64::NAN) };
        let ratio = above.value / below.value;
        let error = ratio * (above.error / above.value).hypot(below.error / below.value);
        Self::new(quantity, "", ratio).error(Some(error).filter(|error| *error > 0.0))
    }

    /// Adds a standard error.
    #[must_use]
    pub fn error(self, error: Option<f64>) -> Self {
        Self { error, ..self }
    }

    /// Adds a published figure and the rule.
    #[must_use]
    pub fn published(self, value: f64, rule: Rule) -> Self {
        Self { published: Some(value), rule, ..self }
    }

    /// Adds a rule that needs no published figure.
    #[must_use]
    pub fn rule(self, rule: Rule) -> Self {
        Self { rule, ..self }
    }

    /// Adds a remark.
    #[must_use]
    pub fn remark(self, remark: impl Into<String>) -> Self {
        Self { remark: remark.into(), ..self }
    }

    /// Adds the reason of a miss that is known, and that does not make `siloflow validate` fail.
    #[must_use]
    pub fn known_miss(self, reason: impl Into<String>) -> Self {
        Self { is_known_miss: true, remark: reason.into(), ..self }
    }

    /// Returns whether the figure obeys the rule. A figure that is no number misses.
    #[must_use]
    pub fn verdict(&self) -> Verdict {
        let from = |bound: f64| (self.found - self.published.unwrap_or(f64::NAN)).abs() <= bound;
        let obeys = match self.rule {
            Rule::Within(share) => from(share * self.published.map_or(f64::NAN, f64::abs)),
            Rule::WithinAbsolute(bound) => from(bound),
            Rule::Between(low, high) => (low..=high).contains(&self.found),
            Rule::Reported => return Verdict::Reported,
        };
        if obeys { Verdict::Pass } else { Verdict::Miss }
    }

    /// Returns the rule in words.
    #[must_use]
    pub fn rule_in_words(&self) -> String {
        let unit = if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) };
        match self.rule {
            Rule::Within(share) => format!("within {} %", trimmed(100.0 * share)),
            Rule::WithinAbsolute(bound) => format!("within {}{unit}", trimmed(bound)),
            Rule::Between(low, high) => format!("{} to {}{unit}", trimmed(low), trimmed(high)),
            Rule::Reported => String::new(),
        }
    }

    /// Returns the figure with its error, without the unit.
    #[must_use]
    pub fn found_in_words(&self) -> String {
        let error = self.error.map_or_else(String::new, |error| format!(" ± {}", digits(error, 2)));
        format!("{}{error}", short(self.found))
    }
}

/// Returns a number without zeros at its end.
fn trimmed(x: f64) -> String {
    let text = short(x);
    if text.contains('e') || !text.contains('.') {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A figure of a case.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Name, added to the name of the case; empty for the first.
    pub name: &'static str,
    /// SVG document.
    pub svg: String,
    /// A sentence below the figure.
    pub caption: String,
}

/// The verdict on a case.
#[derive(Clone, Debug, Default)]
pub struct Judgement {
    /// Rows.
    pub rows: Vec<FigureRow>,
    /// Figures.
    pub pictures: Vec<Picture>,
    /// Paragraphs below the rows: differences from the publication, and what was tried to explain a miss.
    pub remarks: Vec<String>,
}

impl Judgement {
    /// Returns whether a figure misses that is not known to miss.
    #[must_use]
    pub fn has_new_miss(&self) -> bool {
        self.rows.iter().any(|row| row.verdict() == Verdict::Miss && !row.is_known_miss)
    }

    /// Returns the number of rows with a verdict.
    #[must_use]
    pub fn count(&self, verdict: Verdict) -> usize {
        self.rows.iter().filter(|row| row.verdict() == verdict).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_beyond_its_rule_or_without_a_number_misses() {
        let row = |found: f64, rule| FigureRow::new("q", "m", found).published(100.0, rule).verdict();
        for (rule, inside, outside) in [
            (Rule::Within(0.05), [95.1, 104.9], [94.9, 105.1]),
            (Rule::WithinAbsolute(2.0), [98.1, 101.9], [97.9, 102.1]),
            (Rule::Between(90.0, 101.0), [90.0, 101.0], [89.9, 101.1]),
        ] {
            assert_eq!(inside.map(|x| row(x, rule)), [Verdict::Pass; 2]);
            assert_eq!(outside.map(|x| row(x, rule)), [Verdict::Miss; 2]);
            assert_eq!(row(f64::NAN, rule), Verdict::Miss);
        }
        assert_eq!(row(f64::NAN, Rule::Reported), Verdict::Reported);
        assert_eq!(FigureRow::new("q", "", 1.0).rule(Rule::Within(0.5)).verdict(), Verdict::Miss);
    }

    #[test]
    fn rows_are_written_with_the_digits_that_their_errors_leave() {
        let row = FigureRow::new("q", "g/s", 82.345).published(82.3, Rule::Within(0.05)).error(Some(0.123));
        assert_eq!((row.found_in_words(), row.rule_in_words()), ("82.34 ± 0.12".to_owned(), "within 5 %".to_owned()));
        assert_eq!(row.rule(Rule::Between(1.5, 10.0)).rule_in_words(), "1.5 to 10 g/s");
    }
}
