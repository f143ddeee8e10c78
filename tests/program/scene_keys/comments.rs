//! Documentation comments in parts: unit, default, and the rest.
//!
//! A comment names the unit after a comma in its first sentence (`Radius, m.`), and a default in a sentence that begins with that word (`Default 0.`).

const UNITS: [&str; 14] = ["m", "s", "kg", "N", "rad", "Pa", "Hz", "px", "J", "minutes", "steps", "1", "or", "and"];

/// A documentation comment in parts.
pub struct Parts {
    pub text: String,
    pub unit: String,
    pub default: Option<String>,
}

/// Returns whether these are units, such as `kg m^2` or `m/s or rad/s`.
fn is_unit(words: &str) -> bool {
    let is_known = |part: &str| UNITS.contains(&part.split('^').next().unwrap().trim_matches(['(', ')']));
    !words.is_empty() && words.split([' ', '/']).all(is_known)
}

/// Returns a comment without the addresses of links, with powers, and with bars that end no cell.
pub fn plain(doc: &str) -> String {
    let mut text = doc.replace("^2", "²").replace("^3", "³").replace('|', "\\|");
    while let Some(middle) = text.find("](") {
        let end = middle + text[middle..].find(')').unwrap();
        text.replace_range(middle..=end, "");
        text.remove(text[..middle].rfind('[').unwrap());
    }
    text.replace("[`", "`").replace("`]", "`")
}

/// Separates the unit and the default from the rest.
pub fn parts(doc: &str) -> Parts {
    let (defaults, mut sentences): (Vec<_>, Vec<_>) =
        doc.split_inclusive(". ").map(|sentence| sentence.trim().to_owned()).partition(|it| it.starts_with("Default"));
    let mut unit = String::new();
    if let Some(first) = sentences.first_mut() {
        let starts: Vec<_> = first.match_indices([',', ';']).map(|(at, _)| at).collect();
        let segment = |&start: &usize| {
            let length = first[start + 1..].find([',', ';', ':', '.'])?;
            is_unit(first[start + 1..start + 1 + length].trim()).then_some(start..start + 1 + length)
        };
        if let Some(range) = starts.iter().find_map(segment) {
            unit = plain(first[range.start + 1..range.end].trim());
            first.replace_range(range, "");
        }
    }
    let default = defaults.first().map(|it| it["Default".len()..].trim_start_matches(':').trim_end_matches('.').trim());
    Parts { text: plain(&sentences.join(" ")), unit, default: default.map(plain) }
}

/// Returns whether code names every number and every `word` of a default.
pub fn agrees(default: &str, code: &str) -> bool {
    let numbers: Vec<f64> =
        code.split(|c: char| !c.is_ascii_digit() && c != '.').filter_map(|it| it.parse().ok()).collect();
    let has_number = |word: &str| word.parse().map_or(true, |number| numbers.contains(&number));
    let names = default.split('`').skip(1).step_by(2);
    default.split([' ', ',', '(', ')']).all(has_number) && names.into_iter().all(|name| code.contains(name))
}

#[test]
fn comments_have_parts() {
    let Parts { text, unit, default } =
        parts("Rate of [it](a::b), m/s or rad/s, at the start. Default: 0. It is |kept|.");
    assert_eq!(
        (&*text, &*unit, default.as_deref()),
        ("Rate of it, at the start. It is \\|kept\\|.", "m/s or rad/s", Some("0"))
    );
    assert_eq!(parts("Mass, if there is one; kg^2 m.").unit, "kg² m");
    assert_eq!(parts("Number of grains, all of them.").unit, "");
    assert!(agrees("10", "NonNegative::try_from(10.0)") && agrees("`Front`", "Direction::Front"));
    assert!(!agrees("10", "try_from(1.0)") && !agrees("`Front`", "Direction::Back"));
}
