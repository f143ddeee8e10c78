//! Figures of a run: numbers in its `summary.json`, named by their paths, for example `discharge.rate_per_s` or `feed[0].rate_per_s`.
//!
//! | status of the run | figures that count |
//! |---|---|
//! | a regular end | all |
//! | `clogged` | all but the rates of the discharge: an outlet that is blocked has none |
//! | `failed`, `grains_lost` | none |

use std::collections::BTreeSet;

use serde_json::Value;

use siloflow_text::suggestion::did_you_mean;

/// The schema of the summary of a run of grains.
const SCHEMA: &str = include_str!("../../../docs/reference/summary.schema.json");

/// Sections of a summary that a clogged run has no figures of.
const RATES: [&str; 2] = ["discharge", "outflow"];

/// Whether a status is that of a failed run, which has no figures.
#[must_use]
pub fn is_failure(status: &str) -> bool {
    matches!(status, "failed" | "grains_lost")
}

/// The part of the path of a figure.
enum Segment<'a> {
    Key(&'a str),
    Element(usize),
}

/// Splits a path; `None` if it is none.
fn segments(path: &str) -> Option<Vec<Segment<'_>>> {
    let mut all = Vec::new();
    for part in path.split('.') {
        let (key, rest) = part.split_at(part.find('[').unwrap_or(part.len()));
        if key.is_empty() {
            return None;
        }
        all.push(Segment::Key(key));
        for element in rest.split_terminator(']') {
            all.push(Segment::Element(element.strip_prefix('[')?.parse().ok()?));
        }
    }
    Some(all)
}

/// Checks that a summary of a run of grains can have a number at this path.
///
/// # Errors
/// A message and a help.
pub fn check(path: &str) -> Result<(), (String, String)> {
    let Some(segments) = segments(path) else {
        let help = "for example `discharge.rate_per_s`, or `avalanches[0].grains`".to_owned();
        return Err((format!("`{path}` is no path in summary.json"), help));
    };
    let Ok(schema) = serde_json::from_str::<Value>(SCHEMA) else { return Ok(()) };
    let mut at = &schema;
    for segment in segments {
        at = match segment {
            Segment::Element(_) => &at["items"],
            Segment::Key(key) => match (&at["properties"], &at["additionalProperties"]) {
                (Value::Object(keys), _) if keys.contains_key(key) => &keys[key],
                // Names that the scene or a behaviour chooses.
                (_, Value::Object(_) | Value::Bool(true)) => return Ok(()),
                (Value::Object(keys), _) => {
                    let names: Vec<_> = keys.keys().map(String::as_str).collect();
                    return Err((format!("summary.json has no key `{key}` there"), did_you_mean("keys", key, &names)));
                }
                _ => &Value::Null,
            },
        };
        if at.is_null() {
            return Err((
                format!("`{path}` is no path in summary.json"),
                "the page run-directory.md lists its keys".to_owned(),
            ));
        }
    }
    let is_number = |kind: &Value| matches!(kind.as_str(), Some("number" | "integer"));
    let numbers = match &at["type"] {
        Value::Array(kinds) => kinds.iter().any(is_number),
        kind => is_number(kind),
    };
    let keys = at["properties"].as_object().map(|keys| keys.keys().cloned().collect::<Vec<_>>().join(", "));
    match (numbers, keys) {
        (true, _) => Ok(()),
        (false, Some(keys)) => Err((format!("`{path}` is a section of summary.json"), format!("its keys are: {keys}"))),
        (false, None) => {
            Err((format!("`{path}` in summary.json is no number"), "a table has means of numbers".to_owned()))
        }
    }
}

/// Returns the number at a path of a summary.
fn number<'a>(summary: &'a Value, path: &str) -> Option<&'a serde_json::Number> {
    let mut at = summary;
    for segment in segments(path)? {
        at = match segment {
            Segment::Key(key) => at.get(key)?,
            Segment::Element(number) => at.get(number)?,
        };
    }
    match at {
        Value::Number(number) => Some(number),
        _ => None,
    }
}

/// Returns a figure of a run as its summary writes it; `None` if the run has no such figure, or if the figure does not count.
#[must_use]
pub fn figure(summary: &Value, path: &str) -> Option<String> {
    let section = path.split(['.', '[']).next().unwrap_or_default();
    match summary["status"].as_str()? {
        "interrupted" => None,
        status if is_failure(status) => None,
        "clogged" if RATES.contains(&section) => None,
        _ => number(summary, path).map(ToString::to_string),
    }
}

/// Returns the paths of all numbers in a summary, without those of single lost grains.
#[must_use]
pub fn paths(summary: &Value) -> BTreeSet<String> {
    fn add(at: &Value, path: &str, all: &mut BTreeSet<String>) {
        match at {
            Value::Number(_) => {
                all.insert(path.to_owned());
            }
            Value::Object(keys) => {
                let longer = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
                keys.iter().for_each(|(key, value)| add(value, &longer(key), all));
            }
            Value::Array(list) if path != "losses" => {
                list.iter().enumerate().for_each(|(n, value)| add(value, &format!("{path}[{n}]"), all));
            }
            _ => {}
        }
    }
    let mut all = BTreeSet::new();
    add(summary, "", &mut all);
    all
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn paths_that_no_summary_has_are_refused_with_a_help() {
        for path in
            ["discharge.rate_per_s", "rest_time_s", "parameters.width", "behaviours.heat.total", "avalanches[0].grains"]
        {
            check(path).unwrap_or_else(|fault| panic!("{path}: {fault:?}"));
        }
        assert!(check("discharge.rate_pers").unwrap_err().1.contains("`rate_per_s`"));
        assert!(check("discharge").unwrap_err().0.contains("section"));
        assert!(check("status").unwrap_err().0.contains("no number"));
        assert!(check("steps.of").unwrap_err().0.contains("no path"));
        assert!(check("a..b").unwrap_err().0.contains("no path"));
    }

    #[test]
    fn a_clogged_run_has_no_rate_and_a_failed_one_no_figure() {
        let summary = |status: &str| json!({"status": status, "steps": 7, "discharge": {"rate_per_s": 0.5}, "feed": [{"kg": 2.0}]});
        let figures = |status: &str| {
            ["discharge.rate_per_s", "steps", "feed[0].kg"]
                .map(|path| figure(&summary(status), path).unwrap_or_default())
        };
        assert_eq!(figures("empty"), ["0.5", "7", "2.0"]);
        assert_eq!(figures("clogged"), ["", "7", "2.0"]);
        assert_eq!(figures("failed"), ["", "", ""]);
        assert_eq!(figures("grains_lost"), ["", "", ""]);
        assert_eq!(Vec::from_iter(paths(&summary("empty"))), ["discharge.rate_per_s", "feed[0].kg", "steps"]);
    }
}
