//! Grains that break: a grain breaks when a contact presses it with more than `strength` times its diameter.
//!
//! In the plane it breaks into three equal discs, in solid space into four equal spheres, that touch each other and its outline from
//! inside: radii R/(1 + 2/sqrt(3)) = 0.464 R and R/(1 + sqrt(3/2)) = 0.449 R. The pieces share the mass, so they are denser, and they do not overlap, so
//! no energy comes from nowhere. Pieces smaller than `smallest` do not break.

use serde::Deserialize;
use siloflow::prelude::*;

/// The scene's `behaviours: {"breakage": (strength: ..., smallest: ...)}`.
#[derive(Resource, Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Breakage {
    /// Largest load, N per m of diameter.
    strength: f64,
    /// Radius below which grains do not break, m.
    smallest: f64,
}

/// Returns unit vectors to the pieces, and the radius of a piece over that of the grain.
fn pattern<V: Space>() -> (Vec<V>, f64) {
    let corners: &[[f64; 3]] = match V::DIMENSION {
        Dimension::Plane => &[[0.0, 1.0, 0.0], [-0.75f64.sqrt(), -0.5, 0.0], [0.75f64.sqrt(), -0.5, 0.0]],
        Dimension::Solid => &[[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]],
    };
    let share = match V::DIMENSION {
        Dimension::Plane => 1.0 / (1.0 + 2.0 / 3f64.sqrt()),
        Dimension::Solid => 1.0 / (1.0 + 1.5f64.sqrt()),
    };
    (corners.iter().map(|corner| V::narrow(Solid::from_array(*corner)).unit_or_zero()).collect(), share)
}

fn break_grains<V: Space>(
    rule: Res<Breakage>,
    contacts: ContactView<V>,
    particles: Particles<V>,
    mut requests: GrainRequests<V>,
) {
    let (directions, share) = pattern::<V>();
    let mut load = vec![0.0f64; contacts.rows()];
    for contact in contacts.iter() {
        let pressed = [Some(contact.row()), contact.partner_row()];
        for row in pressed.into_iter().flatten() {
            load[row] = load[row].max(contact.force().normal.dot(contact.normal()));
        }
    }
    for row in particles.grains() {
        let radius = particles.radius(row);
        if radius >= rule.smallest && load[row] > rule.strength * 2.0 * radius {
            let pieces = directions.iter().map(|&way| Piece::new(way * (radius * (1.0 - share)), radius * share));
            requests.split(particles.id(row), pieces, "breakage");
        }
    }
}

impl Behaviour for Breakage {
    fn lives_in(&self, _: Dimension) -> bool {
        true
    }

    fn build(self: Box<Self>, app: &mut App) {
        app.insert_resource(*self);
        in_space!(app, V => app.add_systems(Step, break_grains::<V>.in_set(Phase::Control)));
    }
}
