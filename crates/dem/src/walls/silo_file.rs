//! Reader of the assignment's silo file.
//!
//! The first line holds the numbers of wall grains and of door grains. One line per grain follows, wall grains first:
//! x, y and radius, in the `unit` that the scene states (cm for the assignment's file).
//!
//! ```text
//! 183 5
//! -1.300e+02 4.000e+02 3.000e+00
//! ...
//! ```
//!
//! Blank lines at the end are ignored. Any other malformed line is an error with its line and column.

use std::ops::Range;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::space::Vector;
use crate::values::LengthUnit;
use siloflow_text::fault::Fault;

/// The scene key `silo`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Silo {
    /// Path of the silo file, relative to the scene file.
    pub file: PathBuf,
    /// Unit of the numbers in the file.
    pub unit: LengthUnit,
    /// Material. Default 0.
    #[serde(default)]
    pub species: u8,
}

/// A fixed disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Centre, m.
    pub centre: Vector,
    /// Radius, m.
    pub radius: f64,
}

/// Geometry of a silo, SI.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SiloGeometry {
    /// Wall discs, in the order of the file.
    pub wall: Vec<Disc>,
    /// Door discs, in the order of the file.
    pub door: Vec<Disc>,
}

/// A word of the file, with its byte range.
struct Word<'a> {
    text: &'a str,
    range: Range<usize>,
}

/// Parses the text of a silo file. `name` is the file's name in messages.
///
/// # Errors
/// If a count is wrong, a line is missing or surplus, a word is not a finite number, or a radius is not positive. The
/// fault points at the place.
pub fn parse(name: &str, text: &str, unit: LengthUnit) -> Result<SiloGeometry, Fault> {
    let fault = |code, range: Range<usize>, message: String, help: &str| {
        Err(Fault::new(code, message).help(help).at(name, text, range))
    };
    let mut lines = lines(text);
    let (_, header) = lines.next().unwrap_or((0..text.len(), Vec::new()));
    let [walls, doors] = header.as_slice() else {
        return fault(
            "silo_file::header",
            first_line(text),
            format!(
                "the first line must hold two counts, of wall grains and of door grains; it holds {}",
                header.len()
            ),
            "write for example `183 5`",
        );
    };
    let mut counts = [0usize; 2];
    for (count, word) in counts.iter_mut().zip([walls, doors]) {
        let Ok(number) = word.text.parse() else {
            let message = format!("expected a whole number of grains, got `{}`", word.text);
            return fault("silo_file::header", word.range.clone(), message, "counts are written like `183`");
        };
        *count = number;
    }
    let [walls, doors] = counts;
    let expected = walls.saturating_add(doors);
    let mut discs = Vec::new();
    for (range, words) in lines {
        if discs.len() == expected {
            let message = format!("surplus line: the header announces {walls} + {doors} = {expected} grains");
            return fault(
                "silo_file::surplus_line",
                range,
                message,
                "remove the line, or raise a count in the first line",
            );
        }
        let [x, y, radius] = words.as_slice() else {
            let message = format!("expected three numbers (x, y, radius), got {}", words.len());
            return fault("silo_file::columns", range, message, "one grain per line: x y radius");
        };
        let mut values = [0.0; 3];
        for (value, word) in values.iter_mut().zip([x, y, radius]) {
            match word.text.parse::<f64>() {
                Ok(number) if number.is_finite() => *value = number / unit.per_metre(),
                _ => {
                    let message = format!("expected a finite number, got `{}`", word.text);
                    return fault(
                        "silo_file::number",
                        word.range.clone(),
                        message,
                        "numbers are written like `-1.300e+02`",
                    );
                }
            }
        }
        let [x, y, r] = values;
        if r <= 0.0 {
            let message = format!("expected a radius greater than 0, got {}", radius.text);
            return fault(
                "silo_file::radius",
                radius.range.clone(),
                message,
                "the third number of a line is the radius",
            );
        }
        discs.push(Disc { centre: Vector::new(x, y), radius: r });
    }
    if discs.len() < expected {
        let message = format!(
            "{} lines are missing: the header announces {walls} + {doors} = {expected} grains, {} follow",
            expected - discs.len(),
            discs.len()
        );
        let end = text.trim_end().len();
        return fault(
            "silo_file::missing_line",
            end..end,
            message,
            "add the lines, or lower a count in the first line",
        );
    }
    let door = discs.split_off(walls);
    Ok(SiloGeometry { wall: discs, door })
}

/// Returns the byte range of the first line.
fn first_line(text: &str) -> Range<usize> {
    0..text.find('\n').unwrap_or(text.len())
}

/// Returns byte range and words of each line, up to the last line that is not blank.
fn lines(text: &str) -> impl Iterator<Item = (Range<usize>, Vec<Word<'_>>)> {
    let offset_of = move |part: &str| part.as_ptr() as usize - text.as_ptr() as usize;
    text.trim_end().lines().map(move |line| {
        let words = line.split_whitespace().map(|word| {
            let start = offset_of(word);
            Word { text: word, range: start..start + word.len() }
        });
        let start = offset_of(line);
        (start..start + line.len(), words.collect())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = "2 1\n-130 400 3\n1.3e2 4e2 3.0\n0 0 2.5\n\n";

    #[test]
    fn reads_centimetres_into_metres() {
        let silo = parse("good.dat", GOOD, LengthUnit::Centimetre).unwrap();
        assert_eq!(silo.wall[0], Disc { centre: Vector::new(-1.3, 4.0), radius: 0.03 });
        assert_eq!(silo.wall.len(), 2);
        assert_eq!(silo.door, [Disc { centre: Vector::ZERO, radius: 0.025 }]);
    }

    #[test]
    fn faults_point_at_the_wrong_line_and_column() {
        let cases = [
            ("2", "silo_file::header", (1, 1)),
            ("", "silo_file::header", (1, 1)),
            ("2 x\n", "silo_file::header", (1, 3)),
            ("-2 1\n", "silo_file::header", (1, 1)),
            ("1 0\n0 0\n", "silo_file::columns", (2, 1)),
            ("1 0\n0 0 1 7\n", "silo_file::columns", (2, 1)),
            ("1 0\n0 zero 1\n", "silo_file::number", (2, 3)),
            ("1 0\n0 NaN 1\n", "silo_file::number", (2, 3)),
            ("1 0\n0 0 -1\n", "silo_file::radius", (2, 5)),
            ("1 1\n0 0 1\n", "silo_file::missing_line", (2, 6)),
            ("1 0\n0 0 1\n1 1 1\n", "silo_file::surplus_line", (3, 1)),
            ("2 0\n0 0 1\n\n1 1 1\n", "silo_file::columns", (3, 1)),
        ];
        for (text, code, place) in cases {
            let fault = parse("bad.dat", text, LengthUnit::Metre).unwrap_err();
            assert_eq!((fault.code(), fault.line_and_column()), (code, Some(place)), "{text:?}: {fault}");
        }
    }

    #[test]
    fn a_header_of_absurd_size_is_a_missing_line() {
        let text = format!("{} {}\n", usize::MAX, usize::MAX);
        assert_eq!(parse("x", &text, LengthUnit::Metre).unwrap_err().code(), "silo_file::missing_line");
    }
}
