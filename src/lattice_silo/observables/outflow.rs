//! Outflow rate of the silo.

use super::{FLOW_WINDOW, Frame, History, real};

/// Returns the outflow rate Q = (out(300) - out(100))/200, particles per step. Between two frames `out` is interpolated
/// linearly; with a frame every 10 steps no interpolation is needed. `None` if the history ends before step 300. If the
/// silo is empty before step 300, the mean includes the steps without outflow.
#[must_use]
pub fn outflow_rate(history: &History) -> Option<f64> {
    let (first, last) = FLOW_WINDOW;
    Some((out_at(history, last)? - out_at(history, first)?) / real(last - first))
}

/// Returns the number of particles that have left at a step. `None` unless there are frames at the step or on both
/// sides.
fn out_at(history: &History, step: u64) -> Option<f64> {
    let frames = || std::iter::once(&history.start).chain(&history.frames);
    let before = frames().filter(|frame| frame.step <= step).max_by_key(|frame| frame.step)?;
    let after = frames().filter(|frame| frame.step >= step).min_by_key(|frame| frame.step)?;
    Some(interpolated(before, after, step))
}

/// Interpolates `out` linearly between two frames.
fn interpolated(before: &Frame, after: &Frame, step: u64) -> f64 {
    if before.step == after.step {
        return real(before.out);
    }
    let share = real(step - before.step) / real(after.step - before.step);
    real(before.out) + share * (real(after.out) - real(before.out))
}

#[cfg(test)]
mod tests {
    use super::super::synthetic::{Silo, close};
    use super::*;

    /// 1000 particles leave in the first 100 steps, 7 per step in the next 200, then 50 per step.
    fn history() -> History {
        let mut history = Silo { columns: 1, rows: 1, sites: 20 }.history(|_, _| 0.0, |_, _, _| 0.0);
        history.frames.push(Frame { step: 310, ..history.start.clone() });
        for frame in &mut history.frames {
            frame.out = match frame.step {
                ..100 => 10 * frame.step,
                100..=300 => 1000 + 7 * (frame.step - 100),
                _ => 2400 + 50 * (frame.step - 300),
            };
        }
        history
    }

    #[test]
    fn a_steady_outflow_is_exact() {
        // Exact: whole numbers below 2^53, divided once.
        close(outflow_rate(&history()), 7.0, 0.0);
    }

    #[test]
    fn out_is_interpolated_between_frames() {
        let mut history = history();
        // Without the frame at 300, interpolation between 2330 at 290 and 2900 at 310 gives 2615, which is 215 more.
        history.frames.retain(|frame| frame.step != 300);
        close(outflow_rate(&history), 7.0 + 215.0 / 200.0, 1e-12);
    }

    #[test]
    fn a_short_history_has_no_rate() {
        let mut history = history();
        history.frames.retain(|frame| frame.step < 300);
        assert!(outflow_rate(&history).is_none());
        history.frames.clear();
        assert!(outflow_rate(&history).is_none());
    }
}
