//! Records which scene key requested each system while an app is assembled, so that `explain` can print why a system
//! exists.

use std::collections::HashMap;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{InternedScheduleLabel, SystemKey};

/// The scene key that requested each system, over all schedules.
#[derive(Resource, Default)]
pub struct AskedBy(pub HashMap<(InternedScheduleLabel, SystemKey), String>);

/// Adds plugins and records the keys that requested their systems.
pub(crate) struct Assembly<'a> {
    app: &'a mut App,
    asked_by: HashMap<(InternedScheduleLabel, SystemKey), String>,
}

impl<'a> Assembly<'a> {
    pub(crate) fn new(app: &'a mut App) -> Self {
        Self { app, asked_by: HashMap::new() }
    }

    pub(crate) fn world(&self) -> &World {
        self.app.world()
    }

    pub(crate) fn add(&mut self, key: &str, plugin: impl Plugin) -> &mut Self {
        self.app.add_plugins(plugin);
        self.record(key);
        self
    }

    /// Calls `build`, and records `key` for the systems that it adds.
    pub(crate) fn add_with(&mut self, key: &str, build: impl FnOnce(&mut App)) -> &mut Self {
        build(self.app);
        self.record(key);
        self
    }

    pub(crate) fn provide(&mut self, resource: impl Resource) {
        self.app.insert_resource(resource);
    }

    fn record(&mut self, key: &str) {
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
