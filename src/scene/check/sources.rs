//! Warnings about sources of grains that cannot keep their rate, and about ends of a run that wait for more grains than there are.

use crate::ending::stop::conditions::StopCondition;
use crate::scene::Scene;
use crate::scene::loaded::Loaded;
use siloflow_text::fault::Warning;

/// Adds the warnings about the spawner and feeds. `dt` is the step, s.
pub(super) fn examine(loaded: &Loaded, dt: f64, warnings: &mut Vec<Warning>) {
    feeds(loaded, dt, warnings);
    spawner(loaded, warnings);
}

/// Conditions of `stop` that the grains of the scene cannot fulfil. Behaviours may release further grains.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the rules bound the count of a feed")]
pub(super) fn stop(loaded: &Loaded, warnings: &mut Vec<Warning>) {
    let Scene { stop, spawner, feed, mass, behaviours, .. } = &loaded.scene;
    let start = u32::try_from(loaded.grains.len()).unwrap_or(u32::MAX);
    let all = spawner.iter().fold(start, |sum, spawner| sum.saturating_add(spawner.count));
    let fed = feed.iter().filter_map(|feed| feed.count((*mass)?)).map(|count| count as u32);
    let all = fed.fold(all, u32::saturating_add);
    let is_endless = feed.iter().any(|feed| feed.total.is_none());
    for condition in stop {
        if let StopCondition::Out(count) = *condition
            && count > all
            && !is_endless
            && behaviours.is_empty()
        {
            warnings.push(Warning {
                code: "check::stop_out_of_reach",
                message: format!("`stop` waits for {count} grains to leave, and the scene has {all}"),
                help: "the run ends when the silo is empty, or at `until`: lower the number".to_owned(),
            });
        }
    }
}

/// Feeds that would have to release more grains in a step than they may.
fn feeds(loaded: &Loaded, dt: f64, warnings: &mut Vec<Warning>) {
    let Some(mass) = loaded.scene.mass else { return };
    for (index, feed) in loaded.scene.feed.iter().enumerate() {
        let per_step = feed.grains_per_second(mass) * dt;
        if per_step > f64::from(feed.tries) {
            warnings.push(Warning {
                code: "check::feed_too_fast",
                message: format!(
                    "`feed[{index}]` is to release {per_step:.3e} grains in a step, and tries {} places",
                    feed.tries
                ),
                help: format!("lower `feed[{index}].rate`, or raise `feed[{index}].tries`"),
            });
        }
    }
}

/// A spawner whose grains do not clear its place between two releases.
fn spawner(loaded: &Loaded, warnings: &mut Vec<Warning>) {
    if let Some(spawner) = &loaded.scene.spawner {
        let t = spawner.interval.get();
        let g = loaded.scene.gravity.padded();
        let way = (spawner.velocity.padded() * t + 0.5 * t * t * g).length();
        let (_, largest) = spawner.radius.range();
        if way < 2.0 * largest && spawner.count > 1 {
            warnings.push(Warning {
                code: "check::releases_wait",
                message: format!(
                    "a grain moves {way:.3} m between releases and is up to {:.3} m wide: releases will wait",
                    2.0 * largest
                ),
                help: "release less often, or faster grains".to_owned(),
            });
        }
    }
}
