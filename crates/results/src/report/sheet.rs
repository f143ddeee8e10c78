//! A table whose rows are quantities and whose columns are runs. Beside the second and every further run stands its ratio to the first.

use std::borrow::Cow;
use std::fmt::Write as _;

use crate::report::html::{escape, quantity, scrolled, uncertain};

/// A table of quantities by run.
#[derive(Clone, Debug, Default)]
pub struct Sheet {
    rows: Vec<Row>,
    /// Whether most values are words, so that all values begin at the left.
    is_of_words: bool,
}

#[derive(Clone, Debug)]
struct Row {
    name: String,
    cells: Vec<Cell>,
}

/// The value of one run.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// The run has no such value.
    Nothing,
    /// A number and its unit.
    Number(f64, Cow<'static, str>),
    /// A number, the half-width of its confidence interval, and the unit of both.
    Interval(f64, f64, Cow<'static, str>),
    /// HTML.
    Html(String),
}

impl Cell {
    /// A number with a unit, if there is one.
    #[must_use]
    pub fn of(value: Option<f64>, unit: impl Into<Cow<'static, str>>) -> Self {
        value.map_or(Self::Nothing, |value| Self::Number(value, unit.into()))
    }

    /// The number and its unit.
    fn number(&self) -> Option<(f64, &str)> {
        match self {
            Self::Number(value, unit) | Self::Interval(value, _, unit) => Some((*value, unit)),
            _ => None,
        }
    }

    /// Plain text, if there is any.
    #[must_use]
    pub fn text(text: Option<&str>) -> Self {
        text.map_or(Self::Nothing, |text| Self::Html(escape(text)))
    }
}

impl Sheet {
    /// An empty table most of whose values are words, so that all values begin at the left.
    #[must_use]
    pub fn of_words() -> Self {
        Self { is_of_words: true, ..Self::default() }
    }

    /// Adds a row, unless no run has a value. The name is HTML.
    pub fn add(&mut self, name: impl Into<String>, cells: Vec<Cell>) {
        if cells.iter().any(|cell| *cell != Cell::Nothing) {
            self.rows.push(Row { name: name.into(), cells });
        }
    }

    /// Whether the table has no row.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Returns the table as HTML; nothing without rows. `labels` name the runs. Caption and labels are plain text.
    #[must_use]
    pub fn html(&self, caption: &str, labels: &[String]) -> String {
        if self.is_empty() {
            return String::new();
        }
        let has_ratios = |column: usize| self.rows.iter().any(|row| ratio(row, column).is_some());
        let columns: Vec<_> = (0..labels.len()).map(|column| (column, column > 0 && has_ratios(column))).collect();
        let mut html = format!(
            "<table{}>\n<caption>{}</caption>\n<thead>\n<tr><th scope=\"col\">Quantity</th>",
            if self.is_of_words { " class=\"words\"" } else { "" },
            escape(caption)
        );
        for &(column, has_ratio) in &columns {
            let label = if labels.len() > 1 { escape(&labels[column]) } else { "Value".to_owned() };
            let _ = write!(html, "<th scope=\"col\" class=\"figure\">{label}</th>");
            if has_ratio {
                let first = escape(&labels[0]);
                let _ = write!(html, "<th scope=\"col\" class=\"figure ratio\">ratio to {first}</th>");
            }
        }
        html += "</tr>\n</thead>\n<tbody>\n";
        for row in &self.rows {
            let _ = write!(html, "<tr><th scope=\"row\">{}</th>", row.name);
            for &(column, has_ratio) in &columns {
                html += &cell(row.cells.get(column).unwrap_or(&Cell::Nothing));
                if has_ratio {
                    let shown = ratio(row, column).map(|ratio| quantity(ratio, "")).unwrap_or_default();
                    let _ = write!(html, "<td class=\"figure ratio\">{shown}</td>");
                }
            }
            html += "</tr>\n";
        }
        scrolled(caption, &(html + "</tbody>\n</table>\n"))
    }
}

/// The ratio of a run's number to that of the first run.
fn ratio(row: &Row, column: usize) -> Option<f64> {
    let first = row.cells.first()?.number()?;
    let other = row.cells.get(column)?.number()?;
    let ratio = other.0 / first.0;
    (column > 0 && first.1 == other.1 && ratio.is_finite()).then_some(ratio)
}

fn cell(cell: &Cell) -> String {
    match cell {
        Cell::Nothing => "<td class=\"figure\"><span class=\"none\">none</span></td>".to_owned(),
        Cell::Number(value, unit) => format!("<td class=\"figure\">{}</td>", quantity(*value, unit)),
        Cell::Interval(value, half, unit) => {
            format!("<td class=\"figure\">{}</td>", uncertain(*value, *half, unit))
        }
        Cell::Html(html) => format!("<td>{html}</td>"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_are_to_the_first_run_and_only_between_numbers() {
        let mut sheet = Sheet::default();
        let numbers = |numbers: [f64; 2], unit: &'static str| {
            numbers.into_iter().map(Some).chain([None]).map(|number| Cell::of(number, unit)).collect()
        };
        sheet.add("rate", numbers([50.0, 65.0], "grains/s"));
        sheet.add("lost", numbers([0.0, 3.0], "grains"));
        sheet.add("absent", vec![Cell::Nothing, Cell::Nothing, Cell::Nothing]);
        let html = sheet.html("figures", &["a".to_owned(), "<b>".to_owned(), "c".to_owned()]);
        assert!(html.contains(">1.3</data>"), "{html}");
        assert_eq!(html.matches("ratio to a").count(), 1, "only the second run has numbers: {html}");
        assert_eq!(html.matches("<tr>").count(), 3, "{html}");
        assert!(html.contains("&lt;b&gt;") && !html.contains("<b>") && !html.contains("absent"), "{html}");
    }
}
