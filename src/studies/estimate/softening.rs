//! A scene with softer contacts, as changes of its keys.
//!
//! All springs have 1/s of their stiffness. The restitution of an impact stays, and a step is as long beside the duration of a contact as before:
//!
//! | key | factor |
//! |---|---|
//! | `contact.k`, `contact.tangential.k`, `contact.rolling.k`, `contact.twisting.k`, those of `pairs`, `materials[i].young` | 1/s |
//! | damping in N s/m or 1/s (`b`, `B`, `PerMass`) | 1/sqrt(s) |
//! | `step: Fixed` | sqrt(s) |
//!
//! Shares and restitutions follow by themselves, and so does `step: Auto`. An expression keeps its parameters: `"= k * 2"` becomes
//! `"= (k * 2) * 0.1"`.
//!
//! Adhesion is no spring, and no rule for it keeps all that adhesion does: a scene with `adhesion` is not softened.

use siloflow_text::source::Source;
use siloflow_text::source::places::Places;

/// A key of a scene that depends on the softness, with its value.
#[derive(Clone, Debug, PartialEq)]
struct SoftKey {
    path: String,
    value: String,
    /// The power of the softness by which the value is multiplied.
    power: f64,
}

/// The keys of a scene that make it softer.
#[derive(Clone, Debug, PartialEq)]
pub struct Softening(Vec<SoftKey>);

impl Softening {
    /// Finds the keys of a scene.
    ///
    /// # Errors
    /// The reason, in words, why contacts of this scene cannot be made softer.
    pub fn of(source: &Source) -> Result<Self, String> {
        let places = Places::scan(&source.text);
        let mut keys = Vec::new();
        for place in places.all() {
            let path = places.path(place);
            let value = source.text[place.value.clone()].trim();
            if path.ends_with(".adhesion") && value != "None" {
                return Err("adhesion has no rule for softer contacts".to_owned());
            }
            if let Some(power) = power(&path, |of| source.value_of(of).unwrap_or_default().to_owned()) {
                keys.push(SoftKey { path, value: value.to_owned(), power });
            }
        }
        let is_spring = |key: &SoftKey| key.power < -0.75;
        if keys.iter().any(is_spring) { Ok(Self(keys)) } else { Err("the scene names no stiffness".to_owned()) }
    }

    /// Returns the keys and their values at a softness. At softness 1 they are those of the scene.
    #[must_use]
    pub fn settings(&self, softness: f64) -> Vec<(String, String)> {
        self.0.iter().map(|key| (key.path.clone(), scaled(&key.value, softness, key.power))).collect()
    }
}

/// Returns the power of the softness of a key; `None` if it does not depend on it.
fn power(path: &str, value_of: impl Fn(&str) -> String) -> Option<f64> {
    if path == "step.0" {
        return value_of("step").starts_with("Fixed").then_some(0.5);
    }
    if path.starts_with("materials[") {
        return (path.rsplit('.').next() == Some("young")).then_some(-1.0);
    }
    let is_contact = path.starts_with("contact.") || (path.starts_with("pairs[") && path.contains(".contact."));
    let last = path.rsplit('.').next()?;
    match last {
        _ if !is_contact => None,
        "k" => Some(-1.0),
        "b" => Some(-0.5),
        "0" => {
            let whole = path.strip_suffix(".0")?;
            let is_rate = ["B", "PerMass"].iter().any(|name| value_of(whole).split('(').next() == Some(name));
            (whole.ends_with(".damping") && is_rate).then_some(-0.5)
        }
        _ => None,
    }
}

/// Returns a value times a power of the softness: a number, or an expression.
fn scaled(value: &str, softness: f64, power: f64) -> String {
    #[expect(clippy::float_cmp, reason = "the scene's own stiffness is exactly 1")]
    if softness == 1.0 {
        return value.to_owned();
    }
    let factor = softness.powf(power);
    if let Ok(number) = value.replace('_', "").parse::<f64>() {
        return format!("{:e}", rounded(number * factor));
    }
    let formula = ron::from_str::<String>(value).unwrap_or_default();
    let formula = formula.trim().strip_prefix('=').unwrap_or_default().trim().to_owned();
    format!("\"= ({formula}) * {:.12}\"", rounded(factor))
}

/// Twelve significant digits, so that what a table shows is what the run used.
fn rounded(number: f64) -> f64 {
    format!("{number:.11e}").parse().unwrap_or(number)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn softened(text: &str, softness: f64) -> Vec<(String, String)> {
        Softening::of(&Source::new("a.ron", "a", Path::new(""), text.to_owned())).unwrap().settings(softness)
    }

    fn pairs(list: &[(&str, &str)]) -> Vec<(String, String)> {
        list.iter().map(|(path, value)| ((*path).to_owned(), (*value).to_owned())).collect()
    }

    #[test]
    fn springs_dampers_and_the_step_follow_the_softness() {
        let text = r#"(
            contact: Linear(k: 1.0e4, damping: B(2.0), tangential: Spring(k: "= 2 * k", damping: OfNormal(0.5), friction: 0.5),
                rolling: (k: 4.0, damping: PerMass(8.0), friction: 0.1)),
            pairs: [(species: (0, 1), contact: Linear(k: 100, damping: Restitution(0.5)))],
            step: Fixed(1.0e-5), spawner: (k: 3.0), walls: [(b: 1.0)])"#;
        let expected = [
            ("contact.k", "1e2"),
            ("contact.damping.0", "2e-1"),
            ("contact.tangential.k", r#""= (2 * k) * 0.010000000000""#),
            ("contact.rolling.k", "4e-2"),
            ("contact.rolling.damping.0", "8e-1"),
            ("pairs[0].contact.k", "1e0"),
            ("step.0", "1e-4"),
        ];
        assert_eq!(softened(text, 100.0), pairs(&expected));
        assert_eq!(softened(text, 1.0)[2].1, r#""= 2 * k""#);
        let hertz =
            "(materials: [(young: 1.0e7, poisson: 0.3)], contact: Hertz(restitution: 0.5), step: Auto(error: 0.01))";
        assert_eq!(softened(hertz, 10.0), pairs(&[("materials[0].young", "1e6")]));
    }

    #[test]
    fn adhesion_is_not_softened() {
        let of = |text: &str| Softening::of(&Source::new("a.ron", "a", Path::new(""), text.to_owned())).unwrap_err();
        assert!(of("(contact: Linear(k: 1.0, damping: B(1.0), adhesion: Force(1.0)))").contains("adhesion"));
        assert!(of("(method: LatticeGas())").contains("stiffness"));
    }
}
