//! Air drag on every grain: F = -(a + b |v|) v, with a in N s/m (Stokes) and b in N s^2/m^2 (quadratic).
//!
//! A falling grain reaches the terminal speed v with (a + b v) v = m g.

use serde::Deserialize;
use siloflow::prelude::*;

/// The scene's `behaviours: {"air_drag": (linear: ..., quadratic: ...)}`.
#[derive(Resource, Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AirDrag {
    /// a, N s/m.
    linear: f64,
    /// b, N s^2/m^2.
    #[serde(default)]
    quadratic: f64,
}

fn slow_down<V: Space>(air: Res<AirDrag>, mut grains: AddForce<V, &'static Velocity<V>>) {
    grains.each(|velocity| velocity.0 * -(air.linear + air.quadratic * velocity.0.length()));
}

impl Behaviour for AirDrag {
    fn lives_in(&self, _: Dimension) -> bool {
        true
    }

    fn build(self: Box<Self>, app: &mut App) {
        app.insert_resource(*self);
        in_space!(app, V => app.add_systems(Step, slow_down::<V>.in_set(ForceStage::Added)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::simulation;

    const FALL: &str = "(space: SPACE, gravity: GRAVITY, grains: (file: \"pair.csv\"), step: Fixed(1.0e-3), until: 10.0, \
        contact: Linear(k: 1.0e4, damping: B(20.0)), pictures: None, behaviours: {\"air_drag\": DRAG})";

    fn terminal_velocity<V: Space>(gravity: &str, drag: &str) -> f64 {
        let text = FALL.replace("SPACE", &format!("{:?}", V::DIMENSION)).replace("GRAVITY", gravity);
        let mut run = simulation("fall", text.replace("DRAG", drag));
        assert_eq!(run.run(), End::TimeReached);
        let world = run.world_mut();
        let grains = world.query::<(&Species, &Velocity<V>)>().iter(world).find(|(species, _)| species.0 == 0);
        grains.expect("grain 1 is there").1.0.height()
    }

    #[test]
    fn falling_grain_reaches_its_terminal_velocity() {
        let weight = 0.16 * 9.81;
        let stokes = -weight / 0.4;
        let both = -(-0.4 + f64::sqrt(0.4f64.powi(2) + 4.0 * 0.1 * weight)) / (2.0 * 0.1);
        for (drag, expected) in [("(linear: 0.4)", stokes), ("(linear: 0.4, quadratic: 0.1)", both)] {
            let plane = terminal_velocity::<Plane>("(0.0, -9.81)", drag);
            let solid = terminal_velocity::<Solid>("(0.0, 0.0, -9.81)", drag);
            // 25 relaxation times m/a.
            assert!((plane / expected - 1.0).abs() < 1e-10, "{plane} {expected}");
            assert!((solid / expected - 1.0).abs() < 1e-10, "{solid} {expected}");
        }
    }
}
