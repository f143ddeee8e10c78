//! Arithmetic expressions of scenes: `height - orifice / 2`, `max(a, 2 * tan(30 * deg))`.
//!
//! | written | meaning |
//! |---|---|
//! | `+ - * /` | with the usual precedence, from left to right |
//! | `a ^ b` | power; `-2 ^ 2` is -4, and `2 ^ 3 ^ 2` is 2 ^ 9 |
//! | `sin cos tan asin acos atan` | angles in rad |
//! | `sqrt abs round floor ceil` | `round` takes halves away from zero |
//! | `min max` | of two numbers or more |
//! | `pi`, `deg` | π, and π/180: `tan(30 * deg)` |
//!
//! All numbers are 64-bit floats, and every intermediate result must be finite. An expression has at most [`LONGEST`] bytes, and
//! its brackets, signs and powers are nested at most [`DEEPEST`] deep.

use std::f64::consts::PI;
use std::ops::Range;

/// Most bytes of an expression.
pub(super) const LONGEST: usize = 1000;

/// Most levels of brackets, signs and powers.
const DEEPEST: usize = 50;

/// The names that have a meaning of their own.
pub(super) const RESERVED: [&str; 15] =
    ["pi", "deg", "sin", "cos", "tan", "asin", "acos", "atan", "sqrt", "abs", "round", "floor", "ceil", "min", "max"];

/// Why an expression has no value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Trouble {
    /// The value of a name is not known.
    Unknown(String),
    /// It is not an expression, or a result is not finite. In words, with a remedy.
    Wrong(String, &'static str),
}

/// A trouble and its byte range in the expression.
pub(super) type Problem = (Trouble, Range<usize>);

/// Returns the value of an expression. `value_of` returns the values of names.
pub(super) fn evaluate(text: &str, value_of: &mut dyn FnMut(&str) -> Option<f64>) -> Result<f64, Problem> {
    if text.len() > LONGEST {
        let message = format!("an expression has at most {LONGEST} bytes, this one has {}", text.len());
        return Err((Trouble::Wrong(message, "define parts of it as further parameters"), 0..text.len()));
    }
    let mut parser = Parser { text, at: 0, depth: 0, value_of };
    let value = parser.sum()?;
    if parser.at < text.len() {
        return Err(parser.unexpected("an operator or the end"));
    }
    Ok(value)
}

/// Whether a text can name a parameter.
pub(super) fn is_name(text: &str) -> bool {
    text.starts_with(begins_name) && text.chars().all(continues_name)
}

fn begins_name(c: char) -> bool {
    c.is_alphabetic() || c == '_'
}

fn continues_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Parses and evaluates in one pass. Every method leaves blanks skipped behind what it has read.
struct Parser<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
    value_of: &'a mut dyn FnMut(&str) -> Option<f64>,
}

impl Parser<'_> {
    fn sum(&mut self) -> Result<f64, Problem> {
        self.skip_blanks();
        let start = self.at;
        let mut value = self.product()?;
        while let Some(sign) = self.skip_any(['+', '-']) {
            let right = self.product()?;
            value = self.finite(if sign == '+' { value + right } else { value - right }, start)?;
        }
        Ok(value)
    }

    fn product(&mut self) -> Result<f64, Problem> {
        let start = self.at;
        let mut value = self.signed()?;
        while let Some(operator) = self.skip_any(['*', '/']) {
            let divisor = self.at;
            let right = self.signed()?;
            if operator == '/' && right == 0.0 {
                let zero = divisor..self.end_of_read();
                return Err((Trouble::Wrong("division by zero".to_owned(), "give a divisor other than 0"), zero));
            }
            value = self.finite(if operator == '*' { value * right } else { value / right }, start)?;
        }
        Ok(value)
    }

    fn signed(&mut self) -> Result<f64, Problem> {
        match self.skip_any(['-', '+']) {
            Some(sign) => {
                let value = self.deeper(Self::signed)?;
                Ok(if sign == '-' { -value } else { value })
            }
            None => self.power(),
        }
    }

    fn power(&mut self) -> Result<f64, Problem> {
        let start = self.at;
        let base = self.atom()?;
        if self.skip_any(['^']).is_none() {
            return Ok(base);
        }
        let exponent = self.deeper(Self::signed)?;
        self.finite(libm::pow(base, exponent), start)
    }

    fn atom(&mut self) -> Result<f64, Problem> {
        match self.text[self.at..].chars().next() {
            Some('(') => Ok(self.bracket(false)?[0]),
            Some('0'..='9' | '.') => self.number(),
            Some(c) if begins_name(c) => self.name(),
            _ => Err(self.unexpected("a number, a name or a bracket")),
        }
    }

    fn number(&mut self) -> Result<f64, Problem> {
        let start = self.at;
        let rest = &self.text[start..];
        let digits = |text: &str| text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
        let mut end = rest.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(rest.len());
        if let Some(exponent) = rest[end..].strip_prefix(['e', 'E']) {
            let sign = usize::from(exponent.starts_with(['+', '-']));
            let count = digits(&exponent[sign..]);
            end += if count > 0 { 1 + sign + count } else { 0 };
        }
        self.at += end;
        let place = start..self.at;
        let wrong = |message: String| (Trouble::Wrong(message, "write numbers such as 0.05 or 1.0e-3"), place.clone());
        let value: f64 = rest[..end].parse().map_err(|_| wrong(format!("`{}` is not a number", &rest[..end])))?;
        if !value.is_finite() {
            return Err(wrong(format!("`{}` is too large", &rest[..end])));
        }
        self.skip_blanks();
        Ok(value)
    }

    /// A name alone, or a function and its arguments.
    fn name(&mut self) -> Result<f64, Problem> {
        let start = self.at;
        let rest = &self.text[start..];
        let name = &rest[..rest.find(|c| !continues_name(c)).unwrap_or(rest.len())];
        let place = start..start + name.len();
        self.at = place.end;
        self.skip_blanks();
        if self.text[self.at..].starts_with('(') {
            return self.call(name, place);
        }
        match name {
            "pi" => Ok(PI),
            "deg" => Ok(PI / 180.0),
            _ if RESERVED.contains(&name) => {
                let message = format!("`{name}` is a function");
                Err((Trouble::Wrong(message, "write its arguments in brackets, as in `sqrt(2)`"), place))
            }
            _ => (self.value_of)(name).ok_or((Trouble::Unknown(name.to_owned()), place)),
        }
    }

    fn call(&mut self, name: &str, place: Range<usize>) -> Result<f64, Problem> {
        let start = place.start;
        let wrong = |message: String, help| Err((Trouble::Wrong(message, help), place.clone()));
        if !RESERVED[2..].contains(&name) {
            return wrong(
                format!("there is no function `{name}`"),
                "the functions are sin, cos, tan, asin, acos, atan, sqrt, abs, round, floor, ceil, min and max",
            );
        }
        let arguments = self.bracket(true)?;
        let many = matches!(name, "min" | "max");
        if many != (arguments.len() > 1) {
            let wanted = if many { "two numbers or more" } else { "one number" };
            let message = format!("`{name}` takes {wanted}, got {}", arguments.len());
            return wrong(message, "separate the arguments by commas");
        }
        let x = arguments[0];
        let value = match name {
            "sin" => libm::sin(x),
            "cos" => libm::cos(x),
            "tan" => libm::tan(x),
            "asin" => libm::asin(x),
            "acos" => libm::acos(x),
            "atan" => libm::atan(x),
            "sqrt" => x.sqrt(),
            "abs" => x.abs(),
            "round" => x.round(),
            "floor" => x.floor(),
            "ceil" => x.ceil(),
            "min" => arguments.iter().copied().fold(x, f64::min),
            _ => arguments.iter().copied().fold(x, f64::max),
        };
        self.finite(value, start)
    }

    /// Reads a bracket: one expression, or with `many` one or more between commas.
    fn bracket(&mut self, many: bool) -> Result<Vec<f64>, Problem> {
        self.at += 1;
        let mut values = Vec::new();
        loop {
            values.push(self.deeper(Self::sum)?);
            if !many || self.skip_any([',']).is_none() {
                break;
            }
        }
        if self.skip_any([')']).is_none() {
            return Err(self.unexpected("`)`"));
        }
        Ok(values)
    }

    /// Parses one level deeper.
    fn deeper(&mut self, parse: fn(&mut Self) -> Result<f64, Problem>) -> Result<f64, Problem> {
        if self.depth == DEEPEST {
            let message = format!("more than {DEEPEST} brackets, signs and powers within each other");
            return Err((Trouble::Wrong(message, "define the inner part as a further parameter"), self.at..self.at));
        }
        self.depth += 1;
        let value = parse(self);
        self.depth -= 1;
        value
    }

    /// Returns a value that began at `start`, if it is finite.
    fn finite(&self, value: f64, start: usize) -> Result<f64, Problem> {
        if value.is_finite() {
            return Ok(value);
        }
        let message = format!("the result is not a finite number, but {value}");
        Err((Trouble::Wrong(message, "is the argument in its range? Angles are in rad"), start..self.end_of_read()))
    }

    /// The end of what has been read, without the blanks behind it.
    fn end_of_read(&self) -> usize {
        self.text[..self.at].trim_end().len()
    }

    fn unexpected(&self, wanted: &str) -> Problem {
        let next = self.text[self.at..].chars().next();
        let found = next.map_or("the end".to_owned(), |c| format!("`{c}`"));
        let help = "an expression is written like `(height - orifice) / 2`";
        (
            Trouble::Wrong(format!("expected {wanted}, got {found}"), help),
            self.at..self.at + next.map_or(0, char::len_utf8),
        )
    }

    /// Skips one of these characters and the blanks behind it.
    fn skip_any<const N: usize>(&mut self, any: [char; N]) -> Option<char> {
        let c = self.text[self.at..].chars().next().filter(|c| any.contains(c))?;
        self.at += c.len_utf8();
        self.skip_blanks();
        Some(c)
    }

    fn skip_blanks(&mut self) {
        self.at = self.text.len() - self.text[self.at..].trim_start().len();
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn value(text: &str) -> Result<f64, Problem> {
        evaluate(text, &mut |name| (name == "width").then_some(0.3))
    }

    #[test]
    fn arithmetic_follows_the_usual_rules() {
        for (text, expected) in [
            ("1 + 2 * 3 - 4 / 2", 5.0),
            ("2 - 3 - 4", -5.0),
            ("2 / 4 / 5", 0.1),
            ("-2 ^ 2", -4.0),
            ("2 ^ 3 ^ 2", 512.0),
            ("2 ^ -1", 0.5),
            ("(1 + 2) * -3", -9.0),
            ("--2", 2.0),
            ("1.5e1 + .5 + 2.", 17.5),
            (" width / 2 ", 0.15),
            ("min(3, width, 2) + max(1, 2)", 2.3),
            ("sqrt(2 * 8) + abs(-1) + round(2.5) + floor(1.9) + ceil(0.1)", 10.0),
        ] {
            assert_eq!(value(text).map(f64::to_bits), Ok(f64::to_bits(expected)), "{text}");
        }
        for (text, expected) in [
            ("tan(45 * deg)", 1.0),
            ("sin(pi / 6) + cos(60 * deg)", 1.0),
            ("asin(1) / deg", 90.0),
            ("acos(0) / deg", 90.0),
            ("4 * atan(1)", PI),
        ] {
            assert!((value(text).unwrap() - expected).abs() < 1e-13, "{text}");
        }
    }

    #[test]
    fn a_problem_names_its_place() {
        for (text, expected, place) in [
            ("1 + wdth", None, 4..8),
            ("1 / (width - 0.3) + 1", Some("division by zero"), 4..17),
            ("2 * sqrt(-1)", Some("the result is not a finite number, but NaN"), 4..12),
            ("10 ^ 400", Some("the result is not a finite number, but inf"), 0..8),
            ("1e400", Some("`1e400` is too large"), 0..5),
            ("1.2.3", Some("`1.2.3` is not a number"), 0..5),
            ("1 +", Some("expected a number, a name or a bracket, got the end"), 3..3),
            ("(1 + 2", Some("expected `)`, got the end"), 6..6),
            ("1 2", Some("expected an operator or the end, got `2`"), 2..3),
            ("2e", Some("expected an operator or the end, got `e`"), 1..2),
            ("sin", Some("`sin` is a function"), 0..3),
            ("sinh(1)", Some("there is no function `sinh`"), 0..4),
            ("pi(1)", Some("there is no function `pi`"), 0..2),
            ("1 + sin(1, 2)", Some("`sin` takes one number, got 2"), 4..7),
            ("max(1)", Some("`max` takes two numbers or more, got 1"), 0..3),
            ("", Some("expected a number, a name or a bracket, got the end"), 0..0),
        ] {
            let (trouble, at) = value(text).unwrap_err();
            let message = match trouble {
                Trouble::Unknown(_) => None,
                Trouble::Wrong(message, _) => Some(message),
            };
            assert_eq!((message.as_deref(), at), (expected, place), "{text}");
        }
    }

    #[test]
    fn depth_and_length_are_bounded() {
        for text in ["(".repeat(900), "-".repeat(900), "2^".repeat(450), "abs(".repeat(240)] {
            assert!(
                matches!(value(&text), Err((Trouble::Wrong(message, _), _)) if message.contains("within each other"))
            );
        }
        assert!(
            matches!(value(&"1+".repeat(600)), Err((Trouble::Wrong(message, _), _)) if message.contains("at most"))
        );
        assert_eq!(value(&(("(".repeat(40) + "1") + &")".repeat(40))), Ok(1.0));
    }

    proptest! {
        #[test]
        fn any_text_has_a_value_or_a_problem_inside_it(text in "[a-z0-9+*/^(),. éwidth-]{0,40}") {
            match value(&text) {
                Ok(value) => prop_assert!(value.is_finite()),
                Err((_, at)) => prop_assert!(text.get(at).is_some()),
            }
        }
    }
}
