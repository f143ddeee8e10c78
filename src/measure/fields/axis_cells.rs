//! The cells of a grid along one axis: equal widths from `low` to `high`.

/// The cells along one axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct AxisCells {
    pub low: f64,
    pub high: f64,
    pub count: u16,
    /// Whether the grid resolves the axis. An axis that it does not resolve has no place in the output.
    pub is_resolved: bool,
}

impl AxisCells {
    /// An axis that has no bounds.
    pub const WHOLE: Self = Self { low: f64::NEG_INFINITY, high: f64::INFINITY, count: 1, is_resolved: false };

    pub fn new(low: f64, high: f64, count: u16, is_resolved: bool) -> Self {
        Self { low, high, count, is_resolved }
    }

    pub fn width(&self) -> f64 {
        (self.high - self.low) / f64::from(self.count)
    }

    pub fn border(&self, number: u16) -> f64 {
        self.low + f64::from(number) * self.width()
    }

    pub fn middle(&self, number: u16) -> f64 {
        self.low + (f64::from(number) + 0.5) * self.width()
    }

    /// Returns the number of the cell of a coordinate.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the coordinate is inside")]
    pub fn number(&self, coordinate: f64) -> Option<u16> {
        if self.count == 1 {
            return (self.low <= coordinate && coordinate < self.high).then_some(0);
        }
        let number = ((coordinate - self.low) / self.width()).floor();
        // Just below `high` the quotient may round up.
        (self.low <= coordinate && coordinate < self.high).then(|| (number as u16).min(self.count - 1))
    }

    /// Returns the numbers of the cells whose middle may be from `from` to `to`.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    pub fn numbers(&self, from: f64, to: f64) -> std::ops::Range<u16> {
        let number = |x: f64| ((x - self.low) / self.width() - 0.5).clamp(-1.0, f64::from(self.count));
        (number(from).ceil().max(0.0) as u16)..(number(to).floor() + 1.0).min(f64::from(self.count)) as u16
    }
}
