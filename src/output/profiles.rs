//! `profiles.csv`: means of the scene's [`profiles`](crate::measure::profile). `centres.csv`: the centre of mass of
//! each species, every `series.interval` seconds.
//!
//! | column of `profiles.csv` | unit | meaning |
//! |---|---|---|
//! | `profile` | | number of the profile in the scene, from 1 |
//! | `from_s`, `to_s`, `samples` | s | times of the first and last sample of the means, and number of samples |
//! | `place_m` | m | middle of the bin along the axis |
//! | `species` | | number of the species, or `all` |
//! | `count`, `packing_fraction` | | mean number of grains and packing fraction per sample |
//! | `vx_m_per_s`, ... | m/s | mean velocity |
//! | `temperature_m2_per_s2` | m^2/s^2 | granular temperature |
//!
//! `centres.csv` has `time_s`, `species`, `count`, `mass_kg`, the centre (`x_m`, ...) and its velocity (`vx_m_per_s`,
//! ...). Along a periodic axis the centre is the mean of the wrapped positions, which has little meaning.

use std::fmt::Write as _;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::measure::averaging::{Averaging, Progress};
use crate::measure::profile::{Profile, Sampler, SavedSampler};
use crate::measure::{ObserveStage, due};
use crate::scene::outputs::Series;
use crate::writers::rows::{Rows, TakenOnce, numbers};
use siloflow_dem::outcome::Outcome;
use siloflow_dem::particle::Species;
use siloflow_dem::particles::Motion;
use siloflow_dem::persist::PersistApp as _;
use siloflow_dem::persist::Problem;
use siloflow_dem::space::Space;
use siloflow_dem::step::{Clock, Step};
use siloflow_dem::store::register_predictable;
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
    running: Vec<Running<V>>,
}

#[derive(Resource)]
struct Centres {
    file: Rows,
    /// Largest species of the scene.
    species: u8,
}

/// Returns the column names of a vector.
fn axes<V: Space>(prefix: &str, suffix: &str) -> String {
    let names = ["x", "y", "z"].into_iter().take(V::COMPONENTS).map(|axis| format!("{prefix}{axis}{suffix}"));
    names.collect::<Vec<_>>().join(",")
}

fn sample<V: Space>(
    clock: Res<Clock>,
    motion: Motion<V>,
    mut profiles: ResMut<Profiles<V>>,
    mut outcome: ResMut<Outcome>,
) {
    let ends = outcome.end().is_some();
    let Profiles { file, running } = &mut *profiles;
    for profile in running {
        if profile.averaging.is_due(&clock) {
            profile.averaging.count(&clock);
            profile.sampler.add(motion.store(), profile.species);
        }
        if let Some(done) = profile.averaging.complete(&clock, ends) {
            file.append(format_args!("{}", profile.take_rows(done)), &mut outcome);
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
    fn take_rows(&mut self, Progress { samples, window: [from, to], .. }: Progress) -> String {
        let species = self.species.map_or_else(|| "all".to_owned(), |species| species.0.to_string());
        let number = self.number;
        let mut text = String::new();
        for bin in self.sampler.take() {
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "{number},{from:?},{to:?},{samples},{:?},{species},{:?},{:?},{},{:e}",
                bin.place,
                bin.count,
                bin.packing_fraction,
                numbers(bin.velocity),
                bin.temperature
            );
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
            let x = numbers(moment / mass);
            let v = numbers(momentum / mass);
            centres.file.append(format_args!("{:?},{species},{count},{mass:e},{x},{v}\n", clock.time()), &mut outcome);
        }
    }
}

/// Measures and writes profiles and centres of mass.
pub struct ProfilesPlugin<V: Space>(TakenOnce<(Profiles<V>, Centres)>);

impl<V: Space> ProfilesPlugin<V> {
    /// Creates the files with their headers, or continues them.
    ///
    /// `profiles` has each profile with the cross-section of the sampled region (m^2, or m in the plane). `species` is
    /// the largest species of the scene.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn create(
        profiles: &[(Profile, f64)],
        species: u8,
        profiles_place: &OutputPlace,
        centres_place: &OutputPlace,
    ) -> std::io::Result<Self> {
        let header = format!(
            "profile,from_s,to_s,samples,place_m,species,count,packing_fraction,{},temperature_m2_per_s2",
            axes::<V>("v", "_m_per_s")
        );
        let file = Rows::at(profiles_place, &header)?;
        let all = (species > 0).then_some(None);
        let kinds: Vec<_> = (0..=species).map(|number| Some(Species(number))).chain(all).collect();
        let running = (1..).zip(profiles).flat_map(|(number, &(profile, section))| {
            let sampler = Sampler::new(profile, section);
            let averaging = Averaging::new(profile.sample, profile.from, profile.average);
            kinds.iter().map(move |&species| Running { number, species, sampler: sampler.clone(), averaging })
        });
        let running = running.collect();
        let header = format!("time_s,species,count,mass_kg,{},{}", axes::<V>("", "_m"), axes::<V>("v", "_m_per_s"));
        let centres = Centres { file: Rows::at(centres_place, &header)?, species };
        Ok(Self(TakenOnce::new((Profiles { file, running }, centres))))
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
