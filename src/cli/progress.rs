//! Progress of a run on stderr: a line that renews itself on a terminal, plain lines every few seconds elsewhere.

use std::io::IsTerminal as _;
use std::time::{Duration, Instant};

use bevy_ecs::prelude::*;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::columns::Columns;
use crate::ledger::Ledger;
use crate::space::{Dimension, Plane, Solid, Space};
use crate::step::Clock;

/// Steps between two looks at the wall clock.
const STRIDE: u32 = 64;

/// Kinetic energy of translation, J.
fn kinetic<V: Space>(world: &World) -> f64 {
    let columns = world.resource::<Columns<V>>();
    (0..columns.movable_end).map(|i| columns.kinetic_energy(i)).sum()
}

pub(super) struct Progress {
    bar: Option<ProgressBar>,
    plain: bool,
    until: f64,
    stride: u32,
    start: Instant,
    next: Instant,
    last: (Instant, u64),
}

impl Progress {
    pub(super) fn new(until: f64, quiet: bool) -> Self {
        let on_terminal = std::io::stderr().is_terminal();
        let bar = (on_terminal && !quiet).then(|| {
            let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(5));
            if let Ok(style) = ProgressStyle::with_template("{spinner} {wide_msg}") {
                bar.set_style(style);
            }
            bar
        });
        let now = Instant::now();
        let patience = if on_terminal { Duration::from_millis(300) } else { Duration::from_secs(1) };
        Self { bar, plain: !on_terminal && !quiet, until, stride: 0, start: now, next: now + patience, last: (now, 0) }
    }

    pub(super) fn look(&mut self, world: &mut World, particle_steps: u64) {
        self.stride += 1;
        if self.stride < STRIDE {
            return;
        }
        self.stride = 0;
        let now = Instant::now();
        if now < self.next {
            return;
        }
        if let Some(bar) = &self.bar {
            bar.set_message(self.line(world, particle_steps, now));
            bar.tick();
            self.next = now + Duration::from_millis(200);
        } else if self.plain {
            eprintln!("{}", self.line(world, particle_steps, now));
            self.next = now + Duration::from_secs(5);
        } else {
            self.next = now + Duration::from_hours(1);
        }
        self.last = (now, particle_steps);
    }

    #[expect(clippy::cast_precision_loss, reason = "figures for people")]
    fn line(&self, world: &World, particle_steps: u64, now: Instant) -> String {
        let (time, ledger) = (world.resource::<Clock>().time(), world.resource::<Ledger>());
        let kinetic = match Dimension::of_world(world) {
            Dimension::Plane => kinetic::<Plane>(world),
            Dimension::Solid => kinetic::<Solid>(world),
        };
        let seconds = now.duration_since(self.last.0).as_secs_f64().max(1e-9);
        let speed = (particle_steps - self.last.1) as f64 / seconds / 1e6;
        let left = now.duration_since(self.start).as_secs_f64() * (self.until - time) / time.max(1e-9);
        format!(
            "t = {time:.2} s of at most {:.0} s | {speed:.1} M particle-steps/s | at most {left:.0} s to go | inside {}, \
             out {}, lost {} | kinetic {kinetic:.3e} J",
            self.until,
            ledger.inside(),
            ledger.out(),
            ledger.lost()
        )
    }

    pub(super) fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
