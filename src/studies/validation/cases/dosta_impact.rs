//! The impact of Dosta et al., Comput. Phys. Commun. 296, 109066 (2024), case 3: a steel ball in a bed of 25,000 spheres.
//!
//! The published figures are means over ten beds for each of eight codes, computed from the table of the publication. Left out are a column of LIGGGHTS that disagrees
//! with its others by decimetres, and a column of MUSEN whose bed is another one. The table has heights every millisecond, and the ball turns within a fraction of it, so the
//! lowest of such heights lies above the deepest point, in LIGGGHTS by 0.2 to 0.6 mm. siloflow's path is therefore read at the same times. Only LIGGGHTS has a height every 50 us.
//!
//! The bed decides how far the ball is ahead: LIGGGHTS and MUSEN, run with the file of positions of the published set-up (`dem-bulk-dosta2024` of peclet-examples),
//! are about 1.1 ms earlier at the deepest point than in the ten beds. The file `dosta_impact.csv` has the means of the codes in the ten beds every millisecond, the
//! lowest and the highest of them, and both runs with the file.
//!
//! The rebound is chaotic and is not compared.

use crate::studies::validation::runs::{FinishedRun, Studies};
use crate::studies::validation::verdict::{FigureRow, Judgement, Picture, Rule};
use crate::studies::validation::{Case, file};
use siloflow_figures::diagram::{Axis, Curve, Key, Panel, colour, sheet};
use siloflow_figures::statistics::digits::digits;
use siloflow_figures::statistics::mean::Mean;
use siloflow_figures::statistics::points::interpolated;
use siloflow_files::table::Table;
use siloflow_text::fault::Fault;

/// The case.
pub const CASE: Case = Case {
    name: "dosta-impact",
    title: "Impact of Dosta et al. 2024",
    sources: "Dosta et al. 2024, Comput. Phys. Commun. 296, 109066, case 3, 25,000 grains: means over ten beds of MercuryDPM, MUSEN, MFiX, Kratos, LIGGGHTS, \
              Blaze-DEM, GranOO and Yade (table of `dem_benchmark_plots`); runs with the published file of positions from `dem-bulk-dosta2024` of peclet-examples.",
    files: &[
        file!("dosta-impact", "impact.ron"),
        file!("dosta-impact", "short.ron"),
        file!("dosta-impact", "full.ron"),
    ],
    short: &["short.ron"],
    full: &["full.ron"],
    judge,
};

/// Lowest of the heights every millisecond: mean over the beds and standard deviation, mm.
const CODES: [(&str, f64, f64); 8] = [
    ("MercuryDPM", -78.48, 0.19),
    ("MUSEN", -78.40, 0.14),
    ("MFiX", -78.33, 0.19),
    ("Kratos", -78.44, 0.10),
    ("LIGGGHTS", -78.43, 0.13),
    ("Blaze-DEM", -78.40, 0.15),
    ("GranOO", -78.60, 0.10),
    ("Yade", -78.50, 0.22),
];

/// Deepest point in LIGGGHTS, which has a height every 50 us: its mean over nine beds, mm, and its time, ms; and both with the file of positions.
const FINE: (f64, f64) = (-78.85, 31.48);
const FINE_FILE: (f64, f64) = (-78.91, 30.35);

/// Species of the ball.
const BALL: &str = "1";

/// Returns the path of the ball: time since the start (ms), height of its centre (mm).
fn path(run: &FinishedRun) -> Result<Vec<(f64, f64)>, Fault> {
    // At this time the ball has the published place and velocity.
    let start = run.number("parameters.start").unwrap_or(f64::NAN);
    let table = run.table("centres.csv")?;
    let species = table.texts("species").unwrap_or_default();
    let times = table.needed("time_s")?;
    let heights = table.numbers("z_m").unwrap_or_default();
    let rows = species.into_iter().zip(times.into_iter().zip(heights)).filter(|(species, _)| *species == BALL);
    Ok(rows.map(|(_, (time, z))| (1e3 * (time - start), 1e3 * z)).filter(|(time, _)| *time >= -1e-6).collect())
}

/// Returns the lowest height of a path, with its time.
fn lowest(path: &[(f64, f64)]) -> Option<(f64, f64)> {
    path.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1))
}

/// Returns the path at whole milliseconds.
fn every_millisecond(path: &[(f64, f64)]) -> Vec<(f64, f64)> {
    (0..=35).map(f64::from).filter_map(|time| Some((time, interpolated(path, time)?))).collect()
}

fn judge(studies: &Studies) -> Result<Judgement, Fault> {
    let paths = studies.all().map(path).collect::<Result<Vec<_>, _>>()?;
    let published = Table::parse("dosta_impact.csv", include_str!("dosta_impact.csv"))?;
    let (times, depths): (Vec<f64>, Vec<f64>) = paths.iter().filter_map(|path| lowest(path)).unzip();
    let sampled: Vec<f64> = paths.iter().filter_map(|path| Some(lowest(&every_millisecond(path))?.1)).collect();
    let mut judgement = Judgement { rows: vec![depth(&sampled)], ..Judgement::default() };
    if sampled.len() > 1 {
        let count = f64::from(u16::try_from(sampled.len()).unwrap_or(u16::MAX));
        let spread = Mean::of(&sampled).map_or(f64::NAN, |mean| mean.error * count.sqrt());
        let row = FigureRow::new("its standard deviation over the beds", "mm", spread);
        judgement.rows.push(row.remark("The codes have 0.10 to 0.22 mm"));
    }
    let row = FigureRow::of_mean("deepest point", "mm", Mean::of(&depths));
    judgement.rows.push(row.published(FINE.0, Rule::Reported).remark(format!(
        "Published: LIGGGHTS, nine beds, a height every 50 us. With the file of positions it has {} mm",
        FINE_FILE.0
    )));
    let row = FigureRow::of_mean("time of the deepest point", "ms", Mean::of(&times));
    judgement.rows.push(
        row.published(FINE.1, Rule::Reported)
            .remark(format!("Published: LIGGGHTS, nine beds. With the file of positions it has {} ms", FINE_FILE.1)),
    );
    for time in [22.0, 24.0, 28.0] {
        let found = paths.iter().filter_map(|path| interpolated(path, time)).collect::<Vec<_>>();
        let row = FigureRow::of_mean(format!("height {time} ms after the start"), "mm", Mean::of(&found));
        let at = |column: &str| Ok(interpolated(&curve(&published, column)?, time).unwrap_or(f64::NAN));
        judgement.rows.push(row.published(at("mean_mm")?, Rule::Reported).remark(format!(
            "With the file of positions: LIGGGHTS {}, MUSEN {}",
            digits(at("liggghts_file_mm")?, 4),
            digits(at("musen_file_mm")?, 4)
        )));
    }
    judgement.pictures.push(picture(&paths, &published)?);
    judgement.remarks.push(
        "Spheres, box, ball and laws are the published ones. The beds are made here: spheres begin at random places and settle for 0.1 s while the ball flies freely \
         towards its published place and velocity. The published beds could not be read."
            .to_owned(),
    );
    Ok(judgement)
}

/// The row of the lowest height of those every millisecond.
fn depth(sampled: &[f64]) -> FigureRow {
    let depths = CODES.map(|code| code.1);
    let low = depths.iter().copied().fold(f64::INFINITY, f64::min);
    let high = depths.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let row = FigureRow::of_mean("lowest height of those every millisecond", "mm", Mean::of(sampled));
    let row = FigureRow { published: Some(0.5 * (low + high)), ..row };
    if sampled.len() > 1 {
        return row.rule(Rule::Between(low, high)).remark("The bounds are the means of the eight codes");
    }
    // One bed may be as far off as twice its deviation.
    let deviation = CODES.iter().map(|code| code.2).fold(0.0, f64::max);
    row.rule(Rule::Between(low - 2.0 * deviation, high + 2.0 * deviation))
        .remark("One bed: the means of the codes, widened by two deviations")
}

/// Returns a column of the published table over its time, ms.
fn curve(published: &Table, column: &str) -> Result<Vec<(f64, f64)>, Fault> {
    Ok(published.needed("time_ms")?.into_iter().zip(published.needed(column)?).collect())
}

fn picture(paths: &[Vec<(f64, f64)>], published: &Table) -> Result<Picture, Fault> {
    let codes = [
        ("eight codes, ten beds, mean", 2, "mean_mm"),
        ("LIGGGHTS, file of positions", 3, "liggghts_file_mm"),
        ("MUSEN, file of positions", 4, "musen_file_mm"),
    ];
    let mut dots = Vec::new();
    for (name, number, column) in codes {
        dots.push((name, number, curve(published, column)?));
    }
    let panel = |title: &str, x: (f64, f64), y: (f64, f64)| {
        let inside = |points: &[(f64, f64)]| {
            let is_inside = |point: &(f64, f64)| (x.0..=x.1).contains(&point.0) && (y.0..=y.1).contains(&point.1);
            points.iter().copied().filter(is_inside).collect()
        };
        let of_bed = |(number, path): (usize, &Vec<(f64, f64)>)| {
            let name = if number == 0 { "siloflow, each bed".to_owned() } else { String::new() };
            Curve { name, colour: colour(1), points: inside(path), has_line: true, ..Curve::default() }
        };
        let of_codes = |(name, number, points): &(&str, usize, Vec<(f64, f64)>)| Curve {
            name: (*name).to_owned(),
            colour: colour(*number),
            points: inside(points),
            has_dots: true,
            ..Curve::default()
        };
        Panel {
            curves: paths.iter().enumerate().map(of_bed).chain(dots.iter().map(of_codes)).collect(),
            key: Key::LowerLeft,
            ..Panel::new(
                title,
                Axis::linear("time after the published start, ms", x.0, x.1),
                Axis::linear("height of the ball's centre, mm", y.0, y.1),
            )
        }
    };
    let whole = panel("Path of the ball", (0.0, 35.0), (-100.0, 60.0));
    let deepest = panel("In the bed", (20.0, 35.0), (-90.0, -40.0));
    let caption =
        "Height of the ball's centre. The floor is at -90.2 mm, and the ball would touch it at -80.2 mm.".to_owned();
    Ok(Picture { name: "", svg: sheet(&[whole, deepest], 2), caption })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::studies::validation::verdict::Verdict;

    #[test]
    fn a_lowest_height_between_the_codes_passes_and_one_beside_them_misses() {
        assert_eq!(depth(&[-78.4, -78.5]).verdict(), Verdict::Pass);
        assert_eq!(depth(&[-78.7, -78.6]).verdict(), Verdict::Miss);
        assert_eq!(depth(&[-78.7]).verdict(), Verdict::Pass, "one bed");
        assert_eq!(depth(&[-79.1]).verdict(), Verdict::Miss, "one bed");
    }

    #[test]
    fn a_path_read_every_millisecond_misses_its_turning_point() {
        // Down with 2 mm/ms to -79 mm at 30.4 ms, and up.
        let path: Vec<_> = (0..=350).map(f64::from).map(|i| (0.1 * i, -79.0 + 2.0 * (0.1 * i - 30.4).abs())).collect();
        assert!((lowest(&path).unwrap().1 + 79.0).abs() < 1e-9);
        assert!((lowest(&every_millisecond(&path)).unwrap().1 + 78.2).abs() < 1e-9);
    }
}
