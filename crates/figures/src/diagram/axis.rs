//! Axes of plots: range, linear or logarithmic scale, ticks and their labels.

use std::borrow::Cow;

/// An axis of a panel.
#[derive(Clone, Debug)]
pub struct Axis {
    /// Quantity and unit.
    pub label: Cow<'static, str>,
    /// Value at the lower or left end.
    pub from: f64,
    /// Value at the upper or right end.
    pub to: f64,
    /// Whether the axis is logarithmic. Both ends must be positive then.
    pub is_log: bool,
    /// Values of the ticks.
    pub ticks: Vec<f64>,
}

impl Axis {
    /// Returns a linear axis with about five ticks, at whole multiples of 1, 2 or 5 times a power of ten.
    #[must_use]
    pub fn linear(label: impl Into<Cow<'static, str>>, from: f64, to: f64) -> Self {
        let step = round_step(to - from);
        let first = (from / step - 1e-9).ceil();
        let ticks = (0..12u8).map(|n| (first + f64::from(n)) * step).take_while(|&tick| tick <= to + 1e-9 * step);
        Self { label: label.into(), from, to, is_log: false, ticks: ticks.collect() }
    }

    /// Returns a linear axis around the finite numbers of `values`, from tick to tick. Zero is on it unless it would take
    /// more than half of the axis.
    #[must_use]
    pub fn around(label: impl Into<Cow<'static, str>>, values: impl IntoIterator<Item = f64>) -> Self {
        let finite = values.into_iter().filter(|value| value.is_finite());
        let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (v.min(low), v.max(high)));
        let (mut low, mut high) = if low <= high { (low, high) } else { (0.0, 1.0) };
        // As far from zero as the range is wide, zero would take half of the axis.
        if low > 0.0 && low <= high - low {
            low = 0.0;
        } else if high < 0.0 && -high <= high - low {
            high = 0.0;
        }
        // A constant, up to the digits of a table.
        let least = (1e-9 * low.abs().max(high.abs())).max(f64::MIN_POSITIVE);
        if high - low <= least {
            let reach = if low == 0.0 { 1.0 } else { 0.5 * low.abs() };
            (low, high) = (low - reach, high + reach);
        }
        let step = round_step(high - low);
        // Beyond the last tick a curve may reach by a fiftieth of a step.
        Self::linear(label, (low / step + 0.02).floor() * step, (high / step - 0.02).ceil() * step)
    }

    /// Returns a linear axis that reaches beyond its ends by a share of its length, with the same ticks, so that points at the ends are whole.
    #[must_use]
    pub fn with_margins(self, share: f64) -> Self {
        let margin = share * (self.to - self.from);
        Self { from: self.from - margin, to: self.to + margin, ..self }
    }

    /// Returns a logarithmic axis around the positive finite numbers of `values`.
    ///
    /// It extends a factor 2 beyond them and has ticks at powers of ten. An axis of less than three decades also has
    /// ticks at 2 and 5 times powers of ten.
    #[must_use]
    pub fn logarithmic(label: impl Into<Cow<'static, str>>, values: impl IntoIterator<Item = f64>) -> Self {
        let (low, high) = values
            .into_iter()
            .filter(|&value| value > 0.0 && value.is_finite())
            .fold((f64::INFINITY, 0.0), |(low, high), value| (value.min(low), value.max(high)));
        let (from, to) = if low <= high { (low / 2.0, high * 2.0) } else { (0.1, 10.0) };
        #[expect(clippy::cast_possible_truncation, reason = "the exponent of a double")]
        let decades = || from.log10().floor() as i32..=to.log10().ceil() as i32;
        let multiples: &[f64] = if to / from < 1e3 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let ticks = decades().flat_map(|n| multiples.iter().map(move |m| m * 10f64.powi(n)));
        let ticks = ticks.filter(|&tick| (from..=to).contains(&tick)).collect();
        Self { label: label.into(), from, to, is_log: true, ticks }
    }

    /// Returns the position of `value` along the axis, 0 at its lower end and 1 at its upper end.
    pub(super) fn fraction(&self, value: f64) -> f64 {
        if self.is_log {
            (value / self.from).ln() / (self.to / self.from).ln()
        } else {
            (value - self.from) / (self.to - self.from)
        }
    }

    /// Returns the label of a tick, without digits that come from binary rounding.
    pub(super) fn tick_label(&self, value: f64) -> String {
        let largest = self.from.abs().max(self.to.abs());
        let is_scientific =
            if self.is_log { !(0.01..1e4).contains(&value) } else { value != 0.0 && !(1e-2..1e5).contains(&largest) };
        if is_scientific {
            // Digits down to a hundredth of the largest number.
            let mantissa = value / 10f64.powf(value.abs().log10().floor());
            let digits = if (mantissa - mantissa.round()).abs() < 1e-6 { 0 } else { 2 };
            let text = format!("{value:.digits$e}");
            let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
            let mantissa = if digits > 0 { mantissa.trim_end_matches('0') } else { mantissa };
            format!("{mantissa}e{exponent}")
        } else {
            // A multiple of the largest number below this is zero.
            let rounded = (value * 1e9).round() / 1e9;
            format!("{}", rounded + 0.0)
        }
    }
}

/// Returns 1, 2 or 5 times a power of ten that divides `range` into at most five parts.
fn round_step(range: f64) -> f64 {
    let rough = (range / 5.0).max(f64::MIN_POSITIVE);
    let power = 10f64.powf(rough.log10().floor());
    [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|&step| step >= rough).unwrap_or(rough)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ticks(axis: &Axis) -> Vec<String> {
        axis.ticks.iter().map(|&tick| axis.tick_label(tick)).collect()
    }

    #[test]
    fn ticks_are_round_and_within_the_axis() {
        assert_eq!(ticks(&Axis::linear("", 0.0, 1.0)), ["0", "0.2", "0.4", "0.6", "0.8", "1"]);
        assert_eq!(ticks(&Axis::linear("", 0.0, 2.37)), ["0", "0.5", "1", "1.5", "2"]);
        assert_eq!(ticks(&Axis::logarithmic("", [1.0, 10.0])), ["0.5", "1", "2", "5", "10", "20"]);
        assert_eq!(ticks(&Axis::logarithmic("", [1e-6, 1.0])), ["1e-6", "1e-5", "1e-4", "1e-3", "0.01", "0.1", "1"]);
        assert_eq!(ticks(&Axis::logarithmic("", [])), ["0.1", "0.2", "0.5", "1", "2", "5", "10"]);
    }

    #[test]
    fn small_and_large_numbers_have_exponents() {
        assert_eq!(ticks(&Axis::around("", [0.0, 2.5e-12])), ["0", "5e-13", "1e-12", "1.5e-12", "2e-12", "2.5e-12"]);
        assert_eq!(ticks(&Axis::around("", [-3e6, 0.0])), ["-3e6", "-2e6", "-1e6", "0"]);
    }

    #[test]
    fn an_axis_around_values_ends_at_ticks_and_has_zero_if_that_is_near() {
        assert_eq!(ticks(&Axis::around("", [0.3, 0.9])), ["0", "0.2", "0.4", "0.6", "0.8", "1"]);
        assert_eq!(ticks(&Axis::around("", [300.0, 310.0])), ["300", "302", "304", "306", "308", "310"]);
        assert_eq!(ticks(&Axis::around("", [4.0])), ["2", "3", "4", "5", "6"]);
        assert_eq!(ticks(&Axis::around("", [f64::NAN])), ["0", "0.2", "0.4", "0.6", "0.8", "1"]);
        assert_eq!(ticks(&Axis::around("", [0.0, 0.0])), ["-1", "-0.5", "0", "0.5", "1"]);
    }
}
