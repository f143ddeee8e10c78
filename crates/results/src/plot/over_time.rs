//! Figures over time: columns of `series.csv`, and forces on walls.

use std::collections::BTreeMap;

use crate::run_results::RunResults;
use siloflow_figures::diagram::{Axis, Clock, Curve, Key, Mark, Panel, colour};
use siloflow_files::table::Table;
use siloflow_text::fault::Fault;

/// A column and its name in a legend.
type Named = (&'static str, &'static str);

/// Columns that share a panel.
pub(super) struct Group {
    title: &'static str,
    label: &'static str,
    is_log: bool,
    columns: &'static [Named],
}

pub(super) const GRAINS: [Group; 1] = [Group {
    title: "Grains",
    label: "grains",
    is_log: false,
    columns: &[
        ("released", "released"),
        ("entered", "entered"),
        ("inside", "inside"),
        ("out", "out"),
        ("lost", "lost"),
    ],
}];

pub(super) const ENERGY: [Group; 3] = [
    Group {
        title: "Energies",
        label: "energy, J",
        is_log: true,
        columns: &[("kinetic_j", "kinetic"), ("rotational_j", "rotational"), ("elastic_j", "elastic")],
    },
    Group {
        title: "Potential energy, and energy that came and went",
        label: "energy, J",
        is_log: false,
        columns: &[
            ("potential_j", "potential"),
            ("released_j", "entered with grains"),
            ("wall_work_j", "work of walls"),
            ("lifted_j", "lifted at periodic sides"),
            ("added_work_j", "work of behaviours"),
            ("dissipated_j", "dissipated"),
            ("removed_j", "left with grains"),
        ],
    },
    Group {
        title: "Error of the energy balance",
        label: "energy, J",
        is_log: false,
        columns: &[("balance_error_j", "error of the balance")],
    },
];

pub(super) const CONTACTS: [Group; 2] = [
    Group {
        title: "Contacts per grain",
        label: "coordination number",
        is_log: false,
        columns: &[("coordination", "contacts per grain")],
    },
    Group {
        title: "Largest overlap",
        label: "overlap over smaller radius",
        is_log: false,
        columns: &[("largest_overlap_ratio", "largest overlap")],
    },
];

pub(super) const SPEED: [Group; 4] = [
    Group {
        title: "Largest speed of a grain",
        label: "speed, m/s",
        is_log: false,
        columns: &[("largest_speed_m_per_s", "largest speed")],
    },
    Group {
        title: "Mean velocity of the lattice gas",
        label: "velocity, m/step",
        is_log: false,
        columns: &[("vx_m_per_step", "along x"), ("vy_m_per_step", "along y")],
    },
    Group {
        title: "Centre of mass of the lattice gas",
        label: "place, m",
        is_log: false,
        columns: &[("x_m", "x"), ("y_m", "y")],
    },
    Group { title: "Share of particles at rest", label: "share", is_log: false, columns: &[("at_rest", "at rest")] },
];

/// Columns of `series.csv` that other figures show.
const ELSEWHERE: [&str; 7] = ["time_s", "step", "out_kg", "outflow_per_s", "outflow_per_step", "culled", "energy_j"];

/// Returns the figure of one column of `series.csv`; nothing if no run has it.
pub(super) fn column(runs: &[&RunResults], name: &str) -> Vec<Panel> {
    let curves: Vec<_> = runs.iter().filter_map(|run| Some((run.name.clone(), points(run, name)?))).collect();
    if curves.is_empty() {
        return Vec::new();
    }
    let curves =
        if runs.len() == 1 { curves.into_iter().map(|(_, points)| (String::new(), points)).collect() } else { curves };
    vec![panel(runs, name.to_owned(), name.to_owned(), false, curves)]
}

/// Names of the columns of `series.csv` that no other figure shows: those of behaviours.
pub(super) fn other_columns(runs: &[&RunResults]) -> Vec<String> {
    let groups = || [&GRAINS[..], &ENERGY, &CONTACTS, &SPEED].into_iter().flatten();
    let is_known = |name: &str| {
        ELSEWHERE.contains(&name) || groups().any(|group| group.columns.iter().any(|column| column.0 == name))
    };
    let mut names: Vec<String> = Vec::new();
    for name in runs.iter().flat_map(|run| run.series.names()) {
        if !is_known(name) && !names.iter().any(|known| known == name) {
            names.push(name.to_owned());
        }
    }
    names
}

/// Returns the points of a column over time; `None` if the run has no such column.
fn points(run: &RunResults, name: &str) -> Option<Vec<(f64, f64)>> {
    Some(thinned(&run.times().into_iter().zip(run.series.numbers(name)?).collect::<Vec<_>>()))
}

/// Returns a panel for each group, or for several runs a panel for each column.
pub(super) fn of_groups(runs: &[&RunResults], groups: &[Group]) -> Vec<Panel> {
    let of_run = |run: &RunResults, &(column, name): &Named| {
        // A quantity that is zero throughout is not part of the run.
        let points =
            points(run, column).filter(|points| points.iter().any(|point| point.1 != 0.0 && !point.1.is_nan()));
        Some((name.to_owned(), points?))
    };
    let mut panels = Vec::new();
    for Group { title, label, is_log, columns } in groups {
        if let [run] = runs {
            let mut curves: Vec<_> = columns.iter().filter_map(|column| of_run(run, column)).collect();
            if let ([_], [curve]) = (columns, &mut curves[..]) {
                // The title is its name.
                curve.0.clear();
            }
            if !curves.is_empty() {
                panels.push(panel(runs, (*title).to_owned(), (*label).to_owned(), *is_log, curves));
            }
            continue;
        }
        for column in *columns {
            let curves = runs.iter().filter_map(|run| Some((run.name.clone(), of_run(run, column)?.1)));
            let curves: Vec<_> = curves.collect();
            if !curves.is_empty() {
                let title = if columns.len() == 1 { (*title).to_owned() } else { format!("{title}: {}", column.1) };
                panels.push(panel(runs, title, (*label).to_owned(), *is_log, curves));
            }
        }
    }
    panels
}

/// Forces on walls: of one run a curve for each wall, or for each name if walls have names; of several runs the sums over all walls.
pub(super) fn walls(runs: &[&RunResults]) -> Result<Vec<Panel>, Fault> {
    let mut panels = Vec::new();
    let is_solid = runs.iter().any(|run| run.table("walls.csv").is_ok_and(|table| is_solid(table.as_ref())));
    for (axis, title) in [("fx_n", "along x"), ("fy_n", "along y"), ("fz_n", "along z")] {
        // Forces along the horizontal on opposite walls of one name cancel; along the vertical all walls of a name carry together.
        let is_vertical = axis == if is_solid { "fz_n" } else { "fy_n" };
        let mut curves = Vec::new();
        for run in runs {
            let of_run = match runs.len() {
                1 => match run.table("wall_groups.csv")?.filter(|_| is_vertical) {
                    Some(groups) => by_wall(&groups, "walls", axis),
                    None => run.table("walls.csv")?.map(|walls| by_wall(&walls, "wall", axis)).unwrap_or_default(),
                },
                _ => run.table("walls.csv")?.and_then(|walls| sum(&run.name, &walls, axis)).into_iter().collect(),
            };
            curves.extend(of_run);
        }
        if curves.iter().any(|(_, points)| points.iter().any(|point| point.1 != 0.0)) {
            let of = if runs.len() == 1 { "each wall" } else { "all walls together" };
            panels.push(panel(runs, format!("Force on {of}, {title}"), "mean force, N".to_owned(), false, curves));
        }
    }
    Ok(panels)
}

/// Whether a table of forces is one of solid space.
fn is_solid(table: Option<&Table>) -> bool {
    table.is_some_and(|table| table.names().any(|name| name == "fz_n"))
}

/// Most walls in a figure: the ones with the largest forces.
const MOST_WALLS: usize = 6;

/// Returns a column over time, a curve for each name in another column: the force on each wall.
pub(super) fn by_wall(table: &Table, column: &str, axis: &str) -> Vec<(String, Vec<(f64, f64)>)> {
    let (Some(times), Some(walls), Some(forces)) = (table.numbers("time_s"), table.texts(column), table.numbers(axis))
    else {
        return Vec::new();
    };
    let mut curves: Vec<(String, Vec<(f64, f64)>)> = Vec::new();
    for ((time, wall), force) in times.into_iter().zip(walls).zip(forces) {
        let name = if column == "wall" { format!("wall {wall}") } else { wall.to_owned() };
        let known = curves.iter().position(|curve| curve.0 == name).unwrap_or_else(|| {
            curves.push((name, Vec::new()));
            curves.len() - 1
        });
        curves[known].1.push((time, force));
    }
    let largest =
        |curve: &(String, Vec<(f64, f64)>)| curve.1.iter().fold(0.0f64, |most, point| most.max(point.1.abs()));
    let mut sizes: Vec<_> = curves.iter().map(largest).collect();
    sizes.sort_by(|a, b| b.total_cmp(a));
    let least = sizes.get(MOST_WALLS - 1).copied().unwrap_or(0.0);
    curves.retain(|curve| largest(curve) >= least);
    curves.truncate(MOST_WALLS);
    curves.into_iter().map(|(name, points)| (name, thinned(&points))).collect()
}

/// Returns the sum of the forces on all walls over time.
fn sum(name: &str, table: &Table, axis: &str) -> Option<(String, Vec<(f64, f64)>)> {
    let mut sums: BTreeMap<u64, (f64, f64)> = BTreeMap::new();
    for (time, force) in table.numbers("time_s")?.into_iter().zip(table.numbers(axis)?) {
        // Times are not negative, so their bits have their order.
        sums.entry(time.to_bits()).or_insert((time, 0.0)).1 += force;
    }
    Some((name.to_owned(), thinned(&sums.into_values().collect::<Vec<_>>())))
}

/// Returns a panel over time with marks of the runs.
pub(super) fn panel(
    runs: &[&RunResults],
    title: String,
    label: String,
    is_log: bool,
    curves: Vec<(String, Vec<(f64, f64)>)>,
) -> Panel {
    let all = || curves.iter().flat_map(|curve| curve.1.iter());
    let last = all().map(|point| point.0).fold(0.0, f64::max);
    let x = Axis::linear(runs.first().map_or("", |run| run.time_label()), 0.0, if last > 0.0 { last } else { 1.0 });
    let y = if is_log {
        decades(label, all().map(|point| point.1))
    } else {
        Axis::around(label, all().map(|point| point.1))
    };
    let lowest = y.from;
    let curves = curves.into_iter().enumerate().map(|(number, (name, points))| Curve {
        name,
        colour: colour(number),
        // On a logarithmic axis, zero interrupts the line.
        points: points.into_iter().map(|(t, v)| (t, if is_log && v < lowest { f64::NAN } else { v })).collect(),
        has_line: true,
        ..Curve::default()
    });
    let curves = curves.collect();
    Panel { curves, marks: marks(runs), key: Key::Above, clock: Some(Clock::Run), ..Panel::new(title, x, y) }
}

/// Most decades of a logarithmic axis.
const DECADES: f64 = 1e10;

/// Returns a logarithmic axis around the values, but of at most ten decades.
fn decades(label: String, values: impl Iterator<Item = f64> + Clone) -> Axis {
    let largest = values.clone().filter(|value| value.is_finite()).fold(0.0, f64::max);
    Axis::logarithmic(label, values.filter(|&value| value > largest / DECADES))
}

/// Returns the marks of a run. Several runs have their own times, which are marked if there are few, with their names.
pub(super) fn marks(runs: &[&RunResults]) -> Vec<Mark> {
    match runs {
        [run] => run.marks(),
        _ if runs.len() > 3 => Vec::new(),
        _ => {
            let named = |run: &RunResults, mark: Mark| Mark { name: format!("{}: {}", run.name, mark.name), ..mark };
            runs.iter().flat_map(|run| run.marks().into_iter().map(|mark| named(run, mark))).collect()
        }
    }
}

/// Intervals of time of which a curve keeps the extremes: about one for each pixel.
const INTERVALS: usize = 400;

/// Returns at most four points for each pixel: the first, the lowest, the highest and the last.
pub(super) fn thinned(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    if points.len() <= 4 * INTERVALS {
        return points.to_vec();
    }
    let mut kept = Vec::new();
    for part in points.chunks(points.len().div_ceil(INTERVALS)) {
        let order = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        let mut four: Vec<(f64, f64)> =
            [part.first(), part.iter().min_by(order), part.iter().max_by(order), part.last()]
                .into_iter()
                .flatten()
                .copied()
                .collect();
        four.sort_by(|a, b| a.0.total_cmp(&b.0));
        four.dedup();
        kept.extend(four);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_curve_keeps_its_ends_and_its_extremes() {
        let points: Vec<_> = (0..100_000u32).map(|n| (f64::from(n), if n == 54_321 { 7.0 } else { 0.0 })).collect();
        let kept = thinned(&points);
        assert!(kept.len() <= 4 * INTERVALS && kept.contains(&(54_321.0, 7.0)));
        assert_eq!((kept[0], kept[kept.len() - 1]), (points[0], points[99_999]));
        assert!(kept.windows(2).all(|pair| pair[0].0 < pair[1].0));
    }
}
