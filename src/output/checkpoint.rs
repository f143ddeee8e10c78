//! Checkpoints: the whole state of a run, from which it can be resumed to the same bits.
//!
//! They are taken between two steps: every `checkpoint.every` minutes of wall-clock time, before the last step after a signal,
//! and at the regular end. First everything that the run has written is brought to the disk. Then the checkpoint is written beside its
//! name, with the hashes of all these files, synced and renamed.
//! The latest `checkpoint.keep` are kept; at the regular end only the final one.
//!
//! Unless the user has chosen the time between checkpoints, they cost at most a hundredth of the run: if writing takes long, the
//! next one comes later. If one cannot be written, the run goes on without it.

pub mod file;
pub mod find;

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use bevy_ecs::prelude::*;

use self::file::{FORMAT, Header};
use crate::ending::request::StopRequest;
use crate::output::frame_recording::writer::FrameWriter;
use crate::writers::picture_writer::PictureWriter;
use siloflow_dem::outcome::{End, Failure, Outcome};
use siloflow_dem::persist;
use siloflow_dem::persist::{CheckpointConfig, CheckpointFigures};
use siloflow_dem::step::Clock;
use siloflow_dem::store;
use siloflow_files::disk;
use siloflow_files::fnv::Fnv;
use siloflow_files::own_files;
use siloflow_files::run_directory::Guard;
use siloflow_files::run_directory::{
    RunDirectory, checkpoint_name, checkpoints_in, hash_of_input, remove_incomplete_checkpoints,
};
use siloflow_files::run_files::RunFiles;
use siloflow_files::whole_file::{remove_if_there, write_synced};

/// Largest share of the wall-clock time that checkpoints take by default.
const LARGEST_SHARE: f64 = 0.01;

/// Steps between two looks at the wall clock, if checkpoints are at least [`RARE`] apart.
const LOOK_INTERVAL: u64 = 64;
const RARE: Duration = Duration::from_secs(1);

/// Takes the checkpoints of a run.
#[derive(Resource)]
pub struct Checkpoints {
    directory: PathBuf,
    guard: Guard,
    files: RunFiles,
    scene: String,
    /// Hashes of the input and of the program; known from the first checkpoint on.
    identity: Option<[u64; 2]>,
    every: Duration,
    /// Largest share of the wall-clock time that checkpoints take; infinite if the user has chosen the time between them.
    largest_share: f64,
    keep: usize,
    next: Instant,
}

impl Checkpoints {
    /// Takes checkpoints of the scene named `scene` into the run directory. `is_chosen` states that the user has chosen the time between them.
    #[must_use]
    pub fn new(run: &RunDirectory, scene: String, config: CheckpointConfig, is_chosen: bool) -> Self {
        // A century and more is never.
        let every = Duration::try_from_secs_f64((60.0 * config.every.get()).min(1e10)).unwrap_or(Duration::MAX);
        Self {
            directory: run.checkpoints(),
            guard: run.guard(),
            files: run.files().clone(),
            scene,
            identity: None,
            every,
            largest_share: if is_chosen { f64::INFINITY } else { LARGEST_SHARE },
            keep: config.keep.get().into(),
            // A run that has set damaged files aside soon has a checkpoint without them.
            next: if run.files().has_damage() { Instant::now() } else { Instant::now() + every },
        }
    }

    /// Whether a checkpoint is due before the next step.
    fn is_due(&self, steps: u64) -> bool {
        (self.every < RARE || steps.is_multiple_of(LOOK_INTERVAL)) && Instant::now() >= self.next
    }

    /// Returns the hashes of the input and of the program. A final checkpoint is not resumed, so a short run need not read the
    /// whole program.
    fn identity(&mut self, is_final: bool) -> io::Result<[u64; 2]> {
        if let Some(known) = self.identity {
            return Ok(known);
        }
        let input = hash_of_input(self.directory.parent().unwrap_or(Path::new("")))?;
        if is_final {
            return Ok([input, 0]);
        }
        Ok(*self.identity.insert([input, hash_of_program()]))
    }

    /// Writes the state of the world.
    fn take(&mut self, world: &mut World, is_final: bool) -> io::Result<()> {
        let [input, program] = self.identity(is_final)?;
        let start = Instant::now();
        store::refresh_world(world);
        if let Err(failure) = close_writers(world) {
            let error = io::Error::other(failure.to_string());
            world.resource_mut::<Outcome>().fail(failure);
            return Err(error);
        }
        (self.guard)()?;
        if !own_files::is_directory(&self.directory) {
            disk::create_directory(&self.directory)?;
        }
        let run = self.directory.parent().unwrap_or(Path::new(""));
        self.files.sync(run)?;
        let clock = world.resource::<Clock>();
        let header = Header {
            format: FORMAT,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            program,
            input,
            scene: self.scene.clone(),
            steps: clock.steps,
            time: clock.time(),
            is_final,
            files: self.files.manifest(run),
        };
        let path = self.directory.join(checkpoint_name(clock.steps));
        write_synced(&path, |out| file::write_each(out, &header, |keep| persist::save_each(world, keep)))?;
        self.remove_old(if is_final { 1 } else { self.keep })?;
        let taken = start.elapsed();
        let mut figures = world.get_resource_or_init::<CheckpointFigures>();
        figures.written += 1;
        figures.wall_s += taken.as_secs_f64();
        figures.last_bytes = fs::metadata(&path)?.len();
        self.next = Instant::now() + self.every.max(taken.div_f64(self.largest_share));
        Ok(())
    }

    /// Removes all but the latest `keep` checkpoints, and incomplete ones of killed processes.
    fn remove_old(&self, keep: usize) -> io::Result<()> {
        remove_incomplete_checkpoints(&self.directory)?;
        checkpoints_in(&self.directory)?.iter().skip(keep).try_for_each(|path| remove_if_there(path))
    }
}

/// Blocks until all pictures and frames are written.
///
/// # Errors
/// If one could not be written.
pub(crate) fn close_writers(world: &mut World) -> Result<(), Failure> {
    let drawn = world.get_resource_mut::<PictureWriter>().map_or(Ok(()), |mut writer| writer.close());
    let kept = world.get_resource_mut::<FrameWriter>().map_or(Ok(()), |mut writer| writer.close());
    drawn.and(kept)
}

/// Takes a checkpoint, if one is due before the next step or a signal ends the run after it.
pub(crate) fn at_border(world: &mut World) {
    let stops = world.resource::<StopRequest>().is_made();
    let Some(checkpoints) = world.get_resource::<Checkpoints>() else { return };
    let clock = world.resource::<Clock>();
    if !clock.is_step_zero() && (stops || checkpoints.is_due(clock.steps)) {
        take(world, false);
    }
}

/// Takes the final checkpoint of a run that has ended regularly.
pub(crate) fn at_end(world: &mut World) {
    if world.resource::<Outcome>().end().is_some_and(End::is_regular) {
        take(world, true);
    }
}

fn take(world: &mut World, is_final: bool) {
    let Some(mut checkpoints) = world.remove_resource::<Checkpoints>() else { return };
    let step = world.resource::<Clock>().steps;
    match checkpoints.take(world, is_final) {
        Ok(()) => tracing::debug!("step {step}: wrote a checkpoint"),
        Err(error) => {
            tracing::warn!("step {step}: could not write a checkpoint: {error}; the run goes on without it");
            checkpoints.next = Instant::now() + checkpoints.every.max(RARE);
        }
    }
    world.insert_resource(checkpoints);
}

/// Returns the hash of this program's file; 0 if it cannot be read.
#[must_use]
pub fn hash_of_program() -> u64 {
    let mut hash = Fnv::default();
    if cfg!(test) {
        // The program of the unit tests is large, and they resume hundreds of runs.
        return 1;
    }
    let read = std::env::current_exe().and_then(File::open).and_then(|file| hash.update_from(file));
    read.map_or(0, |()| hash.value())
}
