//! A run in slices.

use std::path::Path;
use std::time::Duration;

use siloflow::behaviour::Registry;
use siloflow::cli::check;
use siloflow::cli::sliced::{Slice, SlicedRun};
use siloflow::dem::budget::Budget;
use siloflow::dem::step::Clock;
use siloflow::results::report;
use siloflow::scene::load;
use siloflow::text::fault::Fault;

use crate::examination::refuse_large;
use crate::picture::Pictures;
use crate::sample::{Events, Sample};

/// The run directory.
pub const RUN: &str = "/run";

/// A run that goes on.
pub struct Run {
    engine: SlicedRun,
    pictures: Option<Pictures>,
    last: Slice,
}

impl Run {
    /// Starts a run of the scene at a path.
    pub fn start(path: &str) -> Result<Self, Fault> {
        let registry = Registry::default();
        let scene = load::any(Path::new(path), &[])?;
        refuse_large(&scene, &check::examine(&scene, &registry, &Budget::usual())?)?;
        let engine = SlicedRun::start(scene, registry, Path::new(RUN))?;
        let pictures = Pictures::of(&engine);
        Ok(Self { engine, pictures, last: Slice::Over })
    }

    /// Steps for at most so many milliseconds, not beyond a time, and with `to_event` not beyond the next event.
    pub fn advance(&mut self, milliseconds: f64, until: f64, to_event: bool) {
        let longest = Duration::try_from_secs_f64(milliseconds / 1000.0).unwrap_or_default();
        let before = Events::of(self.engine.world());
        self.last = self.engine.advance(longest, move |world| {
            world.resource::<Clock>().has_reached(until) || to_event && Events::of(world) != before
        });
    }

    /// The present numbers.
    pub fn sample(&mut self) -> Sample {
        Sample::of(self.engine.world(), self.last)
    }

    /// The present state for the player.
    pub fn picture(&mut self, contacts: bool) -> Result<Vec<u8>, Fault> {
        let pictures = self.pictures.as_mut();
        let pictures = pictures
            .ok_or_else(|| Fault::new("page::picture", "the lattice gas has pictures of its own in /run/frames"))?;
        pictures.next(self.engine.world(), contacts)
    }

    /// Ends the run, and writes its state and its summary. Returns the summary in words.
    pub fn finish(self) -> String {
        self.engine.finish().words
    }
}

/// The report of the run that has been finished.
pub fn report() -> Result<String, Fault> {
    report::page(&[Path::new(RUN)], &siloflow::scene::facts::read)
}
