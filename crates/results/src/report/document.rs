//! The page: head, landmarks, sections in order, data and script.
//!
//! The page is one file and asks no server for anything: style, script, pictures and data are inside, and a content security policy
//! forbids the rest. The policy names the script by its SHA-256, so that a script in the text of a scene would not run even if it were not
//! escaped.

use std::fmt::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use hmac_sha256::Hash;
use serde_json::{Map, Value};

use crate::plot::{self, Figure};
use crate::report::html::{Section, escape};
use crate::report::player::{self, Packed};
use crate::report::run::Run;
use crate::report::{
    accounting, behaviours, differences, discharge, energy, overview, profiles, provenance, step, walls,
};
use siloflow_text::safe::{cut, for_terminal};

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// Most characters of the title.
const LONGEST_TITLE: usize = 120;

/// Content of a report that takes long to make.
#[derive(Debug)]
pub struct Contents<'a> {
    /// The runs.
    pub runs: &'a [Run],
    /// The frames of each run, or why there are none, as HTML.
    pub frames: Vec<Result<Packed, String>>,
    /// Curves and maps of all runs.
    pub figures: Vec<Figure>,
}

impl Contents<'_> {
    /// Returns the page.
    #[must_use]
    pub fn html(&self) -> String {
        let labels: Vec<String> = self.runs.iter().map(|run| run.label().to_owned()).collect();
        let sections: Vec<Section> = [
            overview::section_of(self.runs),
            self.players(),
            overview::figures_of(self.runs, &labels),
            differences::section_of(self.runs),
            self.curves(),
            accounting::section_of(self.runs, &labels),
            discharge::section_of(self.runs, &labels),
            walls::section_of(self.runs, &self.figures_of(&OF_WALLS)),
            energy::section_of(self.runs, &labels),
            behaviours::section_of(self.runs, &labels),
            profiles::section_of(self.runs, self.figures_of(&OF_PLACES)),
            step::section_of(self.runs, &labels),
            provenance::section_of(self.runs, &labels),
        ]
        .into_iter()
        .flatten()
        .collect();
        let mut data = String::new();
        for (number, frames) in self.frames.iter().enumerate() {
            if let Ok(frames) = frames {
                data += &frames.element(&frames_id(number));
                data.push('\n');
            }
        }
        let _ = writeln!(data, "<script type=\"application/json\" id=\"summaries\">{}</script>", self.summaries());
        let script = format!("{}\n{SCRIPT}", player::SCRIPT);
        let kind = if self.runs.len() > 1 { "Comparison of runs" } else { "Report of a run" };
        Page { kind, title: &self.title(), sections: &sections, data: &data, script: &script }.html()
    }

    fn title(&self) -> String {
        let titles: Vec<_> = self.runs.iter().map(Run::title).collect();
        cut(&titles.join(" \u{2022} "), LONGEST_TITLE).into_owned()
    }

    /// Players of all runs that have frames, side by side.
    fn players(&self) -> Option<Section> {
        let mut content = "<div class=\"players\">\n".to_owned();
        for (number, (run, frames)) in self.runs.iter().zip(&self.frames).enumerate() {
            let label = escape(run.label());
            let heading = if self.runs.len() > 1 { format!("<h3><bdi>{label}</bdi></h3>\n") } else { String::new() };
            let player = match frames {
                Ok(_) => format!(
                    "<div class=\"run\">\n{heading}<div class=\"player\" role=\"group\" aria-label=\"Player of {label}\" \
                     data-frames=\"{}\"{}></div>\n</div>\n",
                    frames_id(number),
                    run.files.opening().map(|time| format!(" data-opening=\"{time}\"")).unwrap_or_default(),
                ),
                Err(why) => format!("<div class=\"run\">\n{heading}<p class=\"note\">{why}</p>\n</div>\n"),
            };
            content += &player;
        }
        content += "</div>\n";
        if self.frames.iter().any(Result::is_ok) {
            content += "<noscript><p class=\"note\">The player needs JavaScript.</p></noscript>\n";
        }
        let opened =
            self.runs.iter().zip(&self.frames).filter(|(run, frames)| frames.is_ok() && run.files.opening().is_some());
        if self.runs.len() > 1 && opened.count() == self.runs.len() {
            content = format!(
                "<p><label><input type=\"checkbox\" id=\"since-opening\" checked> show the runs at the same time since their \
                 doors opened, instead of the same simulated time</label></p>\n{content}"
            );
        }
        Section::of("motion", "Grains in motion", content)
    }

    /// Figures over time.
    fn curves(&self) -> Option<Section> {
        let figures = self.figures.iter().filter(|figure| !is_of_places(figure));
        Section::of("curves", "Curves", figures.map(Self::figure).collect())
    }

    /// Figures of these names.
    fn figures_of(&self, names: &[&str]) -> String {
        let figures = self.figures.iter().filter(|figure| names.contains(&&*figure.name));
        figures.map(Self::figure).collect()
    }

    fn figure(figure: &Figure) -> String {
        format!(
            "<figure class=\"plot\">\n<figcaption>{}</figcaption>\n<div class=\"panels\">{}</div></figure>\n",
            escape(&figure.title),
            for_terminal(&figure.drawings().collect::<String>())
        )
    }

    /// The summaries of all runs as JSON that cannot end its element.
    fn summaries(&self) -> String {
        let summary = |run: &Run| (run.label().to_owned(), run.files.summary.clone());
        let all: Map<String, Value> = self.runs.iter().map(summary).collect();
        let text = serde_json::to_string(&all).unwrap_or_default();
        text.chars().fold(String::with_capacity(text.len()), |mut json, c| {
            if c.is_ascii() && !"<>&".contains(c) {
                json.push(c);
            } else {
                // Such characters are in strings only.
                json.extend(c.encode_utf16(&mut [0; 2]).iter().map(|unit| format!("\\u{unit:04x}")));
            }
            json
        })
    }
}

fn frames_id(number: usize) -> String {
    format!("frames-{}", number + 1)
}

/// Names of figures that show places, not times. They stand in sections of their own.
const OF_WALLS: [&str; 1] = ["bands"];
const OF_PLACES: [&str; 2] = ["profiles", "fields"];

fn is_of_places(figure: &Figure) -> bool {
    OF_WALLS.contains(&&*figure.name) || OF_PLACES.contains(&&*figure.name)
}

/// A page of siloflow.
#[derive(Clone, Copy, Debug)]
pub(super) struct Page<'a> {
    /// Its kind, such as `Report of a run`.
    pub kind: &'a str,
    /// Its title, plain text.
    pub title: &'a str,
    /// Its sections.
    pub sections: &'a [Section],
    /// Elements with data for the script.
    pub data: &'a str,
    /// The script; empty for none.
    pub script: &'a str,
}

impl Page<'_> {
    /// Returns the page as HTML.
    pub(super) fn html(&self) -> String {
        let Self { kind, title, sections, data, script } = self;
        let mut page = head(title, script);
        page += "<body>\n<a class=\"skip\" href=\"#content\">Skip to the content</a>\n";
        let _ = write!(
            page,
            "<header>\n<p class=\"kind\">{kind} of siloflow</p>\n<h1><bdi>{}</bdi></h1>\n</header>\n",
            escape(title)
        );
        page += &navigation(sections);
        page += "<main id=\"content\">\n";
        for section in *sections {
            page += &section.html();
        }
        page += "</main>\n";
        page += data;
        if !script.is_empty() {
            let _ = writeln!(page, "<script>{script}</script>");
        }
        page + "</body>\n</html>\n"
    }
}

fn head(title: &str, script: &str) -> String {
    let hash = STANDARD.encode(Hash::hash(script.as_bytes()));
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'sha256-{hash}'; \
         style-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'; form-action 'none'\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<meta name=\"generator\" content=\"siloflow {}\">\n\
         <title>{} \u{2013} siloflow</title>\n<style>\n{STYLE}\n{}\n{}</style>\n</head>\n",
        env!("CARGO_PKG_VERSION"),
        escape(title),
        player::STYLE,
        plot::STYLE,
    )
}

/// Links to the sections.
fn navigation(sections: &[Section]) -> String {
    let mut html = "<nav aria-label=\"Sections\">\n<ul>\n".to_owned();
    for Section { id, heading, .. } in sections {
        let _ = writeln!(html, "<li><a href=\"#{id}\">{heading}</a></li>");
    }
    html + "</ul>\n</nav>\n"
}
