//! The drum of Dosta et al., Comput. Phys. Commun. 296, 109066 (2024), case 2: grains of two sizes and materials mix in a drum.
//!
//! The published result is the number of grains of each material in two zones over time: zone 1 has x > 0 and z > 0, zone 2 x < 0 and z < 0, and the drum turns about y.
//! The published curves could not be read, so the counts stand alone. They come from `fields.csv`: density times share of the species times volume, over the mass of a
//! grain.

use std::f64::consts::PI;

use crate::fault::Fault;
use crate::validation::numbers::interpolated;
use crate::validation::runs::{Run, Studies};
use crate::validation::verdict::{Judgement, Picture, Row};
use crate::validation::{Case, file};
use crate::writers::plot::{Axis, Curve, Key, Panel, colour, sheet};

/// The case.
pub const CASE: Case = Case {
    name: "dosta-drum",
    title: "Drum of Dosta et al. 2024",
    sources: "Dosta et al. 2024, Comput. Phys. Commun. 296, 109066, case 2; zones and soft materials from `OSDrum.cpp` of MercuryDPM.",
    files: &[file!("dosta-drum", "drum.ron"), file!("dosta-drum", "short.ron"), file!("dosta-drum", "full.ron")],
    short: &["short.ron"],
    full: &["full.ron"],
    judge,
};

/// Materials: name, column of the share, mass of a grain (kg).
const MATERIALS: [(&str, &str, f64); 2] = [
    ("M1, 2 mm", "share_0", 2500.0 * 4.0 / 3.0 * PI * 1.0e-9),
    ("M2, 4 mm", "share_1", 2000.0 * 4.0 / 3.0 * PI * 8.0e-9),
];

/// Volume of a cell of the grid of the scene, m^3.
const VOLUME: f64 = 0.1 * 0.1 * 0.06;

/// Returns the grains of a material in the cell on this side of both axes, over the time since the drum turns, s.
fn counts(run: &Run, (share, mass): (&str, f64), side: f64) -> Result<Vec<(f64, f64)>, Fault> {
    let start = run.number("parameters.start").unwrap_or(f64::NAN);
    let table = run.table("fields.csv")?;
    let column = |name: &str| table.numbers(name).unwrap_or_default();
    let (x, z) = (column("x1_m"), column("x3_m"));
    let times = table.needed("from_s")?.into_iter().zip(table.needed("to_s")?);
    let grams = column("density").into_iter().zip(column(share));
    let rows = x.into_iter().zip(z).zip(times.zip(grams)).filter(|((x, z), _)| x * side > 0.0 && z * side > 0.0);
    // A cell without grains has no shares.
    let count = |density: f64, share: f64| if density > 0.0 { density * share * VOLUME / mass } else { 0.0 };
    Ok(rows.map(|(_, ((from, to), (density, share)))| (0.5 * (from + to) - start, count(density, share))).collect())
}

fn judge(studies: &Studies) -> Result<Judgement, Fault> {
    let mut judgement = Judgement::default();
    let mut panels = Vec::new();
    for run in studies.all() {
        for (name, share, mass) in MATERIALS {
            let mut curves = Vec::new();
            for (zone, side) in [(1, 1.0), (2, -1.0)] {
                let points = counts(run, (share, mass), side)?;
                for time in [0.4, 1.0, 2.0, 3.0, 4.0] {
                    if let Some(count) = interpolated(&points, time) {
                        judgement.rows.push(Row::new(format!("{name}, zone {zone}, after {time} s"), "grains", count));
                    }
                }
                let name = format!("zone {zone}");
                curves.push(Curve { name, colour: colour(zone), points, has_line: true, ..Curve::default() });
            }
            let most = curves.iter().flat_map(|curve| &curve.points).map(|point| point.1).fold(0.0, f64::max);
            let x =
                Axis::around("time since the drum turns, s", curves.iter().flat_map(|it| &it.points).map(|it| it.0));
            let y = Axis::around("grains", [0.0, most]);
            panels.push(Panel { curves, key: Key::Above, ..Panel::new(name, x, y) });
        }
    }
    let caption = "Grains in zone 1 (x > 0, z > 0) and zone 2 (x < 0, z < 0), means over 0.1 s.".to_owned();
    judgement.pictures.push(Picture { name: "", svg: sheet(&panels, 2), caption });
    judgement.remarks.push(
        "The published curves could not be read, so these counts are siloflow's own result. The grains have the moduli of MercuryDPM's soft variant (2 MPa and 1 MPa), \
         and the bed is made here."
            .to_owned(),
    );
    Ok(judgement)
}
