//! The page of an estimate: the answer, the figure of value against softness, the rungs and the runs.

use crate::report::document::Page;
use crate::report::html::{Section, escape};
use crate::report::sheet::Sheet;
use crate::report::table::details;
use siloflow_files::table::Table;

/// Content of the page.
#[derive(Clone, Copy, Debug)]
pub struct EstimatePage<'a> {
    /// The figure and the scene, in words.
    pub title: &'a str,
    /// The answer, part by part in words.
    pub answer: &'a Sheet,
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
        let mut answer = self.answer.html("The answer in words", &[self.title.to_owned()]);
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
