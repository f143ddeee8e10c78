//! Checks of the names that behaviours register.

use std::collections::{HashMap, HashSet};

use bevy_ecs::prelude::*;

use crate::measure::outputs::{BehaviourOutputs, Quantity};

/// Longest name of a column, value or file, and longest unit and label, in bytes.
const LONGEST: usize = 64;

/// Names that the outputs have already.
pub(crate) struct Reserved<'a> {
    /// Columns of grains.
    pub grains: Vec<&'a str>,
    /// Columns of the series.
    pub series: Vec<&'a str>,
    /// Whether the run directory has or may get a file of this name.
    pub is_file: fn(&str) -> bool,
}

/// Finds the first name that is not allowed or taken. Returns the behaviour that registers it, and the problem in words.
pub(crate) fn refuse(world: &World, reserved: &Reserved) -> Result<(), (String, String)> {
    let Some(outputs) = world.get_resource::<BehaviourOutputs>() else { return Ok(()) };
    if let Some(problem) = outputs.problems.first() {
        return Err(problem.clone());
    }
    let of_grains = outputs.grain_columns.iter().map(|column| &column.quantity);
    let of_series = outputs.series_columns.iter().map(|column| &column.quantity);
    columns("column of grains", of_grains, &reserved.grains)?;
    columns("column of series.csv", of_series, &reserved.series)?;
    let mut taken = HashSet::new();
    for quantity in outputs.values.iter().map(|value| &value.quantity) {
        legal("value of the summary", quantity)?;
        // Values of different behaviours are apart.
        if !taken.insert((&quantity.behaviour, &quantity.name)) {
            return Err((
                quantity.behaviour.clone(),
                format!("the summary value `{}` is registered twice", quantity.name),
            ));
        }
    }
    files(&outputs.files, reserved.is_file)
}

fn columns<'a>(
    kind: &str,
    quantities: impl Iterator<Item = &'a Quantity>,
    reserved: &[&str],
) -> Result<(), (String, String)> {
    let mut taken: HashMap<&str, &str> = HashMap::new();
    for quantity in quantities {
        let Quantity { behaviour, name, .. } = quantity;
        legal(kind, quantity)?;
        let problem = if reserved.contains(&name.as_str()) {
            format!("the {kind} `{name}` is one of siloflow's own")
        } else {
            match taken.insert(name, behaviour) {
                Some(first) if first == behaviour => format!("the {kind} `{name}` is registered twice"),
                Some(first) => format!("the {kind} `{name}` is registered by the behaviour `{first}` too"),
                None => continue,
            }
        };
        return Err((behaviour.clone(), problem));
    }
    Ok(())
}

fn legal(kind: &str, quantity: &Quantity) -> Result<(), (String, String)> {
    let Quantity { behaviour, name, unit, label } = quantity;
    let is_letter = |byte: u8| byte.is_ascii_lowercase() || byte.is_ascii_digit() || byte == b'_';
    let is_legal = name.starts_with(|first: char| first.is_ascii_lowercase()) && name.bytes().all(is_letter);
    let problem = if !is_legal || name.len() > LONGEST {
        format!(
            "`{name}` cannot be the name of a {kind}: a name begins with a letter and has at most {LONGEST} letters from a to z, \
             digits and `_`"
        )
    } else if [unit, label].iter().any(|text| text.len() > LONGEST || text.chars().any(char::is_control)) {
        format!("unit and label of the {kind} `{name}` must be a line of at most {LONGEST} bytes")
    } else {
        return Ok(());
    };
    Err((behaviour.clone(), problem))
}

fn files(files: &[(String, String)], is_taken: fn(&str) -> bool) -> Result<(), (String, String)> {
    for (place, (behaviour, name)) in files.iter().enumerate() {
        let is_letter = |byte: u8| byte.is_ascii_lowercase() || byte.is_ascii_digit() || b"_-.".contains(&byte);
        let is_legal = name.starts_with(|first: char| first.is_ascii_alphanumeric())
            && name.bytes().all(is_letter)
            && name.len() <= LONGEST;
        let problem = if !is_legal {
            format!(
                "`{name}` cannot be the name of a file: a name begins with a letter or digit and has at most {LONGEST} letters \
                 from a to z, digits, `_`, `-` and `.`"
            )
        } else if is_taken(name) {
            format!("`{name}` is a file of siloflow")
        } else if files[..place].iter().any(|(_, other)| other == name) {
            format!("the file `{name}` is declared twice")
        } else {
            continue;
        };
        return Err((behaviour.clone(), problem));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use bevy_app::App;

    use super::*;
    use crate::measure::outputs::OutputApp as _;
    use siloflow_files::frames::scale::{Palette, Scale};

    #[derive(Component)]
    struct Heat(f64);

    fn problem(register: impl FnOnce(&mut App) -> &mut App) -> Option<(String, String)> {
        let mut app = App::empty();
        BehaviourOutputs::begin(&mut app, "first");
        app.grain_column::<Heat>("heat", "J", |heat| heat.0).series_column("heat_j", "J", || 1.0);
        app.summary_value("heat", "J", || 1.0).run_file("heat.csv");
        BehaviourOutputs::begin(&mut app, "second");
        register(&mut app);
        let reserved = Reserved { grains: vec!["mass"], series: vec!["time_s"], is_file: |name| name == "series.csv" };
        refuse(app.world(), &reserved).err()
    }

    #[test]
    fn every_wrong_name_is_found_with_its_behaviour() {
        let number = |heat: &Heat| heat.0;
        let scale = Scale { from: 0.0, to: 1.0, palette: Palette::Viridis };
        let cases: [(&str, Box<dyn FnOnce(&mut App) -> &mut App>); 16] = [
            ("`first` too", Box::new(|app| app.grain_column::<Heat>("heat", "", number))),
            ("`first` too", Box::new(|app| app.series_column("heat_j", "J", || 1.0))),
            ("registered twice", Box::new(|app| app.series_column("a", "", || 1.0).series_column("a", "", || 1.0))),
            ("registered twice", Box::new(|app| app.summary_value("a", "", || 1.0).summary_value("a", "", || 1.0))),
            ("siloflow's own", Box::new(|app| app.grain_column::<Heat>("mass", "", number))),
            ("siloflow's own", Box::new(|app| app.series_column("time_s", "", || 1.0))),
            ("cannot be the name", Box::new(|app| app.series_column("", "", || 1.0))),
            ("cannot be the name", Box::new(|app| app.series_column("Heat", "", || 1.0))),
            ("cannot be the name", Box::new(|app| app.series_column("a,b", "", || 1.0))),
            ("cannot be the name", Box::new(|app| app.series_column("1a", "", || 1.0))),
            ("cannot be the name", Box::new(|app| app.summary_value("ä", "", || 1.0))),
            ("must be a line", Box::new(|app| app.series_column("a", "a\nb", || 1.0))),
            ("is no column of grains", Box::new(move |app| app.column_scale("heat", scale))),
            ("not registered", Box::new(|app| app.column_label("heat", "heat"))),
            ("declared twice", Box::new(|app| app.run_file("heat.csv"))),
            ("is a file of siloflow", Box::new(|app| app.run_file("series.csv"))),
        ];
        for (expected, register) in cases {
            let (behaviour, text) = problem(register).expect(expected);
            assert!(behaviour == "second" && text.contains(expected), "{behaviour}: {text}");
        }
        let up = Scale { from: 1.0, to: f64::NAN, palette: Palette::BlueRed };
        let falls = problem(|app| app.grain_column::<Heat>("cold", "", number).column_scale("cold", up));
        assert!(falls.is_some_and(|(_, text)| text.contains("must go up")));
        for name in ["../a", "/a", ".siloflow", "a/b", "A.csv", ""] {
            let (_, text) = problem(|app| app.run_file(name)).expect(name);
            assert!(text.contains("cannot be the name of a file"), "{text}");
        }
        assert_eq!(problem(|app| app.summary_value("heat", "J", || 2.0).run_file("cold-2.csv")), None);
    }
}
