//! Pieces of HTML: escaped text, and numbers with their units.
//!
//! Text from scenes and files goes through [`escape`]: markup is escaped, and characters on which a terminal or the direction of
//! writing would act are shown as `\u{...}`. Attributes are always in double quotes.
//!
//! A number is rounded to four digits. The element `data` that holds it has all its digits in `value`, and in the title with the unit.

use std::fmt::Write as _;

use siloflow_text::safe::{for_terminal, for_xml};

/// Most characters of a value that a table shows.
const LONGEST_VALUE: usize = 120;

/// Returns text as it stands in an element or in an attribute in double quotes.
#[must_use]
pub fn escape(text: &str) -> String {
    for_xml(&for_terminal(text))
}

/// Returns a value of a scene, cut and escaped, as code.
#[must_use]
pub fn code(text: &str) -> String {
    format!("<code>{}</code>", escape(&siloflow_text::safe::cut(text, LONGEST_VALUE)))
}

/// Returns a message as HTML, with what it puts between backticks as code.
#[must_use]
pub fn message(text: &str) -> String {
    let escaped = escape(text);
    if escaped.matches('`').count() % 2 == 1 {
        return escaped;
    }
    let part = |(number, part): (usize, &str)| match number % 2 {
        0 => part.to_owned(),
        _ => format!("<code>{part}</code>"),
    };
    escaped.split('`').enumerate().map(part).collect()
}

/// Returns a number with its unit. The unit may be empty.
#[must_use]
pub fn quantity(value: f64, unit: &str) -> String {
    let shown = rounded(value);
    let unit = escape(unit);
    let gap = if unit.is_empty() { "" } else { " " };
    let whole = if unit == "%" { format!("{value}\u{202f}%") } else { format!("{value}{gap}{unit}") };
    format!(
        "<data value=\"{value}\" title=\"{whole}\">{shown}</data>{gap}{}",
        if unit.is_empty() { String::new() } else { format!("<span class=\"unit\">{unit}</span>") }
    )
}

/// Returns a number rounded to four digits: with commas between thousands, or with a power of ten.
#[must_use]
pub fn rounded(value: f64) -> String {
    if !value.is_finite() {
        return if value.is_nan() { "not a number".to_owned() } else { "infinite".to_owned() };
    }
    let minus = if value < 0.0 { "\u{2212}" } else { "" };
    let size = value.abs();
    if size == 0.0 {
        return "0".to_owned();
    }
    let is_count = size.fract() == 0.0 && size < 1e15;
    if is_count || (1e-3..1e5).contains(&size) {
        // The number of decimals that makes four digits.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 0 and 7")]
        let decimals = if is_count { 0 } else { (3.0 - size.log10().floor()).clamp(0.0, 7.0) as usize };
        return minus.to_owned() + &grouped(trimmed(&format!("{size:.decimals$}")));
    }
    let text = format!("{size:.3e}");
    let (digits, power) = text.split_once('e').unwrap_or((&text, "0"));
    format!("{minus}{} × 10<sup>{}</sup>", trimmed(digits), power.replace('-', "\u{2212}"))
}

/// Returns a number with the half-width of its confidence interval, both rounded to two digits of the half-width.
#[must_use]
pub fn uncertain(value: f64, half: f64, unit: &str) -> String {
    let power = half.abs().log10().floor();
    if !(power > -6.0 && power < 5.0 && value.abs() < 1e6) {
        return format!("{} ± {}", quantity(value, ""), quantity(half, unit));
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 0 and 7")]
    let decimals = (1.0 - power).max(0.0) as usize;
    let shown = |x: f64| {
        let minus = if x < 0.0 { "\u{2212}" } else { "" };
        minus.to_owned() + &grouped(&format!("{:.decimals$}", x.abs()))
    };
    let unit = escape(unit);
    format!(
        "<data value=\"{value}\" title=\"{value} ± {half} {unit}\">{} ± {}</data> <span class=\"unit\">{unit}</span>",
        shown(value),
        shown(half)
    )
}

/// Removes zeros at the end of decimals.
fn trimmed(digits: &str) -> &str {
    if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.') } else { digits }
}

/// Puts commas between groups of three digits before the point.
fn grouped(digits: &str) -> String {
    let (whole, rest) = digits.split_at(digits.find('.').unwrap_or(digits.len()));
    let mut text = String::new();
    for (number, digit) in whole.chars().enumerate() {
        if number > 0 && (whole.len() - number).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text + rest
}

/// Returns a box of its own for something wide, which can be scrolled with the keyboard. `label` is plain text.
#[must_use]
pub fn scrolled(label: &str, content: &str) -> String {
    format!("<div class=\"scroll\" role=\"region\" tabindex=\"0\" aria-label=\"{}\">\n{content}</div>\n", escape(label))
}

/// A section of a page.
#[derive(Clone, Debug)]
pub struct Section {
    /// Its id.
    pub id: &'static str,
    /// Its heading.
    pub heading: &'static str,
    /// Its content, as HTML.
    pub content: String,
}

impl Section {
    /// Returns a section, or nothing without content.
    #[must_use]
    pub fn of(id: &'static str, heading: &'static str, content: String) -> Option<Self> {
        (!content.is_empty()).then_some(Self { id, heading, content })
    }

    /// Returns the section as HTML.
    #[must_use]
    pub fn html(&self) -> String {
        let Self { id, heading, content } = self;
        format!(
            "<section id=\"{id}\" aria-labelledby=\"{id}-title\">\n<h2 id=\"{id}-title\">{heading}</h2>\n{content}</section>\n"
        )
    }
}

/// Returns a list of items that are HTML; nothing if there is none.
#[must_use]
pub fn list(items: &[String]) -> String {
    if items.is_empty() {
        return String::new();
    }
    let mut html = "<ul>\n".to_owned();
    for item in items {
        let _ = writeln!(html, "<li>{item}</li>");
    }
    html + "</ul>\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded_to_four_digits_and_keep_all_in_the_title() {
        for (value, expected) in [
            (0.0, "0"),
            (-0.0, "0"),
            (72624.0, "72,624"),
            (1_234_567.0, "1,234,567"),
            (51.579_321, "51.58"),
            (0.0400, "0.04"),
            (-12_345.678, "\u{2212}12,346"),
            (0.001_234_56, "0.001235"),
            (6.25e-5, "6.25 × 10<sup>\u{2212}5</sup>"),
            (-123_456.7, "\u{2212}1.235 × 10<sup>5</sup>"),
            (99_999.6, "100,000"),
            (f64::NAN, "not a number"),
        ] {
            assert_eq!(rounded(value), expected, "{value}");
        }
        assert_eq!(
            quantity(51.579_321, "grains/s"),
            "<data value=\"51.579321\" title=\"51.579321 grains/s\">51.58</data> <span class=\"unit\">grains/s</span>"
        );
    }

    #[test]
    fn an_uncertain_number_has_the_digits_that_are_known() {
        let shown = |value, half| uncertain(value, half, "kg/s");
        assert!(shown(35.5213, 3.7062).contains(">35.5 ± 3.7<"), "{}", shown(35.5213, 3.7062));
        assert!(shown(8.31, 0.041).contains(">8.310 ± 0.041<"));
        assert!(shown(12_345.0, 230.0).contains(">12,345 ± 230<"));
        assert!(shown(5.0, 0.0).contains(">5</data> ± "), "{}", shown(5.0, 0.0));
    }

    #[test]
    fn what_a_message_quotes_is_code() {
        assert_eq!(message("raise `until`, or `<b>`"), "raise <code>until</code>, or <code>&lt;b&gt;</code>");
        assert_eq!(message("an odd `"), "an odd `");
    }

    #[test]
    fn hostile_text_stays_text() {
        assert_eq!(
            escape("</script><b onclick='x'>\"\u{202e}\u{7}"),
            "&lt;/script&gt;&lt;b onclick='x'&gt;&quot;\\u{202e}\\u{7}"
        );
    }
}
