//! Panels of the figure of Janssen's silo.

use super::profile::{Profile, vanel_clement};
use super::standard::wheat;
use super::{DIAMETER, Silo};
use siloflow_figures::diagram::{Axis, Curve, Key, Mark, Panel, colour};

/// Points of a line, or dots.
fn curve(name: &str, number: usize, points: Vec<(f64, f64)>, is_line: bool) -> Curve {
    Curve {
        name: name.to_owned(),
        colour: colour(number),
        points,
        has_line: is_line,
        has_dots: !is_line,
        ..Curve::default()
    }
}

/// Shares of the weight on wall and floor over time.
pub(super) fn loads_over_time(silo: &Silo<'_>) -> Panel {
    let settled = silo.run.number("parameters.settled").unwrap_or(0.0);
    let loads = &silo.loads;
    let times = &silo.loads.times;
    let weight = loads.weight(super::window(silo.run, 0));
    let share = |load: &[f64]| times.iter().copied().zip(load.iter().map(|force| force / weight)).collect();
    let curves = vec![curve("wall", 1, share(&loads.wall), true), curve("floor", 2, share(&loads.floor), true)];
    let end = times.last().copied().unwrap_or(1.0);
    let axes = [Axis::linear("time, s", 0.0, end), Axis::linear("share of the weight", 0.0, 1.4)];
    let marks = [(0.0, "lifted"), (0.4, "stopped"), (0.6, "outlet opens")];
    let marks = marks.map(|(after, name)| Mark { at: settled + after, name: name.to_owned() }).to_vec();
    let [x, y] = axes;
    Panel { curves, marks, ..Panel::new("Loads", x, y) }
}

/// Vertical stress and pressure on the wall against depth.
pub(super) fn stresses(time: &str, profile: &Profile) -> Panel {
    let in_diameters = |pascals: f64| pascals / profile.unit_weight / DIAMETER;
    let depth = |of: &dyn Fn(&super::profile::Slice) -> f64| {
        profile.slices.iter().map(|slice| (slice.depth / DIAMETER, in_diameters(of(slice)))).collect::<Vec<_>>()
    };
    let mut curves = vec![
        curve("vertical stress, balance", 1, depth(&|slice| slice.vertical), false),
        curve("vertical stress, contacts", 6, depth(&|slice| slice.coarse), true),
        curve("pressure on the wall", 2, depth(&|slice| slice.pressure), false),
        curve("friction on the wall", 3, depth(&|slice| slice.friction), false),
    ];
    if let Some(fit) = profile.two_parameters() {
        let [a, lambda] = fit.values;
        let places = (0..=100).map(|n| profile.deepest() * f64::from(n) / 100.0);
        let law = places.map(|z| (z / DIAMETER, vanel_clement(z, a, lambda) / DIAMETER)).collect();
        curves.push(curve("Vanel and Clement", 0, law, true));
    }
    let values = || curves.iter().flat_map(|curve| curve.points.iter());
    let x = Axis::around("depth, d", values().map(|point| point.0).chain([0.0]));
    let y = Axis::around("stress over rho g, d", values().map(|point| point.1).chain([0.0]));
    let title = format!("Stresses, {time}");
    Panel { curves, key: Key::Above, ..Panel::new(title, x, y) }
}

/// Load on the floor against the filled mass: dots and law of each time.
pub(super) fn fillings(times: &[(&str, Vec<(f64, f64)>, Option<[f64; 2]>)]) -> Panel {
    let most = times.iter().flat_map(|(_, points, _)| points.iter().map(|point| point.0)).fold(1.0, f64::max);
    let mut curves = vec![Curve { is_dashed: true, ..curve("weight", 0, vec![(0.0, 0.0), (most, most)], true) }];
    for (number, (name, points, law)) in (1..).zip(times) {
        curves.push(curve(name, number, points.clone(), false));
        if let Some([free, scale]) = law {
            let places = (0..=100).map(|n| most * f64::from(n) / 100.0);
            let points = places.map(|m| (m, vanel_clement(m, *free, *scale))).collect();
            curves.push(curve("", number, points, true));
        }
    }
    let [x, y] = ["filled mass, g", "load on the floor over g, g"].map(|label| Axis::around(label, [0.0, most]));
    Panel { curves, ..Panel::new("Fillings", x, y) }
}

/// Pressures on the wall in some times beside those of the standard for wheat.
pub(super) fn beside_the_standard(times: &[(&str, Profile)]) -> Panel {
    let mut curves = Vec::new();
    for (number, (name, profile)) in (1..).zip(times) {
        let scale = profile.unit_weight * profile.radius;
        let found = profile.slices.iter().map(|slice| (slice.depth / profile.radius, slice.pressure / scale));
        curves.push(curve(&format!("siloflow, {name}"), number, found.collect(), false));
    }
    let deepest = times.iter().map(|(_, profile)| profile.deepest() / profile.radius).fold(0.0, f64::max);
    let places = || (0..=100).map(|n| deepest * f64::from(n) / 100.0);
    let edge = |of: fn((f64, f64)) -> f64| places().map(|z| (z, of(wheat(z)))).collect::<Vec<_>>();
    let edges = [("EN 1991-4, wheat, upper", 0, edge(|it| it.1)), ("EN 1991-4, wheat, lower", 3, edge(|it| it.0))];
    curves.extend(edges.map(|(name, number, points)| Curve { is_dashed: true, ..curve(name, number, points, true) }));
    let values = || curves.iter().flat_map(|curve| curve.points.iter());
    let x = Axis::around("depth over R", values().map(|point| point.0).chain([0.0]));
    let y = Axis::around("pressure on the wall over gamma R", values().map(|point| point.1).chain([0.0]));
    Panel { curves, key: Key::Above, ..Panel::new("Not a design check: EN 1991-4 beside it", x, y) }
}
