//! Janssen's silo: loads on wall and floor of a cylinder while the wall is still, while it is lifted slowly, and when an outlet opens.
//!
//! | figure | from | file |
//! |---|---|---|
//! | balance of walls, floor, weight and momentum | `wall_groups.csv`, `centres.csv` | `loads` |
//! | vertical stress, K and mu against depth, laws of Janssen and of Vanel and Clement | `wall_bands.csv`, `fields.csv` | `profile` |
//! | load on the floor against the filled mass | the runs of all fillings | here |
//! | pressures of EN 1991-4 for wheat | closed form | `standard` |
//!
//! Times of a run, with T of the parameter `settled`: the wall is still from T - 0.2 s to T; it is lifted from T to T + 0.4 s, of which the second half
//! counts; the outlet opens at T + 0.6 s. The balance is exact but for half a step at both ends of a time (`loads`).

mod loads;
mod panels;
mod profile;
mod standard;

use self::loads::{GRAVITY, Loads, Window};
use self::profile::{Profile, fit_vanel_clement};
use crate::studies::validation::runs::{FinishedRun, Studies};
use crate::studies::validation::verdict::{FigureRow, Judgement, Picture, Rule};
use crate::studies::validation::{Case, file};
use siloflow_figures::diagram::sheet;
use siloflow_figures::statistics::mean::mean;
use siloflow_text::fault::Fault;

/// The case.
pub const CASE: Case = Case {
    name: "janssen",
    title: "Loads in a silo: Janssen's law",
    sources: "Janssen 1895; Vanel and Clement 1999, Eur. Phys. J. B 11, 525; hydrostatic top: Landry et al. 2003 \
              (cond-mat/0302115); wheat: EN 1991-4 after sgem-2018-0043.",
    files: &[
        file!("janssen", "silo.ron"),
        file!("janssen", "short.ron"),
        file!("janssen", "short-still.ron"),
        file!("janssen", "full.ron"),
        file!("janssen", "full-still.ron"),
    ],
    short: &["short.ron", "short-still.ron"],
    full: &["full.ron", "full-still.ron"],
    judge,
};

/// Mean diameter of the grains, m.
const DIAMETER: f64 = 0.004;

/// Name of a time, and its begin and end after `settled`, s.
const TIMES: [(&str, f64, f64); 4] =
    [("still wall", -0.2, 0.0), ("moving wall", 0.2, 0.4), ("wall stopped again", 0.4, 0.6), ("open outlet", 0.6, 0.9)];

/// Returns a time of a run.
fn window(run: &FinishedRun, number: usize) -> Window {
    let settled = run.number("parameters.settled").unwrap_or(f64::NAN);
    let (_, from, to) = TIMES[number];
    Window { from: settled + from, to: settled + to }
}

/// A run, its height in d, and its loads.
struct Silo<'a> {
    run: &'a FinishedRun,
    layers: f64,
    loads: Loads,
}

fn read(runs: &[FinishedRun]) -> Result<Vec<Silo<'_>>, Fault> {
    let all = runs.iter().map(|run| {
        Ok(Silo { run, layers: run.number("parameters.layers").unwrap_or(f64::NAN), loads: Loads::of(run)? })
    });
    all.collect()
}

fn judge(studies: &Studies) -> Result<Judgement, Fault> {
    let mut judgement = Judgement::default();
    let moved = read(studies.first_of(&["full.ron", "short.ron"]))?;
    let still = read(studies.first_of(&["full-still.ron", "short-still.ron"]))?;
    balance(moved.iter().chain(&still), &mut judgement.rows);
    let highest = moved.iter().map(|silo| silo.layers).fold(0.0, f64::max);
    let tall: Vec<_> = moved.iter().filter(|silo| silo.layers >= highest).collect();
    let mut panels = Vec::new();
    let mut pressures = Vec::new();
    if let Some(first) = tall.first() {
        panels.push(panels::loads_over_time(first));
    }
    for number in [0, 1] {
        let profiles = profiles(&tall, number)?;
        stresses(TIMES[number].0, &profiles, number == 1, &mut judgement.rows);
        if let Some(profile) = profiles.first() {
            panels.push(panels::stresses(TIMES[number].0, profile));
            pressures.push((TIMES[number].0, profile.clone()));
        }
    }
    shares(&tall, highest, &mut judgement.rows);
    panels.push(fillings(&moved, &mut judgement.rows));
    panels.push(panels::beside_the_standard(&pressures));
    opening("after the lift", &tall, &mut judgement.rows);
    opening("after a still wall", &still.iter().collect::<Vec<_>>(), &mut judgement.rows);
    let caption = format!(
        "A bed of {highest} d. Stresses and pressures are those of the first seed. The last panel has the pressures of EN 1991-4 for wheat; it is not a design \
         check: the grains are spheres, and the standard has safety factors and load cases that are not shown."
    );
    judgement.pictures.push(Picture { name: "", svg: sheet(&panels, 3), caption });
    judgement.remarks.push(
        "The friction at the still wall is the one that filling has left, so it depends on the protocol (a rain of grains); the bed bears almost hydrostatically \
         near its top, as in the simulations of Landry et al. The lifted wall mobilises its friction at all depths. The ratio of friction to pressure stays below \
         the coefficient 0.5 of a contact, because grains roll along the wall. With the measured mu and K, R/(2 mu K) is the depth that the stresses \
         show. K is above one while the wall is lifted; published values of 0.6 to 1.1 are quoted from memory and stand without a verdict."
            .to_owned(),
    );
    judgement.remarks.push(
        "Deep pressures tend to gamma R/(2 mu). They lie above those of the standard for wheat, because the wall bears friction of less than half of the \
         standard's 0.57 times the pressure. Rough grains that do not roll would bear more."
            .to_owned(),
    );
    Ok(judgement)
}

/// Adds a row for each time: the largest error of the balance over its bound, and the error itself.
fn balance<'a>(silos: impl Iterator<Item = &'a Silo<'a>> + Clone, rows: &mut Vec<FigureRow>) {
    for (number, (name, ..)) in TIMES.iter().enumerate() {
        let errors: Vec<_> = silos.clone().map(|silo| silo.loads.balance(window(silo.run, number))).collect();
        let mut worst = 0.0f64;
        let mut share = 0.0f64;
        for (error, bound) in &errors {
            worst = if error.is_nan() { f64::NAN } else { worst.max(error.abs()) };
            share = if error.is_nan() { f64::NAN } else { share.max((error / bound).abs()) };
        }
        let found = if errors.is_empty() { f64::NAN } else { share };
        let row = FigureRow::new(
            format!("{name}: error of walls + floor = weight + change of momentum, over its bound"),
            "",
            found,
        );
        rows.push(row.rule(Rule::Between(0.0, 1.0)).remark(format!("largest error {worst:.1e} of the weight")));
    }
}

/// Returns the profiles of runs in a time.
fn profiles(silos: &[&Silo<'_>], number: usize) -> Result<Vec<Profile>, Fault> {
    let all = silos.iter().map(|silo| Profile::of(silo.run, window(silo.run, number).from));
    Ok(all.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect())
}

/// Adds the rows of the stresses in a time.
fn stresses(time: &str, profiles: &[Profile], is_mobilised: bool, rows: &mut Vec<FigureRow>) {
    let of = |name: &str, unit, number: &dyn Fn(&Profile) -> f64| {
        FigureRow::of_mean(format!("{time}: {name}"), unit, mean(profiles.iter().map(number)))
    };
    let lambda = |profile: &Profile| profile.two_parameters().map_or(f64::NAN, |fit| fit.values[1]);
    let agreement =
        of("vertical stress from the balance of slices over the one from contacts", "", &Profile::agreement);
    rows.push(agreement.rule(Rule::Between(0.95, 1.05)));
    rows.push(of("K, pressure on the wall over vertical stress", "", &Profile::pressure_ratio));
    rows.push(of("mu, friction that the wall bears over pressure on it", "", &Profile::mobilised));
    rows.push(of("depth a of the hydrostatic top (Vanel and Clement)", "d", &|profile| {
        profile.two_parameters().map_or(f64::NAN, |fit| fit.values[0] / DIAMETER)
    }));
    rows.push(of("lambda (Vanel and Clement)", "d", &|profile| lambda(profile) / DIAMETER));
    rows.push(of("rms of the stress from the law, over rho g lambda", "%", &|profile| {
        profile.two_parameters().map_or(f64::NAN, |fit| 100.0 * fit.rms / fit.values[1])
    }));
    if is_mobilised {
        rows.push(of("rms of the stress from Janssen's law (a = 0), over rho g lambda", "%", &|profile| {
            profile.one_parameter().map_or(f64::NAN, |fit| 100.0 * fit.rms / fit.values[0])
        }));
        let ratio = of("a + lambda over R/(2 mu K) with the measured mu and K", "", &|profile| {
            let saturated = profile.two_parameters().map_or(f64::NAN, |fit| fit.values[0] + fit.values[1]);
            saturated * 2.0 * profile.mobilised() * profile.pressure_ratio() / profile.radius
        });
        rows.push(ratio.rule(Rule::Between(0.85, 1.15)).remark("Janssen's relation"));
    }
}

/// Adds the share of the weight that the wall bears.
fn shares(tall: &[&Silo<'_>], highest: f64, rows: &mut Vec<FigureRow>) {
    for number in [0, 1] {
        let share = mean(tall.iter().map(|silo| {
            let window = window(silo.run, number);
            silo.loads.mean(&silo.loads.wall, window) / silo.loads.weight(window)
        }));
        rows.push(FigureRow::of_mean(
            format!("{}, {highest} d: share of the weight on the wall", TIMES[number].0),
            "",
            share,
        ));
    }
}

/// Adds the rows of the load on the floor against the filled mass, and returns their panel.
fn fillings(silos: &[Silo<'_>], rows: &mut Vec<FigureRow>) -> siloflow_figures::diagram::Panel {
    let mut curves = Vec::new();
    for number in [0, 1] {
        let points: Vec<_> = silos
            .iter()
            .map(|silo| {
                let window = window(silo.run, number);
                let [filled, floor] = [silo.loads.weight(window), silo.loads.mean(&silo.loads.floor, window)];
                (1e3 * filled / GRAVITY, 1e3 * floor / GRAVITY)
            })
            .collect();
        let law = fit_vanel_clement(&points);
        let [scale, error] = law.map_or([f64::NAN; 2], |fit| [fit.values[1], fit.errors[1]]);
        let row = FigureRow::new(format!("{}: mass M of the fillings' load on the floor", TIMES[number].0), "g", scale);
        rows.push(row.error(Some(error)).remark("M_floor = M_0 + M (1 - exp(-(M_filled - M_0)/M))"));
        curves.push((TIMES[number].0, points, law.map(|fit| fit.values)));
    }
    panels::fillings(&curves)
}

/// Adds the rows of the opening of the outlet.
fn opening(words: &str, silos: &[&Silo<'_>], rows: &mut Vec<FigureRow>) {
    let share = |silo: &Silo<'_>, from: f64, to: f64| {
        let settled = silo.run.number("parameters.settled").unwrap_or(f64::NAN);
        let window = Window { from: settled + from, to: settled + to };
        silo.loads.mean(&silo.loads.wall, window) / silo.loads.weight(window)
    };
    for (name, from, to) in
        [("before", 0.5, 0.6), ("during the first 0.1 s after", 0.6, 0.7), ("0.2 to 0.3 s after", 0.8, 0.9)]
    {
        let quantity = format!("outlet {words}: share of the weight on the wall {name} the opening");
        rows.push(FigureRow::of_mean(quantity, "", mean(silos.iter().map(|silo| share(silo, from, to)))));
    }
}
