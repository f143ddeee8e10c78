//! Ends a run when the outlet is clogged: the door is open, no grain has left for a time, and grains are above the outlet.
//!
//! `stop/outlet.rs` defines which grains are above the outlet. The avalanche is what has left since the door began to open.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::door::DoorState;
use crate::ending::regular::{Endings, end_at_time, end_when_empty};
use crate::ending::stop::avalanches::Avalanches;
use crate::ending::stop::conditions::end_by_flow;
use crate::ending::stop::outlet::count_above;
use crate::ending::stop::stillness::is_still;
use crate::ledger::{GrainsAccounted, Ledger};
use siloflow_dem::outcome::{End, Outcome};
use siloflow_dem::particles::Particles;
use siloflow_dem::space::{Solid, Space};
use siloflow_dem::step::{Clock, Phase, Step, time_moves};

/// The scene's condition, and the boxes around its doors, m.
#[derive(Resource)]
struct Outlets {
    still: f64,
    boxes: Vec<[Solid; 2]>,
}

/// Run condition: the door is open, and no grain has left for a time.
fn has_stopped(
    (clock, outlets, ledger): (Res<Clock>, Res<Outlets>, Res<Ledger>),
    door: Option<Res<DoorState>>,
    avalanches: Option<Res<Avalanches>>,
) -> bool {
    is_still(&clock, &ledger, door.as_deref(), avalanches.as_deref(), outlets.still)
}

fn end_by_clog<V: Space>(
    (outlets, ledger): (Res<Outlets>, Res<Ledger>),
    particles: Particles<V>,
    mut outcome: ResMut<Outcome>,
) {
    let above = count_above(&particles, &ledger, &outlets.boxes);
    if above > 0 {
        outcome.finish(End::Clogged { still_s: outlets.still, above, avalanche: ledger.out() });
    }
}

/// Ends the run at a clog.
pub struct ClogPlugin<V: Space> {
    /// Time without a grain that leaves, s.
    pub still: f64,
    /// The boxes around the doors, m.
    pub boxes: Vec<[Solid; 2]>,
    /// The space.
    pub space: PhantomData<V>,
}

impl<V: Space> Plugin for ClogPlugin<V> {
    fn build(&self, app: &mut App) {
        app.insert_resource(Outlets { still: self.still, boxes: self.boxes.clone() }).add_systems(
            Step,
            end_by_clog::<V>
                .in_set(Phase::Cull)
                .in_set(Endings)
                .after(GrainsAccounted)
                .after(end_when_empty)
                .before(end_by_flow)
                .before(end_at_time)
                .run_if(has_stopped)
                .run_if(time_moves),
        );
    }
}
