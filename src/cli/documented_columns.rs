//! Compares the tables of `docs/reference/run-directory.md` with the columns of the files: names, units and meanings.
//!
//! This command writes the tables anew:
//!
//! ```sh
//! SILOFLOW_RENEW_TABLES=1 cargo test --lib documented_columns
//! ```
//!
//! Neighbouring columns with the same unit and meaning share a row. A name in parentheses belongs to files of solid space alone, or of
//! the plane alone if its meaning says so.

use std::fs;
use std::path::Path;

use siloflow_files::columns::{Column, Spaces};

use crate::grains::file::write as grains;
use crate::lattice_silo;
use crate::measure::fields::{Layout, MEANS};
use crate::output::{fields, flow, free_walls, losses, profiles, series, slopes, summary, wall_bands, walls};

const PAGE: &str = "docs/reference/run-directory.md";
const RENEW: &str = "SILOFLOW_RENEW_TABLES";

/// Most numbered names of a row; of more, the row has the first two.
const MOST_NUMBERED: usize = 3;

/// A row of a table.
#[derive(Clone)]
struct Row {
    names: Vec<String>,
    unit: String,
    meaning: String,
}

impl Row {
    fn new(names: Vec<String>, unit: &str, meaning: &str) -> Self {
        Self { names, unit: unit.replace("^2", "²").replace("^3", "³"), meaning: meaning.to_owned() }
    }

    fn text(&self) -> String {
        let is_numbered = self.names.iter().all(|name| name.trim_end_matches(['`', ')']).ends_with(char::is_numeric));
        let names = if is_numbered && self.names.len() > MOST_NUMBERED {
            format!("{}, ...", self.names[..2].join(", "))
        } else {
            self.names.join(", ")
        };
        let unit = if self.unit.is_empty() { " ".to_owned() } else { format!(" {} ", self.unit) };
        format!("| {names} |{unit}| {} |\n", self.meaning)
    }
}

/// Returns the rows of these columns.
fn rows<T>(lists: &[&[Column<T>]]) -> Vec<Row> {
    let mut rows: Vec<Row> = Vec::new();
    for column in lists.iter().copied().flatten() {
        let name =
            if column.space == Spaces::Both { format!("`{}`", column.name) } else { format!("(`{}`)", column.name) };
        let row = Row::new(vec![name], column.unit, column.meaning);
        match rows.last_mut().filter(|last| (&last.unit, &last.meaning) == (&row.unit, &row.meaning)) {
            Some(last) => last.names.extend(row.names),
            None => rows.push(row),
        }
    }
    rows
}

fn series_rows() -> Vec<Row> {
    let mut rows = rows(&[series::COLUMNS, series::BALANCE, series::STATE]);
    rows.push(further());
    rows
}

fn lattice_series_rows() -> Vec<Row> {
    let mut rows = rows(&[lattice_silo::series::COLUMNS]);
    rows.push(further());
    rows
}

/// The row of the columns of behaviours.
fn further() -> Row {
    let meaning = "those that [behaviours](../how-to/behaviour-crate.md#results) register";
    Row::new(vec!["further columns".to_owned()], "in their names", meaning)
}

fn field_rows() -> Vec<Row> {
    let mut rows = rows(&[fields::CELLS]);
    let plane = Layout { components: 2, species: 4 };
    let solid = Layout { components: 3, species: 4 };
    rows.extend(MEANS.iter().map(|mean| {
        let in_plane = mean.names(plane);
        let is_planar = |name: &String| in_plane.contains(name);
        let names = mean.names(solid);
        let names = names
            .iter()
            .map(|name| if is_planar(name) { format!("`{name}`") } else { format!("(`{name}`)") })
            .collect();
        Row::new(names, mean.unit, mean.meaning)
    }));
    rows
}

/// Returns the heading and the rows of each table.
fn tables() -> Vec<(&'static str, Vec<Row>)> {
    vec![
        ("## `series.csv`", series_rows()),
        ("## `fields.csv`", field_rows()),
        ("### `state.csv`", [rows(&[grains::COLUMNS, grains::SPINS]), rows(&[grains::SHAPES])].concat()),
        ("### `walls.csv`", rows(&[walls::WALL, walls::LOADS])),
        ("### `wall_groups.csv`", rows(&[walls::GROUP, walls::LOADS])),
        ("### `free_walls.csv`", rows(&[free_walls::COLUMNS])),
        ("### `slopes.csv`", rows(&[slopes::COLUMNS])),
        ("### `wall_bands.csv`", rows(&[wall_bands::COLUMNS])),
        ("### `profiles.csv`", rows(&[profiles::PROFILES, profiles::ORIENTATIONS])),
        ("### `centres.csv`", rows(&[profiles::CENTRES])),
        ("### `flow.csv`", rows(&[flow::COLUMNS])),
        ("### `losses.csv`", rows(&[losses::COLUMNS])),
        ("### `series.csv` of the lattice gas", lattice_series_rows()),
        ("### `flow.csv` of the lattice gas", rows(&[flow::lattice::COLUMNS])),
        ("### `state.csv` of the lattice gas", rows(&[summary::lattice::STATE])),
    ]
}

/// Returns the page with this table in place of the first one after the heading.
fn with_table(page: &str, heading: &str, table: &str) -> String {
    let heading = format!("\n{heading}\n");
    let (before, after) = page.split_once(&heading).unwrap_or_else(|| panic!("{PAGE} has no heading {heading}"));
    let start = after.find("\n|").map_or(0, |start| start + 1);
    let length =
        after[start..].split_inclusive('\n').take_while(|line| line.starts_with('|')).map(str::len).sum::<usize>();
    format!("{before}{heading}{}{table}{}", &after[..start], &after[start + length..])
}

#[test]
fn the_page_has_the_columns_of_every_file() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(PAGE);
    let page = fs::read_to_string(&path).unwrap();
    let mut expected = page.clone();
    for (heading, rows) in tables() {
        let rows: String = rows.iter().map(Row::text).collect();
        expected = with_table(&expected, heading, &format!("| column | unit | meaning |\n|---|---|---|\n{rows}"));
    }
    if std::env::var_os(RENEW).is_some() {
        fs::write(&path, expected).unwrap();
    } else if let Some((found, wanted)) = page.lines().zip(expected.lines()).find(|(found, wanted)| found != wanted) {
        panic!("{PAGE} has\n{found}\nin place of\n{wanted}\n{RENEW}=1 renews the tables");
    } else {
        assert_eq!(page, expected, "{RENEW}=1 renews the tables");
    }
}
