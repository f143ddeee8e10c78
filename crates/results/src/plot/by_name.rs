//! Figures over time of tables with several rows at each time, told apart by a name: walls that forces move, and slopes.

use crate::plot::over_time::{by_wall, panel};
use crate::run_results::RunResults;
use siloflow_figures::diagram::Panel;
use siloflow_text::fault::Fault;

/// A panel of such a table.
struct OfTable {
    file: &'static str,
    /// The column of the names.
    key: &'static str,
    column: &'static str,
    title: &'static str,
    label: &'static str,
}

const FREE_WALLS: [OfTable; 2] = [
    OfTable {
        file: "free_walls.csv",
        key: "walls",
        column: "coordinate",
        title: "Place of walls that forces move",
        label: "shift, m, or angle, rad",
    },
    OfTable {
        file: "free_walls.csv",
        key: "walls",
        column: "of_grains",
        title: "Force of the grains on them",
        label: "force, N, or torque, N m",
    },
];

const SLOPES: [OfTable; 1] = [OfTable {
    file: "slopes.csv",
    key: "slope",
    column: "angle_deg",
    title: "Slope of the free surface",
    label: "angle, degrees",
}];

/// Places of walls that forces move, and the force of the grains.
pub(super) fn free_walls(runs: &[&RunResults]) -> Result<Vec<Panel>, Fault> {
    panels(runs, &FREE_WALLS)
}

/// Angles of the free surface.
pub(super) fn slopes(runs: &[&RunResults]) -> Result<Vec<Panel>, Fault> {
    panels(runs, &SLOPES)
}

fn panels(runs: &[&RunResults], tables: &[OfTable]) -> Result<Vec<Panel>, Fault> {
    let mut panels = Vec::new();
    for OfTable { file, key, column, title, label } in tables {
        let mut curves = Vec::new();
        for run in runs {
            let Some(table) = run.table(file)? else { continue };
            let of_run = by_wall(&table, key, column).into_iter();
            curves.extend(of_run.map(|(name, points)| match runs {
                [_] => (name, points),
                _ => (format!("{}: {name}", run.name), points),
            }));
        }
        if !curves.is_empty() {
            panels.push(panel(runs, (*title).to_owned(), (*label).to_owned(), false, curves));
        }
    }
    Ok(panels)
}
