//! Tables of a run as they are in its CSV files, to be opened by the reader.

use std::fmt::Write as _;

use crate::report::html::{escape, rounded, scrolled};
use siloflow_files::table::Table;

/// Most rows of a table that are shown: those of the latest times.
const MOST_ROWS: usize = 200;

/// Returns the last rows of a table, folded; nothing without rows. The caption is plain text.
#[must_use]
pub fn details(table: Option<&Table>, caption: &str) -> String {
    let Some(table) = table else { return String::new() };
    let first = table.len().saturating_sub(MOST_ROWS);
    let shown = match first {
        0 => caption.to_owned(),
        _ => format!("{caption}: the last {MOST_ROWS} of {} rows", table.len()),
    };
    let mut html = format!("<table>\n<caption>{}</caption>\n<thead>\n<tr>", escape(&shown));
    let columns: Vec<_> = table.names().filter_map(|name| Some((name, table.texts(name)?))).collect();
    for (name, _) in &columns {
        let _ = write!(html, "<th scope=\"col\" class=\"figure\">{}</th>", escape(name));
    }
    html += "</tr>\n</thead>\n<tbody>\n";
    for row in first..table.len() {
        html += "<tr>";
        for (_, texts) in &columns {
            let _ = match texts[row].parse::<f64>() {
                Ok(value) => write!(html, "<td class=\"figure\" title=\"{value}\">{}</td>", rounded(value)),
                Err(_) => write!(html, "<td>{}</td>", escape(texts[row])),
            };
        }
        html += "</tr>\n";
    }
    let table = scrolled(&shown, &(html + "</tbody>\n</table>\n"));
    format!("<details>\n<summary>{}</summary>\n{table}</details>\n", escape(&shown))
}
