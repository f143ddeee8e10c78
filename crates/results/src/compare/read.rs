//! Reads the data of a comparison from a run directory of grains or of a lattice gas.
//!
//! * `summary.json`: `grains.released` or `particles.entered`, `performance.wall_s` (s), and the time at which the door
//!   opened, `door_open_time_s` (s) or `door_open_step`. If the latter is `null` or absent, the silo was open from the
//!   start.
//! * `series.csv`: `out` as a function of `time_s` or `step`.
//! * `flow.csv`: `x_m`, `y_m`, `samples`, `count`, and `vx`, `vy` in `_m_per_s` or `_m_per_step`. LAMMPS writes none.
//! * `scene.ron`: wall grains, for pictures; optional.

use std::path::Path;

use serde_json::Value;

use crate::compare::Run;
use crate::compare::discharge::Curve;
use crate::compare::field::Field;
use crate::scene_facts::ReadOutline;
use siloflow_files::flow_means::FlowMeans;
use siloflow_files::own_files;
use siloflow_files::run_directory::{Depth, refuse_odd};
use siloflow_files::table::Table;
use siloflow_text::fault::Fault;
use siloflow_text::file;

/// Help text for a directory without a velocity field.
const NO_FLOW: &str = "give its scene the key `flow`, for example `flow: (cell: 0.05, sample: 0.02)`, m and s (of a lattice gas `sample: 5.0`, steps), \
     and run it again";

/// Reads the run in `directory` and gives it the name `name`. `outline_of` reads the outline of its scene.
///
/// # Errors
/// If a file is missing or malformed. The fault names the file and suggests a remedy.
pub fn run(directory: &Path, name: &str, outline_of: ReadOutline) -> Result<Run, Fault> {
    if !directory.is_dir() {
        return Err(Fault::new("compare::no_run", format!("there is no run directory {}", directory.display()))
            .help("give run directories such as out/silo2d, or scenes (.ron) to be run first"));
    }
    refuse_odd(directory, Depth::Top)?;
    let summary = summary(&directory.join("summary.json"))?;
    let series = Table::read(&directory.join("series.csv"), "is it a run directory? `siloflow run` makes one")?;
    let (time_unit, times) = match series.finite("time_s")? {
        Some(times) => ("s", times),
        None => ("step", series.needed("step")?),
    };
    let rows: Vec<_> = times.into_iter().zip(series.needed("out")?).collect();
    let number = |keys: &[&str]| keys.iter().try_fold(&summary, |value, key| value.get(key)).and_then(Value::as_f64);
    let needed = |found: Option<f64>, key: &str| {
        found.ok_or_else(|| {
            let path = directory.join("summary.json");
            Fault::new("compare::summary", format!("{} has no number {key}", path.display()))
                .help("run the scene again with this version")
        })
    };
    let opened = number(&["door_open_time_s"]).or(number(&["door_open_step"])).unwrap_or(0.0);
    let released = number(&["grains", "released"]).or(number(&["particles", "entered"]));
    let has_field = summary.get("program").is_none_or(|program| program != "LAMMPS");
    Ok(Run {
        name: name.to_owned(),
        field: has_field.then(|| field(&directory.join("flow.csv"))).transpose()?,
        discharge: Curve::of_rows(&rows, needed(released, "grains.released or particles.entered")?, opened),
        time_unit,
        wall_s: needed(number(&["performance", "wall_s"]), "performance.wall_s")?,
        outline: outline_of(&directory.join("scene.ron")),
    })
}

fn summary(path: &Path) -> Result<Value, Fault> {
    let text = own_files::read_text(path, file::RESULT_BYTES).map_err(|error| {
        Fault::new("compare::no_summary", format!("could not read {}: {error}", path.display()))
            .help("a run writes it when it ends: has this one ended? `siloflow run` makes run directories")
    })?;
    serde_json::from_str(&text).map_err(|error| {
        Fault::new("compare::summary", format!("{} is not JSON: {error}", path.display())).help("run the scene again")
    })
}

fn field(path: &Path) -> Result<Field, Fault> {
    let table = Table::read(path, NO_FLOW)?;
    let velocity = |axis: &str| match table.finite(&format!("v{axis}_m_per_step"))? {
        Some(column) => Ok(column),
        None => table.needed(&format!("v{axis}_m_per_s")),
    };
    let x = table.needed("x_m")?;
    let y = table.needed("y_m")?;
    let count = table.needed("count")?;
    let samples = table.needed("samples")?;
    let vx = velocity("x")?;
    let vy = velocity("y")?;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count; saturates")]
    let means: Vec<_> = (0..x.len())
        .map(|n| FlowMeans { x: x[n], y: y[n], samples: samples[n] as u64, count: count[n], vx: vx[n], vy: vy[n] })
        .collect();
    Field::new(&means).ok_or_else(|| {
        Fault::new("compare::no_flow", format!("{} has no velocity field: {} rows", path.display(), means.len())).help(
            "samples are taken while the fraction of grains that are out is from `flow.from` to `flow.to`: did the run \
             reach `flow.from`?",
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene_facts::Outline;

    fn directory(files: &[(&str, &str)]) -> tempfile::TempDir {
        let here = tempfile::tempdir().unwrap();
        for (name, text) in files {
            std::fs::write(here.path().join(name), text).unwrap();
        }
        here
    }

    const SUMMARY: (&str, &str) =
        ("summary.json", r#"{"particles": {"entered": 8}, "door_open_step": 2, "performance": {"wall_s": 0.5}}"#);
    const SERIES: (&str, &str) = ("series.csv", "step,out\n0,0\n2,0\n4,4\n6,8\n");
    const FLOW: (&str, &str) = (
        "flow.csv",
        "x_m,y_m,samples,count,vx_m_per_step,vy_m_per_step\n0.05,0.05,10,2.5,0,-0.5\n0.15,0.05,10,1,0,-1\n",
    );

    #[test]
    fn run_directory_of_a_lattice_gas_is_read_in_steps() {
        let run = run(directory(&[SUMMARY, SERIES, FLOW]).path(), "lattice", &|_| Outline::default()).unwrap();
        assert_eq!((run.time_unit, run.wall_s), ("step", 0.5));
        assert_eq!(run.discharge.points(), [(0.0, 0.0), (2.0, 0.5), (4.0, 1.0)]);
        let cells: Vec<_> = run.field.unwrap().seen(0.0).map(|(key, cell)| (key, cell.looks, cell.down)).collect();
        assert_eq!(cells, [([0, 0], 25.0, 0.5), ([0, 1], 10.0, 1.0)]);
    }

    #[test]
    fn a_run_of_lammps_has_no_field() {
        let summary = r#"{"program": "LAMMPS", "grains": {"released": 8}, "door_open_time_s": 2, "performance": {"wall_s": 0.5}}"#;
        let series = ("series.csv", "time_s,out\n0,0\n2,0\n4,4\n6,8\n");
        let run =
            run(directory(&[("summary.json", summary), series]).path(), "lammps", &|_| Outline::default()).unwrap();
        assert!(run.field.is_none() && run.time_unit == "s");
        assert_eq!(run.discharge.points(), [(0.0, 0.0), (2.0, 0.5), (4.0, 1.0)]);
    }

    #[test]
    fn missing_or_malformed_files_are_named() {
        let code = |files: &[(&str, &str)]| run(directory(files).path(), "run", &|_| Outline::default()).unwrap_err();
        assert_eq!(code(&[SERIES, FLOW]).code(), "compare::no_summary");
        let fault = code(&[SUMMARY, SERIES]);
        assert!(fault.to_string().contains("flow.csv"), "{fault}");
        assert_eq!(code(&[SUMMARY, SERIES, ("flow.csv", FLOW.1.lines().next().unwrap())]).code(), "compare::no_flow");
        assert_eq!(code(&[("summary.json", "{}"), SERIES, FLOW]).code(), "compare::summary");
        let fault = code(&[SUMMARY, ("series.csv", "step,out\n0,zero\n"), FLOW]);
        assert!(fault.to_string().contains("line 2, column out"), "{fault}");
        let fault = code(&[SUMMARY, ("series.csv", "time,out\n0,0\n"), FLOW]);
        assert!(fault.to_string().contains("no column step"), "{fault}");
    }
}
