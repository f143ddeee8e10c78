//! Figures in the prose and the tables of pages, compared with files.
//!
//! `<!-- value FILE PATH DECIMALS -->52.8<!-- end -->` is a number of a file that the page's commands have written, or of a committed file below `docs`.
//!
//! | file | `PATH` | number |
//! |---|---|---|
//! | JSON | `discharge.rate_per_s` | of the object `discharge` |
//! | JSON | `/entries/case=drum&scheme=Verlet/order` | of the first entry with these members |
//! | CSV | `out@52.6` | in the column `out`, in the last row up to this `time_s` |
//! | CSV | `rate@silo=flat&seed=1` | in the column `rate`, in the first row with these cells |
//! | CSV | `slow/fast@bed=w1` | the quotient of two columns |
//!
//! `_` stands for a space in a cell. A figure in per cent ends `DECIMALS` with `%`, one as a power of ten with `e`: `1e` is for 6.3e-4.
//!
//! With `SILOFLOW_RENEW_PAGES` set, pages are rewritten in place of a comparison.

use std::fs;
use std::path::Path;

use serde_json::Value;

const BEGIN: &str = "<!-- value ";
const END: &str = "<!-- end -->";

/// Returns the text of a page with the values of the files in `here` and of the committed files in `root`, and a list of those that differ. Values of
/// files in `here` are compared only if the page `is_complete`: if all of its commands ran.
pub fn values(text: &str, here: &Path, root: &Path, is_complete: bool) -> Result<(String, Vec<String>), String> {
    let mut renewed = String::new();
    let mut wrong = Vec::new();
    let mut rest = text;
    while let Some(start) = rest.find(BEGIN) {
        let (before, from) = rest.split_at(start);
        let (call, after) = from[BEGIN.len()..].split_once(" -->").ok_or("a value without `-->`")?;
        let (shown, behind) = after.split_once(END).ok_or("a value without an end")?;
        let file = call.split_whitespace().next().unwrap_or_default();
        // Commands may write committed files anew, with the times of another machine.
        let is_committed = file.starts_with("docs/");
        let file = if is_committed { root.join(file) } else { here.join(file) };
        let value = if is_committed || is_complete { value(call, &file)? } else { shown.to_owned() };
        if value != shown {
            wrong.push(format!("{call}: the page shows {shown}, the file has {value}"));
        }
        renewed.extend([before, BEGIN, call, " -->", &value, END]);
        rest = behind;
    }
    Ok((renewed + rest, wrong))
}

fn value(call: &str, file: &Path) -> Result<String, String> {
    let [name, path, decimals] = call.split_whitespace().collect::<Vec<_>>()[..] else {
        return Err(format!("`{call}` is not FILE PATH DECIMALS"));
    };
    let text = fs::read_to_string(file).map_err(|error| format!("{name}: {error}"))?;
    let number = if let Some((columns, row)) = path.split_once('@') {
        of_table(&text, columns, row)
    } else {
        let json: Value = serde_json::from_str(&text).map_err(|error| format!("{name}: {error}"))?;
        of_object(&json, path)
    };
    let number = number.ok_or(format!("{name} has no {path}"))?;
    let places =
        decimals.trim_end_matches(['%', 'e']).parse().map_err(|_| format!("{decimals}: a number of decimals"))?;
    Ok(match decimals.chars().last() {
        Some('%') => format!("{:.places$}", 100.0 * number),
        Some('e') => format!("{number:.places$e}"),
        _ => format!("{number:.places$}"),
    })
}

/// Returns whether all conditions of the form `key=value&key=value` hold, for the cells or members that `of` returns.
fn hold(conditions: &str, of: impl Fn(&str) -> Option<String>) -> bool {
    conditions.split('&').all(|condition| {
        condition.split_once('=').is_some_and(|(key, value)| of(key).is_some_and(|own| own.replace(' ', "_") == value))
    })
}

fn of_object(json: &Value, path: &str) -> Option<f64> {
    let parts =
        path.strip_prefix('/').map_or_else(|| path.split('.').collect(), |path| path.split('/').collect::<Vec<_>>());
    let found = parts.into_iter().try_fold(json, |json, part| {
        let fits = |object: &&Value| hold(part, |key| object.get(key)?.as_str().map(str::to_owned));
        if part.contains('=') { json.as_array()?.iter().find(fits) } else { json.pointer(&format!("/{part}")) }
    });
    found?.as_f64()
}

fn of_table(text: &str, columns: &str, row: &str) -> Option<f64> {
    let mut table = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
    let names = table.headers().ok()?.clone();
    let cell = |record: &csv::StringRecord, name: &str| {
        record.get(names.iter().position(|found| found == name)?).map(str::to_owned)
    };
    let number = |record: &csv::StringRecord, name: &str| cell(record, name)?.parse::<f64>().ok();
    let records: Vec<_> = table.records().map_while(Result::ok).collect();
    let record = if let Ok(time) = row.parse::<f64>() {
        records.iter().rfind(|record| number(record, "time_s").is_some_and(|own| own <= time + 1e-9))
    } else {
        records.iter().find(|record| hold(row, |key| cell(record, key)))
    }?;
    match columns.split_once('/') {
        Some((part, whole)) => Some(number(record, part)? / number(record, whole)?),
        None => number(record, columns),
    }
}

#[test]
fn values_are_read_from_files() {
    let here = tempfile::tempdir().unwrap();
    fs::write(here.path().join("a.json"), r#"{"b": {"c": 1.26}, "d": [{"e": "f"}, {"e": "g.1", "h": 2.5e-4}]}"#)
        .unwrap();
    fs::write(here.path().join("a.csv"), "time_s,out\n0,1\n0.5,7\n1,9\n").unwrap();
    fs::write(here.path().join("b.csv"), "law,e,slow,fast\nno drag,1,8,2\n\"drag, 2\",1,9,2\n").unwrap();
    for (call, right) in [
        ("a.json b.c 1", "1.3"),
        ("a.json /d/e=g.1/h 2%", "0.03"),
        ("a.json /d/e=g.1/h 1e", "2.5e-4"),
        ("a.csv out@0.9 0", "7"),
        ("b.csv slow@law=no_drag&e=1 0", "8"),
        ("b.csv slow/fast@law=drag,_2 1", "4.5"),
    ] {
        let text = |shown: &str| format!("x <!-- value {call} -->{shown}<!-- end -->.");
        let (renewed, wrong) = values(&text("0"), here.path(), here.path(), true).unwrap();
        assert_eq!(renewed, text(right));
        assert!(wrong.len() == 1 && wrong[0].contains("shows 0, the file has"), "{wrong:?}");
        assert_eq!(values(&renewed, here.path(), here.path(), false), Ok((renewed.clone(), Vec::new())));
    }
    for missing in ["a.json b.d 1", "a.json /d/e=x/h 1", "a.csv in@0.9 0", "b.csv slow@law=x 0"] {
        assert!(
            values(&format!("<!-- value {missing} -->1<!-- end -->"), here.path(), here.path(), true).is_err(),
            "{missing}"
        );
    }
    let of_no_file = "<!-- value c.json b.c 1 -->1.3<!-- end -->";
    assert!(values(of_no_file, here.path(), here.path(), true).is_err());
    assert_eq!(values(of_no_file, here.path(), here.path(), false), Ok((of_no_file.to_owned(), Vec::new())));
}
