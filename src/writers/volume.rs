//! How much a run may write: rows, pictures and bytes, and their limits.
//!
//! `until` is often far later than the end of a run, or stands for a run without end. So the limits apply to the first
//! [`HORIZON`] steps, or to all steps up to `until` if they are fewer. The output of later steps is not limited.

/// Number of steps to which the limits apply.
pub const HORIZON: f64 = 1.0e6;

/// Most rows of all CSV files within the horizon.
pub const MOST_ROWS: f64 = 1.0e8;

/// Most pictures within the horizon.
pub const MOST_PICTURES: f64 = 1.0e5;

/// Most bytes of all files within the horizon.
pub const MOST_BYTES: f64 = 1.0e11;

/// One kind of output, written every now and then.
#[derive(Clone, Debug)]
pub struct Output {
    /// The scene key of the time between two of them.
    pub key: String,
    /// Steps between two of them. A run writes at most once in a step.
    pub interval: f64,
    /// Rows of each.
    pub rows: f64,
    /// Pictures of each.
    pub pictures: f64,
    /// Bytes of each, about.
    pub bytes: f64,
}

/// Sums over outputs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Volume {
    /// Rows of CSV files.
    pub rows: f64,
    /// Pictures.
    pub pictures: f64,
    /// Bytes.
    pub bytes: f64,
}

impl Output {
    fn volume(&self, steps: f64) -> Volume {
        let times = (steps / self.interval.max(1.0)).floor() + 1.0;
        Volume { rows: times * self.rows, pictures: times * self.pictures, bytes: times * self.bytes }
    }
}

/// Returns what these outputs write in a number of steps.
#[must_use]
pub fn total(outputs: &[Output], steps: f64) -> Volume {
    outputs.iter().fold(Volume::default(), |sum, output| {
        let Volume { rows, pictures, bytes } = output.volume(steps);
        Volume { rows: sum.rows + rows, pictures: sum.pictures + pictures, bytes: sum.bytes + bytes }
    })
}

/// Returns the key of the output with the largest part in a limit that is passed within the horizon, and a message.
#[must_use]
pub fn excess(outputs: &[Output], until: f64) -> Option<(&str, String)> {
    type Figure = fn(&Volume) -> f64;
    let limits: [(&str, f64, Figure); 3] = [
        ("rows", MOST_ROWS, |volume| volume.rows),
        ("pictures", MOST_PICTURES, |volume| volume.pictures),
        ("bytes", MOST_BYTES, |volume| volume.bytes),
    ];
    let steps = until.min(HORIZON);
    let (what, limit, figure) =
        limits.into_iter().find(|(_, limit, figure)| figure(&total(outputs, steps)) > *limit)?;
    let share = |output: &Output| figure(&output.volume(steps));
    let largest = outputs.iter().max_by(|a, b| share(a).total_cmp(&share(b)))?;
    let sum = figure(&total(outputs, steps));
    Some((
        &largest.key,
        format!("the first {steps} steps would write about {sum:.1e} {what}, more than the limit of {limit:e}"),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn output(key: &str, interval: f64, rows: f64, pictures: f64, bytes: f64) -> Output {
        Output { key: key.to_owned(), interval, rows, pictures, bytes }
    }

    #[test]
    fn a_run_without_end_is_judged_by_its_first_million_steps() {
        let usual =
            [output("series.interval", 50.0, 1.0, 0.0, 200.0), output("pictures.interval", 1000.0, 0.0, 1.0, 1e5)];
        assert_eq!(excess(&usual, 1e300), None);
        assert_eq!(total(&usual, 1000.0), Volume { rows: 21.0, pictures: 2.0, bytes: 21.0 * 200.0 + 2.0 * 1e5 });
        // More often than steps is once in a step.
        assert_eq!(total(&[output("a", 1e-300, 1.0, 0.0, 0.0)], 10.0), Volume { rows: 11.0, ..Volume::default() });
    }

    #[test]
    fn the_largest_part_is_named() {
        let outputs =
            [output("series.interval", 1.0, 1.0, 0.0, 200.0), output("pictures.interval", 1.0, 0.0, 1.0, 1e5)];
        let (key, message) = excess(&outputs, 1e6).unwrap();
        assert_eq!(key, "pictures.interval");
        assert!(message.contains("1000000 steps") && message.contains("1.0e6 pictures"), "{message}");
        assert_eq!(excess(&outputs, 9e4), None);
        assert_eq!(excess(&[output("profiles[0].average", 1.0, 1e4, 0.0, 1.0)], 1e9).unwrap().0, "profiles[0].average");
        assert!(excess(&[output("pictures.interval", 100.0, 0.0, 1.0, 1e8)], 1e9).unwrap().1.contains("bytes"));
    }
}
