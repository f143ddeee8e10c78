//! A thrown grain in free flight, against its parabola.

use glam::DVec2;

use super::super::case::{Case, Measure, Truth, disc, linear};
use super::super::reference::closed::{duration, flight};
use super::super::reference::{State, System};

const G: DVec2 = DVec2::new(0.0, -9.81);

pub(super) fn case() -> Case {
    let v = DVec2::new(3.0, 2.0);
    let k = 1.0e5;
    let m = 0.16;
    let contact_duration = duration(k, 1.0, true, 0.5 * m);
    let end = 20.0 * contact_duration;
    Case {
        name: "free-flight",
        title: "free flight",
        systems: vec![System {
            clumps: vec![],
            gravity: G,
            law: linear(k, 1.0, true),
            discs: vec![disc(0.04, m, DVec2::ZERO, v)],
            floors: vec![],
        }],
        contact_duration,
        end,
        truth: Truth::Closed(parabola),
        measure: Measure::Place(v.length() * end),
        finest: 200.0,
        touch: None,
    }
}

fn parabola(system: &System, t: f64) -> State {
    let disc = &system.discs[0];
    let (x, v) = flight(disc.x, disc.v, system.gravity, t);
    State { x: vec![x], v: vec![v], w: vec![0.0] }
}
