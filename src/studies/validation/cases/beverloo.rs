//! The discharge rate of flat-bottomed silos against the width of the orifice: a slot and a circle.
//!
//! | law | rate W over rho sqrt(g) d^(5/2); for a slot also over its length in d | numbers |
//! |---|---|---|
//! | Beverloo, Leniger and van de Velde, Chem. Eng. Sci. 15, 260 (1961) | C (R - k)^p | C, k |
//! | the same with k = 1.4, as DIRT fits its slot | C (R - 1.4)^n | C, n |
//! | the same with all numbers free | C (R - k)^n | C, k, n |
//! | Mankoc et al., Granular Matter 9, 407 (2007) | C' (1 - exp(-b (R - 1))/2) (R - 1)^p | C', b |
//!
//! R is the width over the mean diameter d; p = 5/2 for a circle and 3/2 for a slot; rho is the density of the bed. The rate of a run is the slope of a
//! straight line through the number of grains out from 0.1 s after the opening on. Laws are fitted to the logarithms of the rates of all runs, so that each
//! run counts by its relative deviation. A run that clogs has no rate: it is listed.
//!
//! The density is the number of grains per volume 3 d away from the floor and the walls and in the lower half of the bed, at the end of the runs that clog.

mod bed;
mod heights;
mod laws;

use std::fmt::Write as _;

use self::bed::{Silo, density, rate};
use self::heights::heights;
use self::laws::{Laws, OFFSET};
use crate::studies::validation::groups::{groups_by, mean_of};
use crate::studies::validation::runs::{FinishedRun, Studies};
use crate::studies::validation::verdict::{FigureRow, Judgement, Picture, Rule};
use crate::studies::validation::{Case, file};
use siloflow_figures::diagram::sheet;
use siloflow_figures::statistics::digits::short;
use siloflow_figures::statistics::mean::Mean;
use siloflow_text::fault::Fault;

/// The case.
pub const CASE: Case = Case {
    name: "beverloo",
    title: "Discharge rates: laws of Beverloo and Mankoc",
    sources: "Beverloo et al. 1961; exponents, validity and Mankoc's form: Mankoc et al. 2007 (arXiv:0707.4550); bound of the \
              exponent: `bench_hopper_beverloo` of DIRT.",
    files: &[
        file!("beverloo", "slot.ron"),
        file!("beverloo", "circle.ron"),
        file!("beverloo", "short-slot.ron"),
        file!("beverloo", "short-circle.ron"),
        file!("beverloo", "short-height.ron"),
        file!("beverloo", "full-slot.ron"),
        file!("beverloo", "full-circle.ron"),
        file!("beverloo", "full-height.ron"),
    ],
    short: &["short-slot.ron", "short-circle.ron", "short-height.ron"],
    full: &["full-slot.ron", "full-circle.ron", "full-height.ron"],
    judge,
};

/// Bound of the exponent at k = 1.4: DIRT accepts 3/2 within 1/4 for its slot.
const BOUND: f64 = 0.25;

fn judge(studies: &Studies) -> Result<Judgement, Fault> {
    let mut judgement = Judgement::default();
    let mut panels = Vec::new();
    for silo in [Silo::Slot, Silo::Circle] {
        let runs = studies.first_of(&silo.sweeps());
        if let Some(laws) = exponents(silo, runs, &mut judgement)? {
            panels.extend(laws.panels(silo));
        }
    }
    if let Some(two) = heights(studies) {
        judgement.rows.push(two.row()?);
        panels.push(two.panel()?);
    }
    let caption = "Dots: rates of all runs that did not clog; W is in units of the density of the bed times sqrt(g) d^(5/2), for the slot per diameter of its \
                   length. To a power, Beverloo's law is a straight line. The form of Mankoc is dashed."
        .to_owned();
    judgement.pictures.push(Picture { name: "", svg: sheet(&panels, 2), caption });
    judgement.remarks.push(
        "Published constants: C 0.58 and k 1.4 to 1.5 for circles, C 1.03 for slots, Mankoc's b 0.051 in solid space and 0.23 in the plane. They are \
         quoted from memory of the literature, so they stand beside the fits without a verdict; C and k also depend on friction and on the density that is \
         inserted. The slot is 5 d long and periodic, and the silos are 40 d and 20 d wide; in the short form 2.5 d, 30 d and 15 d."
            .to_owned(),
    );
    Ok(judgement)
}

/// Adds the rows of a kind of orifice. `None` if too few widths have a rate.
fn exponents(silo: Silo, runs: &[FinishedRun], judgement: &mut Judgement) -> Result<Option<Laws>, Fault> {
    let name = silo.name();
    let power = silo.power();
    let clogged: Vec<_> = runs.iter().filter(|run| run.status() == "clogged").collect();
    let mut points = Vec::new();
    let widths = groups_by(runs, |run| silo.width(run));
    for (width, of_width) in &widths {
        let flowing: Vec<_> = of_width.iter().copied().filter(|run| run.status() != "clogged").collect();
        let rates = flowing.iter().map(|run| rate(run)).collect::<Result<Vec<_>, _>>()?;
        points.extend(rates.iter().map(|rate| (*width, *rate)));
        if let Some(mean) = Mean::of(&rates) {
            let row = FigureRow::of_mean(format!("{name} of {width} d: rate"), "grains/s", Some(mean));
            judgement.rows.push(row.remark(format!("runs: {}", rates.len())));
        }
    }
    if let Some((width, of_narrowest)) = widths.first() {
        let share = mean_of(of_narrowest.iter().copied(), |run| Some(f64::from(u8::from(run.status() == "clogged"))));
        let row = FigureRow::new(
            format!("{name} of {width} d: share of the runs that clog"),
            "",
            share.map_or(f64::NAN, |it| it.value),
        );
        judgement.rows.push(row.rule(Rule::Between(1.0, 1.0)).remark("these runs have no rate and are in no fit"));
    }
    judgement.remarks.extend(list_of_clogs(silo, &clogged));
    let densities = clogged.iter().map(|run| density(silo, run)).collect::<Result<Vec<_>, _>>()?;
    let Some(unit) = Mean::of(&densities).map(|it| it.value).zip(runs.first()).and_then(|(n, run)| silo.unit(run, n))
    else {
        return Ok(None);
    };
    let scaled: Vec<_> = points.iter().map(|(width, rate)| (*width, rate / unit)).collect();
    let Some(laws) = Laws::fit(power, scaled) else { return Ok(None) };
    let [exponent, error] = [laws.exponent.values[1], laws.exponent.errors[1]];
    let row =
        FigureRow::new(format!("{name}: exponent of Beverloo's law at k = {OFFSET}"), "", exponent).error(Some(error));
    judgement.rows.push(row.published(power, Rule::WithinAbsolute(BOUND)).remark("k and bound are those of DIRT"));
    let [offset, exponent] = [1, 2].map(|i| (laws.free.values[i], laws.free.errors[i]));
    let row = FigureRow::new(format!("{name}: exponent of Beverloo's law, with C and k free"), "", exponent.0);
    let with = format!("with k {} ± {}: both numbers depend on each other", short(offset.0), short(offset.1));
    let row = row.error(Some(exponent.1)).published(power, Rule::WithinAbsolute(BOUND));
    judgement.rows.push(row.known_miss(with));
    let c = laws.beverloo.values[0].exp();
    let row =
        FigureRow::new(format!("{name}: C at an exponent of {power}"), "", c).error(Some(c * laws.beverloo.errors[0]));
    judgement.rows.push(row.published(silo.constants().0, Rule::Reported));
    let row = FigureRow::new(format!("{name}: k at an exponent of {power}"), "", laws.beverloo.values[1]);
    judgement.rows.push(row.error(Some(laws.beverloo.errors[1])).published(1.4, Rule::Reported));
    let row = FigureRow::new(format!("{name}: rms deviation from Beverloo's law"), "%", 100.0 * laws.beverloo.rms);
    judgement.rows.push(row);
    if let Some(mankoc) = laws.mankoc {
        let row =
            FigureRow::new(format!("{name}: b of Mankoc's form"), "", mankoc.values[1]).error(Some(mankoc.errors[1]));
        judgement.rows.push(row.published(silo.constants().1, Rule::Reported));
        let prefactor = mankoc.values[0].exp() * unit;
        let row = FigureRow::new(format!("{name}: C' of Mankoc's form"), "grains/s", prefactor);
        judgement.rows.push(row.error(Some(prefactor * mankoc.errors[0])));
        let row = FigureRow::new(format!("{name}: rms deviation from Mankoc's form"), "%", 100.0 * mankoc.rms);
        judgement.rows.push(row);
    }
    Ok(Some(laws))
}

/// Returns a paragraph that lists the runs that clogged, if there are any.
fn list_of_clogs(silo: Silo, clogged: &[&FinishedRun]) -> Option<String> {
    let mut text = format!("Runs of the {} that clogged, with the grains that left before:", silo.name());
    for run in clogged {
        let [width, out] = [silo.width(run), run.number("clog.avalanche_grains")].map(|it| it.unwrap_or(f64::NAN));
        // Writing to a string cannot fail.
        let _ = write!(text, " {width} d, seed {}: {out};", run.seed);
    }
    let kept = text.trim_end_matches(';').len();
    text.truncate(kept);
    (!clogged.is_empty()).then(|| text + ".")
}
