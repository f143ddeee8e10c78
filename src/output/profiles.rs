//! `profiles.csv`: means of the scene's [`profiles`](crate::measure::profile), with the columns `PROFILES`. `centres.csv`: the centre of mass of
//! each species, every `series.interval` seconds, with the columns `CENTRES`.
//!
//! Along a periodic axis the centre is the mean of the wrapped positions, which has little meaning.

use std::fmt::Write as _;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::measure::averaging::{Averaging, Progress};
use crate::measure::orientation::vertical;
use crate::measure::profile::{Means, Profile, Sampler, SavedSampler};
use crate::measure::{ObserveStage, due};
use crate::scene::outputs::Series;
use crate::writers::rows::{Rows, TakenOnce};
use siloflow_dem::gravity::Gravity;
use siloflow_dem::outcome::Outcome;
use siloflow_dem::particle::Species;
use siloflow_dem::particles::Motion;
use siloflow_dem::persist::PersistApp as _;
use siloflow_dem::persist::Problem;
use siloflow_dem::space::{Dimension, Solid, Space};
use siloflow_dem::step::{Clock, Step};
use siloflow_dem::store::register_predictable;
use siloflow_files::columns::Cell::{Decimal, Scientific, Text, Whole};
use siloflow_files::columns::{Column, Columns};
use siloflow_files::growing::OutputPlace;

/// A profile that is being averaged, of one species or of all.
#[derive(Clone)]
struct Running<V: Space> {
    /// Number of the profile in the scene, from 1.
    number: usize,
    /// The species; `None` for all grains.
    species: Option<Species>,
    sampler: Sampler<V>,
    averaging: Averaging,
}

#[derive(Resource)]
struct Profiles<V: Space> {
    file: Rows,
    columns: Columns<ProfileRow>,
    running: Vec<Running<V>>,
}

#[derive(Resource)]
struct Centres {
    file: Rows,
    columns: Columns<CentreRow>,
    /// Largest species of the scene.
    species: u8,
}

/// A row of `profiles.csv`.
#[derive(Debug)]
pub(crate) struct ProfileRow {
    profile: usize,
    /// s.
    window: [f64; 2],
    samples: u64,
    species: Option<Species>,
    means: Means<Solid>,
}

const VELOCITY: &str = "mean velocity: momentum over mass";

/// The columns of `profiles.csv`.
pub(crate) const PROFILES: &[Column<ProfileRow>] = &[
    Column::new("profile", "", "number of the profile in the scene, from 1", |row| Whole(row.profile as u64)),
    Column::new("from_s", "s", "times of the first and the last sample", |row| Decimal(row.window[0])),
    Column::new("to_s", "s", "times of the first and the last sample", |row| Decimal(row.window[1])),
    Column::new("samples", "", "number of samples", |row| Whole(row.samples)),
    Column::new("place_m", "m", "middle of the bin along the axis", |row| Decimal(row.means.place)),
    Column::new("species", "", "number of the species, or `all`", |row| {
        row.species.map_or(Text("all"), |species| Whole(species.0.into()))
    }),
    Column::new("count", "grains", "grains per sample", |row| Decimal(row.means.count)),
    Column::new("packing_fraction", "", "packing fraction", |row| Decimal(row.means.packing_fraction)),
    Column::new("vx_m_per_s", "m/s", VELOCITY, |row| Scientific(row.means.velocity.x)),
    Column::new("vy_m_per_s", "m/s", VELOCITY, |row| Scientific(row.means.velocity.y)),
    Column::solid("vz_m_per_s", "m/s", VELOCITY, |row| Scientific(row.means.velocity.z)),
    Column::new("temperature_m2_per_s2", "m^2/s^2", "granular temperature", |row| Scientific(row.means.temperature)),
];

/// Further columns of `profiles.csv` in scenes with shapes.
pub(crate) const ORIENTATIONS: &[Column<ProfileRow>] = &[
    Column::new("inclination_rad", "rad", "mean angle to the vertical, of grains with a shape", |row| {
        Decimal(row.means.orientation.inclination)
    }),
    Column::new("nematic_order", "", "nematic order of grains with a shape, from 0 to 1", |row| {
        Decimal(row.means.orientation.order)
    }),
];

/// A row of `centres.csv`.
#[derive(Debug)]
pub(crate) struct CentreRow {
    /// s.
    time: f64,
    species: u8,
    count: u32,
    /// kg.
    mass: f64,
    /// m.
    centre: Solid,
    /// m/s.
    velocity: Solid,
}

/// The columns of `centres.csv`.
pub(crate) const CENTRES: &[Column<CentreRow>] = &[
    Column::new("time_s", "s", "simulated time", |row| Decimal(row.time)),
    Column::new("species", "", "number of the species; a species without grains has no row", |row| {
        Whole(row.species.into())
    }),
    Column::new("count", "grains", "grains that are present", |row| Whole(row.count.into())),
    Column::new("mass_kg", "kg", "their mass", |row| Scientific(row.mass)),
    Column::new("x_m", "m", "centre of mass", |row| Scientific(row.centre.x)),
    Column::new("y_m", "m", "centre of mass", |row| Scientific(row.centre.y)),
    Column::solid("z_m", "m", "centre of mass", |row| Scientific(row.centre.z)),
    Column::new("vx_m_per_s", "m/s", VELOCITY, |row| Scientific(row.velocity.x)),
    Column::new("vy_m_per_s", "m/s", VELOCITY, |row| Scientific(row.velocity.y)),
    Column::solid("vz_m_per_s", "m/s", VELOCITY, |row| Scientific(row.velocity.z)),
];

fn sample<V: Space>(
    clock: Res<Clock>,
    gravity: Res<Gravity<V>>,
    motion: Motion<V>,
    mut profiles: ResMut<Profiles<V>>,
    mut outcome: ResMut<Outcome>,
) {
    let ends = outcome.end().is_some();
    let Profiles { file, columns, running } = &mut *profiles;
    for profile in running {
        if profile.averaging.is_due(&clock) {
            profile.averaging.count(&clock);
            profile.sampler.add(motion.store(), profile.species, vertical(gravity.0));
        }
        if let Some(done) = profile.averaging.complete(&clock, ends) {
            file.append(format_args!("{}", profile.take_rows(columns, done)), &mut outcome);
        }
    }
}

/// Run condition: a sample is due, an average is complete, or the run ends.
fn has_work<V: Space>(clock: Res<Clock>, profiles: Res<Profiles<V>>, outcome: Res<Outcome>) -> bool {
    outcome.end().is_some() || profiles.running.iter().any(|profile| profile.averaging.has_work(&clock))
}

impl<V: Space> Profiles<V> {
    fn restore(&mut self, (length, averages): (u64, Vec<(SavedSampler<V>, Progress)>)) -> Result<(), Problem> {
        if averages.len() != self.running.len() {
            return Err("the number of profiles differs".to_owned());
        }
        for (running, (sums, progress)) in self.running.iter_mut().zip(averages) {
            running.averaging.restore(progress);
            running.sampler.restore(sums)?;
        }
        self.file.restore(length)
    }
}

impl<V: Space> Running<V> {
    fn saved(&self) -> (SavedSampler<V>, Progress) {
        (self.sampler.saved(), self.averaging.saved())
    }

    /// Returns the means as CSV rows and begins a new average.
    fn take_rows(&mut self, columns: &Columns<ProfileRow>, done: Progress) -> String {
        let mut text = String::new();
        for Means { place, count, packing_fraction, velocity, temperature, orientation } in self.sampler.take() {
            let row = ProfileRow {
                profile: self.number,
                window: done.window,
                samples: done.samples,
                species: self.species,
                means: Means { place, count, packing_fraction, velocity: velocity.spread(), temperature, orientation },
            };
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{}", columns.cells(&row));
        }
        text
    }
}

fn write_centres<V: Space>(
    clock: Res<Clock>,
    motion: Motion<V>,
    mut centres: ResMut<Centres>,
    mut outcome: ResMut<Outcome>,
) {
    for species in 0..=centres.species {
        let mut count = 0u32;
        let mut mass = 0.0;
        let mut moment = V::ZERO;
        let mut momentum = V::ZERO;
        for grain in motion.grains().filter(|&grain| motion.species(grain) == Species(species)) {
            count += 1;
            mass += motion.mass(grain);
            moment += motion.position(grain) * motion.mass(grain);
            momentum += motion.velocity(grain) * motion.mass(grain);
        }
        if count > 0 {
            let centre = (moment / mass).spread();
            let velocity = (momentum / mass).spread();
            let row = CentreRow { time: clock.time(), species, count, mass, centre, velocity };
            let Centres { file, columns, .. } = &mut *centres;
            file.append(format_args!("{}\n", columns.cells(&row)), &mut outcome);
        }
    }
}

/// Measures and writes profiles and centres of mass.
pub struct ProfilesPlugin<V: Space>(TakenOnce<(Profiles<V>, Centres)>);

impl<V: Space> ProfilesPlugin<V> {
    /// Creates the files with their headers, or continues them.
    ///
    /// `profiles` has each profile with the cross-section of the sampled region (m^2, or m in the plane). `species` is
    /// the largest species of the scene. `has_shapes` says whether grains have orientations.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn create(
        profiles: &[(Profile, f64)],
        species: u8,
        has_shapes: bool,
        profiles_place: &OutputPlace,
        centres_place: &OutputPlace,
    ) -> std::io::Result<Self> {
        let is_solid = V::DIMENSION == Dimension::Solid;
        let columns = if has_shapes {
            Columns::of(is_solid, &[PROFILES, ORIENTATIONS])
        } else {
            Columns::of(is_solid, &[PROFILES])
        };
        let file = Rows::at(profiles_place, &columns.header())?;
        let all = (species > 0).then_some(None);
        let kinds: Vec<_> = (0..=species).map(|number| Some(Species(number))).chain(all).collect();
        let running = (1..).zip(profiles).flat_map(|(number, &(profile, section))| {
            let sampler = Sampler::new(profile, section);
            let averaging = Averaging::new(profile.sample, profile.from, profile.average);
            kinds.iter().map(move |&species| Running { number, species, sampler: sampler.clone(), averaging })
        });
        let running = running.collect();
        let profiles = Profiles { file, columns, running };
        let columns = Columns::of(is_solid, &[CENTRES]);
        let centres = Centres { file: Rows::at(centres_place, &columns.header())?, columns, species };
        Ok(Self(TakenOnce::new((profiles, centres))))
    }
}

impl<V: Space> Plugin for ProfilesPlugin<V> {
    fn build(&self, app: &mut App) {
        let Some((profiles, centres)) = self.0.open() else { return };
        app.persist_sound_part::<Centres, _>(
            |centres| centres.file.saved(),
            |centres, length| centres.file.restore(length),
        );
        app.persist_sound_part::<Profiles<V>, _>(
            |profiles| Ok((profiles.file.saved()?, profiles.running.iter().map(Running::saved).collect())),
            Profiles::restore,
        );
        app.insert_resource(profiles).insert_resource(centres);
        register_predictable(app, has_work::<V>, has_work::<V>);
        app.add_systems(
            Step,
            (
                sample::<V>.in_set(ObserveStage::Measure).run_if(has_work::<V>),
                write_centres::<V>.in_set(ObserveStage::Write).run_if(due::<Series>),
            ),
        );
    }
}
