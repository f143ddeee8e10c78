//! Paths of grains of a draining silo, from its frames: mean squared displacement across the flow against the distance fallen.
//!
//! Tracers start in every tenth frame. The displacement across of a tracer is taken when it has fallen a distance for the first time, between the two frames about that
//! time on a straight line. It counts if the tracer started in a box that lies half of this distance above the window, so the paths of all lengths have their middles
//! in the window: grains spread faster near the orifice, where the flow shears more.
//!
//! | direction | mean motion that is subtracted from a step between two frames |
//! |---|---|
//! | x, towards the side walls | the mean step of all grains at that place, from cells of two by three lengths, linear between their middles: grains converge to the orifice |
//! | y, along the periodic slot | the mean step of all grains in the window, since nothing holds the bed along the slot |
//!
//! All lengths are in mean diameters.

use std::path::Path;

use crate::studies::validation::unreadable;
use siloflow_files::frames::Frame;
use siloflow_files::frames::reader::FrameReader;
use siloflow_text::fault::Fault;

/// Frames between the starts of tracers.
const EVERY: usize = 10;

/// Width and height of the cells of the mean step, diameters.
const CELL: [f64; 2] = [2.0, 3.0];

/// The places of all grains in the frames of a run.
#[derive(Debug)]
pub struct Tracks {
    /// Places of each grain by frame; NaN for a grain that is out.
    places: Vec<Vec<[f64; 3]>>,
    /// Displacement x and y of each grain since the first frame, less the mean one.
    across: Vec<Vec<[f64; 2]>>,
}

/// The window in which paths have their middles.
#[derive(Clone, Copy, Debug)]
pub struct Window {
    /// Half-width about the middle.
    pub half: f64,
    /// Lowest middle of a path.
    pub low: f64,
    /// Highest middle of a path.
    pub high: f64,
}

impl Window {
    fn has(&self, place: [f64; 3]) -> bool {
        place[0].abs() < self.half && (self.low..self.high).contains(&place[2])
    }

    /// Whether a path from a place by at most the longest of some distances can have its middle in the window.
    fn reaches(&self, place: [f64; 3], fallen: &[f64]) -> bool {
        let longest = fallen.last().copied().unwrap_or(0.0);
        place[0].abs() < self.half && (self.low..self.high + 0.5 * longest).contains(&place[2])
    }
}

impl Tracks {
    /// Reads the frames from `from` (s) on. `diameter` (m) is the unit of length.
    ///
    /// # Errors
    /// If the frames cannot be read.
    pub fn read(path: &Path, from: f64, diameter: f64, window: Window) -> Result<Self, Fault> {
        let unreadable = |error| unreadable(path, &error);
        let reader = FrameReader::open(path).map_err(unreadable)?;
        let depth = reader.header.periodic[1].map_or(f64::INFINITY, |(low, high)| (high - low) / diameter);
        let mut places = Vec::new();
        for frame in reader {
            let frame = frame.map_err(unreadable)?;
            if frame.time >= from {
                places.push(by_id(&frame, diameter));
            }
        }
        Ok(Self::new(places, depth, window))
    }

    /// Takes places by frame and grain; `depth` is the length of the periodic side along y.
    #[must_use]
    pub fn new(places: Vec<Vec<[f64; 3]>>, depth: f64, window: Window) -> Self {
        let mean = MeanStep::of(&places);
        let mut path = vec![[0.0; 2]; places.iter().map(Vec::len).max().unwrap_or(0)];
        let mut across = vec![path.clone()];
        for pair in places.windows(2) {
            let step_y = |a: [f64; 3], b: [f64; 3]| {
                let y = b[1] - a[1];
                if depth.is_finite() { y - depth * (y / depth).round() } else { y }
            };
            let drift = drift(pair, window, step_y);
            for ((place, a), b) in path.iter_mut().zip(&pair[0]).zip(&pair[1]) {
                place[0] += b[0] - a[0] - mean.at(middle(*a, *b));
                place[1] += step_y(*a, *b) - drift;
            }
            across.push(path.clone());
        }
        Self { places, across }
    }

    /// Returns the mean squared displacements along x and y at distances fallen, in ascending order, and the number of tracers.
    #[must_use]
    pub fn spread(&self, window: Window, fallen: &[f64]) -> Vec<([f64; 2], f64)> {
        let mut sums = vec![([0.0; 2], 0.0); fallen.len()];
        for start in (0..self.places.len()).step_by(EVERY) {
            for (grain, place) in self.places[start].iter().enumerate() {
                if !place[0].is_nan() && window.reaches(*place, fallen) {
                    self.follow(start, grain, window, fallen, &mut sums);
                }
            }
        }
        sums.into_iter().map(|([x, y], n)| ([x / n, y / n], n)).collect()
    }

    /// Adds the squared displacements of one tracer.
    fn follow(&self, start: usize, grain: usize, window: Window, fallen: &[f64], sums: &mut [([f64; 2], f64)]) {
        let [x, y, top] = self.places[start][grain];
        let mut next = 0;
        let mut before = 0.0;
        for frame in start + 1..self.places.len() {
            let Some(place) = self.places[frame].get(grain).filter(|place| !place[2].is_nan()) else { return };
            let fall = top - place[2];
            while next < fallen.len() && fall >= fallen[next] {
                let share = if fall > before { (fallen[next] - before) / (fall - before) } else { 1.0 };
                if window.has([x, y, top - 0.5 * fallen[next]]) {
                    for axis in 0..2 {
                        let [origin, a, b] = [start, frame - 1, frame].map(|frame| self.across[frame][grain][axis]);
                        sums[next].0[axis] += (a + share * (b - a) - origin).powi(2);
                    }
                    sums[next].1 += 1.0;
                }
                next += 1;
            }
            before = fall;
        }
    }
}

/// Returns the places of a frame by the grains' ids, which begin with 1.
fn by_id(frame: &Frame, diameter: f64) -> Vec<[f64; 3]> {
    let mut places = Vec::new();
    let Some(table) = frame.table("grains") else { return places };
    let (Some(ids), Some(numbers)) = (table.whole("id"), table.floats("position")) else { return places };
    for (id, place) in ids.into_iter().zip(numbers.chunks_exact(3)) {
        let Ok(id) = usize::try_from(id) else { continue };
        if places.len() <= id {
            places.resize(id + 1, [f64::NAN; 3]);
        }
        places[id] = [place[0] / diameter, place[1] / diameter, place[2] / diameter];
    }
    places
}

fn middle(a: [f64; 3], b: [f64; 3]) -> [f64; 2] {
    [0.5 * (a[0] + b[0]), 0.5 * (a[2] + b[2])]
}

/// Returns the mean step along y in the window.
fn drift(pair: &[Vec<[f64; 3]>], window: Window, step: impl Fn([f64; 3], [f64; 3]) -> f64) -> f64 {
    let steps = pair[0].iter().zip(&pair[1]).filter(|(a, _)| window.has(**a)).map(|(a, b)| step(*a, *b));
    let (sum, n) = steps.filter(|step| !step.is_nan()).fold((0.0, 0.0), |(sum, n), step| (sum + step, n + 1.0));
    if n > 0.0 { sum / n } else { 0.0 }
}

/// The mean step along x between two frames, by place.
struct MeanStep {
    /// Place of the first cell's corner.
    low: [f64; 2],
    /// Number of cells along x and z.
    cells: [usize; 2],
    means: Vec<f64>,
}

impl MeanStep {
    fn of(places: &[Vec<[f64; 3]>]) -> Self {
        let all = || places.iter().flatten().filter(|place| !place[0].is_nan());
        let ends = |axis: usize| {
            all().map(|place| place[axis]).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)))
        };
        let (left, right) = ends(0);
        let (bottom, top) = ends(2);
        let number = |low: f64, high: f64, cell: f64| {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a number of cells of a silo")]
            let number = ((high - low) / cell).ceil().max(1.0) as usize;
            number
        };
        let cells = [number(left, right, CELL[0]), number(bottom, top, CELL[1])];
        let mut this = Self { low: [left, bottom], cells, means: vec![0.0; cells[0] * cells[1]] };
        let mut counts = vec![0.0; this.means.len()];
        for pair in places.windows(2) {
            for (a, b) in pair[0].iter().zip(&pair[1]).filter(|(a, b)| !(a[0] + b[0]).is_nan()) {
                let cell = this.cell(this.scaled(middle(*a, *b)).map(f64::floor));
                this.means[cell] += b[0] - a[0];
                counts[cell] += 1.0;
            }
        }
        for (mean, count) in this.means.iter_mut().zip(counts) {
            *mean /= f64::max(count, 1.0);
        }
        this
    }

    /// Returns a place in cells.
    fn scaled(&self, place: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| (place[axis] - self.low[axis]) / CELL[axis])
    }

    /// Returns the number of the cell with these coordinates, which are kept inside.
    fn cell(&self, at: [f64; 2]) -> usize {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative, and kept inside")]
        let [i, k] = [0, 1].map(|axis| (at[axis].max(0.0) as usize).min(self.cells[axis] - 1));
        i + self.cells[0] * k
    }

    /// Returns the mean step at a place, linear between the middles of cells.
    fn at(&self, place: [f64; 2]) -> f64 {
        let at = self.scaled(place).map(|at| at - 0.5);
        let cell = at.map(f64::floor);
        let [right, up] = [at[0] - cell[0], at[1] - cell[1]];
        let mean = |x: f64, z: f64| self.means[self.cell([cell[0] + x, cell[1] + z])];
        (1.0 - up) * ((1.0 - right) * mean(0.0, 0.0) + right * mean(1.0, 0.0))
            + up * ((1.0 - right) * mean(0.0, 1.0) + right * mean(1.0, 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    const WINDOW: Window = Window { half: 8.0, low: 20.0, high: 40.0 };

    /// Returns grains that fall by 0.1 a frame and step across by `step` (x, y) of grain and frame, in a flow that converges.
    fn falling(step: impl Fn(u64, u64) -> [f64; 2]) -> Vec<Vec<[f64; 3]>> {
        let place =
            |n: u64, k: u64| -20.0 + 40.0 * Stream::new(9, "place").uniform::<3>(n)[usize::try_from(k).unwrap()];
        let mut now: Vec<_> = (0..1500).map(|n| [place(n, 0), place(n, 1), 60.0 + 2.0 * place(n, 2)]).collect();
        let mut all = vec![now.clone()];
        for frame in 0..120 {
            for (n, place) in (0..).zip(&mut now) {
                let [x, y] = step(n, frame);
                *place = [place[0] * 0.998 + x, (place[1] + 0.05 + y + 40.0).rem_euclid(4.0), place[2] - 0.1];
            }
            all.push(now.clone());
        }
        all
    }

    #[test]
    fn random_steps_diffuse_and_steady_ones_do_not_in_a_flow_that_converges_and_drifts() {
        let noise = Stream::new(1, "steps");
        let places = falling(|grain, frame| noise.gaussian::<2>(1000 * grain + frame).map(|g| 0.05 * g));
        let spread = Tracks::new(places, 4.0, WINDOW).spread(WINDOW, &[1.0, 4.0, 8.0]);
        for (([x, y], n), fallen) in spread.into_iter().zip([1.0, 4.0, 8.0]) {
            // Ten steps of variance 0.0025 for each diameter. Some hundred grains: their variance scatters by sqrt(2/300), 8 %; three of that.
            let expected = 0.025 * fallen;
            assert!(n > 300.0 && (y / expected - 1.0).abs() < 0.25, "{fallen}: {y} {n}");
            assert!((x / expected - 1.0).abs() < 0.25, "{fallen}: {x}");
        }
        let still = Tracks::new(falling(|_, _| [0.0; 2]), 4.0, WINDOW).spread(WINDOW, &[8.0]);
        // The mean step is linear in x, so the cells take it off but for the grains' unequal places in them.
        assert!(still[0].0[0] < 2e-3 && still[0].0[1] < 1e-20, "{still:?}");
    }
}
