//! Suggestions for misspelt names: the likeliest of the known ones, by the similarity of Jaro and Winkler.

/// The name of the list that is most like a misspelt one, if any is like it.
#[must_use]
pub fn closest<'a>(found: &str, names: &[&'a str]) -> Option<&'a str> {
    // A name that is longer than all keys is like none of them.
    let longest = 2 * names.iter().map(|name| name.len()).max()?;
    if found.len() > longest {
        return None;
    }
    let likeness = |name: &str| strsim::jaro_winkler(&found.to_lowercase(), &name.to_lowercase());
    let best = names.iter().map(|name| (likeness(name), *name)).max_by(|a, b| a.0.total_cmp(&b.0))?;
    (best.0 > 0.85).then_some(best.1)
}

/// The help for a misspelt name: the closest one, or else all.
#[must_use]
pub fn did_you_mean(what: &str, found: &str, names: &[&str]) -> String {
    closest(found, names)
        .map_or_else(|| format!("the {what} here are: {}", names.join(", ")), |name| format!("did you mean `{name}`?"))
}
