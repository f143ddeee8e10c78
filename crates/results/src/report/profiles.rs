//! Tables of profiles and fields, folded. Figures of them are among the curves and maps.

use crate::report::html::Section;
use crate::report::run::Run;
use crate::report::table;

const TABLES: [(&str, &str); 5] = [
    ("profiles.csv", "Profiles in bins"),
    ("slopes.csv", "Slopes of the free surface"),
    ("centres.csv", "Centres of mass by species"),
    ("fields.csv", "Fields on grids"),
    ("flow.csv", "Field of mean velocity"),
];

/// The section of profiles and fields, which begins with `figures`; nothing if no run has any.
#[must_use]
pub fn section_of(runs: &[Run], figures: String) -> Option<Section> {
    let mut content = figures;
    for run in runs {
        let name = if runs.len() > 1 { format!("{}: ", run.label()) } else { String::new() };
        for (file, title) in TABLES {
            content += &table::details(run.table(file).as_ref(), &format!("{name}{title} ({file})"));
        }
    }
    Section::of("profiles", "Profiles and fields", content)
}
