//! The request of the caller to end the run, for example because the process received a signal.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use bevy_ecs::prelude::*;

/// A request of the caller to end the run.
///
/// The request is read once per step, before the step begins. All systems of the step therefore agree on whether it is the
/// last one.
#[derive(Resource, Default)]
pub(crate) struct StopRequest {
    flag: Option<Arc<AtomicUsize>>,
    is_made: bool,
}

impl StopRequest {
    /// Takes any number other than zero in `flag` as the request.
    pub(crate) fn watch(&mut self, flag: Arc<AtomicUsize>) {
        self.flag = Some(flag);
    }

    /// Reads the flag, at the beginning of a step.
    pub(crate) fn read(&mut self) {
        self.is_made |= self.flag.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed) != 0);
    }

    /// Whether this step is the last one.
    pub(crate) fn is_made(&self) -> bool {
        self.is_made
    }
}
