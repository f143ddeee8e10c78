//! Tests 1 to 5 of Chung and Ooi, Granular Matter 13, 643 (2011): impacts of one or two spheres.
//!
//! | test | figures | file |
//! |---|---|---|
//! | 1, 2: elastic impacts | force against overlap and time, from the contacts in `frames.bin` | `normal` |
//! | 3: damped impacts | restitution, from `state.csv` | `normal` |
//! | 4, 5: oblique impacts | tangential restitution, spin and recoil, from `state.csv` | `oblique` |
//!
//! The paper's curves are those that Kratos has digitised (`published`). The bound of 5 % is the one of Kratos's own validation. At small angles the
//! paper's codes use other laws of the tangential spring; `law` integrates those.

mod law;
mod normal;
mod oblique;
mod published;

use crate::studies::validation::runs::{FinishedRun, Studies};
use crate::studies::validation::verdict::{FigureRow, Judgement, Picture, Rule};
use crate::studies::validation::{Case, file};
use siloflow_figures::diagram::{Curve, colour, sheet};
use siloflow_figures::statistics::points::interpolated;
use siloflow_text::fault::Fault;

/// The sweep files, one for each test.
const SWEEPS: [&str; 5] = ["test-1.ron", "test-2.ron", "test-3.ron", "test-4.ron", "test-5.ron"];

/// The case.
pub const CASE: Case = Case {
    name: "chung-ooi",
    title: "Impacts of Chung and Ooi 2011, tests 1 to 5",
    sources: "Chung and Ooi 2011, Granular Matter 13, 643, as digitised by Kratos; experiment: Kharaz et al. 2001, Powder \
              Technology 120, 281.",
    files: &[
        file!("chung-ooi", "impact-1.ron"),
        file!("chung-ooi", "impact-2.ron"),
        file!("chung-ooi", "impact-3.ron"),
        file!("chung-ooi", "impact-4.ron"),
        file!("chung-ooi", "impact-5.ron"),
        file!("chung-ooi", "test-1.ron"),
        file!("chung-ooi", "test-2.ron"),
        file!("chung-ooi", "test-3.ron"),
        file!("chung-ooi", "test-4.ron"),
        file!("chung-ooi", "test-5.ron"),
    ],
    short: &SWEEPS,
    full: &SWEEPS,
    judge,
};

/// Bound of Kratos's own validation, in percent.
const BOUND: Rule = Rule::Between(0.0, 5.0);

/// A curve: abscissa, ordinate.
type Points = Vec<(f64, f64)>;

fn judge(studies: &Studies) -> Result<Judgement, Fault> {
    let mut judgement = Judgement::default();
    let [first, second, third, fourth, fifth] = SWEEPS.map(|name| studies.runs(name));
    let mut panels = vec![
        normal::elastic(&normal::SPHERES, first, &mut judgement.rows)?,
        normal::elastic(&normal::PLANE, second, &mut judgement.rows)?,
        normal::damped(third, &mut judgement.rows)?,
    ];
    panels.extend(oblique::constant_speed(fourth, &mut judgement.rows)?);
    panels.extend(oblique::constant_normal_velocity(fifth, &mut judgement.rows)?);
    let caption = "Dots: published. Lines: siloflow. Dashed: the law of the tangential spring with which the published curve comes out, as differential \
                   equations."
        .to_owned();
    judgement.pictures.push(Picture { name: "", svg: sheet(&panels, 3), caption });
    judgement.remarks.push(
        "At small angles the published curves depend on how a code treats the tangential spring while its stiffness grows and shrinks with the overlap. \
         siloflow keeps the force while the stiffness grows, and lowers it in proportion while the stiffness shrinks, so that a contact never creates energy. \
         The curves of test 4 come out with the force k_t S of the present stiffness. The curves of test 5 come out with half the stiffness and a force \
         that changes by k_t dS at all times. Half the stiffness is that of a plane whose shear modulus is the sphere's instead of a thousand times as large; \
         the paper could not be read for its reason. In both laws a stretched spring can gain energy from nowhere. The finite elements of the paper, which know no such law, lie nearer to siloflow \
         than to the paper's own curve (test 5)."
            .to_owned(),
    );
    Ok(judgement)
}

/// Returns the runs of a material of a sweep, by another axis.
fn by_axis<'a>(runs: &'a [FinishedRun], material: f64, key: &str) -> Vec<(f64, &'a FinishedRun)> {
    let found = runs.iter().filter(|run| run.value("parameters.material") == Some(material));
    let mut found: Vec<_> = found.map(|run| (run.value(key).unwrap_or(f64::NAN), run)).collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found
}

/// Returns the numbers of the only grain at the end of a run.
fn end<const N: usize>(run: &FinishedRun, columns: [&str; N]) -> Result<[f64; N], Fault> {
    let table = run.table("state.csv")?;
    let mut numbers = [f64::NAN; N];
    for (number, column) in numbers.iter_mut().zip(columns) {
        *number = table.needed(column)?.first().copied().unwrap_or(f64::NAN);
    }
    Ok(numbers)
}

/// Returns the largest deviation of a curve from published points, in percent of the largest published number, or of each.
fn deviation(curve: &[(f64, f64)], published: &[(f64, f64)], is_of_each: bool) -> f64 {
    let largest = published.iter().fold(0.0f64, |largest, (_, y)| largest.max(y.abs()));
    let of = |&(x, y): &(f64, f64)| {
        let found = interpolated(curve, x).unwrap_or(f64::NAN);
        100.0 * (found - y).abs() / if is_of_each { y.abs() } else { largest }
    };
    let all: Vec<_> = published.iter().map(of).collect();
    // `max` would pass over a number that is missing.
    if all.iter().any(|percent| percent.is_nan()) { f64::NAN } else { all.into_iter().fold(0.0, f64::max) }
}

/// Returns a row for a deviation with Kratos's bound.
fn bounded(quantity: String, percent: f64) -> FigureRow {
    FigureRow::new(quantity, "%", percent).rule(BOUND)
}

/// Returns published points as dots.
fn dots(name: &str, number: usize, points: &[(f64, f64)]) -> Curve {
    Curve { name: name.to_owned(), colour: colour(number), points: points.to_vec(), has_dots: true, ..Curve::default() }
}

/// Returns a curve as a line.
fn line(name: &str, number: usize, points: Points) -> Curve {
    Curve { name: name.to_owned(), colour: colour(number), points, has_line: true, ..Curve::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_deviation_is_that_of_the_worst_point_and_needs_all_points() {
        let curve = [(0.0, 0.0), (10.0, 100.0)];
        let published = [(1.0, 10.0), (5.0, 40.0), (9.0, 90.0)];
        // 50 instead of 40, of 90 and of 40. Round-off of a few operations.
        assert!((deviation(&curve, &published, false) - 1000.0 / 90.0).abs() < 1e-12);
        assert!((deviation(&curve, &published, true) - 25.0).abs() < 1e-12);
        assert!(deviation(&curve[..1], &published, true).is_nan());
        assert!(deviation(&curve, &[(5.0, 50.0), (11.0, 1.0)], true).is_nan());
        assert!(deviation(&curve, &[(11.0, 1.0), (5.0, 50.0)], true).is_nan());
    }
}
