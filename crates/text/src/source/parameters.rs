//! The scene key `parameters`: named values, and expressions of them in the place of numbers.
//!
//! ```text
//! parameters: {"height": 1.2, "orifice": 0.05, "half": "= orifice / 2"},
//! spawner: (point: (0.0, "= height - half"), count: "= round(200 * height)", ...),
//! ```
//!
//! In a scene with this key, every string that begins with `=` is an expression (`source/expression.rs`), and its value takes its
//! place before the text is parsed. A whole value is written without a decimal point, so that it also serves as a count. A raw
//! string (`r"= ..."`) stays a text. A scene without this key is parsed as it is written.
//!
//! The scene in a run directory keeps its parameters and expressions. Functions such as `sin` are those of the crate `libm`, with the same
//! bits on every machine.
//!
//! Limits: 250 parameters; a parameter must not depend on itself.

use std::ops::Range;

use rustc_hash::FxHashMap;

use crate::fault::Fault;
use crate::source::expression::{self, Problem, Trouble};
use crate::source::places::{Place, Places};
use crate::suggestion::did_you_mean;

/// The scene key.
pub const KEY: &str = "parameters";

/// Most parameters of a scene.
const MOST: usize = 250;

/// A part of the scene's text, and the part of the parsed text that stands for it.
#[derive(Clone, Debug)]
struct Replaced {
    written: Range<usize>,
    parsed: Range<usize>,
}

/// A scene's text with a number in the place of each expression.
#[derive(Clone, Debug, Default)]
pub struct Resolved {
    /// The text to be parsed.
    pub text: String,
    /// The names of parameters that no expression uses, in the order of the scene.
    pub unused: Vec<String>,
    replaced: Vec<Replaced>,
}

impl Resolved {
    /// Returns the range of the scene's text for a range of the parsed text. A range that touches a number in the place of an
    /// expression includes the whole expression.
    pub(super) fn written(&self, parsed: Range<usize>) -> Range<usize> {
        let map = |offset: usize, is_end: bool| {
            let before = self.replaced.partition_point(|r| r.parsed.end <= offset);
            let inside = self.replaced.get(before).filter(|r| r.parsed.start < offset);
            match (inside, before.checked_sub(1).map(|last| &self.replaced[last])) {
                (Some(r), _) => {
                    if is_end {
                        r.written.end
                    } else {
                        r.written.start
                    }
                }
                (None, Some(last)) => offset - last.parsed.end + last.written.end,
                (None, None) => offset,
            }
        };
        let start = map(parsed.start, false);
        let end = map(parsed.end, true);
        start..end.max(start)
    }

    /// Returns the offset in the parsed text of an offset in the scene's text that is not inside an expression.
    pub(super) fn parsed(&self, written: usize) -> usize {
        let before = self.replaced.partition_point(|r| r.written.end <= written);
        let last = before.checked_sub(1).map(|last| &self.replaced[last]);
        last.map_or(written, |last| written - last.written.end + last.parsed.end)
    }
}

/// Puts numbers in the place of all expressions of a scene. Returns `None` if the scene has no parameters.
pub(super) fn resolve(name: &str, text: &str, places: &Places) -> Result<Option<Resolved>, Fault> {
    let Some(section) = places.get(KEY).filter(|section| text[section.value.clone()].starts_with('{')) else {
        return Ok(None);
    };
    let scene = Written { name, text, places };
    let parameters = scene.parameters(section)?;
    let mut values = scene.evaluate_all(&parameters)?;
    let mut resolved = Resolved::default();
    let mut copied = 0;
    for place in places.all() {
        let Some(expression) = scene.expression(place) else { continue };
        let value = scene.evaluate(place, expression, &parameters, &mut values)?;
        resolved.text.push_str(&text[copied..place.value.start]);
        let start = resolved.text.len();
        resolved.text.push_str(&number(value));
        resolved.replaced.push(Replaced { written: place.value.clone(), parsed: start..resolved.text.len() });
        copied = place.value.end;
    }
    resolved.text.push_str(&text[copied..]);
    let unused = parameters.list.iter().zip(&values.is_used).filter(|(_, is_used)| !**is_used);
    resolved.unused = unused.map(|((name, _), _)| (*name).to_owned()).collect();
    Ok(Some(resolved))
}

/// Returns a number as RON that is read as the same number. Zero has no sign, because counts have none.
fn number(value: f64) -> String {
    let value = value + 0.0;
    if (1e-5..1e15).contains(&value.abs()) || value == 0.0 { value.to_string() } else { format!("{value:e}") }
}

/// The parameters of a scene, in its order, and their numbers by name.
struct Parameters<'a> {
    list: Vec<(&'a str, &'a Place)>,
    by_name: FxHashMap<&'a str, usize>,
}

/// The known values of the parameters, and whether an expression uses them.
struct Values {
    known: Vec<Option<f64>>,
    is_used: Vec<bool>,
}

impl Values {
    /// Returns the value of a parameter, and records the use.
    fn of(&mut self, name: &str, all: &Parameters) -> Option<f64> {
        let number = *all.by_name.get(name)?;
        self.is_used[number] = true;
        self.known[number]
    }
}

struct Written<'a> {
    name: &'a str,
    text: &'a str,
    places: &'a Places,
}

impl<'a> Written<'a> {
    fn fault(&self, code: &'static str, place: &Place, message: String) -> Fault {
        let range = place.value.clone();
        Fault::new(code, message).key(self.places.path(place)).at(self.name, self.text, range)
    }

    /// Lists the parameters of a scene.
    fn parameters(&self, section: &Place) -> Result<Parameters<'a>, Fault> {
        let list: Vec<_> = self.places.entries(section).collect();
        if list.len() > MOST {
            let message = format!("a scene has at most {MOST} parameters, this one has {}", list.len());
            return Err(self
                .fault("scene::parameter", section, message)
                .help("write some values where they are needed"));
        }
        let mut by_name = FxHashMap::default();
        for (number, &(name, place)) in list.iter().enumerate() {
            let (message, help) = if expression::RESERVED.contains(&name) {
                (format!("`{name}` has a meaning of its own in expressions"), "give the parameter another name")
            } else if !expression::is_name(name) {
                (
                    format!("`{name}` cannot be used in an expression"),
                    "a name has letters, digits and `_`, and no digit first",
                )
            } else if by_name.insert(name, number).is_some() {
                ("the parameter stands here twice".to_owned(), "remove one of the two")
            } else {
                continue;
            };
            return Err(self.fault("scene::parameter", place, message).help(help));
        }
        Ok(Parameters { list, by_name })
    }

    /// Returns the text of an expression, if the value is one.
    fn expression(&self, place: &Place) -> Option<&'a str> {
        self.text[place.value.clone()].strip_prefix("\"=")?.strip_suffix('"')
    }

    /// Evaluates all parameters, each after those that it depends on.
    fn evaluate_all(&self, parameters: &Parameters) -> Result<Values, Fault> {
        let count = parameters.list.len();
        let mut values = Values { known: vec![None; count], is_used: vec![false; count] };
        for first in 0..count {
            // Each one waits for the next.
            let mut waiting = if values.known[first].is_none() { vec![first] } else { Vec::new() };
            while let Some(&current) = waiting.last() {
                let (_, place) = parameters.list[current];
                match self.value(place, parameters, &mut values)? {
                    Ok(value) => {
                        values.known[current] = Some(value);
                        waiting.pop();
                    }
                    Err(needed) if waiting.contains(&needed) => {
                        let begin = waiting.iter().position(|&number| number == needed).unwrap_or(0);
                        let circle = waiting[begin..].iter().chain([&needed]);
                        let names: Vec<_> = circle.map(|&number| parameters.list[number].0).collect();
                        let message = format!("the parameter depends on itself: {}", names.join(" needs "));
                        return Err(self.fault("scene::parameter", place, message).help("give one of them a number"));
                    }
                    Err(needed) => waiting.push(needed),
                }
            }
        }
        Ok(values)
    }

    /// Returns the value of a parameter, or the number of another one that must be known before.
    fn value(&self, place: &Place, all: &Parameters, values: &mut Values) -> Result<Result<f64, usize>, Fault> {
        let Some(expression) = self.expression(place) else {
            let text = &self.text[place.value.clone()];
            let number = ron::from_str::<f64>(text).ok().filter(|value| value.is_finite());
            return number.map(Ok).ok_or_else(|| {
                self.fault("scene::parameter", place, format!("`{text}` is neither a finite number nor an expression"))
                    .help("give a number, or an expression in a string that begins with `=`, as \"= 2 * width\"")
            });
        };
        match expression::evaluate(expression, &mut |name| values.of(name, all)) {
            Ok(value) => Ok(Ok(value)),
            Err(problem) => match &problem.0 {
                Trouble::Unknown(name) if all.by_name.contains_key(&**name) => Ok(Err(all.by_name[&**name])),
                _ => Err(self.explain(place, problem, all)),
            },
        }
    }

    /// Returns the value of an expression, once all parameters are known.
    fn evaluate(&self, place: &Place, expression: &str, all: &Parameters, values: &mut Values) -> Result<f64, Fault> {
        expression::evaluate(expression, &mut |name| values.of(name, all))
            .map_err(|problem| self.explain(place, problem, all))
    }

    /// The fault for an expression without a value.
    fn explain(&self, place: &Place, (trouble, at): Problem, all: &Parameters) -> Fault {
        let names: Vec<_> = all.list.iter().map(|(name, _)| *name).collect();
        let (message, help) = match trouble {
            Trouble::Wrong(message, help) => (message, help.to_owned()),
            Trouble::Unknown(name) if names.is_empty() => {
                (format!("there is no parameter `{name}`"), format!("define it: `parameters: {{\"{name}\": ...}}`"))
            }
            Trouble::Unknown(name) => {
                (format!("there is no parameter `{name}`"), did_you_mean("parameters", &name, &names))
            }
        };
        // The expression begins behind the quote and the sign `=`.
        let start = place.value.start + 2;
        Fault::new("scene::expression", message).help(help).key(self.places.path(place)).at(
            self.name,
            self.text,
            start + at.start..start + at.end,
        )
    }
}

/// Checks that a setting of a parameter changes one that the scene has. Otherwise a misspelt one would have no effect.
pub(super) fn check_setting(places: &Places, key: &str) -> Result<(), Fault> {
    let Some(section) = places.get(KEY) else { return Ok(()) };
    let Some(name) = key.strip_prefix(KEY).and_then(|rest| rest.strip_prefix('.')) else { return Ok(()) };
    let names: Vec<_> = places.entries(section).map(|(name, _)| name).collect();
    if names.is_empty() || names.contains(&name) {
        return Ok(());
    }
    Err(Fault::new("call::set", format!("--set {key}: there is no parameter `{name}`")).help(did_you_mean(
        "parameters",
        name,
        &names,
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn resolved(text: &str) -> Result<Resolved, Fault> {
        resolve("a.ron", text, &Places::scan(text)).map(Option::unwrap)
    }

    const TEXT: &str = r#"(
    parameters: {"b": "= 2 * a", "a": 0.25, "angle": 30, "spare": 1e-9},
    title: r"= kept",
    point: (0.0, "= -b - 1.5"), count: "= round(10 * sin(angle * deg))", until: "=a",
)"#;

    #[test]
    fn numbers_stand_in_the_place_of_expressions() {
        let resolved = resolved(TEXT).unwrap();
        let expected = r#"(
    parameters: {"b": 0.5, "a": 0.25, "angle": 30, "spare": 1e-9},
    title: r"= kept",
    point: (0.0, -2), count: 5, until: 0.25,
)"#;
        assert_eq!((resolved.text.as_str(), &resolved.unused[..]), (expected, &["spare".to_owned()][..]));
        assert!(resolve("a.ron", "(a: \"= 1\")", &Places::scan("(a: \"= 1\")")).unwrap().is_none());
    }

    #[test]
    fn every_place_of_the_parsed_text_has_a_place_in_the_scene() {
        let resolved = resolved(TEXT).unwrap();
        for (parsed, written) in
            [("0.25, \"angle\"", "0.25, \"angle\""), ("-2)", "\"= -b - 1.5\")"), ("until", "until"), (",\n)", ",\n)")]
        {
            let [p, w] = [resolved.text.find(parsed).unwrap(), TEXT.find(written).unwrap()];
            let range = resolved.written(p..p + parsed.len());
            assert_eq!(&TEXT[range], written);
            assert_eq!(resolved.parsed(w), p);
        }
        let inside = resolved.text.find("-2)").unwrap() + 1;
        assert_eq!(&TEXT[resolved.written(inside..inside)], "\"= -b - 1.5\"");
    }

    #[test]
    fn numbers_are_read_as_they_were_computed() {
        for value in [0.1 + 0.2, -1.0 / 3.0, 1e-300, 5e-324, 1.7e308, 123_456_789.0, 1e15, 0.0, 2e-5, -7.0] {
            assert_eq!(
                ron::from_str::<f64>(&number(value)).unwrap().to_bits(),
                f64::to_bits(value),
                "{}",
                number(value)
            );
        }
        assert_eq!((number(-0.0).as_str(), number(200.0).as_str()), ("0", "200"));
    }

    #[test]
    fn a_fault_points_into_the_expression() {
        for (text, key, column, message) in [
            (r#"(parameters: {"width": 1}, a: "= 2 * widht")"#, "a", 38, "there is no parameter `widht`"),
            (r#"(parameters: {"a": 1, "a": 2})"#, "parameters.a", 28, "the parameter stands here twice"),
            (r#"(parameters: {"a": true})"#, "parameters.a", 20, "neither a finite number"),
            (r#"(parameters: {"a": inf})"#, "parameters.a", 20, "neither a finite number"),
            (r#"(parameters: {"pi": 3})"#, "parameters.pi", 21, "a meaning of its own"),
            (r#"(parameters: {"a b": 3})"#, "parameters.a b", 22, "cannot be used in an expression"),
            (r#"(parameters: {"a": "= b", "b": "= c + 1", "c": "= b"})"#, "parameters.c", 48, "b needs c needs b"),
            (r#"(parameters: {"a": "= a"})"#, "parameters.a", 20, "a needs a"),
            (r#"(parameters: {"a": 0}, b: "= 1 / a")"#, "b", 34, "division by zero"),
        ] {
            let fault = resolved(text).unwrap_err();
            assert_eq!(fault.scene_key(), Some(key), "{text}");
            assert_eq!(fault.line_and_column(), Some((1, column)), "{text}: {fault}");
            assert!(fault.to_string().contains(message), "{text}: {fault}");
        }
    }

    #[test]
    fn a_long_chain_of_parameters_needs_no_deep_recursion() {
        let chain: Vec<_> = (1..MOST).map(|n| format!("\"p{n}\": \"= p{} + 1\"", n + 1)).collect();
        let text = format!("(parameters: {{{}, \"p{MOST}\": 1}}, a: \"= p1\")", chain.join(", "));
        assert!(resolved(&text).unwrap().text.ends_with("a: 250)"));
        let one_more = text.replacen('{', "{\"more\": 1, ", 1);
        assert!(resolved(&one_more).unwrap_err().to_string().contains("at most 250 parameters"));
    }
}
