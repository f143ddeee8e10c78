//! Part of a table as the text of a figure names it.

use siloflow_text::fault::Fault;

use crate::measure::moment::Moment;

/// Part of a table.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Excerpt {
    pub(super) file: String,
    pub(super) column: String,
    pub(super) of: Statistic,
    /// Column and text that a row must have.
    pub(super) only: Vec<(String, String)>,
    /// Words without a column: names of walls.
    pub(super) named: Option<String>,
    pub(super) places: Option<(f64, f64)>,
    pub(super) window: Option<(Moment, Moment)>,
}

/// The statistic of the numbers of a column.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Statistic {
    #[default]
    Mean,
    Largest,
    Slope,
}

pub(super) fn fault(message: String, help: impl Into<String>) -> Fault {
    Fault::new("estimate::figure", message).help(help)
}

/// Example of a figure of a table.
const EXAMPLE: &str = "for example `series.csv: rate of out, AfterDoor(0.1) to AfterDoor(0.4)`";

impl Excerpt {
    pub(super) fn parse(file: &str, rest: &str) -> Result<Self, Fault> {
        let is_table = std::path::Path::new(file).extension().is_some_and(|ending| ending == "csv");
        if !is_table || file.contains(['/', '\\']) {
            return Err(fault(format!("`{file}` is no table of a run directory"), EXAMPLE));
        }
        let mut found = Self { file: file.to_owned(), ..Self::default() };
        let mut words = Vec::new();
        for part in rest.split(',').map(str::trim) {
            if let Some((low, high)) = part.split_once(" to ") {
                found.range(part, low.trim(), high.trim())?;
            } else if let Some((column, text)) = part.split_once('=') {
                found.only.push((column.trim().to_owned(), text.trim().to_owned()));
            } else if !part.is_empty() {
                words.push(part);
            }
        }
        let (column, named) = match words[..] {
            [column] => (column, None),
            [named, column] => (column, Some(named)),
            _ => return Err(fault(format!("`{file}:{rest}` does not name one column"), EXAMPLE)),
        };
        found.named = named.map(str::to_owned);
        let statistics = [("rate of ", Statistic::Slope), ("largest ", Statistic::Largest), ("mean ", Statistic::Mean)];
        let statistic = statistics.iter().find_map(|(word, of)| Some((column.strip_prefix(word)?, *of)));
        let (column, of) = statistic.unwrap_or((column, Statistic::Mean));
        column.trim().clone_into(&mut found.column);
        found.of = of;
        Ok(found)
    }

    /// Takes a range of places or of times.
    fn range(&mut self, part: &str, low: &str, high: &str) -> Result<(), Fault> {
        let metres = |words: &str| words.strip_suffix('m')?.trim().parse().ok().filter(|place: &f64| place.is_finite());
        match (metres(low), metres(high), Moment::parse(low), Moment::parse(high)) {
            (Some(low), Some(high), ..) if low < high => self.places = Some((low, high)),
            (_, _, Ok(from), Ok(to)) => self.window = Some((from, to)),
            _ => {
                let help = "a range of places is `0.1 m to 0.2 m`, a window of time `1 s to 2 s`, or with moments \
                            AfterDoor(seconds), AfterRest(seconds), Out(share)";
                return Err(fault(format!("`{part}` is neither a range of places nor a window of time"), help));
            }
        }
        Ok(())
    }
}

impl Statistic {
    /// Returns the statistic of values with their times; `None` if there are too few.
    pub(super) fn of(self, points: &[(f64, f64)]) -> Option<f64> {
        #[expect(clippy::cast_precision_loss, reason = "rows of a table")]
        let count = points.len() as f64;
        match self {
            Self::Mean => (!points.is_empty()).then(|| points.iter().map(|point| point.1).sum::<f64>() / count),
            Self::Largest => points.iter().map(|point| point.1).reduce(f64::max),
            Self::Slope => siloflow_figures::statistics::points::slope(points),
        }
    }
}
