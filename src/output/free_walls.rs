//! `free_walls.csv`: the free walls at the times of the rows of `series.csv`, and their figures in the summary.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::Serialize;

use crate::measure::{ObserveStage, due};
use crate::scene::outputs::Series;
use crate::writers::rows::{Rows, TakenOnce};
use siloflow_dem::outcome::Outcome;
use siloflow_dem::persist::PersistApp as _;
use siloflow_dem::space::{Dimension, Plane, Solid, Space};
use siloflow_dem::step::{Clock, Step};
use siloflow_dem::walls::free::{FreeState, FreeWall};
use siloflow_dem::walls::surfaces::Surfaces;
use siloflow_files::columns::Cell::{Decimal, Scientific, Text, Whole};
use siloflow_files::columns::{Column, Columns};
use siloflow_files::growing::OutputPlace;

/// A free wall at a time.
#[derive(Debug)]
pub(crate) struct FreeRow {
    /// s.
    time: f64,
    name: String,
    /// J.
    kinetic: f64,
    state: FreeState,
}

/// The columns.
pub(crate) const COLUMNS: &[Column<FreeRow>] = &[
    Column::new("time_s", "s", "simulated time", |row| Decimal(row.time)),
    Column::new("walls", "", "name of the walls", |row| Text(&row.name)),
    Column::new("coordinate", "m or rad", "shift along the direction, or angle", |row| {
        Scientific(row.state.coordinate)
    }),
    Column::new("rate", "m/s or rad/s", "its rate", |row| Scientific(row.state.rate)),
    Column::new("of_grains", "N or N m", "force of the grains along the direction, or torque about the axis", |row| {
        Scientific(row.state.of_grains)
    }),
    Column::new("applied", "N or N m", "all other forces: load, weight, spring, dashpot, motor", |row| {
        Scientific(row.state.applied)
    }),
    Column::new("work_j", "J", "work of these other forces so far", |row| Scientific(row.state.work)),
    Column::new("kinetic_j", "J", "kinetic energy of the walls", |row| Scientific(row.kinetic)),
    Column::new("lost_j", "J", "energy that stops have taken so far", |row| Scientific(row.state.lost)),
    Column::new("hits", "", "how often the walls have met a stop", |row| Whole(row.state.hits.into())),
];

/// A free wall at the end of a run, in the summary. Coordinates are in m or rad, forces in N or N m.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FreeWallFigures {
    /// Name of the walls.
    pub walls: String,
    /// Shift along the direction, or angle.
    pub coordinate: f64,
    /// Its rate.
    pub rate: f64,
    /// Force of the grains along the direction, or torque about the axis.
    pub of_grains: f64,
    /// All other forces.
    pub applied: f64,
    /// Work of all other forces, J.
    pub work_j: f64,
    /// How often the walls have met a stop.
    pub hits: u32,
}

/// The figures of all free walls of a world.
#[must_use]
pub fn figures(world: &World) -> Vec<FreeWallFigures> {
    fn of<V: Space>(world: &World) -> Vec<FreeWallFigures> {
        let figures = |(wall, state): (&FreeWall, &FreeState)| FreeWallFigures {
            walls: wall.walls.clone(),
            coordinate: state.coordinate,
            rate: state.rate,
            of_grains: state.of_grains,
            applied: state.applied,
            work_j: state.work,
            hits: state.hits,
        };
        world.get_resource::<Surfaces<V>>().into_iter().flat_map(Surfaces::free).map(figures).collect()
    }
    match Dimension::of_world(world) {
        Dimension::Plane => of::<Plane>(world),
        Dimension::Solid => of::<Solid>(world),
    }
}

#[derive(Resource)]
struct FreeWallsFile {
    /// Number of walls of which a message has told that they met a stop.
    told: usize,
    rows: Rows,
    columns: Columns<FreeRow>,
}

fn write_rows<V: Space>(
    clock: Res<Clock>,
    walls: Res<Surfaces<V>>,
    mut file: ResMut<FreeWallsFile>,
    mut outcome: ResMut<Outcome>,
) {
    let FreeWallsFile { told, rows, columns } = &mut *file;
    let stopped: Vec<_> = walls.free().filter(|(_, state)| state.hits > 0).collect();
    if stopped.len() > *told {
        let names: Vec<_> = stopped.iter().map(|(wall, _)| wall.walls.as_str()).collect();
        tracing::warn!("t = {:.3} s: at a stop of `free_walls`, by now: {}", clock.time(), names.join(", "));
        *told = stopped.len();
    }
    for (wall, state) in walls.free() {
        let row = FreeRow { time: clock.time(), name: wall.walls.clone(), kinetic: state.kinetic(wall), state: *state };
        rows.append(format_args!("{}\n", columns.cells(&row)), &mut outcome);
    }
}

/// Writes `free_walls.csv`.
pub struct FreeWallsFilePlugin<V: Space>(TakenOnce<FreeWallsFile>, std::marker::PhantomData<V>);

impl<V: Space> FreeWallsFilePlugin<V> {
    /// Creates the file with its header, or continues it.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn create(place: &OutputPlace) -> std::io::Result<Self> {
        let columns = Columns::of(V::DIMENSION == Dimension::Solid, &[COLUMNS]);
        let rows = Rows::at(place, &columns.header())?;
        Ok(Self(TakenOnce::new(FreeWallsFile { told: 0, rows, columns }), std::marker::PhantomData))
    }
}

impl<V: Space> Plugin for FreeWallsFilePlugin<V> {
    fn build(&self, app: &mut App) {
        let Some(file) = self.0.open() else { return };
        app.persist_sound_part::<FreeWallsFile, _>(
            |file| file.rows.saved(),
            |file, length: u64| file.rows.restore(length),
        );
        app.insert_resource(file).add_systems(Step, write_rows::<V>.in_set(ObserveStage::Write).run_if(due::<Series>));
    }
}
