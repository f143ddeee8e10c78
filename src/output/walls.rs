//! `walls.csv`: the force of the grains on each wall surface, one row per wall every `series.interval` seconds.
//!
//! | column | unit | meaning |
//! |---|---|---|
//! | `time_s` | s | simulated time |
//! | `wall` | | number of the wall among the scene's `walls`, from 1, not counting discs |
//! | `fx_n`, `fy_n`, `fz_n` | N | force *on the wall*: on a floor under gravity it points down; z in solid space only |
//! | `tx_nm`, `ty_nm`, `tz_nm` | N m | torque of this force about the wall's reference point; in the plane z only |
//!
//! The reference point is the `point` of a half-plane, the `from` of a segment, cylinder or cone, the `corner` of a panel
//! and the `centre` of an annulus. Force and torque are those of the step, not averages over the interval.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::measure::{ObserveStage, due};
use crate::outcome::Outcome;
use crate::persist::PersistApp as _;
use crate::scene::outputs::Series;
use crate::space::{Dimension, Space};
use crate::step::{Clock, Step};
use crate::walls::surfaces::Surfaces;
use crate::writers::rows::{Rows, RowsPlace, TakenOnce, numbers};

#[derive(Resource)]
struct WallsFile(Rows);

fn write_rows<V: Space>(
    clock: Res<Clock>,
    walls: Res<Surfaces<V>>,
    mut file: ResMut<WallsFile>,
    mut outcome: ResMut<Outcome>,
) {
    for (wall, load) in walls.with_loads() {
        let (number, force, torque) = (wall.number + 1, numbers(load.force), numbers(load.torque));
        file.0.append(format_args!("{:.9},{number},{force},{torque}\n", clock.time()), &mut outcome);
    }
}

/// Writes `walls.csv`, at the times of the rows of [`SeriesPlugin`](crate::output::series::SeriesPlugin).
pub struct WallForcesPlugin<V: Space>(TakenOnce<WallsFile>, std::marker::PhantomData<V>);

impl<V: Space> WallForcesPlugin<V> {
    /// Creates the file with its header, or continues it.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn create(place: &RowsPlace) -> std::io::Result<Self> {
        let is_solid = V::DIMENSION == Dimension::Solid;
        let header =
            if is_solid { "time_s,wall,fx_n,fy_n,fz_n,tx_nm,ty_nm,tz_nm" } else { "time_s,wall,fx_n,fy_n,tz_nm" };
        Ok(Self(TakenOnce::new(WallsFile(Rows::at(place, header)?)), std::marker::PhantomData))
    }
}

impl<V: Space> Plugin for WallForcesPlugin<V> {
    fn build(&self, app: &mut App) {
        let Some(file) = self.0.open() else { return };
        app.persist_part::<WallsFile, _>(|file| file.0.saved(), |file, length| file.0.restore(length));
        app.insert_resource(file).add_systems(Step, write_rows::<V>.in_set(ObserveStage::Write).run_if(due::<Series>));
    }
}
