//! Clogging of ellipses and of discs in a plane hopper, and the orientation of ellipses near the outlet.
//!
//! Tang and Behringer find in experiments with ellipses of an aspect ratio of 2 that contacting ellipses align, and that this enhances the chance of stable
//! arches (EPL 114, 34002, abstract). So ellipses have to clog earlier than discs of the same area, by more than three standard errors. Elongated grains in a
//! flow have their long axes nearly along it (arXiv 2312.05050, introduction). So the mean inclination to the vertical near the outlet has to be below 45
//! degrees, that of random orientations in the plane. It is the mean of the lowest bin of `profiles.csv`, over all of the run, arches at rest included.

use super::two_shapes::{TwoShapes, of};
use crate::studies::validation::runs::{FinishedRun, Studies};
use crate::studies::validation::verdict::{FigureRow, Judgement, Rule};
use crate::studies::validation::{Case, file};
use siloflow_text::fault::Fault;

/// The case.
pub const CASE: Case = Case {
    name: "ellipses-hopper",
    title: "Clogging of ellipses and of discs in a hopper",
    sources: "Tang and Behringer 2016, EPL 114, 34002 (abstract): ellipses against discs; orientation in a flow: arXiv 2312.05050 (introduction).",
    files: &[
        file!("ellipses-hopper", "hopper.ron"),
        file!("ellipses-hopper", "short.ron"),
        file!("ellipses-hopper", "full.ron"),
    ],
    short: &["short.ron"],
    full: &["full.ron"],
    judge,
};

fn judge(studies: &Studies) -> Result<Judgement, Fault> {
    let mut judgement = Judgement::default();
    let runs = studies.first_of(&["full.ron", "short.ron"]);
    let with =
        |is_round: bool| runs.iter().filter(move |run| (run.value("parameters.aspect") == Some(1.0)) == is_round);
    let two =
        TwoShapes { round: of("discs", with(true)), shaped: of("ellipses", with(false)), names: ["discs", "ellipses"] };
    two.judge(&mut judgement, |row| row.rule(Rule::Between(3.0, 1e3)));
    for (run, it) in with(false).zip(&two.shaped) {
        judgement.rows.extend(orientation(run, &it.name)?);
    }
    judgement.remarks.push(
        "The walls of the hopper fall at 60 degrees to the horizontal; the silo above is 12 d wide. The figures of the publication (rates, chances of a clog, \
         grains in an arch) could not be read, so the rules are what its abstract says. Its unit of the width is the size of a particle."
            .to_owned(),
    );
    Ok(judgement)
}

/// Returns the rows of the mean inclination and of the nematic order in the lowest bin of the profile.
fn orientation(run: &FinishedRun, name: &str) -> Result<[FigureRow; 2], Fault> {
    let profile = run.table("profiles.csv")?;
    let lowest = |column: &str| profile.needed(column).map(|numbers| numbers.first().copied().unwrap_or(f64::NAN));
    let degrees = lowest("inclination_rad")?.to_degrees();
    let quantity = format!("{name}: mean inclination to the vertical, 1 to 3 d above the outlet");
    Ok([
        FigureRow::new(quantity, "degrees", degrees).rule(Rule::Between(0.0, 45.0)).remark("45: random orientations"),
        FigureRow::new(format!("{name}: nematic order there"), "", lowest("nematic_order")?),
    ])
}
