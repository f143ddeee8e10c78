//! Comparison of flow patterns: runs of any model against a reference run.
//!
//! Models differ in speeds and clocks: grains move in metres per second, a lattice gas in metres per step. Each run is
//! therefore scaled by units of its own:
//!
//! * the [field] of vertical velocity by its mean downward speed;
//! * the [discharge] by the time until half of the grains are out.
//!
//! A run of LAMMPS has no field, so its discharge alone is compared.
//!
//! After scaling, only the patterns differ. The cost of a run is the wall-clock time of its steps. Two runs of one
//! scene with different seeds show the differences that are due to chance alone.

pub mod discharge;
pub mod field;
pub mod pictures;
pub mod read;
pub mod report;

use crate::compare::discharge::Curve;
use crate::compare::field::Field;
use crate::compare::report::{FieldFigures, Report, Row};
use crate::scene_facts::Outline;
use siloflow_text::fault::Fault;

/// The flow of a run, as read from its run directory.
#[derive(Clone, Debug)]
pub struct Run {
    /// Name in tables and pictures.
    pub name: String,
    /// Mean velocities in cells; `None` for a run of LAMMPS, which writes none.
    pub field: Option<Field>,
    /// Fraction of the grains that are out, as a function of the time since the door opened.
    pub discharge: Curve,
    /// Unit of time, `s` or `step`.
    pub time_unit: &'static str,
    /// Wall-clock time of the steps, s.
    pub wall_s: f64,
    /// The silo, for pictures.
    pub outline: Outline,
}

/// Compares each run with the reference, over cells in which both counted at least `looks` grains.
///
/// The first row of the report compares the reference with itself.
///
/// # Errors
/// If two fields cannot be compared, or if no grain leaves in one of the runs.
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
    Fault::new("compare::discharge", format!("{}: no grain leaves after the door opens", run.name))
        .help("compare runs whose silo discharges; does the scene open its door?")
}

fn row(reference: &Run, run: &Run, looks: f64, unit_share: f64) -> Result<Row, Fault> {
    let fields = run.field.as_ref().zip(reference.field.as_ref()).map(|(field, reference_field)| {
        field.against(reference_field, looks).map_err(|trouble| {
            let one = &run.name;
            let other = &reference.name;
            Fault::new("compare::field", format!("{one} and {other}: {trouble}")).help(
                "give the scenes the same `flow.cell`, silos in the same place and a window in which they flow; or lower \
                 --looks",
            )
        })
    });
    let fields = fields.transpose()?;
    let unit =
        |run: &Run| run.discharge.time_of(unit_share).filter(|&time| time > 0.0).ok_or_else(|| no_discharge(run));
    let unit_time = unit(run)?;
    let reference_unit = unit(reference)?;
    let discharge = run.discharge.in_units(unit_time).largest_difference(&reference.discharge.in_units(reference_unit));
    Ok(Row {
        run: run.name.clone(),
        field: fields.map(|fields| FieldFigures {
            field_rms: fields.rms,
            field_correlation: fields.correlation,
            common_cells: fields.common,
            only_reference: fields.only_reference,
            only_run: fields.only_run,
            mean_speed: fields.mean_run,
        }),
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
    use siloflow_files::flow_means::FlowMeans;

    /// Returns a run with the downward speed `down(x, y)` over 4 x 4 cells and the discharge 1 - exp(-t/`time`).
    pub(crate) fn run(name: &str, time: f64, down: impl Fn(f64, f64) -> f64) -> Run {
        let cell = |k: u8| {
            let x = 0.5 * f64::from(k % 4) + 0.25;
            let y = 0.5 * f64::from(k / 4) + 0.25;
            FlowMeans { x, y, samples: 1, count: 100.0, vx: 0.0, vy: -down(x, y) }
        };
        let means: Vec<_> = (0..16).map(cell).collect();
        let times = (0..200u8).map(|n| 0.05 * f64::from(n) * time);
        Run {
            name: name.to_owned(),
            field: Field::new(&means),
            discharge: Curve::new(times.map(|t| (t, 1.0 - (-t / time).exp()))),
            time_unit: "s",
            wall_s: time,
            outline: Outline::default(),
        }
    }

    #[test]
    fn equal_patterns_agree_for_any_scale_of_speed_and_time() {
        let pattern = |x: f64, y: f64| 1.0 + x + 0.3 * y * y;
        let reference = run("reference", 2.0, pattern);
        let others = [run("same", 2.0, pattern), run("faster", 0.25, |x, y| 8.0 * pattern(x, y))];
        let report = compare(&reference, &others, 1.0).unwrap();
        assert_eq!((report.rows.len(), report.unit_share), (3, 0.5));
        for row in &report.rows {
            // Scaling by powers of two rounds only in the argument of the exponential.
            let field = row.field.as_ref().unwrap();
            assert!(field.field_rms < 1e-15 && row.discharge_difference < 1e-15, "{row:?}");
            assert!((field.field_correlation.unwrap() - 1.0).abs() < 1e-15, "{row:?}");
        }
        assert_eq!(report.rows[2].wall_ratio, 0.125);
        let [slow, fast] = [0, 2].map(|row: usize| report.rows[row].field.as_ref().unwrap().mean_speed);
        assert!((fast / slow - 8.0).abs() < 1e-14);
    }

    #[test]
    fn a_run_without_a_field_is_compared_by_its_discharge() {
        let reference = run("reference", 2.0, |x, _| 1.0 + x);
        let other = Run { field: None, ..run("other", 1.0, |_, _| 1.0) };
        for (first, second) in [(&reference, &other), (&other, &reference)] {
            let report = compare(first, std::slice::from_ref(second), 1.0).unwrap();
            assert_eq!(report.rows[0].field.is_some(), first.field.is_some());
            let row = &report.rows[1];
            assert!(row.field.is_none() && row.discharge_difference < 1e-15, "{row:?}");
            assert_eq!(row.wall_ratio, second.wall_s / first.wall_s);
        }
    }

    #[test]
    fn unit_of_time_is_a_fraction_that_all_runs_reach() {
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
