//! Transcripts in pages, compared with what the commands of the page print.
//!
//! A `text` block after an `sh` block shows what its commands print, on both streams. A line `...` stands for any lines that are left out; so it leaves
//! out times of a machine too. Several `text` blocks may follow.
//!
//! With `SILOFLOW_RENEW_PAGES` set, pages are rewritten in place of a comparison. A transcript keeps its lines: each is replaced by the next line of the
//! output that differs from it in digits alone.

/// A line without its numbers.
fn skeleton(line: &str) -> String {
    let mut text = String::new();
    let mut is_number = false;
    for c in line.chars() {
        let continues = c.is_ascii_digit() || (is_number && matches!(c, '.' | 'e' | '-'));
        if continues && !is_number {
            text.push('#');
        } else if !continues {
            text.push(c);
        }
        is_number = continues;
    }
    // Columns move with the lengths of numbers.
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Finds the lines of a transcript in the output, with `same` as equality. Returns for each line the line of the output, `None` for `...`; or the first
/// line that is not found.
fn aligned<'a>(
    shown: &'a str,
    output: &'a str,
    same: impl Fn(&str, &str) -> bool,
) -> Result<Vec<Option<&'a str>>, &'a str> {
    let output: Vec<&str> = output.lines().collect();
    let mut at = 0;
    let mut found = Vec::new();
    let mut is_free = false;
    let mut lines = shown.lines().peekable();
    while let Some(line) = lines.next() {
        if line.trim() == "..." {
            is_free = true;
            found.push(None);
            continue;
        }
        // After `...` a line may stand anywhere below, as long as the lines up to the next `...` follow it.
        let rest: Vec<&str> = lines.clone().take_while(|next| next.trim() != "...").collect();
        let fits = |start: usize| {
            let here = std::iter::once(line).chain(rest.iter().copied());
            here.enumerate()
                .all(|(n, line)| output.get(start + n).is_some_and(|own| same(own.trim_end(), line.trim_end())))
        };
        let place =
            if is_free { (at..output.len()).find(|&start| fits(start)) } else { Some(at).filter(|&at| fits(at)) };
        let Some(place) = place else {
            let wrong = std::iter::once(line).chain(rest).enumerate();
            let mut wrong =
                wrong.filter(|(n, line)| output.get(at + n).is_none_or(|own| !same(own.trim_end(), line.trim_end())));
            return Err(wrong.next().map_or(line, |(_, line)| line));
        };
        found.push(Some(output[place]));
        at = place + 1;
        is_free = false;
    }
    if !is_free && output[at..].iter().any(|line| !line.trim().is_empty()) {
        return Err("(the output goes on: add `...`)");
    }
    Ok(found)
}

/// Compares a transcript with the output.
pub fn compare(shown: &str, output: &str) -> Result<(), String> {
    aligned(shown, output, |own, line| own == line)
        .map(drop)
        .map_err(|line| format!("the page shows\n  {line}\nand the commands print\n{output}"))
}

/// Returns the transcript with the numbers of the output. Lines before and after it that the page leaves out get a `...`.
pub fn renewed(shown: &str, output: &str) -> Result<String, String> {
    let free = "...\n";
    let same = |own: &str, line: &str| skeleton(own) == skeleton(line);
    for shown in [shown.to_owned(), format!("{shown}{free}"), format!("{free}{shown}"), format!("{free}{shown}{free}")]
    {
        if let Ok(lines) = aligned(&shown, output, same) {
            return Ok(lines.into_iter().map(|line| line.map_or("...", str::trim_end).to_owned() + "\n").collect());
        }
    }
    let line = aligned(shown, output, same).err().unwrap_or_default();
    Err(format!("no line like\n  {line}\nis in\n{output}"))
}

/// Leaves lines about progress out: they depend on the speed of the machine.
pub fn without_progress(output: &str) -> String {
    let is_progress = |line: &str| line.contains(" s to go") || line.contains(" runs are over");
    output.lines().filter(|line| !is_progress(line)).map(|line| line.to_owned() + "\n").collect()
}

#[test]
fn transcripts_are_compared_line_by_line() {
    let output = "a 1.5 s\nb\nc 3\nd\n";
    for right in ["a 1.5 s\nb\nc 3\nd\n", "...\nc 3\nd\n", "a 1.5 s\n...\n", "a 1.5 s\n...\nd\n", "...\nb\n...\n"] {
        assert_eq!(compare(right, output), Ok(()), "{right}");
    }
    for wrong in ["a 1.6 s\n...\n", "b\n...\n", "a 1.5 s\n", "...\nc 3\n", "...\nd\n...\nb\n"] {
        assert!(compare(wrong, output).is_err(), "{wrong}");
    }
    assert_eq!(renewed("a  0.1 s\n...\nc 17\n...\n", output).unwrap(), "a 1.5 s\n...\nc 3\n...\n");
    assert_eq!(renewed("c 17\n", output).unwrap(), "...\nc 3\n...\n");
    assert!(renewed("e 1\n...\n", output).is_err());
}

#[test]
fn lines_of_progress_are_left_out() {
    let of_diff = "step 3903, t = 0.20 of at most 1: the same so far | at most 4 s to go\n";
    let of_run = "t = 0.20 s of at most 1 s | 1.2 M particle-steps/s | at most 4 s to go | inside 3, out 0\n";
    assert_eq!(without_progress(&format!("{of_diff}first out\n{of_run}")), "first out\n");
}
