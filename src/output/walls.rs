//! `walls.csv`: the mean force of the grains on each wall surface, one row per wall every `series.interval` seconds, with the columns `WALL` and
//! `LOADS`. `wall_groups.csv`: the same for all walls of one name together, if walls have names, with `GROUP` and `LOADS`.
//!
//! The force is that *on the wall*: on a floor under gravity it points down. A mean is over all steps since the row before; the first row is of
//! time 0 alone. The reference point of the torque is the `point` of a
//! half-plane, the `from` of a segment, cylinder or cone, the `corner` of a panel and the `centre` of an annulus or spherical zone, and moves with
//! the wall; of a group it is the one of its first wall.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::measure::{ObserveStage, due};
use crate::scene::outputs::Series;
use crate::writers::rows::{Rows, TakenOnce};
use siloflow_dem::outcome::Outcome;
use siloflow_dem::persist::{PersistApp as _, Problem};
use siloflow_dem::space::{Dimension, Linear as _, Solid, Space};
use siloflow_dem::step::{Clock, Part, Phase, Step};
use siloflow_dem::store::KickAppliedAtEnd;
use siloflow_dem::walls::surfaces::Surfaces;
use siloflow_files::columns::Cell::{Decimal, Scientific, Text, Whole};
use siloflow_files::columns::{Column, Columns};
use siloflow_files::growing::OutputPlace;

/// Sums of force, N, and torque, N m, over steps.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
#[serde(bound = "")]
struct Sums<V: Space> {
    force: V,
    torque: V::Spin,
}

/// A row of either file.
#[derive(Debug)]
pub(crate) struct LoadRow {
    /// s.
    time: f64,
    /// The number of the wall, from 1; in `wall_groups.csv` the number of the group.
    number: usize,
    /// The name of the walls; empty in `walls.csv`.
    name: String,
    /// N.
    force: Solid,
    /// N m.
    torque: Solid,
}

const FORCE: &str =
    "mean force of the grains on the wall, over all steps since the row before; the first row is of time 0 alone";
const TORQUE: &str =
    "mean torque of this force about `point`, `from`, `corner` or `centre` of the wall, which moves along";

/// The first columns of `walls.csv`.
pub(crate) const WALL: &[Column<LoadRow>] = &[
    Column::new("time_s", "s", "simulated time at the end of the interval", |row| Decimal(row.time)),
    Column::new("wall", "", "number in the scene, from 1, not counting discs", |row| Whole(row.number as u64)),
];

/// The first columns of `wall_groups.csv`.
pub(crate) const GROUP: &[Column<LoadRow>] = &[
    Column::new("time_s", "s", "simulated time at the end of the interval", |row| Decimal(row.time)),
    Column::new("walls", "", "name of the walls; the torque is about the point of the first of them", |row| {
        Text(&row.name)
    }),
];

/// The last columns of both files.
pub(crate) const LOADS: &[Column<LoadRow>] = &[
    Column::new("fx_n", "N", FORCE, |row| Scientific(row.force.x)),
    Column::new("fy_n", "N", FORCE, |row| Scientific(row.force.y)),
    Column::solid("fz_n", "N", FORCE, |row| Scientific(row.force.z)),
    Column::solid("tx_nm", "N m", TORQUE, |row| Scientific(row.torque.x)),
    Column::solid("ty_nm", "N m", TORQUE, |row| Scientific(row.torque.y)),
    Column::new("tz_nm", "N m", TORQUE, |row| Scientific(row.torque.z)),
];

/// Walls of one name.
struct Group<V: Space> {
    name: String,
    /// Numbers of the walls, ascending.
    walls: Vec<usize>,
    sums: Sums<V>,
}

#[derive(Resource)]
struct WallFiles<V: Space> {
    walls: Rows,
    wall_columns: Columns<LoadRow>,
    sums: Vec<Sums<V>>,
    /// The file of the groups, if there are any.
    groups_file: Option<Rows>,
    group_columns: Columns<LoadRow>,
    groups: Vec<Group<V>>,
    /// Number of steps in the sums.
    steps: u64,
}

/// The saved state: lengths of the two files, the sums, and the number of steps in them.
type Saved<V> = (u64, Option<u64>, Vec<Sums<V>>, Vec<Sums<V>>, u64);

impl<V: Space> WallFiles<V> {
    fn saved(&self) -> Result<Saved<V>, Problem> {
        let groups = self.groups_file.as_ref().map(Rows::saved).transpose()?;
        let sums = self.groups.iter().map(|group| group.sums).collect();
        Ok((self.walls.saved()?, groups, self.sums.clone(), sums, self.steps))
    }

    fn restore(&mut self, (length, groups_length, sums, of_groups, steps): Saved<V>) -> Result<(), Problem> {
        if (sums.len(), of_groups.len()) != (self.sums.len(), self.groups.len()) {
            return Err("the number of walls differs".to_owned());
        }
        self.sums = sums;
        self.groups.iter_mut().zip(of_groups).for_each(|(group, sums)| group.sums = sums);
        self.steps = steps;
        if let (Some(file), Some(length)) = (&mut self.groups_file, groups_length) {
            file.restore(length)?;
        }
        self.walls.restore(length)
    }
}

/// Adds the loads of the step.
fn add_loads<V: Space>(walls: Res<Surfaces<V>>, mut files: ResMut<WallFiles<V>>) {
    let WallFiles { sums, groups, steps, .. } = &mut *files;
    for (sums, load) in sums.iter_mut().zip(&walls.loads) {
        sums.force += load.force;
        sums.torque += load.torque;
    }
    for group in groups {
        let pivot = walls.first_surface(group.walls[0]).reference;
        for &number in &group.walls {
            let load = &walls.loads[number];
            let reference = walls.first_surface(number).reference;
            group.sums.force += load.force;
            group.sums.torque += load.torque + (reference - pivot).cross(load.force);
        }
    }
    *steps += 1;
}

fn write_rows<V: Space>(clock: Res<Clock>, mut files: ResMut<WallFiles<V>>, mut outcome: ResMut<Outcome>) {
    let WallFiles { walls, wall_columns, sums, groups_file, group_columns, groups, steps } = &mut *files;
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let share = 1.0 / *steps as f64;
    let row = |number: usize, name: &str, sums: &mut Sums<V>| {
        let Sums { force, torque } = std::mem::take(sums);
        LoadRow {
            time: clock.time(),
            number,
            name: name.to_owned(),
            force: (force * share).spread(),
            torque: (torque * share).spread(),
        }
    };
    for (number, sums) in (1..).zip(sums) {
        walls.append(format_args!("{}\n", wall_columns.cells(&row(number, "", sums))), &mut outcome);
    }
    if let Some(file) = groups_file {
        for (number, Group { name, sums, .. }) in (1..).zip(groups) {
            file.append(format_args!("{}\n", group_columns.cells(&row(number, name, sums))), &mut outcome);
        }
    }
    *steps = 0;
}

/// Writes `walls.csv` and `wall_groups.csv`, at the times of the rows of
/// [`SeriesPlugin`](crate::output::series::SeriesPlugin).
pub struct WallForcesPlugin<V: Space>(TakenOnce<WallFiles<V>>);

impl<V: Space> WallForcesPlugin<V> {
    /// Creates the files with their headers, or continues them. `names` has the name of each wall surface; names have no comma.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn create(names: &[Option<&str>], walls: &OutputPlace, groups: &OutputPlace) -> std::io::Result<Self> {
        let is_solid = V::DIMENSION == Dimension::Solid;
        let wall_columns = Columns::of(is_solid, &[WALL, LOADS]);
        let group_columns = Columns::of(is_solid, &[GROUP, LOADS]);
        let mut found: Vec<Group<V>> = Vec::new();
        for (number, name) in names.iter().enumerate() {
            let Some(name) = name else { continue };
            match found.iter_mut().find(|group| group.name == *name) {
                Some(group) => group.walls.push(number),
                None => found.push(Group { name: (*name).to_owned(), walls: vec![number], sums: Sums::default() }),
            }
        }
        let has_groups = !found.is_empty();
        Ok(Self(TakenOnce::new(WallFiles {
            walls: Rows::at(walls, &wall_columns.header())?,
            wall_columns,
            sums: vec![Sums::default(); names.len()],
            groups_file: has_groups.then(|| Rows::at(groups, &group_columns.header())).transpose()?,
            group_columns,
            groups: found,
            steps: 0,
        })))
    }
}

impl<V: Space> Plugin for WallForcesPlugin<V> {
    fn build(&self, app: &mut App) {
        let Some(files) = self.0.open() else { return };
        app.persist_sound_part::<WallFiles<V>, _>(WallFiles::saved, WallFiles::restore);
        app.insert_resource(files);
        app.add_systems(Step, add_loads::<V>.in_set(Part::Engine(Phase::Observe)).after(KickAppliedAtEnd));
        app.add_systems(Step, write_rows::<V>.in_set(ObserveStage::Write).run_if(due::<Series>));
    }
}
