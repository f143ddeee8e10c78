//! The page of an estimate: the answer, the figure of value against softness, the rungs and the runs.

use std::fmt::Write as _;

use crate::report::document::Page;
use crate::report::html::{Section, escape};
use crate::report::table::details;
use siloflow_files::table::Table;

/// A part of the answer in words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    /// Name of the part, such as `value`.
    pub name: &'static str,
    /// The part.
    pub words: String,
}

/// Content of the page.
#[derive(Clone, Copy, Debug)]
pub struct EstimatePage<'a> {
    /// The figure and the scene, in words.
    pub title: &'a str,
    /// The answer in words.
    pub lines: &'a [Line],
    /// Why the answer is not as good as asked for.
    pub refused: Option<&'a str>,
    /// The value against softness, and the error against cost: SVG of siloflow.
    pub drawings: &'a str,
    /// `rungs.csv`.
    pub rungs: Option<&'a Table>,
    /// `runs.csv`.
    pub runs: Option<&'a Table>,
}

impl EstimatePage<'_> {
    /// Returns the page as HTML.
    #[must_use]
    pub fn html(&self) -> String {
        let mut answer = "<table>\n<tbody>\n".to_owned();
        for Line { name, words } in self.lines {
            let _ = writeln!(answer, "<tr><th scope=\"row\">{}</th><td>{}</td></tr>", escape(name), escape(words));
        }
        answer += "</tbody>\n</table>\n";
        if let Some(why) = self.refused {
            answer = format!("<p class=\"fate\"><strong>Refused</strong>: {}</p>\n{answer}", escape(why));
        }
        let figure = format!("<figure class=\"plot\">\n<div class=\"panels\">{}</div>\n</figure>\n", self.drawings);
        let tables = details(self.rungs, "Stiffnesses: rungs.csv") + &details(self.runs, "Runs: runs.csv");
        let sections: Vec<_> = [
            Section::of("answer", "Answer", answer),
            Section::of("softness", "Value against softness, and error against cost", figure),
            Section::of("runs", "Runs", tables),
        ]
        .into_iter()
        .flatten()
        .collect();
        Page { kind: "Estimate", title: self.title, sections: &sections, data: "", script: "" }.html()
    }
}
