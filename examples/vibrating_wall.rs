//! A behaviour in one file: the wall of a silo vibrates sideways.
//!
//! x(t) = x_0 + A sin(2 pi f t) for every wall grain, with A in m and f in Hz. The velocity of the wall is set too, so
//! that damping uses it and its work is counted. Run it with
//!
//! ```text
//! cargo run --release --example vibrating_wall -- run examples/vibrating_wall.ron
//! ```

use std::f64::consts::TAU;
use std::process::ExitCode;

use serde::{Deserialize, Serialize};
use siloflow::prelude::*;

/// The scene's `behaviours: {"vibrating_wall": (...)}`.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VibratingWall {
    /// Amplitude A, m.
    amplitude: f64,
    /// Frequency f, Hz.
    frequency: f64,
}

/// Position of a wall grain without vibration, m.
#[derive(Component, Serialize, Deserialize)]
struct Home(Vector);

#[derive(Resource)]
struct Vibration(VibratingWall);

/// Filter for wall grains. `With<Fixed>` makes the query disjoint from queries of grains that move in this phase.
type WallGrain = With<Fixed>;

fn remember_home(mut commands: Commands, new: Query<(Entity, &Position), (WallGrain, Without<Home>)>) {
    for (wall_grain, position) in &new {
        commands.entity(wall_grain).insert(Home(position.0));
    }
}

fn vibrate(
    clock: Res<Clock>,
    vibration: Res<Vibration>,
    mut wall: Query<(&Home, &mut Position, &mut Velocity), WallGrain>,
) {
    let VibratingWall { amplitude, frequency } = vibration.0;
    let (sine, cosine) = (TAU * frequency * clock.time()).sin_cos();
    for (home, mut x, mut v) in &mut wall {
        x.0 = home.0 + Vector::new(amplitude * sine, 0.0);
        v.0 = Vector::new(TAU * frequency * amplitude * cosine, 0.0);
    }
}

impl Behaviour for VibratingWall {
    fn check(&self, scene: &Loaded) -> Result<(), String> {
        let per_period = 1.0 / (self.frequency * scene.step());
        if per_period < 20.0 {
            return Err(format!("a period has only {per_period:.1} steps, 20 are needed: lower `frequency` or `step`"));
        }
        Ok(())
    }

    fn build(self: Box<Self>, app: &mut App) {
        // Saved with checkpoints, because a wall grain is not at home when a run is resumed.
        app.persist_component::<Home>();
        app.insert_resource(Vibration(*self))
            .add_systems(Step, (remember_home.in_set(Phase::Spawn), vibrate.in_set(Phase::Drift).after(ClockAdvanced)));
    }
}

/// Runs the program `siloflow` with this behaviour.
#[allow(dead_code, reason = "the test suite includes this file as a module")]
fn main() -> ExitCode {
    siloflow::cli::main_with(Registry::default().register::<VibratingWall>("vibrating_wall"))
}
