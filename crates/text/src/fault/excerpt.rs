//! The lines around a place of a text, as an error message shows them.
//!
//! An excerpt holds at most three lines. A line longer than [`WIDTH`] characters is cut to a window of that width around the
//! place, because the renderer cannot mark columns beyond 65,535, and a terminal is narrower still.

use std::ops::Range;

use miette::{MietteError, MietteSpanContents, SourceCode, SourceSpan, SpanContents};

use crate::safe::for_terminal;

/// Most characters of a line.
const WIDTH: usize = 300;

/// Part of a text around a place.
#[derive(Clone, Debug)]
pub(super) struct Excerpt {
    name: String,
    text: String,
    /// Number of the first line, from 0.
    first_line: usize,
    /// Line and column of the place in the whole text, both from 0. Columns count characters.
    pub(super) line: usize,
    pub(super) column: usize,
    /// The place in `text`. It ends with its first line.
    pub(super) place: Range<usize>,
}

impl Excerpt {
    /// Takes the lines around the byte range `place` of `text`, the content of the file `name`.
    pub(super) fn new(name: &str, text: &str, place: Range<usize>) -> Self {
        let start = text.floor_char_boundary(place.start.min(text.len()));
        let line_start = text[..start].rfind('\n').map_or(0, |newline| newline + 1);
        let line = text[..line_start].bytes().filter(|&byte| byte == b'\n').count();
        let column = text[line_start..start].chars().count();
        let this_line = text[line_start..].split('\n').next().unwrap_or_default();
        let end = text.floor_char_boundary(place.end.clamp(start, line_start + this_line.len()));
        // All lines are cut alike, so that columns stay in line.
        let from = if this_line.chars().count() > WIDTH { column.saturating_sub(WIDTH / 2) } else { 0 };
        let mut excerpt = Self {
            name: for_terminal(name).into_owned(),
            text: String::new(),
            first_line: line,
            line,
            column,
            place: 0..0,
        };
        if line_start > 0 {
            let before = &text[..line_start - 1];
            let before = &before[before.rfind('\n').map_or(0, |newline| newline + 1)..];
            excerpt.text = window(before, from) + "\n";
            excerpt.first_line -= 1;
        }
        let marked = window_parts(this_line, from, [start - line_start, end - line_start]);
        let lengths = marked.each_ref().map(String::len);
        let at = excerpt.text.len() + lengths[0];
        excerpt.place = at..at + lengths[1];
        excerpt.text.extend(marked);
        if let Some(after) = text[line_start + this_line.len()..].strip_prefix('\n') {
            excerpt.text.push('\n');
            excerpt.text += &window(after.split('\n').next().unwrap_or_default(), from);
        }
        excerpt
    }
}

impl Excerpt {
    /// The name of the file.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// The number of characters of the place.
    pub(super) fn width(&self) -> usize {
        self.text[self.place.clone()].chars().count()
    }
}

/// Returns a line from character `from` on, cut to the width, with its control characters escaped.
fn window(line: &str, from: usize) -> String {
    window_parts(line, from, [line.len(); 2]).concat()
}

/// Returns the three parts of a window: before, at and after the byte offsets `marks` of the line.
fn window_parts(line: &str, from: usize, marks: [usize; 2]) -> [String; 3] {
    let byte = |character: usize| line.char_indices().nth(character).map_or(line.len(), |(byte, _)| byte);
    let cut = byte(from)..byte(from + WIDTH);
    let [start, end] = marks.map(|mark| mark.clamp(cut.start, cut.end));
    let ellipsis = |is_cut: bool| if is_cut { "…" } else { "" };
    let line_end = line.strip_suffix('\r').map_or(line.len(), str::len);
    let part =
        |range: Range<usize>| for_terminal(&line[range.start.min(line_end)..range.end.min(line_end)]).into_owned();
    [
        ellipsis(cut.start > 0).to_owned() + &part(cut.start..start),
        part(start..end),
        part(end..cut.end) + ellipsis(cut.end < line.len()),
    ]
}

impl SourceCode for Excerpt {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        lines_before: usize,
        _lines_after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let (range, line, column) = if lines_before == 0 {
            (span.offset()..span.offset() + span.len(), self.line, self.column)
        } else {
            (0..self.text.len(), self.first_line, 0)
        };
        let data = self.text.as_bytes().get(range.clone()).ok_or(MietteError::OutOfBounds)?;
        let lines = self.text[range.clone()].matches('\n').count();
        let span = SourceSpan::from(range);
        Ok(Box::new(MietteSpanContents::new_named(self.name.clone(), data, span, line, column, lines)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn marked(text: &str, place: Range<usize>) -> (usize, usize, String, String) {
        let excerpt = Excerpt::new("a.ron", text, place);
        (excerpt.line, excerpt.column, excerpt.text[excerpt.place.clone()].to_owned(), excerpt.text)
    }

    #[test]
    fn short_lines_are_shown_whole() {
        let (line, column, place, text) = marked("é\nab: 3,\nlast\nnot shown", 7..8);
        assert_eq!((line, column, place.as_str(), text.as_str()), (1, 4, "3", "é\nab: 3,\nlast"));
        assert_eq!(marked("", 5..9), (0, 0, String::new(), String::new()));
    }

    #[test]
    fn long_lines_are_cut_around_the_place() {
        let line = "é".repeat(70_000) + "HERE" + &"x".repeat(70_000);
        let (number, column, place, text) = marked(&line, 140_000..140_004);
        assert_eq!((number, column, place.as_str()), (0, 70_000, "HERE"));
        assert_eq!(text.chars().count(), WIDTH + 2);
        // A long place is cut, and so are the lines beside it.
        let (_, _, place, text) = marked(&format!("{line}\n{line}"), line.len() + 1..2 * line.len() + 1);
        assert_eq!((place.chars().count(), text.lines().count()), (WIDTH, 2));
    }

    #[test]
    fn control_characters_are_shown_as_escapes() {
        let (_, _, place, text) = marked("a\u{1b}[2Jb\r\nc", 1..2);
        assert_eq!((place.as_str(), text.as_str()), ("\\u{1b}", "a\\u{1b}[2Jb\nc"));
    }
}
