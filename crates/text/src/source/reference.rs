//! Values and units of scene keys, quoted from a page of reference for the help of an error.
//!
//! The page is [`Source::reference`](super::Source::reference). Its tables have the columns key or choice, value, unit, default, meaning. The value of a section is
//! a link to the heading of its table. A row of a choice, such as `Cylinder(...)`, is followed by rows of its keys, whose names stand after a dash.

const GRAINS: &str = "scenes-of-grains";
const LATTICE_GAS: &str = "scenes-of-the-lattice-gas";

/// Most forms of a value that help shows.
const MOST_FORMS: usize = 6;

/// A row of a table.
#[derive(Clone, Copy)]
struct Row<'a> {
    /// The first cell of the choice that a key belongs to; nothing for a key of all choices.
    choice: &'a str,
    /// The first cell of a key; nothing in the row of a choice.
    key: &'a str,
    value: &'a str,
    unit: &'a str,
    default: &'a str,
    meaning: &'a str,
}

impl<'a> Row<'a> {
    /// The anchor of the table of the value.
    fn link(&self) -> Option<&'a str> {
        self.value.split_once("](#").and_then(|(_, rest)| rest.split(')').next())
    }

    /// The value as a form has it: its unit, or else its type.
    fn short(&self) -> &'a str {
        match (self.unit, self.link()) {
            ("", Some(_)) => "...",
            ("", None) => self.value,
            (unit, _) => unit,
        }
    }
}

/// Returns whether a first cell has this name, such as `` `Disc(...)` (also `Sphere(...)`) ``.
fn names(cell: &str, name: &str) -> bool {
    cell.split('`').skip(1).step_by(2).any(|span| span.trim_end_matches("(...)") == name)
}

/// Returns the anchor of a heading, as code hosts derive it.
fn anchor(heading: &str) -> String {
    let kept = heading.trim().to_lowercase().replace(' ', "-");
    kept.chars().filter(|c| c.is_alphanumeric() || matches!(c, '-' | '_')).collect()
}

/// Returns the rows of the tables below the heading with this anchor.
fn rows<'a>(reference: &'a str, wanted: &str) -> Vec<Row<'a>> {
    let is_wanted = |line: &&str| line.starts_with('#') && anchor(line.trim_start_matches('#')) == wanted;
    let section =
        reference.lines().skip_while(|line| !is_wanted(line)).skip(1).take_while(|line| !line.starts_with('#'));
    let mut choice = "";
    let rows = section.filter_map(|line| {
        let cells: Vec<_> = line.strip_prefix('|')?.strip_suffix('|')?.split(" |").map(str::trim).collect();
        let [first, value, unit, default, meaning] = cells[..] else { return None };
        let inner = first.strip_prefix("– ");
        let is_choice = inner.is_none() && (first.contains("(...)") || default.is_empty());
        if inner.is_none() {
            choice = if is_choice && first.contains('`') { first } else { "" };
        }
        let key = if is_choice { "" } else { inner.unwrap_or(first) };
        Some(Row { choice, key, value, unit, default, meaning })
    });
    rows.collect()
}

/// Returns a text without the addresses of links.
fn plain(text: &str) -> String {
    let mut text = text.to_owned();
    while let Some(middle) = text.find("](")
        && let (Some(start), Some(length)) = (text[..middle].rfind('['), text[middle..].find(')'))
    {
        text.replace_range(middle..=middle + length, "");
        text.remove(start);
    }
    text
}

/// Returns the forms of a section: of each choice, or of its needed keys.
fn forms(rows: &[Row]) -> Vec<String> {
    let keys = |choice: &str| {
        let needed = rows.iter().filter(|row| row.choice == choice && row.default == "*needed*");
        let keys: Vec<_> = needed.map(|row| format!("{}: {}", row.key.trim_matches('`'), row.short())).collect();
        keys.join(", ")
    };
    let choices: Vec<_> = rows.iter().filter(|row| row.key.is_empty() && !row.choice.is_empty()).collect();
    if choices.is_empty() {
        return vec![format!("`({})`", keys(""))];
    }
    let form = |row: &&Row| {
        let name = row.choice.split('`').nth(1).unwrap_or_default();
        let inside = if row.value.is_empty() { keys(row.choice) } else { row.short().to_owned() };
        format!("`{}`", name.replace("...", &inside))
    };
    choices.iter().map(form).collect()
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

/// Returns the rows of the keys of this name in a section.
fn find<'a>(reference: &'a str, field: &str, Section { here, text, scene }: Section) -> Option<Row<'a>> {
    let kind = text.split('(').next().unwrap_or_default().trim();
    let mut tables = vec![rows(reference, if scene.contains("LatticeGas(") { LATTICE_GAS } else { GRAINS })];
    for part in here.split('.').filter_map(|part| part.split('[').next()).filter(|part| !part.is_empty()) {
        let links = tables.iter().flatten().filter(|row| names(row.key, part)).filter_map(Row::link);
        tables = links.map(|link| rows(reference, link)).collect();
    }
    // The only value of a choice may have keys, which stand in the brackets of the choice.
    let links =
        tables.iter().flatten().filter(|row| names(row.choice, kind) && row.key.is_empty()).filter_map(Row::link);
    let inner: Vec<_> = links.map(|link| rows(reference, link)).collect();
    let is_here = |row: &&Row| names(row.key, field) && (row.choice.is_empty() || names(row.choice, kind));
    tables.iter().chain(&inner).flatten().find(is_here).copied()
}

/// Returns help for the missing key `field` of a section, from a page of reference.
pub(super) fn help(reference: &str, field: &str, section: Section) -> String {
    let Some(row) = find(reference, field, section) else { return format!("add `{field}: ...` here") };
    let value = match row.link() {
        Some(link) => {
            let forms = forms(&rows(reference, link));
            let more = if forms.len() > MOST_FORMS { ", ..." } else { "" };
            format!("{}{more}", forms[..forms.len().min(MOST_FORMS)].join(", "))
        }
        None if row.unit.is_empty() => plain(row.value),
        None => format!("{}, {}", plain(row.value), row.unit),
    };
    let meaning = row.meaning.split(". ").next().unwrap_or_default().trim_end_matches('.');
    format!("add `{field}: ...` here; its value: {value} ({})", plain(meaning))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_help_has_values_units_and_forms_of_the_reference() {
        let page = include_str!("../../../../docs/reference/scene-file.md");
        let of = |here, field, text| help(page, field, Section { here, text, scene: "" });
        let gravity = "add `gravity: ...` here; its value: vector, m/s² (Acceleration of gravity (x, y), in solid space (x, y, z))";
        assert_eq!(of("", "gravity", ""), gravity);
        assert_eq!(
            of("spawner", "count", "(point"),
            "add `count: ...` here; its value: whole number (Number of grains)"
        );
        let rate = "add `rate: ...` here; its value: `Grains(1/s)`, `Mass(kg/s)` (Amount per time)";
        assert_eq!(of("feed[0]", "rate", "(region"), rate);
        assert!(
            of("feed[0]", "region", "()").contains("value: `Box(low: m, high: m)`, `Disc(centre: m, radius: m)` (")
        );
        assert!(of("cull", "below", "()").contains("number, m ("));
        assert!(
            of("rest", "energy", "(speed: 1.0)")
                .ends_with("(Threshold of the kinetic energy per grain, in units of m g R)")
        );
        assert!(of("walls[3]", "radius", "Cylinder(from").contains("number > 0, m ("));
        assert!(of("walls[3]", "normal", "Annulus(centre").contains("vector (Direction of the axis"));
        assert!(of("contact.tangential", "friction", "Mindlin(").contains("number ≥ 0 (Coefficient"));
        assert!(of("", "contact", "").contains("`Assignment(k: N/m, b: N s/m)`, `Linear(k: N/m, damping: ...)`"));
        let lattice = |here, text| Section { here, text, scene: "method: LatticeGas(" };
        assert!(help(page, "per_site", lattice("fill", "()")).contains("number > 0 ("));
        assert!(help(page, "spacing", lattice("method", "LatticeGas(p: 0.1)")).contains("number > 0, m ("));
        assert_eq!(of("behaviours.wall", "speed", "()"), "add `speed: ...` here");
    }

    #[test]
    fn addresses_of_links_are_left_out() {
        assert_eq!(plain("a [list](#lists) `[m, ...]` of [b](c.md) ones"), "a list `[m, ...]` of b ones");
    }
}
