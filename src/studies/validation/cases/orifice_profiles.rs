//! Profiles of velocity and solid fraction across the orifice of a planar silo, with the laws of Janda, Zuriguel and Maza, Phys. Rev. Lett. 108, 248001 (2012):
//!
//! v(x) = sqrt(2 gamma g R) (1 - (x/R)^2)^(1/2), phi(x) = phi_0 (1 - (x/R)^2)^(1/nu), phi_0 = phi_inf (1 - a_1 exp(-R/a_2)),
//!
//! with R half the width of the orifice and x the distance from its middle.
//!
//! `fields.csv` has the density of the centres of grains in cells of a tenth of a diameter d. The solid fraction at a point is the share of the time in
//! which a grain covers it: the integral of the number density over the disc of radius d/2 about the point. The velocity is that of the covering
//! grains, the same integral of density times velocity over that of the density. Both are taken on the line of the floor.
//!
//! Fits use |x| < 0.9 R. gamma is the least-squares figure with the exponent 1/2; the exponents are slopes of the logarithms.

mod profile;

use self::profile::{DIAMETER, GRAVITY, Point, Profile};
use crate::studies::validation::groups::groups_by;
use crate::studies::validation::runs::Studies;
use crate::studies::validation::verdict::{FigureRow, Judgement, Picture, Rule};
use crate::studies::validation::{Case, file};
use siloflow_figures::diagram::{Axis, Curve, Key, Panel, colour, sheet};
use siloflow_figures::statistics::fit::best_line;
use siloflow_figures::statistics::mean;
use siloflow_figures::statistics::mean::Mean;
use siloflow_text::fault::Fault;

/// The case.
pub const CASE: Case = Case {
    name: "orifice-profiles",
    title: "Profiles at the orifice (Janda et al. 2012)",
    sources: "Janda, Zuriguel and Maza 2012, Phys. Rev. Lett. 108, 248001: the laws; its constants are quoted from memory, since the paper could not be \
              read, and are no rules.",
    files: &[
        file!("orifice-profiles", "silo.ron"),
        file!("orifice-profiles", "short.ron"),
        file!("orifice-profiles", "full.ron"),
    ],
    short: &["short.ron"],
    full: &["full.ron"],
    judge,
};

fn judge(studies: &Studies) -> Result<Judgement, Fault> {
    let runs = studies.first_of(&["short.ron", "full.ron"]);
    let mut groups = Vec::new();
    for (_, of_width) in groups_by(runs, |run| run.value("parameters.width")) {
        // A clogged run has no steady profile.
        let flowing = of_width.into_iter().filter(|run| run.status() != "clogged");
        groups.push(flowing.map(Profile::of).collect::<Result<Vec<_>, _>>()?);
    }
    groups.retain(|group| !group.is_empty());
    Ok(judgement_of(&groups))
}

/// Returns the mean over the seeds of one width.
fn mean(group: &[Profile], of: impl Fn(&Profile) -> f64) -> Mean {
    mean::mean(group.iter().map(of)).unwrap_or(Mean { value: f64::NAN, error: 0.0 })
}

/// Returns the mean over the widths of the means over their seeds.
fn over_widths(groups: &[Vec<Profile>], of: fn(&Profile) -> f64) -> Option<Mean> {
    mean::mean(groups.iter().map(|group| mean(group, of).value))
}

/// Judges the profiles, one group for each width.
fn judgement_of(groups: &[Vec<Profile>]) -> Judgement {
    let mut judgement = Judgement::default();
    let unread = "published constant not read in the source: no rule";
    let over = |of: fn(&Profile) -> f64| over_widths(groups, of);
    let rows = &mut judgement.rows;
    rows.push(
        FigureRow::of_mean("gamma, mean over the widths", "", over(|it| it.gamma))
            .published(1.07, Rule::Reported)
            .remark(unread),
    );
    rows.push(
        FigureRow::of_mean("exponent of the velocity, mean over the widths", "", over(|it| it.velocity_exponent))
            .published(0.5, Rule::Reported)
            .remark(unread),
    );
    rows.push(
        FigureRow::of_mean("1/nu, mean over the widths", "", over(|it| it.fraction_exponent))
            .published(0.22, Rule::Reported)
            .remark(unread),
    );
    let middles: Vec<_> = groups.iter().map(|group| (1e3 * group[0].half, mean(group, |it| it.middle).value)).collect();
    let decay = fraction_against_width(&middles);
    if let Some([limit, depth, length]) = decay {
        rows.push(FigureRow::new("phi_inf", "", limit).published(0.83, Rule::Reported).remark(unread));
        rows.push(FigureRow::new("a_1", "", depth).published(0.50, Rule::Reported).remark(unread));
        rows.push(FigureRow::new("a_2", "mm", length).published(3.3, Rule::Reported).remark(unread));
    }
    rows.push(
        FigureRow::of_mean(
            "counted rate over the law of Mankoc et al. for discs, mean over the widths",
            "",
            over(mankoc),
        )
        .published(1.0, Rule::Reported)
        .remark(unread),
    );
    for group in groups {
        let name = group[0].width();
        let row = |quantity: &str, of: fn(&Profile) -> f64| {
            FigureRow::of_mean(format!("{name}: {quantity}"), "", Some(mean(group, of)))
        };
        rows.push(row("gamma", |it| it.gamma));
        rows.push(row("phi_0", |it| it.middle));
        rows.push(
            row("flux of the profiles over the counted rate", |it| it.flux)
                .rule(Rule::Between(0.97, 1.03))
                .remark("two independent ways to the same rate"),
        );
    }
    judgement.pictures.push(Picture {
        name: "",
        svg: sheet(&[velocities(groups), fractions(groups), middle_panel(&middles, decay)], 3),
        caption: "Left: velocity over sqrt(2 g R), with the law of the mean gamma dashed. Middle: solid fraction over its fitted value in the middle, with \
                  the law of the mean exponent dashed. Right: that value against the half-width, with its fit."
            .to_owned(),
    });
    judgement.remarks.push(
        "Discs with friction 0.5 and restitution 0.5 in the plane; the experiment has steel spheres between two glass plates, whose friction slows the grains. The solid fraction is the share of \
         time in which a point of the floor's line is covered. gamma refers to half the width; with the whole width in its place it would be half as large. With the quoted constants \
         the laws give a flux 16 to 23 % below the rate of Mankoc et al. 2007 from the same laboratory, which the counted rates agree with, so the quoted gamma is in doubt \
         until the paper is read."
            .to_owned(),
    );
    judgement
}

/// Returns the rate over the law W = 108/s (1 - exp(-0.23 (D/d - 1))/2) (D/d - 1)^(3/2) of Mankoc et al., Granular Matter 9, 407 (2007), for discs of 1 mm.
fn mankoc(it: &Profile) -> f64 {
    let free = 2.0 * it.half / DIAMETER - 1.0;
    it.rate / (108.0 * (1.0 - 0.5 * (-0.23 * free).exp()) * free.powf(1.5))
}

/// Fits phi_0 = phi_inf (1 - a_1 exp(-R/a_2)) to points (R in mm, phi_0). Returns phi_inf, a_1 and a_2 (mm); `None` below four points.
fn fraction_against_width(middles: &[(f64, f64)]) -> Option<[f64; 3]> {
    if middles.len() < 4 {
        return None;
    }
    let best = best_line(middles, (10..=1000).map(|n| 0.02 * f64::from(n)), |half, length| (-half / length).exp())?;
    let limit = best.fitted.value("intercept")?;
    Some([limit, -best.fitted.value("slope")? / limit, best.candidate])
}

/// Returns a panel of scaled profiles, one curve a width, with a law.
fn scaled(
    groups: &[Vec<Profile>],
    y: Axis,
    title: &str,
    of: impl Fn(&Profile, &Point) -> f64,
    law: impl Fn(f64) -> f64,
) -> Panel {
    let mut curves: Vec<_> = groups
        .iter()
        .enumerate()
        .map(|(number, group)| {
            let first = &group[0];
            Curve {
                name: first.width(),
                colour: colour(number + 1),
                points: first.points.iter().map(|point| (point.0 / first.half, of(first, point))).collect(),
                has_line: true,
                ..Curve::default()
            }
        })
        .collect();
    let points = (-100..=100).map(|n| 0.01 * f64::from(n)).map(|x| (x, law(1.0 - x * x))).collect();
    curves.push(Curve { colour: colour(0), points, has_line: true, is_dashed: true, ..Curve::default() });
    Panel { curves, key: Key::Above, ..Panel::new(title, Axis::linear("x / R", -1.0, 1.0), y) }
}

fn velocities(groups: &[Vec<Profile>]) -> Panel {
    let gamma = over_widths(groups, |it| it.gamma).map_or(f64::NAN, |mean| mean.value);
    let y = Axis::linear("velocity / sqrt(2 g R)", 0.0, 1.8);
    scaled(groups, y, "Velocity", |it, point| point.2 / (2.0 * GRAVITY * it.half).sqrt(), move |s| (gamma * s).sqrt())
}

fn fractions(groups: &[Vec<Profile>]) -> Panel {
    let exponent = over_widths(groups, |it| it.fraction_exponent).map_or(f64::NAN, |mean| mean.value);
    let y = Axis::linear("solid fraction / phi_0", 0.0, 1.2);
    scaled(groups, y, "Solid fraction", |it, point| point.1 / it.middle, move |s| s.powf(exponent))
}

fn middle_panel(middles: &[(f64, f64)], decay: Option<[f64; 3]>) -> Panel {
    let mut curves = vec![Curve { colour: colour(1), points: middles.to_vec(), has_dots: true, ..Curve::default() }];
    let last = middles.last().map_or(1.0, |point| point.0);
    if let Some([limit, depth, length]) = decay {
        let places = (0..=100).map(|n| last * (0.2 + 0.008 * f64::from(n)));
        let points = places.map(|half| (half, limit * (1.0 - depth * (-half / length).exp()))).collect();
        curves.push(Curve { colour: colour(0), points, has_line: true, is_dashed: true, ..Curve::default() });
    }
    let y = Axis::around("phi_0", curves.iter().flat_map(|curve| &curve.points).map(|point| point.1));
    Panel { curves, ..Panel::new("Middle of the orifice", Axis::linear("R, mm", 0.0, last * 1.05), y) }
}

#[cfg(test)]
mod tests {
    use super::profile::tests::exact;
    use super::*;
    use crate::studies::validation::verdict::Verdict;

    #[test]
    fn the_constants_of_the_middle_are_recovered() {
        let middles: Vec<_> =
            [3.0, 4.0, 5.5, 7.0, 10.0].map(|half: f64| (half, 0.83 * (1.0 - 0.5 * (-half / 3.3).exp()))).to_vec();
        let [limit, depth, length] = fraction_against_width(&middles).unwrap();
        assert!((limit - 0.83).abs() < 1e-6 && (depth - 0.5).abs() < 1e-6 && (length - 3.3).abs() < 1e-6);
        assert!(fraction_against_width(&middles[..3]).is_none());
    }

    #[test]
    fn a_flux_that_is_not_the_counted_rate_is_a_miss() {
        let group = |share: f64| vec![Profile { flux: share, ..exact(0.006, 1.07, 0.22, 0.76) }];
        let misses = |share| judgement_of(&[group(share)]).count(Verdict::Miss);
        assert_eq!((misses(1.01), misses(1.2)), (0, 1));
    }
}
