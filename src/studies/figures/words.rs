//! The name of a figure on the axis of a picture: words with a unit, `discharge: rate, 1/s` for `discharge.rate_per_s`.

/// Endings of names in `summary.json`, and their units. Longer endings come first.
const UNITS: [(&str, &str); 11] = [
    ("_kg_per_s", "kg/s"),
    ("_m_per_s", "m/s"),
    ("_per_s", "1/s"),
    ("_n_per_m", "N/m"),
    ("_deg", "degrees"),
    ("_kg", "kg"),
    ("_pa", "Pa"),
    ("_s", "s"),
    ("_m", "m"),
    ("_n", "N"),
    ("_j", "J"),
];

/// Returns a figure in words. Figures of tables and probabilities are written in words already.
#[must_use]
pub fn words(figure: &str) -> String {
    if figure.contains([':', ' ']) {
        return figure.to_owned();
    }
    let mut unit = None;
    let spoken: Vec<_> = figure
        .split('.')
        .map(|part| {
            let found = UNITS.iter().find_map(|(ending, unit)| Some((part.strip_suffix(ending)?, *unit)));
            unit = found.map(|(_, unit)| unit).or(unit);
            found.map_or(part, |(name, _)| name).replace('_', " ")
        })
        .collect();
    let spoken = spoken.join(": ");
    unit.map_or_else(|| spoken.clone(), |unit| format!("{spoken}, {unit}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_the_summary_become_words_with_a_unit_and_others_stay() {
        assert_eq!(words("discharge.rate_per_s"), "discharge: rate, 1/s");
        assert_eq!(words("discharge.rate_kg_per_s"), "discharge: rate, kg/s");
        assert_eq!(words("rest_time_s"), "rest time, s");
        assert_eq!(words("outflow.rate_per_s.mean"), "outflow: rate: mean, 1/s");
        assert_eq!(words("grains.inside"), "grains: inside");
        assert_eq!(words("share of clogged"), "share of clogged");
        assert_eq!(words("bands.csv: sides, pressure_pa, 0 s to 1 s"), "bands.csv: sides, pressure_pa, 0 s to 1 s");
    }
}
