//! Forces on walls: the rows of `walls.csv` and `wall_groups.csv` at rest and at the end, and `wall_bands.csv`.
//!
//! A row of forces is the mean over all steps since the row before. A silo that has run empty bears nothing at the end, so the
//! moment before the door opens counts too.

use std::fmt::Write as _;

use crate::report::html::{Section, escape, quantity, scrolled};
use crate::report::run::Run;
use crate::report::table;
use siloflow_files::table::Table;

/// Most walls that are listed.
const MOST_WALLS: usize = 60;

/// The section of forces on walls, which begins with `figures`; nothing if no run has any.
#[must_use]
pub fn section_of(runs: &[Run], figures: &str) -> Option<Section> {
    let mut content = figures.to_owned();
    for run in runs {
        let name = if runs.len() > 1 { format!("{}: ", run.label()) } else { String::new() };
        let groups = run.table("wall_groups.csv").and_then(|table| forces(run, &table, "walls"));
        let walls = run.table("walls.csv").and_then(|table| forces(run, &table, "wall"));
        content +=
            &groups.map_or(String::new(), |html| captioned(&format!("{name}Forces on all walls of one name"), &html));
        content += &walls.map_or(String::new(), |html| captioned(&format!("{name}Forces on walls"), &html));
        let caption = format!("{name}Walls that forces move (free_walls.csv)");
        content += &table::details(run.table("free_walls.csv").as_ref(), &caption);
        let caption = format!("{name}Pressure and friction on walls by height");
        content += &table::details(run.table("wall_bands.csv").as_ref(), &caption);
    }
    if content.is_empty() {
        return None;
    }
    let note = "<p class=\"note\">Forces of the grains on the walls, as means over all steps since the row of the series before. \
                Torques are about the wall's own point.</p>\n";
    Section::of("walls", "Forces on walls", content + note)
}

fn captioned(caption: &str, rows: &str) -> String {
    let caption_html = escape(caption);
    scrolled(caption, &format!("<table>\n<caption>{caption_html}</caption>\n{rows}</table>\n"))
}

/// Returns head and rows of a table of forces; `None` without rows. `key` is the column that names the wall.
fn forces(run: &Run, table: &Table, key: &str) -> Option<String> {
    let times = table.numbers("time_s").filter(|times| !times.is_empty())?;
    let walls = table.texts(key)?;
    let columns: Vec<_> =
        table.names().filter_map(|name| Some((heading(name), unit_of(name)?, table.numbers(name)?))).collect();
    let mut html = "<thead>\n<tr><th scope=\"col\">Wall</th><th scope=\"col\">Moment</th>".to_owned();
    for (heading, _, _) in &columns {
        let _ = write!(html, "<th scope=\"col\" class=\"figure\">{heading}</th>");
    }
    html += "</tr>\n</thead>\n<tbody>\n";
    for (moment, time) in moments(run, &times) {
        #[expect(clippy::float_cmp, reason = "the time is that of a row")]
        let rows = (0..times.len()).filter(|&row| times[row] == time);
        for row in rows.take(MOST_WALLS) {
            let wall = wall_name(run, key, walls[row]);
            let _ = write!(html, "<tr><th scope=\"row\">{wall}</th><td>{moment} ({})</td>", quantity(time, "s"));
            for (_, unit, values) in &columns {
                let _ = write!(html, "<td class=\"figure\">{}</td>", quantity(values[row], unit));
            }
            html += "</tr>\n";
        }
    }
    Some(html + "</tbody>\n")
}

/// Moments of interest with the time of a row: the last row before the door opens, and the last of all.
fn moments(run: &Run, times: &[f64]) -> Vec<(&'static str, f64)> {
    let last = times.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let shut = run.number("/door_open_time_s").map(|open| {
        // The row at the moment of opening still is of a shut door.
        times.iter().copied().filter(|time| *time <= open + 1e-9).fold(f64::NEG_INFINITY, f64::max)
    });
    let shut = shut.filter(|shut| shut.is_finite() && *shut < last);
    shut.map(|shut| ("before the door opens", shut)).into_iter().chain([("at the end", last)]).collect()
}

/// Number and name of a wall of the scene, as HTML.
fn wall_name(run: &Run, key: &str, text: &str) -> String {
    let Some(scene) = run.scene.as_ref().ok().filter(|scene| !scene.is_lattice) else { return escape(text) };
    let wall = (key == "wall").then(|| text.parse::<usize>().ok()?.checked_sub(1)).flatten();
    match wall.and_then(|wall| scene.wall_names.get(wall)?.as_ref()) {
        Some(name) => format!("{} <bdi>{}</bdi>", escape(text), escape(name)),
        None => format!("<bdi>{}</bdi>", escape(text)),
    }
}

/// The unit of a column of forces or torques.
fn unit_of(column: &str) -> Option<&'static str> {
    match column.rsplit_once('_')?.1 {
        "n" => Some("N"),
        "nm" => Some("N m"),
        _ => None,
    }
}

/// The heading of a column of forces or torques, as HTML.
fn heading(column: &str) -> String {
    let (symbol, axis) = column.split_once('_').unwrap_or((column, "")).0.split_at(1);
    let kind = if symbol == "t" { "Torque" } else { "Force" };
    format!("{kind} <var>{}</var>", escape(axis))
}
