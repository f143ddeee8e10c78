//! Edits of a text that keep much of its structure, so that mutants reach beyond the parser.

use bolero::TypeGenerator;

/// One edit. Places are shares of the length, in 65,536ths.
#[derive(Clone, Debug, TypeGenerator)]
pub enum Edit {
    /// Removes some characters.
    Remove { at: u16, length: u8 },
    /// Inserts a word of [`WORDS`].
    Insert { at: u16, word: u8 },
    /// Repeats some characters at another place.
    Repeat { from: u16, length: u8, at: u16 },
    /// Repeats a word or a character very often.
    Flood { at: u16, word: u8, times: u16 },
    /// Replaces a number by an extreme one.
    Number { number: u8, word: u8 },
    /// Replaces a character by any other.
    Character { at: u16, character: char },
}

/// Words that appear in inputs, and words that do not.
const WORDS: [&str; 40] = [
    "(",
    ")",
    "[",
    "]",
    "{",
    "}",
    ",",
    ":",
    "\"",
    "//",
    "/*",
    "*/",
    "r#\"",
    "\n",
    "\\u{1b}",
    "é",
    "\u{202e}",
    "Some(",
    "None",
    "true",
    "Fixed(",
    "Uniform(0.1, 0.2)",
    "Mixture([])",
    "Auto(error: 1e-3)",
    "Hertz(restitution: 0.5)",
    "VerletList(skin: 0.0)",
    "Solid",
    "species: 255",
    "fixed: true",
    "periodic: (x: (0.0, 1.0))",
    "spawner",
    "LatticeGas",
    "<g>",
    "</g>",
    "&amp;",
    "href=\"/etc/passwd\"",
    "seed: 1",
    "'",
    "\r\n",
    ";",
];

/// Numbers at the ends of ranges.
const NUMBERS: [&str; 24] = [
    "0",
    "-0.0",
    "1",
    "-1",
    "0.5",
    "1e-3",
    "1e3",
    "1e-30",
    "1e30",
    "1e-300",
    "1e300",
    "5e-324",
    "1.8e308",
    "NaN",
    "inf",
    "-inf",
    "255",
    "256",
    "65536",
    "4294967295",
    "4294967296",
    "18446744073709551615",
    "1e9",
    "0.1e",
];

/// Returns the text after these edits. It has at most 200,000 characters.
pub fn edited(text: &str, edits: &[Edit]) -> String {
    let mut characters: Vec<char> = text.chars().collect();
    for edit in edits {
        apply(&mut characters, edit);
        characters.truncate(200_000);
    }
    characters.into_iter().collect()
}

fn apply(text: &mut Vec<char>, edit: &Edit) {
    let place = |share: u16, length: usize| length * usize::from(share) / 65_536;
    let word = |number: u8| WORDS[usize::from(number) % WORDS.len()];
    let length = text.len();
    let insert = |text: &mut Vec<char>, at: u16, what: Vec<char>| {
        let at = place(at, length);
        text.splice(at..at, what);
    };
    match *edit {
        Edit::Remove { at, length: count } => {
            let from = place(at, length);
            text.drain(from..length.min(from + usize::from(count % 32)));
        }
        Edit::Insert { at, word: number } => insert(text, at, word(number).chars().collect()),
        Edit::Repeat { from, length: count, at } => {
            let from = place(from, length);
            let part = text[from..length.min(from + usize::from(count))].to_vec();
            insert(text, at, part);
        }
        Edit::Flood { at, word: number, times } => {
            insert(text, at, word(number).repeat(usize::from(times % 4096)).chars().collect());
        }
        Edit::Number { number, word } => {
            if let Some(range) = number_at(text, usize::from(number)) {
                text.splice(range, NUMBERS[usize::from(word) % NUMBERS.len()].chars());
            }
        }
        Edit::Character { at, character } => {
            if let Some(place) = text.get_mut(place(at, length)) {
                *place = character;
            }
        }
    }
}

/// The range of one of the numbers in a text.
fn number_at(text: &[char], number: usize) -> Option<std::ops::Range<usize>> {
    let is_part = |c: char| c.is_ascii_digit() || ".-+eE".contains(c);
    let starts = (0..text.len()).filter(|&at| {
        text[at].is_ascii_digit() && (at == 0 || !(is_part(text[at - 1]) || text[at - 1].is_alphabetic()))
    });
    let starts: Vec<usize> = starts.collect();
    let start = *starts.get(number % starts.len().max(1))?;
    let end = (start..text.len()).find(|&at| !is_part(text[at])).unwrap_or(text.len());
    let start = if start > 0 && text[start - 1] == '-' { start - 1 } else { start };
    Some(start..end)
}
