//! The zero of a function of one variable.

/// A place, and the value of a function there.
#[derive(Clone, Copy)]
pub(super) struct Value {
    pub place: f64,
    pub value: f64,
}

/// Returns where a function has a zero, between a place where it is negative and a higher one where it is positive, to rounding: by the
/// Illinois form of the rule of false position.
pub(super) fn zero_between(value: impl Fn(f64) -> f64, mut low: Value, mut high: Value) -> f64 {
    let mut last_side = 0.0;
    // Some ten steps are enough; halving alone would need 53.
    for _ in 0..80 {
        let place = (low.place * high.value - high.place * low.value) / (high.value - low.value);
        if place <= low.place || place >= high.place {
            break;
        }
        let found = value(place);
        if found == 0.0 {
            return place;
        }
        if found < 0.0 {
            low = Value { place, value: found };
            high.value *= if last_side < 0.0 { 0.5 } else { 1.0 };
        } else {
            high = Value { place, value: found };
            low.value *= if last_side > 0.0 { 0.5 } else { 1.0 };
        }
        last_side = found;
    }
    if -low.value < high.value { low.place } else { high.place }
}
