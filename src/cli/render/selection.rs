//! Which frames are drawn, and the ends of colour scales that cover them.

use std::collections::BTreeSet;
use std::io;

use glam::DVec2;

use super::args::RenderArgs;
use siloflow_files::frames::columns::Columns;
use siloflow_files::frames::{Frame, Header};
use siloflow_results::pictures;
use siloflow_results::pictures::camera::Camera;
use siloflow_results::pictures::style::speeds;

/// Most frames of a movie without `--every`.
const MOVIE_FRAMES: u32 = 200;

/// The frames of a run: their times, and the lowest and highest number that colours grains in each.
#[derive(Default)]
pub(super) struct FrameIndex {
    pub times: Vec<f64>,
    pub ranges: Vec<Option<(f64, f64)>>,
    /// Columns of all frames.
    pub columns: Columns,
    /// Lower left and upper right corner of the box around all grains of all frames, m, in the axes of the camera; `None` without a camera.
    pub box_of_grains: Option<(DVec2, DVec2)>,
}

impl FrameIndex {
    /// Reads all frames. With `colour`, also the numbers of that name; with `camera`, also the places of grains.
    pub fn of(
        header: &Header,
        frames: impl Iterator<Item = io::Result<Frame>>,
        colour: Option<&str>,
        camera: Option<&Camera>,
    ) -> io::Result<Self> {
        let mut survey = Self::default();
        for frame in frames {
            let frame = frame?;
            survey.columns.add(&frame)?;
            survey.times.push(frame.time);
            survey.ranges.push(colour.and_then(|name| range(header, &frame, name)));
            let of_frame = camera.and_then(|camera| pictures::box_of_grains(header, &frame, camera));
            survey.box_of_grains =
                survey.box_of_grains.into_iter().chain(of_frame).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        }
        Ok(survey)
    }

    /// Returns the numbers of the frames to be drawn, ascending.
    pub fn select(&self, args: &RenderArgs) -> Vec<usize> {
        let count = self.times.len();
        if let Some(every) = args.every {
            return self.every(every);
        }
        if !args.at.is_empty() {
            return args
                .at
                .iter()
                .filter_map(|&time| self.nearest(time))
                .collect::<BTreeSet<_>>()
                .into_iter()
                .collect();
        }
        if args.movie {
            return self.even();
        }
        count.checked_sub(1).into_iter().collect()
    }

    /// Says which of the wanted times have no frame near: before the first, after the last, or more than a frame away.
    pub fn tell_far_times(&self, args: &RenderArgs) {
        let (Some(first), Some(last)) = (self.times.first(), self.times.last()) else { return };
        for &time in &args.at {
            let Some(found) = self.nearest(time).map(|number| self.times[number]) else { continue };
            let apart = (last - first) / f64::from(u32::try_from(self.times.len()).unwrap_or(u32::MAX));
            if (found - time).abs() > apart + 1e-9 * time.abs() {
                tracing::warn!(
                    "render::far_time: there is no frame near {time} s: the frame at {found} s is drawn; the run has frames from {first} s to {last} s"
                );
            }
        }
    }

    /// Returns the frames of a movie: at equal times, no nearer than the two neighbours that are farthest apart, so that the motion is even.
    fn even(&self) -> Vec<usize> {
        let (Some(first), Some(last)) = (self.times.first(), self.times.last()) else { return Vec::new() };
        let widest = self.times.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        let parts = ((last - first) / widest - 1e-3).ceil().clamp(1.0, f64::from(MOVIE_FRAMES - 1)) as u32;
        let time = |number: u32| first + (last - first) * f64::from(number) / f64::from(parts);
        let frames: BTreeSet<usize> = (0..=parts).filter_map(|number| self.nearest(time(number))).collect();
        frames.into_iter().collect()
    }

    fn nearest(&self, time: f64) -> Option<usize> {
        let apart = |number: &usize| (self.times[*number] - time).abs();
        (0..self.times.len()).min_by(|a, b| apart(a).total_cmp(&apart(b)))
    }

    /// Returns the first frame at or after each multiple of an interval, s.
    fn every(&self, interval: f64) -> Vec<usize> {
        let mut next = f64::NEG_INFINITY;
        let mut selected = Vec::new();
        for (number, &time) in self.times.iter().enumerate() {
            // Times of frames are multiples of the step, so they may be a little early.
            if time >= next - 1e-3 * interval {
                selected.push(number);
                next = ((time / interval + 1e-3).floor() + 1.0) * interval;
            }
        }
        selected
    }

    /// Returns the lowest and highest number in the selected frames.
    pub fn range(&self, selected: &[usize]) -> Option<(f64, f64)> {
        let ranges = selected.iter().filter_map(|&number| self.ranges[number]);
        ranges.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }
}

/// Returns the lowest and highest number of grains, without wall grains; `None` if there is none.
fn range(header: &Header, frame: &Frame, name: &str) -> Option<(f64, f64)> {
    let grains = frame.table("grains")?;
    let values = if name == "speed" { speeds(header, frame) } else { grains.numbers(name)? };
    let kinds = grains.numbers("kind")?;
    let values = values.into_iter().zip(kinds).filter(|(value, kind)| *kind < 0.5 && value.is_finite());
    values.map(|(value, _)| (value, value)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

/// Returns a round number at or above this one, with one or two digits.
pub(super) fn round_up(value: f64) -> f64 {
    let power = 10f64.powf(value.log10().floor());
    let steps = [1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0];
    steps.into_iter().map(|m| m * power).find(|&end| end >= value * (1.0 - 1e-12)).unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Arguments {
        #[command(flatten)]
        args: RenderArgs,
    }

    fn selected(times: Vec<f64>, options: &[&str]) -> Vec<usize> {
        let ranges = vec![None; times.len()];
        let call = Arguments::parse_from([&["render", "run"], options].concat());
        FrameIndex { times, ranges, ..FrameIndex::default() }.select(&call.args)
    }

    #[test]
    fn frames_are_selected_by_time() {
        let times = || vec![0.0, 0.5, 0.999_999, 1.5, 2.0, 2.3];
        assert_eq!(selected(times(), &["--at", "0.6", "--at", "0.1", "--at", "99", "--at=-5"]), [0, 1, 5]);
        assert_eq!(selected(times(), &["--every", "1"]), [0, 2, 4]);
        assert_eq!(selected(times(), &["--every", "0.01"]), [0, 1, 2, 3, 4, 5]);
        assert_eq!(selected(times(), &["--movie"]), [0, 1, 2, 3, 4, 5]);
        assert_eq!(selected(times(), &["--width", "500"]), [5]);
        assert_eq!(selected(Vec::new(), &["--movie"]), [0_usize; 0]);
        assert_eq!(selected(vec![0.0], &["--movie"]), [0]);
    }

    #[test]
    fn a_movie_of_a_long_run_begins_and_ends_with_it() {
        let times = (0..1000).map(f64::from).collect();
        let movie = selected(times, &["--movie"]);
        assert_eq!((movie.len(), movie[0], movie[199]), (200, 0, 999));
        assert!(movie.windows(2).all(|pair| pair[1] - pair[0] >= 5));
    }

    #[test]
    fn a_movie_of_frames_that_grow_rarer_is_even() {
        let times =
            (0..8).map(|n| 0.125 * f64::from(n)).chain([1.0, 1.25, 1.5, 1.75, 2.0, 2.5, 3.0, 3.5, 4.0]).collect();
        assert_eq!(selected(times, &["--movie"]), [0, 4, 8, 10, 12, 13, 14, 15, 16]);
    }

    #[test]
    fn scales_end_at_round_numbers() {
        for (value, expected) in [(0.97, 1.0), (1.0, 1.0), (1.3, 1.5), (0.034, 0.04), (6.1, 8.0), (9.0, 10.0)] {
            assert!((round_up(value) - expected).abs() < 1e-12 * expected, "{value}");
        }
    }
}
