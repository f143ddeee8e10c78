//! The thirteen velocities of a particle at a site (the paper's figure 1).

use super::paper::{Anchor, FAINT, INK, Lattice, Paper, Pen};
use super::site::pen;
use siloflow_dem::space::Vector;
use siloflow_lattice::velocities::{STEPS, in_bonds};

const WIDTH: f64 = 640.0;
const HEIGHT: f64 = 640.0;
const LATTICE: Lattice = Lattice { origin: Vector::new(320.0, 275.0), bond: 125.0 };

/// Distance from the centre up to which sites are drawn, bonds.
const REACH: f64 = 2.1;

/// Draws a site with the vectors v1 to v12 to its nearest and second-nearest neighbours, to scale, and v0 for a
/// particle at rest.
#[must_use]
pub fn vectors() -> String {
    let mut paper = Paper::new(WIDTH, HEIGHT);
    lattice(&mut paper);
    for (d, &step) in STEPS.iter().enumerate().skip(1) {
        let tip = LATTICE.at(step);
        let ahead = (tip - LATTICE.origin).normalize();
        paper.arrow(LATTICE.origin + 10.0 * ahead, tip - 6.0 * ahead, Pen { width: 2.4, ..pen(d) });
        name(&mut paper, tip + 21.0 * ahead, d);
    }
    paper.dot(LATTICE.origin, 8.0, INK);
    // The name of v0 is placed between two arrows.
    name(&mut paper, LATTICE.origin + 48.0 * Vector::from_angle((-15f64).to_radians()), 0);
    legend(&mut paper);
    paper.finish()
}

/// Draws the sites as dots, with the bonds between nearest neighbours.
fn lattice(paper: &mut Paper) {
    let shown = |site: &(i32, i32)| {
        let (x, y) = in_bonds(*site);
        (site.0 + site.1) % 2 == 0 && x.hypot(y) < REACH
    };
    let sites: Vec<_> = (-3..=3).flat_map(|x| (-5..=5).map(move |y| (x, y))).filter(shown).collect();
    for &site in &sites {
        // Three of the six directions draw each bond once.
        for step in &STEPS[1..=3] {
            let other = (site.0 + step.0, site.1 + step.1);
            if shown(&other) {
                paper.line(LATTICE.at(site), LATTICE.at(other), Pen { width: 0.8, colour: FAINT });
            }
        }
    }
    for &site in &sites {
        paper.dot(LATTICE.at(site), 3.5, [0x77; 3]);
    }
}

fn name(paper: &mut Paper, middle: Vector, direction: usize) {
    paper.formula(middle + Vector::new(0.0, 6.0), 19.0, Anchor::Middle, &format!("v_{direction}"));
}

fn legend(paper: &mut Paper) {
    let row = |n: f64| Vector::new(110.0, HEIGHT - 66.0 + 25.0 * n);
    let texts = [
        "speed 1: v_1 to v_6, to the nearest neighbours",
        "speed √3: v_7 to v_12, to the second-nearest neighbours",
        "speed 0: v_0, a particle at rest",
    ];
    for (n, text) in (0u8..).zip(texts) {
        let at = row(f64::from(n));
        match n {
            0 => paper.arrow(at, at + Vector::new(30.0, 0.0), Pen { width: 2.4, ..pen(1) }),
            1 => paper.arrow(at, at + Vector::new(30.0 * 3f64.sqrt(), 0.0), Pen { width: 2.4, ..pen(7) }),
            _ => paper.dot(at + Vector::new(15.0, 0.0), 6.0, INK),
        }
        paper.formula(at + Vector::new(68.0, 5.0), 15.0, Anchor::Start, text);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_thirteen_velocities_are_named() {
        let svg = vectors();
        super::super::renders(&svg);
        // The pattern leaves out the names in the legend, which are not at the start of a text.
        assert_eq!(svg.matches(">v<tspan").count(), 13);
    }
}
