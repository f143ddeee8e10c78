//! The resultants of collisions, and an example collision (the paper's figure 2).
//!
//! The example is the first state of three movers, in ascending order, whose sum V points obliquely upwards and that
//! has an outgoing state with exactly the sum V + v4 and no velocity in common. The first of these outgoing states is
//! shown.

use std::collections::BTreeMap;

use super::paper::{Anchor, FAINT, INK, Lattice, Paper, Pen};
use super::site::{incoming, outgoing, sum_pen};
use siloflow_dem::space::Vector;
use siloflow_figures::colour::{hex, viridis};
use siloflow_lattice::collisions::{Collisions, resultant_index};
use siloflow_lattice::velocities::{DOWN, STEPS, momentum};

const WIDTH: f64 = 900.0;
const HEIGHT: f64 = 620.0;
const PLANE: Lattice = Lattice { origin: Vector::new(300.0, 300.0), bond: 50.0 };

/// Returns the sums (X, Y) of all sets of movers, each with the number of sets that have this sum.
#[must_use]
pub fn sums() -> BTreeMap<(i32, i32), u32> {
    let mut sums = BTreeMap::new();
    for movers in 0..1u16 << 12 {
        *sums.entry(momentum(movers << 1)).or_insert(0) += 1;
    }
    sums
}

/// Draws the sums of all 4096 sets of movers as points of the plane, coloured by the number of sets. Beside them it
/// draws a collision: the incoming state, V, V + v4, and an outgoing state.
#[must_use]
pub fn resultants() -> String {
    let mut paper = Paper::new(WIDTH, HEIGHT);
    axes(&mut paper);
    let sums = sums();
    let most = f64::from(sums.values().copied().max().unwrap_or(1));
    for (&sum, &count) in &sums {
        let at = PLANE.at(sum);
        let fill = hex(viridis(f64::from(count).ln() / most.ln()));
        paper.put(format_args!(r#"<circle class="sum" cx="{:.1}" cy="{:.1}" r="8" fill="{fill}"/>"#, at.x, at.y));
    }
    paper.ring(PLANE.origin, 11.0, Pen { width: 1.4, colour: INK });
    let others = sums.len() - 1;
    let title = format!("{others} resultants V, and zero (ringed), of the 4096 sets of movers");
    paper.formula(Vector::new(300.0, 22.0), 16.0, Anchor::Middle, &title);
    legend(&mut paper, most);
    example(&mut paper);
    paper.finish()
}

fn axes(paper: &mut Paper) {
    let pen = Pen { width: 0.8, colour: FAINT };
    let o = PLANE.origin;
    for n in -5..=5i8 {
        let off = PLANE.bond * f64::from(n);
        let reach = if n == 0 { 266.0 } else { 4.0 };
        paper.line(o + Vector::new(off, -reach), o + Vector::new(off, reach), pen);
        paper.line(o + Vector::new(-reach, off), o + Vector::new(reach, off), pen);
    }
}

/// Draws the colour scale, which is logarithmic.
fn legend(paper: &mut Paper, most: f64) {
    let x = 190.0;
    let y = HEIGHT - 34.0;
    let width = 220.0;
    paper.put(format_args!(r#"<linearGradient id="sets">"#));
    for stop in 0..=20u8 {
        let share = f64::from(stop) / 20.0;
        paper.put(format_args!(r#"<stop offset="{share}" stop-color="{}"/>"#, hex(viridis(share))));
    }
    paper.put(format_args!("</linearGradient>"));
    paper.put(format_args!(r#"<rect x="{x}" y="{y}" width="{width}" height="12" fill="url(#sets)"/>"#));
    paper.text(Vector::new(x - 12.0, y + 11.0), 14.0, Anchor::End, "sets with this sum");
    for count in [1.0, 3.0, 10.0, 30.0, most] {
        let at = Vector::new(x + width * count.ln() / most.ln(), y + 26.0);
        paper.text(at, 13.0, Anchor::Middle, &format!("{count}"));
    }
}

/// Returns the incoming and the outgoing state of the example, which includes a kick by gravity.
fn example_states(table: &Collisions) -> Option<(u16, u16)> {
    let states = (0..4096u16).map(|movers| movers << 1).filter(|state| state.count_ones() == 3);
    states.into_iter().find_map(|state| {
        let (x, y) = momentum(state);
        let choice = table.choice(3, resultant_index((x, y + STEPS[DOWN].1)));
        let out = table.states(choice).iter().find(|&&out| out & state == 0)?;
        (choice.is_exact && x != 0 && y > 0).then_some((state, *out))
    })
}

fn example(paper: &mut Paper) {
    let Some((before, after)) = example_states(&Collisions::default()) else { return };
    let site = |y: f64| Lattice { origin: Vector::new(745.0, y), bond: 54.0 };
    let label = |paper: &mut Paper, y: f64, text: &str| {
        paper.formula(Vector::new(745.0, y), 15.0, Anchor::Middle, text);
    };
    label(paper, 44.0, "three particles come in");
    incoming(paper, site(130.0), before);
    label(paper, 228.0, "their sum V, and gravity: V + v_4");
    triangle(paper, Lattice { origin: Vector::new(698.0, 340.0), bond: 54.0 }, before);
    label(paper, 412.0, "three with the sum V + v_4 go out");
    outgoing(paper, site(515.0), after);
    paper.line(Vector::new(600.0, 30.0), Vector::new(600.0, HEIGHT - 30.0), Pen { width: 0.8, colour: FAINT });
}

/// Draws V, v4 at the tip of V, and their sum.
fn triangle(paper: &mut Paper, at: Lattice, before: u16) {
    let v = momentum(before);
    let down = STEPS[DOWN];
    let kicked = (v.0 + down.0, v.1 + down.1);
    let tip = at.at(v);
    let sum = at.at(kicked);
    paper.arrow(at.origin, tip, sum_pen([0x88; 3]));
    paper.arrow(tip, sum, sum_pen([0x33, 0xa0, 0x62]));
    paper.arrow(at.origin, sum, sum_pen(INK));
    paper.text(0.5 * (at.origin + tip) + Vector::new(-6.0, -8.0), 15.0, Anchor::End, "V");
    paper.formula(0.5 * (tip + sum) + Vector::new(8.0, 5.0), 15.0, Anchor::Start, "v_4");
    paper.formula(0.5 * (at.origin + sum) + Vector::new(4.0, 20.0), 15.0, Anchor::Start, "V + v_4");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_109_sums() {
        let svg = resultants();
        super::super::renders(&svg);
        assert_eq!(svg.matches(r#"class="sum""#).count(), 109);
        assert_eq!(sums().values().sum::<u32>(), 4096);
    }

    #[test]
    fn the_example_gains_exactly_one_kick() {
        let (before, after) = example_states(&Collisions::default()).unwrap();
        let v = momentum(before);
        let out = momentum(after);
        assert_eq!(out, (v.0, v.1 - 2));
        assert_eq!(before.count_ones(), after.count_ones());
    }
}
