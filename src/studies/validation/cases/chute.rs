//! A layer of spheres that flows down a rough incline: friction against the inertial number, and Bagnold's profile.
//!
//! For each window of time `fields.csv` has the solid fraction phi, the velocity v along the incline and the stress in cells of a diameter d. The depth D of a cell is the solid
//! above its middle over the solid fraction of the bulk, in diameters, so it needs no free surface. Fits use the cells more than five diameters above the floor and more
//! than two below the surface.
//!
//! | figure | definition |
//! |---|---|
//! | mu | shear stress over normal stress, sums over the cells; tan(angle) in a steady layer |
//! | exponent n | least squares of v = v_s - A D^n over v_s, A and n; Bagnold's is 3/2 |
//! | I | shear rate times d over sqrt(P/rho), of the fit with n = 3/2: 3 A / (2 sqrt(phi g cos(angle) d)), the same at all depths |
//!
//! mu(I) = mu_s + (mu_2 - mu_s) / (1 + I_0/I) (Jop, Forterre and Pouliquen, Nature 441, 727, 2006). With layers of several depths at one angle the mean velocity
//! grows as the depth to the power of 3/2.

mod layer;

use self::layer::Layer;
use crate::studies::validation::runs::{FinishedRun, Studies};
use crate::studies::validation::verdict::{FigureRow, Judgement, Picture, Rule};
use crate::studies::validation::{Case, file};
use siloflow_figures::diagram::{Axis, Curve, Panel, colour, sheet};
use siloflow_figures::statistics::digits::short;
use siloflow_figures::statistics::fit::Law;
use siloflow_figures::statistics::fit::best_line;
use siloflow_figures::statistics::mean;
use siloflow_figures::statistics::mean::Mean;
use siloflow_text::fault::Fault;

/// The case.
pub const CASE: Case = Case {
    name: "chute",
    title: "Layer on a rough incline: mu(I) and Bagnold's profile",
    sources: "Jop, Forterre and Pouliquen 2006, Nature 441, 727: the law, with the constants of glass beads as quoted by another code; \
              Bagnold 1954, Proc. R. Soc. A 225, 49: the exponent 3/2; Silbert, Landry and Grest 2003, Phys. Fluids 15, 1 (abstract): no steady flow beyond an angle.",
    files: &[
        file!("chute", "layer.ron"),
        file!("chute", "short.ron"),
        file!("chute", "short-angles.ron"),
        file!("chute", "full.ron"),
        file!("chute", "full-angles.ron"),
        file!("chute", "full-depths.ron"),
        file!("chute", "full-stiff-depths.ron"),
        file!("chute", "full-stiffness.ron"),
    ],
    short: &["short.ron", "short-angles.ron"],
    full: &["full.ron", "full-angles.ron", "full-depths.ron", "full-stiff-depths.ron", "full-stiffness.ron"],
    judge,
};

/// mu_s, mu_2 and I_0 of glass beads (Jop), as a secondary source quotes them.
const GLASS: [f64; 3] = [0.382, 0.643, 0.279];

/// Largest relative deviation of the friction of a steady layer from the tangent of its angle.
const STEADY: f64 = 0.03;

/// Smallest depth of a thick layer, diameters.
const THICK: f64 = 28.5;

/// Angle from which on a thick layer may have no steady flow, degrees. There is such an angle (Silbert, Landry and Grest, Phys. Fluids 15, 1, 2003); its value is
/// the smallest of the full form's angles at which the layer accelerates.
const STEEP: f64 = 28.0;

fn mean(layers: &[Layer], of: impl Fn(&Layer) -> f64) -> Option<Mean> {
    mean::mean(layers.iter().map(of))
}

fn layers_of(runs: &[FinishedRun]) -> Result<Vec<Vec<Layer>>, Fault> {
    runs.iter().map(Layer::all).collect()
}

fn judge(studies: &Studies) -> Result<Judgement, Fault> {
    let thick = layers_of(studies.first_of(&["short.ron", "full.ron"]))?.concat();
    let angles = layers_of(studies.first_of(&["short-angles.ron", "full-angles.ron"]))?;
    let mut judgement = judgement_of(&thick, &angles);
    for run in studies.runs("full-stiffness.ron") {
        stiffness(run, &thick, &mut judgement)?;
    }
    judgement.rows.extend(
        depths(&layers_of(studies.runs("full-depths.ron"))?, "")
            .map(|row| row.known_miss("the grains at the floor are too soft: see the same with stiffer grains")),
    );
    judgement.rows.extend(depths(&layers_of(studies.runs("full-stiff-depths.ron"))?, "4 times the stiffness: "));
    Ok(judgement)
}

/// Returns the exponent of the mean velocity of layers of several depths; `None` without layers. `words` precede its name.
fn depths(layers: &[Vec<Layer>], words: &str) -> Option<FigureRow> {
    let point = |it: &Vec<Layer>| Some((mean(it, |it| it.depth)?.value, mean(it, |it| it.mean_velocity)?.value));
    let points: Vec<_> = layers.iter().filter_map(point).collect();
    let exponent = Law::Power.fit(&points)?.parameter("exponent")?;
    let name = format!("{words}exponent of the mean velocity over {} depths", points.len());
    Some(FigureRow::new(name, "", exponent.value).error(exponent.error).published(1.5, Rule::WithinAbsolute(0.15)))
}

/// Adds the rows of a run with another stiffness. Stiffer grains must flow alike; softer ones show where that ends.
fn stiffness(run: &FinishedRun, thick: &[Layer], judgement: &mut Judgement) -> Result<(), Fault> {
    let layers = Layer::all(run)?;
    let share = 2.0 / run.value("parameters.soft").unwrap_or(f64::NAN);
    let rows: [(&str, fn(&Layer) -> f64); 2] = [("exponent", |it| it.exponent), ("inertial number", |it| it.inertial)];
    for (name, of) in rows {
        let row = FigureRow::of_mean(format!("{share} times the stiffness: {name}"), "", mean(&layers, of));
        let other = mean(thick, of).map_or(f64::NAN, |mean| mean.value);
        let rule = if share > 1.0 { Rule::Within(0.1) } else { Rule::Reported };
        judgement.rows.push(row.published(other, rule).remark("the other value is that of the thick layer"));
    }
    Ok(())
}

/// Judges the windows of the thick layer, and of the layers of several angles.
fn judgement_of(thick: &[Layer], angles: &[Vec<Layer>]) -> Judgement {
    let mut judgement = Judgement::default();
    let rows = &mut judgement.rows;
    let depth = mean(thick, |it| it.depth).map_or(f64::NAN, |mean| mean.value);
    let tangent = thick.first().map_or(f64::NAN, |it| it.angle.tan());
    rows.push(
        FigureRow::new("depth of the thick layer", "d", depth)
            .rule(Rule::Between(THICK, 100.0))
            .remark("30 at a solid fraction of 0.57"),
    );
    rows.push(
        FigureRow::of_mean("thick layer: shear over normal stress", "", mean(thick, |it| it.friction))
            .published(tangent, Rule::Within(0.03))
            .remark("a steady layer has the tangent of the angle"),
    );
    rows.push(
        FigureRow::of_mean(
            "thick layer: exponent of v(surface) - v(z) against depth",
            "",
            mean(thick, |it| it.exponent),
        )
        .published(1.5, Rule::WithinAbsolute(0.15))
        .remark("error over the windows of 0.25 s"),
    );
    rows.push(FigureRow::of_mean("thick layer: inertial number", "", mean(thick, |it| it.inertial)));
    let mut points = Vec::new();
    for layers in angles {
        let (Some(friction), Some(inertial)) = (mean(layers, |it| it.friction), mean(layers, |it| it.inertial)) else {
            continue;
        };
        let degrees = (100.0 * layers[0].angle.to_degrees()).round() / 100.0;
        let (sine, cosine) = layers[0].angle.sin_cos();
        let row = FigureRow::of_mean(format!("{degrees} degrees: mu"), "", Some(friction))
            .published(sine / cosine, Rule::Within(STEADY));
        // The balance of momentum along the incline.
        let gain = 9.81 * (sine - friction.value * cosine);
        let is_steady = (friction.value * cosine / sine - 1.0).abs() <= STEADY;
        let is_thick = mean(layers, |it| it.depth).is_some_and(|depth| depth.value >= THICK);
        rows.push(if is_steady || degrees < STEEP || !is_thick {
            row.remark("as above")
        } else {
            row.known_miss(format!("no steady flow of so thick a layer: it gains {} m/s in a second", short(gain)))
        });
        rows.push(FigureRow::of_mean(format!("{degrees} degrees: I"), "", Some(inertial)));
        points.push((inertial.value, friction.value));
    }
    let from_glass: Vec<_> = points.iter().map(|(inertial, friction)| friction - law_at(GLASS, *inertial)).collect();
    rows.push(
        FigureRow::of_mean(
            "mu less that of glass beads at the same I, mean over the angles",
            "",
            Mean::of(&from_glass),
        )
        .remark("constants of glass beads from a secondary source: no rule"),
    );
    let line = Law::Line.fit(&points);
    for (name, words) in [("intercept", "mu = mu_s + c I: mu_s"), ("slope", "mu = mu_s + c I: c")] {
        if let Some(found) = line.as_ref().and_then(|line| line.parameter(name)) {
            rows.push(FigureRow::new(words, "", found.value).error(found.error));
        }
    }
    let law = friction_law(&points);
    if let Some(found) = law {
        for ((name, found), glass) in ["mu_s", "mu_2", "I_0"].into_iter().zip(found).zip(GLASS) {
            rows.push(
                FigureRow::new(name, "", found)
                    .published(glass, Rule::Reported)
                    .remark("the other value is that of glass beads, from a secondary source: no rule"),
            );
        }
    }
    judgement.pictures.push(Picture {
        name: "",
        svg: sheet(&[profile(thick), law_panel(&points, law)], 2),
        caption: format!(
            "Left: velocity against the depth to the power of 3/2 in the layer {} diameters deep, by windows; Bagnold's profile is a straight line. Right: friction against the inertial number, with the fit if the points leave one, and the law of \
             glass beads dashed.",
            short(depth)
        ),
    });
    judgement.remarks.push(
        "Spheres with friction 0.5 between each other and with the fixed ones, restitution 0.88. Each figure is a mean over the windows of the second half of the run. Layers of several angles are 15 diameters deep in the \
         short form. With springs of 2,000 m g/d in place of 10,000, as in first runs, the exponent was 1.6 to 1.8: grains at the floor were too soft. Friction and I of a layer \
         that is not steady are those of its own stress and shear rate."
            .to_owned(),
    );
    judgement
}

/// Returns the friction of the law with the constants mu_s, mu_2 and I_0.
fn law_at([start, end, scale]: [f64; 3], inertial: f64) -> f64 {
    start + (end - start) * inertial / (inertial + scale)
}

/// Fits mu_s, mu_2 and I_0 to points (I, mu); `None` below four points, or if the points are so straight that I_0 is beyond 2.
fn friction_law(points: &[(f64, f64)]) -> Option<[f64; 3]> {
    if points.len() < 4 {
        return None;
    }
    let best = best_line(points, (5..=400).map(|n| 0.005 * f64::from(n)), |i, scale| i / (i + scale))?;
    if best.candidate > 1.99 {
        return None;
    }
    let start = best.fitted.value("intercept")?;
    Some([start, start + best.fitted.value("slope")?, best.candidate])
}

fn profile(thick: &[Layer]) -> Panel {
    let curves: Vec<_> = thick
        .iter()
        .map(|it| Curve {
            colour: colour(1),
            points: it.points.iter().map(|(depth, v)| (depth.powf(1.5), *v)).collect(),
            has_line: true,
            has_dots: true,
            ..Curve::default()
        })
        .collect();
    let all = || curves.iter().flat_map(|curve| &curve.points);
    let x = Axis::around("(depth / d)^(3/2)", all().map(|point| point.0).chain([0.0]));
    let y = Axis::around("velocity, m/s", all().map(|point| point.1).chain([0.0]));
    Panel { curves, ..Panel::new("Profile", x, y) }
}

fn law_panel(points: &[(f64, f64)], law: Option<[f64; 3]>) -> Panel {
    let last = points.iter().map(|point| point.0).fold(0.1, f64::max) * 1.1;
    let of = |law: [f64; 3]| {
        let places = (1..=100).map(|n| last * f64::from(n) / 100.0);
        places.map(|i| (i, law_at(law, i))).collect::<Vec<_>>()
    };
    let mut curves = vec![
        Curve {
            name: "siloflow".to_owned(),
            colour: colour(1),
            points: points.to_vec(),
            has_dots: true,
            ..Curve::default()
        },
        Curve {
            name: "glass beads (Jop)".to_owned(),
            colour: colour(0),
            points: of(GLASS),
            has_line: true,
            is_dashed: true,
            ..Curve::default()
        },
    ];
    curves.extend(law.map(|law| Curve { colour: colour(1), points: of(law), has_line: true, ..Curve::default() }));
    let y =
        Axis::around("shear over normal stress", curves.iter().flat_map(|curve| &curve.points).map(|point| point.1));
    Panel { curves, ..Panel::new("mu(I)", Axis::linear("inertial number", 0.0, last), y) }
}

#[cfg(test)]
mod tests {
    use super::layer::tests::layer;
    use super::*;
    use crate::studies::validation::verdict::Verdict;

    #[test]
    fn a_parabola_and_an_accelerating_layer_are_misses() {
        let misses = |it: Layer| judgement_of(&[it], &[]).count(Verdict::Miss);
        let steady = 24f64.to_radians().tan();
        assert_eq!(
            (misses(layer(1.5, steady)), misses(layer(2.0, steady)), misses(layer(1.5, 0.9 * steady))),
            (0, 1, 1)
        );
    }

    #[test]
    fn the_constants_of_the_friction_law_are_recovered() {
        let [start, end, scale] = GLASS;
        let points = [0.05, 0.1, 0.2, 0.3, 0.5].map(|i| (i, law_at(GLASS, i)));
        let found = friction_law(&points).unwrap();
        // The steps of the third are 0.005.
        assert!(
            (found[2] - scale).abs() < 5e-3 && (found[0] - start).abs() < 2e-3 && (found[1] - end).abs() < 5e-3,
            "{found:?}"
        );
        assert!(friction_law(&points[..3]).is_none());
        assert!(friction_law(&points.map(|(i, _)| (i, 0.35 + 0.4 * i))).is_none());
    }
}
