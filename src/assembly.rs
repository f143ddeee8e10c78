//! An app under assembly: which key of the scene asked for each plugin, so that `explain` can tell why a system is there.

use std::collections::HashMap;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{InternedScheduleLabel, SystemKey};

/// Which scene key asked for each system of all schedules.
#[derive(Resource, Default)]
pub struct AskedBy(pub HashMap<(InternedScheduleLabel, SystemKey), String>);

/// Adds plugins and notes who asked for their systems.
pub(crate) struct Assembly<'a> {
    app: &'a mut App,
    asked_by: HashMap<(InternedScheduleLabel, SystemKey), String>,
}

impl<'a> Assembly<'a> {
    pub(crate) fn new(app: &'a mut App) -> Self {
        Self { app, asked_by: HashMap::new() }
    }

    pub(crate) fn add(&mut self, key: &str, plugin: impl Plugin) -> &mut Self {
        self.app.add_plugins(plugin);
        self.note(key);
        self
    }

    /// Adds what `build` adds, asked for by `key`.
    pub(crate) fn add_with(&mut self, key: &str, build: impl FnOnce(&mut App)) {
        build(self.app);
        self.note(key);
    }

    pub(crate) fn provide(&mut self, resource: impl Resource) {
        self.app.insert_resource(resource);
    }

    fn note(&mut self, key: &str) {
        let Some(schedules) = self.app.world().get_resource::<Schedules>() else { return };
        for (_, schedule) in schedules.iter() {
            for (system, ..) in schedule.graph().systems.iter() {
                self.asked_by.entry((schedule.label(), system)).or_insert_with(|| key.to_owned());
            }
        }
    }

    pub(crate) fn finish(self) {
        self.app.insert_resource(AskedBy(self.asked_by));
    }
}
