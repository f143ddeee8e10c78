//! Comparison of flow patterns: runs of any model against a reference, by what they have in common.
//!
//! Models differ in their speeds and clocks: grains fall in metres a second, a lattice gas in metres a step. So each run is
//! measured in units of its own:
//!
//! * the [field] of vertical velocity by its mean downward speed;
//! * the [discharge] by the time until half is out.
//!
//! What is left is the pattern. Its cost is the wall-clock time of the run's steps. Two runs of one scene with different
//! seeds tell the floor: what chance alone makes of the figures.

pub mod discharge;
pub mod field;
pub mod pictures;
pub mod read;
pub mod report;

use crate::compare::discharge::Curve;
use crate::compare::field::Field;
use crate::compare::report::{Report, Row};
use crate::fault::Fault;
use crate::space::Vector;
use crate::walls::silo_file::Disc;

/// What a run directory says about its flow.
#[derive(Clone, Debug)]
pub struct Run {
    /// What it is called in tables and pictures.
    pub name: String,
    /// Mean velocities in cells.
    pub field: Field,
    /// Share of the grains that are out, against the time since the door opened.
    pub discharge: Curve,
    /// Unit of its time, `s` or `step`.
    pub time_unit: &'static str,
    /// Wall-clock time of its steps, s.
    pub wall_s: f64,
    /// Its wall grains, for pictures.
    pub walls: Vec<Disc>,
    /// The edges of its silo, for pictures, m.
    pub lines: Vec<(Vector, Vector)>,
}

/// Compares each of `others` with the reference, over cells in which both saw at least `looks` grains.
///
/// # Errors
/// If two fields have no cells in common or do not flow down, or if nothing comes out.
pub fn compare(reference: &Run, others: &[Run], looks: f64) -> Result<Report, Fault> {
    let all = || std::iter::once(reference).chain(others);
    if let Some(dry) = all().find(|run| run.discharge.largest() <= 0.0) {
        return Err(no_discharge(dry));
    }
    let unit_share = all().map(|run| run.discharge.largest()).fold(0.5, f64::min);
    let rows = all().map(|run| row(reference, run, looks, unit_share)).collect::<Result<Vec<Row>, Fault>>()?;
    Ok(Report { unit_share, looks, rows })
}

fn no_discharge(run: &Run) -> Fault {
    Fault::new("compare::discharge", format!("{}: nothing comes out after the door opened", run.name))
        .help("compare runs whose silo discharges; does the scene open its door?")
}

fn row(reference: &Run, run: &Run, looks: f64, unit_share: f64) -> Result<Row, Fault> {
    let fields = run.field.against(&reference.field, looks).map_err(|trouble| {
        let (one, other) = (&run.name, &reference.name);
        Fault::new("compare::field", format!("{one} and {other}: {trouble}")).help(
            "give the scenes the same `flow.cell`, silos in the same place and a window in which they flow; or lower \
                 --looks",
        )
    })?;
    let unit =
        |run: &Run| run.discharge.time_of(unit_share).filter(|&time| time > 0.0).ok_or_else(|| no_discharge(run));
    let (unit_time, of_reference) = (unit(run)?, unit(reference)?);
    let discharge = run.discharge.in_units(unit_time).largest_difference(&reference.discharge.in_units(of_reference));
    Ok(Row {
        run: run.name.clone(),
        field_rms: fields.rms,
        field_correlation: fields.correlation,
        common_cells: fields.common,
        only_reference: fields.only_reference,
        only_run: fields.only_run,
        mean_speed: fields.mean_run,
        discharge_difference: discharge,
        unit_time,
        time_unit: run.time_unit,
        wall_s: run.wall_s,
        wall_ratio: run.wall_s / reference.wall_s,
    })
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "exact values")]
pub(crate) mod tests {
    use super::*;
    use crate::measure::flow::FlowField;

    /// A flow that falls with speed `down(x, y)` over 4 x 4 cells and empties as 1 - exp(-t/`time`).
    pub(crate) fn run(name: &str, time: f64, down: impl Fn(f64, f64) -> f64) -> Run {
        let mut field = FlowField::new(0.5);
        for k in 0..16u8 {
            let (x, y) = (0.5 * f64::from(k % 4) + 0.25, 0.5 * f64::from(k / 4) + 0.25);
            (0..100).for_each(|_| field.add(x, y, 1.0, 0.0, -down(x, y)));
        }
        field.end_sample();
        let times = (0..200u8).map(|n| 0.05 * f64::from(n) * time);
        Run {
            name: name.to_owned(),
            field: Field::new(&field.means()).unwrap(),
            discharge: Curve::new(times.map(|t| (t, 1.0 - (-t / time).exp()))),
            time_unit: "s",
            wall_s: time,
            walls: Vec::new(),
            lines: Vec::new(),
        }
    }

    #[test]
    fn a_run_compared_with_itself_agrees_and_scales_do_not_count() {
        let pattern = |x: f64, y: f64| 1.0 + x + 0.3 * y * y;
        let reference = run("reference", 2.0, pattern);
        let others = [run("same", 2.0, pattern), run("faster", 0.25, |x, y| 8.0 * pattern(x, y))];
        let report = compare(&reference, &others, 1.0).unwrap();
        assert_eq!((report.rows.len(), report.unit_share), (3, 0.5));
        for row in &report.rows {
            // Powers of two scale without rounding, but for the exponential's argument.
            assert!(row.field_rms < 1e-15 && row.discharge_difference < 1e-15, "{row:?}");
            assert!((row.field_correlation.unwrap() - 1.0).abs() < 1e-15, "{row:?}");
        }
        assert_eq!(report.rows[2].wall_ratio, 0.125);
        assert!((report.rows[2].mean_speed / report.rows[0].mean_speed - 8.0).abs() < 1e-14);
    }

    #[test]
    fn what_one_run_never_reaches_is_no_unit() {
        let reference = run("reference", 1.0, |_, _| 1.0);
        let mut slow = run("slow", 1.0, |_, _| 1.0);
        slow.discharge = Curve::new([(0.0, 0.0), (1.0, 0.2)]);
        let report = compare(&reference, &[slow.clone()], 1.0).unwrap();
        assert_eq!((report.unit_share, report.rows[1].unit_time), (0.2, 1.0));
        slow.discharge = Curve::new([(0.0, 0.0), (1.0, 0.0)]);
        let fault = compare(&reference, &[slow], 1.0).unwrap_err();
        assert!(fault.code() == "compare::discharge" && fault.to_string().starts_with("slow:"), "{fault}");
    }
}
