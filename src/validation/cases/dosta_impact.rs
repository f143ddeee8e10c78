//! The impact of Dosta et al., Comput. Phys. Commun. 296, 109066 (2024), case 3: a steel ball in a bed of 25,000 spheres.
//!
//! The published figures are means over ten beds for each of seven codes, computed from the table of the publication. The deepest point agrees between the codes
//! to 0.27 mm. The rebound does not, because it is chaotic, and is not compared.

use crate::fault::Fault;
use crate::lattice_study::results::Mean;
use crate::validation::runs::{Run, Studies};
use crate::validation::verdict::{Judgement, Picture, Row, Rule};
use crate::validation::{Case, file};
use crate::writers::plot::{Axis, Curve, Key, Panel, colour, sheet};

/// The case.
pub const CASE: Case = Case {
    name: "dosta-impact",
    title: "Impact of Dosta et al. 2024",
    sources: "Dosta et al. 2024, Comput. Phys. Commun. 296, 109066, case 3, 25,000 grains: means over ten beds of MercuryDPM, MUSEN, MFiX, Kratos, Blaze-DEM, \
              GranOO and Yade.",
    files: &[
        file!("dosta-impact", "impact.ron"),
        file!("dosta-impact", "short.ron"),
        file!("dosta-impact", "full.ron"),
    ],
    short: &["short.ron"],
    full: &["full.ron"],
    judge,
};

/// Deepest place of the ball's centre (mm) and its standard deviation over ten beds, and the time of it (ms).
const CODES: [(&str, f64, f64, f64); 7] = [
    ("MercuryDPM", -78.48, 0.18, 31.1),
    ("MUSEN", -78.37, 0.16, 31.1),
    ("MFiX", -78.33, 0.18, 31.4),
    ("Kratos", -78.44, 0.10, 31.0),
    ("Blaze-DEM", -78.40, 0.14, 31.2),
    ("GranOO", -78.60, 0.10, 31.0),
    ("Yade", -78.50, 0.21, 32.0),
];

/// Species of the ball.
const BALL: &str = "1";

/// Returns the path of the ball: time since the start (ms), height of its centre (mm).
fn path(run: &Run) -> Result<Vec<(f64, f64)>, Fault> {
    // At this time the ball has the published place and velocity.
    let start = run.number("parameters.start").unwrap_or(f64::NAN);
    let table = run.table("centres.csv")?;
    let species = table.texts("species").unwrap_or_default();
    let (times, heights) = (table.needed("time_s")?, table.numbers("z_m").unwrap_or_default());
    let rows = species.into_iter().zip(times.into_iter().zip(heights)).filter(|(species, _)| *species == BALL);
    Ok(rows.map(|(_, (time, z))| (1e3 * (time - start), 1e3 * z)).filter(|(time, _)| *time >= -1e-6).collect())
}

fn judge(studies: &Studies) -> Result<Judgement, Fault> {
    let paths = studies.all().map(path).collect::<Result<Vec<_>, _>>()?;
    let deepest = |path: &Vec<(f64, f64)>| path.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1));
    let (times, depths): (Vec<f64>, Vec<f64>) = paths.iter().filter_map(deepest).unzip();
    let ends = |of: fn(&(&str, f64, f64, f64)) -> f64| {
        CODES.iter().map(of).fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
    };
    let middle = |(low, high): (f64, f64)| 0.5 * (low + high);
    let (of_depth, of_time) = (ends(|code| code.1), ends(|code| code.3));
    let depth = Row::of_mean("deepest place of the ball's centre", "mm", Mean::of(&depths));
    let depth = if depths.len() > 1 {
        Row { published: Some(middle(of_depth)), ..depth }
            .rule(Rule::Between(of_depth.0, of_depth.1))
            .remark("The bounds are the means of the seven codes")
    } else {
        // One bed may be as far off as twice its deviation.
        let deviation = CODES.iter().map(|code| code.2).fold(0.0, f64::max);
        let (low, high) = (of_depth.0 - 2.0 * deviation, of_depth.1 + 2.0 * deviation);
        Row { published: Some(middle(of_depth)), ..depth }
            .rule(Rule::Between(low, high))
            .remark("One bed: the means of the codes, widened by two deviations")
    };
    let time = Row::of_mean("time of it", "ms", Mean::of(&times));
    let time = Row { published: Some(middle(of_time)), ..time }.remark("The codes have 31.0 to 32.0 ms");
    let count = f64::from(u16::try_from(depths.len()).unwrap_or(u16::MAX));
    let spread = Mean::of(&depths).map_or(f64::NAN, |mean| mean.error * count.sqrt());
    let spread = Row::new("standard deviation of the deepest place over the beds", "mm", spread)
        .remark("The codes have 0.10 to 0.21 mm");
    let mut judgement = Judgement { rows: vec![depth, time], ..Judgement::default() };
    if depths.len() > 1 {
        judgement.rows.push(spread);
    }
    judgement.pictures.push(picture(&paths));
    judgement.remarks.push(
        "Spheres, box, ball and laws are the published ones. The beds are made here: spheres begin at random places and settle for 0.1 s while the ball flies freely \
         towards its published place and velocity."
            .to_owned(),
    );
    Ok(judgement)
}

fn picture(paths: &[Vec<(f64, f64)>]) -> Picture {
    let panel = |title: &str, x: (f64, f64), y: (f64, f64)| {
        let is_inside = |point: &(f64, f64)| (x.0..=x.1).contains(&point.0) && (y.0..=y.1).contains(&point.1);
        let of_bed = |(number, path): (usize, &Vec<(f64, f64)>)| {
            let name = if number == 0 { "siloflow, each bed".to_owned() } else { String::new() };
            let points = path.iter().copied().filter(is_inside).collect();
            Curve { name, colour: colour(1), points, has_line: true, ..Curve::default() }
        };
        let codes = CODES.iter().map(|code| (code.3, code.1)).collect();
        let name = "deepest place of seven codes".to_owned();
        let published = Curve { name, colour: colour(2), points: codes, has_dots: true, ..Curve::default() };
        Panel {
            curves: paths.iter().enumerate().map(of_bed).chain([published]).collect(),
            key: Key::LowerLeft,
            ..Panel::new(
                title,
                Axis::linear("time after the published start, ms", x.0, x.1),
                Axis::linear("height of the ball's centre, mm", y.0, y.1),
            )
        }
    };
    let whole = panel("Path of the ball", (0.0, 35.0), (-100.0, 60.0));
    let deepest = panel("Near its deepest place", (28.0, 34.0), (-81.0, -76.0));
    let caption =
        "Height of the ball's centre. The floor is at -90.2 mm, and the ball would touch it at -80.2 mm.".to_owned();
    Picture { name: "", svg: sheet(&[whole, deepest], 2), caption }
}
