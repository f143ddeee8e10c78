//! `walls.csv`: the mean force of the grains on each wall surface, one row per wall every `series.interval` seconds.
//! `wall_groups.csv`: the same for all walls of one name together, if walls have names.
//!
//! | column | unit | meaning |
//! |---|---|---|
//! | `time_s` | s | simulated time at the end of the interval |
//! | `wall` | | in `walls.csv`, number of the wall among the scene's `walls`, from 1, not counting discs |
//! | `walls` | | in `wall_groups.csv`, the name of the walls |
//! | `fx_n`, `fy_n`, `fz_n` | N | mean force *on the wall*: on a floor under gravity it points down; z in solid space only |
//! | `tx_nm`, `ty_nm`, `tz_nm` | N m | mean torque of this force about the reference point; in the plane z only |
//!
//! A mean is over all steps since the row before; the first row is of time 0 alone. The reference point is the `point` of a
//! half-plane, the `from` of a segment, cylinder or cone, the `corner` of a panel and the `centre` of an annulus or spherical zone, and moves with
//! the wall; of a group it is the one of its first wall.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::measure::{ObserveStage, due};
use crate::scene::outputs::Series;
use crate::writers::rows::{Rows, TakenOnce, numbers};
use siloflow_dem::outcome::Outcome;
use siloflow_dem::persist::{PersistApp as _, Problem};
use siloflow_dem::space::{Dimension, Space};
use siloflow_dem::step::{Clock, Part, Phase, Step};
use siloflow_dem::store::KickAppliedAtEnd;
use siloflow_dem::walls::surfaces::Surfaces;
use siloflow_files::growing::OutputPlace;

/// Sums of force, N, and torque, N m, over steps.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
#[serde(bound = "")]
struct Sums<V: Space> {
    force: V,
    torque: V::Spin,
}

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
    sums: Vec<Sums<V>>,
    /// The file of the groups, if there are any.
    groups_file: Option<Rows>,
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
    let WallFiles { walls, sums, groups_file, groups, steps } = &mut *files;
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let share = 1.0 / *steps as f64;
    let means = |sums: &mut Sums<V>| {
        let Sums { force, torque } = std::mem::take(sums);
        format!("{},{}", numbers(force * share), numbers(torque * share))
    };
    for (number, sums) in (1..).zip(sums) {
        walls.append(format_args!("{:?},{number},{}\n", clock.time(), means(sums)), &mut outcome);
    }
    if let Some(file) = groups_file {
        for group in groups {
            let means = means(&mut group.sums);
            file.append(format_args!("{:?},{},{means}\n", clock.time(), group.name), &mut outcome);
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
        let columns = if is_solid { "fx_n,fy_n,fz_n,tx_nm,ty_nm,tz_nm" } else { "fx_n,fy_n,tz_nm" };
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
            walls: Rows::at(walls, &format!("time_s,wall,{columns}"))?,
            sums: vec![Sums::default(); names.len()],
            groups_file: has_groups.then(|| Rows::at(groups, &format!("time_s,walls,{columns}"))).transpose()?,
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
