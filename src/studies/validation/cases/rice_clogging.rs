//! Clogging of rice and of spheres in a small round silo.
//!
//! Zuriguel et al. find that the shape of grains deeply influences the formation of arches, while their material does not (Phys. Rev. E 71, 051303, abstract). So the
//! means of both kinds have to differ by more than three standard errors, and the sizes of both to be exponential. Their critical diameters for spheres and rice
//! could not be read. Thomas and Durian find the same clogging diagram for spheres, sand, lentils and rice at circular orifices, in terms of
//! their own measure of the size of a grain (arXiv 1206.7052, abstract).

use super::two_shapes::{TwoShapes, of};
use crate::studies::validation::runs::Studies;
use crate::studies::validation::verdict::{FigureRow, Judgement, Rule};
use crate::studies::validation::{Case, file};
use siloflow_text::fault::Fault;

/// The case.
pub const CASE: Case = Case {
    name: "rice-clogging",
    title: "Clogging of rice and of spheres",
    sources: "Zuriguel et al. 2005, Phys. Rev. E 71, 051303 (cond-mat/0407761, abstract): exponential sizes; the shape of the grains deeply influences \
              the formation of arches.",
    files: &[
        file!("rice-clogging", "silo.ron"),
        file!("rice-clogging", "short-spheres.ron"),
        file!("rice-clogging", "short-rice.ron"),
        file!("rice-clogging", "full-spheres.ron"),
        file!("rice-clogging", "full-rice.ron"),
    ],
    short: &["short-spheres.ron", "short-rice.ron"],
    full: &["full-spheres.ron", "full-rice.ron"],
    judge,
};

#[expect(clippy::unnecessary_wraps, reason = "other cases can fail")]
fn judge(studies: &Studies) -> Result<Judgement, Fault> {
    let mut judgement = Judgement::default();
    let two = TwoShapes {
        round: of("spheres", studies.first_of(&["full-spheres.ron", "short-spheres.ron"])),
        shaped: of("rice", studies.first_of(&["full-rice.ron", "short-rice.ron"])),
        names: ["spheres", "rice"],
    };
    // The abstract does not say which kind clogs earlier.
    two.judge(&mut judgement, |row| {
        let found = row.found.abs();
        let remark = "without its sign: shape has an influence";
        FigureRow { found, ..row }.rule(Rule::Between(3.0, 1e3)).remark(remark)
    });
    Ok(judgement)
}
