//! Text from scenes, files and file names, made safe for messages and pictures.
//!
//! | place | rule |
//! |---|---|
//! | terminal | control characters and characters that change the direction of writing are written as `\u{1b}` |
//! | message | a quotation is cut at [`LONGEST_QUOTATION`] characters, a message at [`LONGEST_MESSAGE`] |
//! | SVG | markup is escaped; characters that XML forbids are replaced by U+FFFD |

use std::borrow::Cow;

/// Most characters of a quotation in a message, and of a title in a picture.
pub const LONGEST_QUOTATION: usize = 200;

/// Most characters of a message.
pub const LONGEST_MESSAGE: usize = 4000;

/// Whether a terminal would act on the character instead of showing it. A line break and a tab are no harm.
fn acts_on_a_terminal(c: char) -> bool {
    let changes_direction =
        matches!(c, '\u{61c}' | '\u{200e}'..='\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    changes_direction || (c.is_control() && !matches!(c, '\n' | '\t'))
}

/// Returns the text with characters escaped on which a terminal would act.
#[must_use]
pub fn for_terminal(text: &str) -> Cow<'_, str> {
    if !text.contains(acts_on_a_terminal) {
        return Cow::Borrowed(text);
    }
    let escaped = text.chars().fold(String::with_capacity(text.len() + 16), |mut escaped, c| {
        if acts_on_a_terminal(c) {
            escaped.extend(c.escape_unicode());
        } else {
            escaped.push(c);
        }
        escaped
    });
    Cow::Owned(escaped)
}

/// Returns the first `longest` characters of a text, and an ellipsis if that is not all.
#[must_use]
pub fn cut(text: &str, longest: usize) -> Cow<'_, str> {
    match text.char_indices().nth(longest) {
        None => Cow::Borrowed(text),
        Some((end, _)) => Cow::Owned(format!("{}…", &text[..end])),
    }
}

/// Returns a message with its quotations (between backticks) cut, and with escapes for the terminal.
#[must_use]
pub fn message(text: &str) -> String {
    let part = |(number, part): (usize, &str)| match number % 2 {
        0 => part.to_owned(),
        _ => cut(part, LONGEST_QUOTATION).into_owned(),
    };
    let quotations_cut = text.split('`').enumerate().map(part).collect::<Vec<_>>().join("`");
    for_terminal(&cut(&quotations_cut, LONGEST_MESSAGE)).into_owned()
}

/// Returns the text as character data of XML.
#[must_use]
pub fn for_xml(text: &str) -> String {
    // The characters that XML 1.0 allows (section 2.2).
    let is_allowed =
        |c: char| matches!(c, '\t' | '\n' | '\r' | ' '..='\u{d7ff}' | '\u{e000}'..='\u{fffd}' | '\u{10000}'..);
    text.chars().fold(String::with_capacity(text.len()), |mut escaped, c| {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            c if is_allowed(c) => escaped.push(c),
            _ => escaped.push('\u{fffd}'),
        }
        escaped
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terminals_get_no_commands() {
        assert_eq!(
            for_terminal("a\u{1b}[2J\u{7f}\u{9b}\u{202e}b\n\tc é"),
            "a\\u{1b}[2J\\u{7f}\\u{9b}\\u{202e}b\n\tc é"
        );
        assert!(matches!(for_terminal("plain"), Cow::Borrowed("plain")));
    }

    #[test]
    fn quotations_and_messages_are_cut() {
        let long = "é".repeat(1000);
        assert_eq!(message(&format!("got `{long}`, not 1")), format!("got `{}…`, not 1", "é".repeat(200)));
        assert_eq!(message(&format!("got `{}`", "é".repeat(200))), format!("got `{}`", "é".repeat(200)));
        assert_eq!(message(&"x".repeat(100_000)).chars().count(), LONGEST_MESSAGE + 1);
    }

    #[test]
    fn xml_gets_neither_markup_nor_forbidden_characters() {
        assert_eq!(
            for_xml("a ]]> <b> & \"c\" \u{1b}\u{ffff}\u{0}é"),
            "a ]]&gt; &lt;b&gt; &amp; &quot;c&quot; \u{fffd}\u{fffd}\u{fffd}é"
        );
    }
}
