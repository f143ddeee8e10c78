//! Values and units of scene keys, quoted from a page of reference for the help of an error.
//!
//! The page is [`Source::reference`](super::Source::reference). Its tables have a row for each key: its name in backticks, or nothing in a row of another form of the
//! key before it, then its values and units. A form of a section is a code span such as `(below: m)` or `Panel(corner: m, ...)`.

const GRAINS: [&str; 2] = ["## Scenes of grains", "\n### "];
const LATTICE_GAS: [&str; 2] = ["## Scenes of the lattice gas", "\n## "];

/// Returns the cells of all rows of the page with their keys, for a scene with this text.
fn rows<'a>(reference: &'a str, scene: &str) -> impl Iterator<Item = (&'a str, &'a str)> {
    let [start, end] = if scene.contains("LatticeGas(") { LATTICE_GAS } else { GRAINS };
    let section = reference.split_once(start).map_or("", |(_, rest)| rest.split_once(end).map_or(rest, |(it, _)| it));
    let mut last = "";
    section.lines().filter_map(move |line| {
        let mut cells = line.strip_prefix('|')?.split(" | ").map(str::trim);
        let keys = cells.next()?;
        let values = cells.next()?;
        last = if keys.is_empty() { last } else { keys };
        Some((last, values))
    })
}

/// Returns whether a cell of keys names this one.
fn names(keys: &str, key: &str) -> bool {
    keys.split(", ").any(|one| one.trim_matches('`') == key)
}

/// Returns the code spans of a cell.
fn spans(values: &str) -> impl Iterator<Item = &str> {
    values.split('`').skip(1).step_by(2)
}

/// Returns a cell without marks of emphasis and links, and without the word that the key is needed.
fn plain(values: &str) -> String {
    let mut text = values.replace("*needed*: ", "").replace("*needed*; ", "").replace("; *needed*", "");
    while let Some(middle) = text.find("](")
        && let (Some(start), Some(length)) = (text[..middle].rfind('['), text[middle..].find(')'))
    {
        text.replace_range(middle..=middle + length, "");
        text.remove(start);
    }
    text
}

/// A section of a scene that misses a key.
#[derive(Clone, Copy)]
pub(super) struct Section<'a> {
    /// Key path of the section.
    pub here: &'a str,
    /// Text of the section.
    pub text: &'a str,
    /// Text of the whole scene.
    pub scene: &'a str,
}

/// Returns help for the missing key `field` of a section, from a page of reference.
pub(super) fn help(reference: &str, field: &str, Section { here, text, scene }: Section) -> String {
    let generic = here.split('[').map(|part| part.split_once(']').map_or(part, |(_, rest)| rest)).collect::<Vec<_>>();
    let key = if here.is_empty() { field.to_owned() } else { format!("{}.{field}", generic.join("[i]")) };
    let exact = rows(reference, scene).find(|(keys, _)| names(keys, &key)).map(|(_, values)| plain(values));
    if let Some(values) = exact.filter(|values| !values.contains("following") && values != "*needed*") {
        return format!("add `{field}: ...` here; its value: {values}");
    }
    let parent = generic.concat();
    let kind = text.split('(').next().unwrap_or_default().trim();
    let has_field = |span: &&str| span.contains(&format!("{field}:")) || span.contains(&format!(", {field},"));
    let form = rows(reference, scene)
        .filter(|(keys, _)| names(keys, &parent))
        .flat_map(|(_, values)| spans(values))
        .find(|span| span.split('(').next() == Some(kind) && has_field(span));
    match form {
        Some(form) => format!("add `{field}: ...` here, as in `{form}`"),
        None => format!("add `{field}: ...` here"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_help_has_units_and_forms_of_the_reference() {
        let page = include_str!("../../../../docs/reference/scene-file.md");
        let of = |here, field, text| help(page, field, Section { here, text, scene: "" });
        assert_eq!(of("", "gravity", ""), "add `gravity: ...` here; its value: m/s²");
        assert_eq!(of("spawner", "count", "(point"), "add `count: ...` here; its value: grains");
        assert_eq!(of("feed[0]", "rate", "(region"), "add `rate: ...` here; its value: `Grains(1/s)`, `Mass(kg/s)`");
        assert_eq!(of("cull", "below", "()"), "add `below: ...` here, as in `(below: m)`");
        assert!(
            of("rest", "energy", "(speed: 1.0)")
                .ends_with("here, as in `(speed: in √(gR), energy: in m g R a grain, hold: s, stop: false)`")
        );
        assert!(of("walls[3]", "radius", "Cylinder(from").contains("as in `Cylinder(from: m, to: m, radius: m, "));
        assert!(of("walls[3]", "normal", "Annulus(centre").contains("as in `Annulus(centre: m, normal: direction, "));
        let lattice = Section { here: "fill", text: "()", scene: "method: LatticeGas(" };
        assert!(help(page, "per_site", lattice).contains("as in `(per_site: 6.0)`"));
        assert_eq!(of("behaviours.wall", "speed", "()"), "add `speed: ...` here");
    }

    #[test]
    fn links_and_marks_are_left_out() {
        assert_eq!(plain("*needed*; a [list](#lists) `[m, ...]` of [b](c.md) ones"), "a list `[m, ...]` of b ones");
    }
}
