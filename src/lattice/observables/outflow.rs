//! How fast the silo empties.

use super::{FLOW_WINDOW, Frame, History, real};

/// Outflow rate Q = (out(300) - out(100))/200, particles per step. Between two frames `out` is interpolated linearly;
/// with a frame every 10 steps it never needs to be. A history that ends before 300 has no rate; one that goes on when
/// the silo has run empty has the lower one.
#[must_use]
pub fn outflow_rate(history: &History) -> Option<f64> {
    let (first, last) = FLOW_WINDOW;
    Some((out_at(history, last)? - out_at(history, first)?) / real(last - first))
}

/// Particles out at a step, if there are frames at or on both sides of it.
fn out_at(history: &History, step: u64) -> Option<f64> {
    let frames = || std::iter::once(&history.start).chain(&history.frames);
    let before = frames().filter(|frame| frame.step <= step).max_by_key(|frame| frame.step)?;
    let after = frames().filter(|frame| frame.step >= step).min_by_key(|frame| frame.step)?;
    Some(between(before, after, step))
}

fn between(before: &Frame, after: &Frame, step: u64) -> f64 {
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

    /// 1000 in the first 100 steps, 7 a step in the next 200, then 50 a step.
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
        // Whole numbers below 2^53, divided once.
        close(outflow_rate(&history()), 7.0, 0.0);
    }

    #[test]
    fn what_lies_between_frames_is_interpolated() {
        let mut history = history();
        // Without the frame at 300: between 2330 at 290 and 2900 at 310 lies 2615; 215 more than there were.
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
