//! The keys in which the scenes of several runs differ, and the files that they name.
//!
//! Values are compared as written. A key is shown with its innermost value, or if scenes make another choice, such as `contact: Linear(...)`
//! and `contact: Hertz(...)`, with the whole one.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use crate::report::html::{Section, code, escape, scrolled};
use crate::report::run::Run;
use siloflow_files::fnv::Fnv;
use siloflow_files::own_files;
use siloflow_text::file;
use siloflow_text::source::places::Places;

/// Most rows of the table.
const MOST_ROWS: usize = 200;

/// The section of differences; nothing for a single run.
#[must_use]
pub fn section_of(runs: &[Run]) -> Option<Section> {
    if runs.len() < 2 {
        return None;
    }
    let scenes: Vec<_> = runs.iter().map(values).collect();
    let rows = differing(&scenes);
    let content = if rows.is_empty() {
        "<p>The scenes have the same keys and values, and the same files.</p>\n".to_owned()
    } else {
        table(runs, &rows)
    };
    Section::of("differences", "Differences of the scenes", content)
}

/// A value of a scene.
#[derive(Clone, Debug, PartialEq)]
struct Written {
    /// The value without what it holds: the name of a choice, or a bracket.
    outer: String,
    /// The whole value in one line.
    whole: String,
}

/// A key, and its value in each scene.
type Row = (String, Vec<Option<String>>);

/// Returns the keys whose values are not the same in all scenes. Numbers are compared as numbers. Where the outer parts of values
/// differ, or a scene has no such key, what the values hold is not listed by itself.
fn differing(scenes: &[BTreeMap<String, Written>]) -> Vec<Row> {
    let keys: BTreeSet<_> = scenes.iter().flat_map(BTreeMap::keys).collect();
    let is_same = |a: Option<&Written>, b: Option<&Written>| match (a, b) {
        (Some(a), Some(b)) => {
            let numbers = a.outer.parse::<f64>().ok().zip(b.outer.parse::<f64>().ok());
            a.outer == b.outer || numbers.is_some_and(|(a, b)| a.total_cmp(&b).is_eq())
        }
        (a, b) => a.is_none() && b.is_none(),
    };
    let mut rows: Vec<Row> = Vec::new();
    for key in keys {
        let is_inside = |outer: &str| key.strip_prefix(outer).is_some_and(|rest| rest.starts_with(['.', '[']));
        let values: Vec<_> = scenes.iter().map(|scene| scene.get(key)).collect();
        let is_same = values.windows(2).all(|two| is_same(two[0], two[1]));
        if !is_same && !rows.iter().any(|(outer, _)| is_inside(outer)) {
            rows.push((key.clone(), values.iter().map(|value| value.map(|value| value.whole.clone())).collect()));
        }
    }
    rows
}

/// Returns the values of a scene by key, and for each of its files a hash of its content.
fn values(run: &Run) -> BTreeMap<String, Written> {
    let mut values = written(&run.scene_text);
    let entries = std::fs::read_dir(&run.files.directory).into_iter().flatten().filter_map(Result::ok);
    for name in entries.filter_map(|entry| entry.file_name().into_string().ok()) {
        let is_input = name.starts_with("input-");
        if is_input && let Ok(bytes) = own_files::read_bytes(&run.files.directory.join(&name), file::GRAIN_BYTES) {
            let mut hash = Fnv::default();
            hash.update(&bytes);
            let text = format!("content with the hash {:016x}", hash.value());
            values.insert(name, Written { outer: text.clone(), whole: text });
        }
    }
    values
}

/// Returns the values of a RON text by key.
fn written(text: &str) -> BTreeMap<String, Written> {
    let places = Places::scan(text);
    let all = places.all();
    let mut values = BTreeMap::new();
    for (number, place) in all.iter().enumerate() {
        let path = places.path(place);
        let value = &text[place.value.clone()];
        let holds = all.get(number + 1).is_some_and(|next| next.entry.start < place.value.end);
        let end =
            if holds { value.find(['(', '[', '{']).map_or(value.len(), |bracket| bracket + 1) } else { value.len() };
        if !path.is_empty() {
            values.insert(path, Written { outer: value[..end].trim().to_owned(), whole: in_one_line(value) });
        }
    }
    values
}

/// Returns a value without comments and line breaks.
fn in_one_line(value: &str) -> String {
    let lines = value.lines().map(|line| line.split("//").next().unwrap_or_default());
    lines.flat_map(str::split_whitespace).collect::<Vec<_>>().join(" ")
}

fn table(runs: &[Run], rows: &[Row]) -> String {
    let caption = match rows.len() {
        1 => "One key differs".to_owned(),
        count if count > MOST_ROWS => format!("{count} keys differ; these are the first {MOST_ROWS}"),
        count => format!("{count} keys differ"),
    };
    let mut html = format!("<table>\n<caption>{caption}</caption>\n<thead>\n<tr><th scope=\"col\">Key</th>");
    for run in runs {
        let _ = write!(html, "<th scope=\"col\"><bdi>{}</bdi></th>", escape(run.label()));
    }
    html += "</tr>\n</thead>\n<tbody>\n";
    for (key, values) in rows.iter().take(MOST_ROWS) {
        let _ = write!(html, "<tr><th scope=\"row\">{}</th>", code(key));
        for value in values {
            let shown = value.as_ref().map_or("<span class=\"none\">not given</span>".to_owned(), |value| code(value));
            let _ = write!(html, "<td>{shown}</td>");
        }
        html += "</tr>\n";
    }
    scrolled(&caption, &(html + "</tbody>\n</table>\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_values_that_differ_are_listed() {
        let first =
            written("(a: 1.0, contact: Linear(k: 1.0e5, b: 1), list: [1, 2], same: (x: 3), /* no */ text: \"x\")");
        let second = written(
            "(a: 1, contact: Hertz(k: 2.0e5), list: [1, 3], same: (x: 4),\n text: \"x\", bed: (low: 1, // m\n high: 2))",
        );
        let rows = differing(&[first, second]);
        let shown: Vec<_> = rows
            .iter()
            .map(|(key, values)| {
                (&**key, values.iter().map(|value| value.as_deref().unwrap_or("-")).collect::<Vec<_>>())
            })
            .collect();
        assert_eq!(
            shown,
            [
                ("bed", vec!["-", "(low: 1, high: 2)"]),
                ("contact", vec!["Linear(k: 1.0e5, b: 1)", "Hertz(k: 2.0e5)"]),
                ("list[1]", vec!["2", "3"]),
                ("same.x", vec!["3", "4"]),
            ]
        );
    }
}
