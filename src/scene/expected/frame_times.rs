//! The times of the frames of data: those of the scene, or as many as a movie needs, wherever the run ends.

use crate::measure::times::Times;
use crate::scene::expected::{frame_bytes, known_step};
use crate::scene::loaded::Loaded;
use crate::scene::outputs::DataFrames;
use siloflow_dem::values::Positive;

/// Most bytes of the frames of a run to `until`, if the scene gives no interval of its own.
const FREE_BYTES: f64 = 150.0e6;

/// Numbers n of frames in each doubling of the time, and the longest finest interval that goes with each, as a share of `until`.
const FREE_DOUBLINGS: [(u32, f64); 4] = [(100, 1.0 / 1600.0), (50, 1.0 / 800.0), (25, 1.0 / 400.0), (12, 1.0 / 200.0)];

impl Loaded {
    /// The frames of data and their times; `None` if the run keeps none.
    ///
    /// Without `data_frames.interval` a scene with pictures has frames for a movie and the player wherever the run ends: some 200 until an eighth or
    /// sixteenth of `until`, and some 100 more with each doubling of the time. There are fewer if they need more than 150 MB. Each
    /// picture has a frame: intervals are halves, quarters and so on of that between pictures.
    #[must_use]
    pub fn data_frames(&self) -> Option<(&DataFrames, Times)> {
        let frames = self.scene.data_frames.as_ref()?;
        if let Some(interval) = frames.interval {
            return Some((frames, Times::every(interval.get())));
        }
        let pictures = self.scene.pictures.as_ref()?.interval.get();
        let until = self.scene.until.get();
        let bytes = frame_bytes(self, frames);
        let dt = known_step(self).unwrap_or(0.0);
        let growing = FREE_DOUBLINGS.map(|(n, share)| Times::growing(halved(pictures, share * until), n, pictures));
        let affordable = |times: &Times| {
            (dt..pictures).contains(&times.finest) && bytes * times.count(until, Times::MOST_COUNTED) <= FREE_BYTES
        };
        Some((frames, growing.into_iter().find(affordable).unwrap_or(Times::every(pictures))))
    }

    /// The interval of frames for a program that has one interval for a whole run, s: that of the scene, or a part of that between pictures of which
    /// at least 200 fit into `until`.
    #[must_use]
    pub fn even_frames(&self) -> Option<f64> {
        let frames = self.scene.data_frames.as_ref()?;
        let pictures = || Some(self.scene.pictures.as_ref()?.interval.get());
        let part = || Some(halved(pictures()?, self.scene.until.get() / 200.0));
        frames.interval.map(Positive::get).or_else(part)
    }
}

/// Halves an interval until it is at most `most`.
fn halved(interval: f64, most: f64) -> f64 {
    // Rounding may not halve once more.
    std::iter::successors(Some(interval), |it| Some(0.5 * it)).find(|it| *it <= most * (1.0 + 1e-9)).unwrap_or(interval)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scene::load;

    fn loaded(spacing: f64, more: &str) -> Loaded {
        let text = format!(
            "(gravity: (0.0, -9.81), contact: Linear(k: 1.0e4, damping: Restitution(0.5)), step: Fixed(1.0e-3), mass: Disc(100.0), walls: [], until: 30.0, \
             fill: [(low: (0.0, 0.0), high: (1.0, 1.0), spacing: {spacing:?}, radius: Fixed(0.005))], {more})"
        );
        load::from_text("test.ron", "test", Path::new(""), text.clone(), &[])
            .unwrap_or_else(|fault| panic!("{fault}\n{text}"))
    }

    fn times(more: &str) -> Times {
        loaded(0.1, more).data_frames().unwrap().1
    }

    #[test]
    fn a_scene_without_an_interval_of_frames_has_some_for_a_movie_wherever_it_ends() {
        let usual = times("pictures: (interval: 0.5)");
        // The largest of 0.5, 0.25, ... below 30/1600 s. Up to 3.1 s there are 200 frames.
        assert_eq!(usual, Times::growing(0.5 / 32.0, 100, 0.5));
        assert!((usual.count(3.125, 10_000) - 201.0).abs() < 1e-9);
        // A picture in every hundredth of a second has a frame.
        assert_eq!(times("pictures: (interval: 0.01)"), Times::every(0.01));
        assert_eq!(times("pictures: (interval: 0.5), data_frames: (interval: 2.0)"), Times::every(2.0));
        assert!(loaded(0.1, "pictures: None").data_frames().is_none());
    }

    #[test]
    fn frames_that_no_scene_asks_for_are_few_if_they_are_large() {
        let loaded = loaded(0.03, "pictures: (interval: 0.5), data_frames: (format: [Vtk, ExtXyz, LammpsDump])");
        let (frames, times) = loaded.data_frames().unwrap();
        assert!(
            times.finest > 0.5 / 32.0 && frame_bytes(&loaded, frames) * times.count(30.0, 10_000) <= FREE_BYTES,
            "{times:?}"
        );
    }
}
