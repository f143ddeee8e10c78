//! `siloflow report` and `run --report`: what the page holds, that it asks no server for anything, that text of scenes stays text, and
//! what is refused.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::command_line::{siloflow, text};
use crate::run_directory::content;

/// Runs the program, which must succeed, and returns what it prints.
fn done(here: &Path, arguments: &[&str]) -> String {
    let output = siloflow(here, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
    text(&output.stdout)
}

/// Runs a shipped scene with settings into `out`.
fn run(here: &Path, out: &str, scene: &str, settings: &[&str]) {
    let set: Vec<_> = settings.iter().flat_map(|setting| ["--set", setting]).collect();
    let scene = crate::scene(scene).display().to_string();
    done(here, &[&["run", &scene, "--quiet", "--force", "--out", out], &set[..]].concat());
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// An element with its attributes, or the end of one.
#[derive(Debug, PartialEq)]
struct Tag {
    name: String,
    attributes: Vec<(String, String)>,
}

/// Returns all tags of a page in order. Fails if elements are not closed in order, or an attribute is not in double quotes.
fn tags(page: &str) -> Vec<Tag> {
    const VOID: [&str; 5] = ["meta", "input", "br", "!DOCTYPE", "hr"];
    let mut rest = page;
    let mut open = Vec::<String>::new();
    let mut tags = Vec::new();
    while let Some(start) = rest.find('<') {
        rest = &rest[start + 1..];
        if let Some(comment) = rest.strip_prefix("!--") {
            rest = &comment[comment.find("-->").unwrap()..];
            continue;
        }
        let end = rest.find(|c: char| c.is_whitespace() || c == '>' || (c == '/' && !rest.starts_with('/'))).unwrap();
        let name = if let Some(closed) = rest.strip_prefix('/') {
            let name = &closed[..closed.find('>').unwrap()];
            assert_eq!(open.pop().as_deref(), Some(name), "{}", &rest[..rest.len().min(200)]);
            rest = &closed[name.len() + 1..];
            tags.push(Tag { name: format!("/{name}"), attributes: Vec::new() });
            continue;
        } else {
            rest[..end].to_owned()
        };
        rest = &rest[end..];
        let mut attributes = Vec::new();
        loop {
            rest = rest.trim_start();
            if let Some(after) = rest.strip_prefix("/>") {
                rest = after;
                break;
            }
            if let Some(after) = rest.strip_prefix('>') {
                rest = after;
                if !VOID.contains(&&*name) {
                    open.push(name.clone());
                }
                break;
            }
            let length = rest.find(|c: char| c.is_whitespace() || c == '=' || c == '>').unwrap();
            let key = rest[..length].to_owned();
            rest = &rest[length..];
            let mut value = String::new();
            if let Some(quoted) = rest.strip_prefix('=') {
                let quoted = quoted.strip_prefix('"').unwrap_or_else(|| panic!("{key} of {name} has no double quotes"));
                let length = quoted.find('"').unwrap();
                quoted[..length].clone_into(&mut value);
                rest = &quoted[length + 1..];
            }
            attributes.push((key, value));
        }
        if ["script", "style"].contains(&&*name) {
            // The content of these elements is no markup.
            rest = &rest[rest.find(&format!("</{name}>")).unwrap()..];
        }
        tags.push(Tag { name, attributes });
    }
    assert!(open.is_empty(), "not closed: {open:?}");
    tags
}

/// Asserts that a page opens without a network, and that a reader can find their way.
fn assert_sound(page: &str) {
    let tags = tags(page);
    let of = |name: &str| tags.iter().filter(|tag| tag.name == name).collect::<Vec<_>>();
    for Tag { name, attributes } in &tags {
        for (key, value) in attributes {
            let is_inside = match &**key {
                "href" | "xlink:href" => value.starts_with('#'),
                "src" | "srcset" | "action" | "poster" | "data" | "ping" => value.starts_with("data:"),
                "xmlns" | "xmlns:xlink" => true,
                _ => !value.contains("://"),
            };
            assert!(is_inside, "{name} has {key}=\"{value}\"");
            assert!(!key.starts_with("on"), "{name} has {key}");
        }
    }
    for name in ["link", "iframe", "object", "embed", "base", "form"] {
        assert!(of(name).is_empty(), "{name}");
    }
    // Styles load nothing.
    let style = &page[page.find("<style>").unwrap()..page.find("</style>").unwrap()];
    assert!(!style.contains("url(") && !style.contains("@import"), "{style}");
    let policy = of("meta")
        .into_iter()
        .flat_map(|tag| &tag.attributes)
        .find(|(key, value)| key == "content" && value.starts_with("default-src 'none'; script-src 'sha256-"));
    assert!(policy.is_some(), "no policy");
    // One script runs; the others are data.
    let is_data = |tag: &&&Tag| tag.attributes.iter().any(|(key, _)| key == "type");
    assert_eq!(of("script").iter().filter(|tag| !is_data(tag)).count(), 1);
    for (name, count) in [("main", 1), ("nav", 1), ("header", 1), ("h1", 1), ("title", 1)] {
        assert_eq!(of(name).len(), count, "{name}");
    }
    assert_eq!(of("caption").len(), of("table").len());
    let is_scoped = |tag: &&Tag| tag.attributes.iter().any(|(key, _)| key == "scope");
    assert!(of("th").iter().all(is_scoped));
    // Links lead to sections, and ids are there once.
    let mut ids: Vec<_> = tags.iter().flat_map(|tag| &tag.attributes).filter(|(key, _)| key == "id").collect();
    let count = ids.len();
    ids.sort();
    ids.dedup();
    assert_eq!(ids.len(), count, "an id is there twice");
    for (_, link) in of("a").into_iter().flat_map(|tag| &tag.attributes).filter(|(key, _)| key == "href") {
        assert!(ids.iter().any(|(_, id)| format!("#{id}") == *link), "{link}");
    }
    // No heading leaves out a level.
    let levels = tags.iter().filter_map(|tag| tag.name.strip_prefix('h')?.parse::<i32>().ok());
    levels.fold(0, |above, level| {
        assert!(level <= above + 1, "h{level} below h{above}");
        level
    });
}

/// The cells of the row with this name in all tables, without markup.
fn row(page: &str, name: &str) -> Vec<String> {
    let start = page.find(&format!("<th scope=\"row\">{name}</th>")).unwrap_or_else(|| panic!("no row {name}"));
    let row = &page[start..start + page[start..].find("</tr>").unwrap()];
    row.split("<td").skip(1).map(|cell| plain(&cell[cell.find('>').unwrap() + 1..])).collect()
}

/// Text without markup.
fn plain(html: &str) -> String {
    html.split('<')
        .enumerate()
        .map(|(n, part)| if n == 0 { part } else { &part[part.find('>').unwrap() + 1..] })
        .collect()
}

/// A scene of the plane with a wall of a name: three grains fall onto a floor.
fn scene(title: &str, wall: &str) -> String {
    format!(
        "(title: {title:?}, gravity: (0.0, -9.81), contact: Linear(k: 1.0e4, damping: Restitution(0.5)), mass: ArealSquare(100.0),
        step: Fixed(1.0e-4), walls: [Segment(from: (-1.0, 0.0), to: (1.0, 0.0), name: {wall:?})],
        fill: [(low: (-0.1, 0.1), high: (0.1, 0.17), spacing: 0.07, radius: Fixed(0.03))],
        until: 0.3, pictures: None, data_frames: (interval: 0.1))"
    )
}

#[test]
fn a_run_writes_its_report_as_one_file_that_asks_for_nothing() {
    let here = tempfile::tempdir().unwrap();
    let silo = crate::scene("silo1.ron").display().to_string();
    let arguments = ["run", &silo, "--set", "spawner.count=12", "--until", "1.5", "--out", "a", "--report"];
    let said = done(here.path(), &arguments);
    assert_eq!(said.lines().last().unwrap().split_whitespace().collect::<Vec<_>>(), ["report", "a/report.html"]);
    let page = read(&here.path().join("a/report.html"));
    assert_sound(&page);
    assert!(page.contains("<h1><bdi>silo1: uniform grains</bdi></h1>"), "the title");
    let summary: Value = serde_json::from_str(&read(&here.path().join("a/summary.json"))).unwrap();
    // Numbers are rounded, with all digits in the element, and once more in the data.
    for pointer in ["/time_s", "/max_overlap_ratio", "/energy/dissipated", "/performance/wall_s"] {
        let number = summary.pointer(pointer).unwrap().as_f64().unwrap();
        assert!(page.contains(&format!("<data value=\"{number}\" title=\"{number}")), "{pointer}");
    }
    assert_eq!(row(&page, "Grains released"), ["12 grains"]);
    assert_eq!(row(&page, "Step"), ["0.001 s"]);
    assert_eq!(row(&page, "Seed"), ["2009"]);
    assert_eq!(row(&page, "Hash of the state at the end"), [summary["state_hash"].as_str().unwrap()]);
    assert!(row(&page, "Command")[0].starts_with("siloflow run "), "{:?}", row(&page, "Command"));
    let data = page.split("id=\"summaries\">").nth(1).unwrap().split("</script>").next().unwrap();
    let data: Value = serde_json::from_str(data).unwrap();
    assert_eq!(data["silo1"], summary);
    // The frames are played.
    assert!(page.contains("data-frames=\"frames-1\"") && page.contains("id=\"frames-1\""));
    // JSON stays alone, and a run that is replaced takes its report along.
    let json = done(here.path(), &[&arguments[..], &["--force", "--json", "--quiet"]].concat());
    assert!(serde_json::from_str::<Value>(&json).is_ok() && here.path().join("a/report.html").exists());
    done(here.path(), &[&arguments[..8], &["--force", "--quiet"]].concat());
    assert!(!here.path().join("a/report.html").exists());
}

#[test]
fn a_failed_run_and_one_without_frames_have_a_report() {
    let here = tempfile::tempdir().unwrap();
    let silo = crate::scene("silo1-literal.ron").display().to_string();
    let settings = ["--set", "spawner.count=3", "--set", "pictures=None", "--until", "20"];
    let output = siloflow(here.path(), &[&["run", &silo, "--out", "a", "--report"], &settings[..]].concat());
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
    let page = read(&here.path().join("a/report.html"));
    assert_sound(&page);
    assert!(page.contains("No success.") && page.contains("through the wall"), "the failure");
    assert!(page.contains("data_frames: (interval: 0.1)") && !page.contains("data-frames="), "the key of frames");
}

#[test]
fn hostile_text_stays_text() {
    let here = tempfile::tempdir().unwrap();
    let hostile = "</script><script>alert(1)</script><img src=x onerror=alert(1)>\"'&amp;\u{1b}[2J\u{202e}";
    let pages = [("calm", "calm"), ("<b onclick=\"x\">'&", hostile)].map(|(out, title)| {
        fs::write(here.path().join("a.ron"), scene(title, "floor")).unwrap();
        done(here.path(), &["run", "a.ron", "--out", out, "--quiet"]);
        // Names that a scene may not have, in files that another program may have changed.
        let groups = here.path().join(out).join("wall_groups.csv");
        let quoted = format!("\"{}\"", title.replace('"', "\"\""));
        fs::write(&groups, read(&groups).replace("floor", &quoted)).unwrap();
        let summary = here.path().join(out).join("summary.json");
        let mut value: Value = serde_json::from_str(&read(&summary)).unwrap();
        for key in ["scene", "status", "state_hash"] {
            value[key] = Value::from(title);
        }
        value["provenance"]["command"] = Value::from(title);
        // The times of the two runs differ, and a page writes large and small numbers with powers of ten.
        for key in ["wall_s", "particle_steps_per_s", "peak_memory_bytes"] {
            assert!(value["performance"][key].as_f64().is_some(), "{value}");
            value["performance"][key] = Value::from(1.0);
        }
        value["behaviours"] = serde_json::json!({ title: { title: { "value": 1.0, "unit": title, "label": title } } });
        fs::write(&summary, value.to_string()).unwrap();
        done(here.path(), &["report", out, "--out", &format!("{}.html", title.len())]);
        read(&here.path().join(format!("{}.html", title.len())))
    });
    for page in &pages {
        assert_sound(page);
        assert!(!page.contains("onerror=alert(1)>") && !page.contains('\u{1b}') && !page.contains('\u{202e}'));
    }
    // The same elements, whatever the text.
    let names = |page: &str| tags(page).into_iter().map(|tag| tag.name).collect::<Vec<_>>();
    assert_eq!(names(&pages[0]), names(&pages[1]));
    assert!(pages[1].contains("&lt;/script&gt;&lt;script&gt;alert(1)&lt;/script&gt;&lt;img src=x"), "the title");
}

#[test]
fn walls_have_their_own_names_beside_discs() {
    let here = tempfile::tempdir().unwrap();
    let scene = r#"(gravity: (0.0, -9.81), contact: Linear(k: 1.0e4, damping: Restitution(0.5)), mass: Disc(100.0), step: Fixed(1.0e-4),
        walls: [Disc(centre: (0.5, 0.5), radius: 0.1), Segment(from: (-1.0, 0.0), to: (1.0, 0.0), name: "floor")],
        spawner: (point: (0.0, 0.1), velocity: (0.0, 0.0), interval: 1.0, count: 1, radius: Fixed(0.05)), until: 0.1)"#;
    fs::write(here.path().join("floor.ron"), scene).unwrap();
    done(here.path(), &["run", "floor.ron", "--quiet", "--out", "run", "--report"]);
    // Discs have no number in walls.csv.
    assert!(read(&here.path().join("run/report.html")).contains("1 <bdi>floor</bdi>"));
}

#[test]
fn several_runs_are_compared() {
    let here = tempfile::tempdir().unwrap();
    run(here.path(), "a/silo", "silo1.ron", &["spawner.count=12", "until=1.0"]);
    run(
        here.path(),
        "b/silo",
        "silo1-mixture.ron",
        &["spawner.count=6", "until=1.0", "pictures=None", "data_frames=None"],
    );
    run(here.path(), "gas", "funnel-flow.ron", &["until=5"]);
    let said = done(here.path(), &["report", "a/silo", "b/silo"]);
    assert_eq!(said, "out/report.html\n");
    let page = read(&here.path().join("out/report.html"));
    assert_sound(&page);
    assert_eq!(row(&page, "Grains released"), ["12 grains", "6 grains", "0.5"]);
    assert_eq!(row(&page, "<code>spawner.radius</code>"), ["Fixed(0.04)", "Mixture([(0.04, 0.5), (0.03, 0.5)])"]);
    assert_eq!(row(&page, "<code>spawner.count</code>"), ["12", "6"]);
    assert!(!page.contains("<th scope=\"row\"><code>seed</code></th>"), "equal keys are not listed");
    assert!(page.contains("id=\"frames-1\"") && !page.contains("id=\"frames-2\""), "one of them has frames");
    // Runs of the same scene are told apart.
    run(here.path(), "c", "silo1.ron", &["spawner.count=6", "until=1.0"]);
    done(here.path(), &["report", "a/silo", "c", "--out", "same.html"]);
    assert_eq!(row(&read(&here.path().join("same.html")), "Scene"), ["silo1", "silo1", ""]);
    // Runs of both methods.
    done(here.path(), &["report", "a/silo", "gas", "--out", "mixed.html"]);
    let page = read(&here.path().join("mixed.html"));
    assert_sound(&page);
    assert_eq!(row(&page, "Grains released"), ["12 grains", "none", ""]);
    assert_eq!(row(&page, "Steps"), ["1,000 steps", "5 steps", "0.005"]);
    assert!(page.contains("id=\"frames-2\""), "its pictures are played");
    run(here.path(), "unseen", "funnel-flow.ron", &["until=5", "pictures=None"]);
    done(here.path(), &["report", "unseen"]);
    assert!(read(&here.path().join("unseen/report.html")).contains("The lattice gas keeps no frames to play"));
}

#[test]
fn a_run_of_the_lattice_gas_has_a_report() {
    let here = tempfile::tempdir().unwrap();
    run(here.path(), "gas", "funnel-flow.ron", &["until=20"]);
    done(here.path(), &["report", "gas"]);
    let page = read(&here.path().join("gas/report.html"));
    assert_sound(&page);
    let summary: Value = serde_json::from_str(&read(&here.path().join("gas/summary.json"))).unwrap();
    let entered = summary["particles"]["entered"].as_f64().unwrap();
    assert!(page.contains(&format!("<data value=\"{entered}\" title=\"{entered} particles\">")));
    assert_eq!(row(&page, "Hash of the state at the end"), [summary["state_hash"].as_str().unwrap()]);
}

#[test]
fn a_killed_run_is_reported_as_far_as_its_files_go() {
    let here = tempfile::tempdir().unwrap();
    run(here.path(), "a", "silo1.ron", &["spawner.count=12", "until=1.0"]);
    let directory = here.path().join("a");
    fs::remove_file(directory.join("summary.json")).unwrap();
    let series = read(&directory.join("series.csv"));
    // Six whole rows, and one that was being written: the last is of 0.25 s, when five grains were released.
    let lines: Vec<_> = series.lines().take(7).collect();
    fs::write(directory.join("series.csv"), lines.join("\n") + "\n0.300000000,7,7").unwrap();
    done(here.path(), &["report", "a"]);
    let page = read(&directory.join("report.html"));
    assert_sound(&page);
    assert!(page.contains("There is no summary"), "the status");
    let last: Vec<_> = lines[6].split(',').collect();
    assert_eq!(last[0], "0.25");
    assert_eq!(row(&page, "Grains released"), [format!("{} grains", last[1])]);
    // Nothing but the scene and the header of the series.
    fs::write(directory.join("series.csv"), format!("{}\n", lines[0])).unwrap();
    fs::remove_file(directory.join("frames.bin")).unwrap();
    fs::write(directory.join("summary.json"), "{\"status\": \"emp").unwrap();
    let output = siloflow(here.path(), &["report", "a", "--force"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("summary.json is not JSON"), "{}", text(&output.stderr));
    fs::remove_file(directory.join("summary.json")).unwrap();
    done(here.path(), &["report", "a", "--force"]);
    assert_sound(&read(&directory.join("report.html")));
    // A scene that cannot be read leaves a gap.
    fs::write(directory.join("scene.ron"), "(gravity: ").unwrap();
    done(here.path(), &["report", "a", "--force"]);
    assert!(read(&directory.join("report.html")).contains("cannot be examined"));
}

#[test]
fn what_cannot_be_reported_is_refused_with_a_remedy() {
    let here = tempfile::tempdir().unwrap();
    fs::write(here.path().join("a.ron"), scene("a", "floor")).unwrap();
    done(here.path(), &["run", "a.ron", "--out", "run", "--quiet"]);
    let assert_refused = |arguments: &[&str], words: &[&str]| {
        let before = content(here.path());
        let output = siloflow(here.path(), &[&["report"], arguments].concat());
        let said = text(&output.stderr).split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ");
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(words.iter().all(|word| said.contains(word)), "{words:?}: {said}");
        assert_eq!(content(here.path()), before, "{arguments:?}");
    };
    assert_refused(&[], &["RUN"]);
    assert_refused(&["nowhere"], &["there is no run directory nowhere", "siloflow run"]);
    assert_refused(&["run", "nowhere"], &["there is no run directory nowhere"]);
    assert_refused(&["."], &["no run directory", "series.csv"]);
    assert_refused(&["run/scene.ron"], &["is not a directory"]);
    assert_refused(&["run", "run/../run"], &["given twice"]);
    assert_refused(&["run", "--pages", "2"], &["--pages"]);
    assert_refused(&["run", "--out", "a/b/c.html"], &["could not write", "--out"]);
    assert_refused(&["run", "--out", "run"], &["run is a directory"]);
    assert_refused(&["run", "--out", "run", "--force"], &["run is a directory"]);
    assert_refused(&["run", "--out", "run/series.csv"], &["run/series.csv exists", "--force"]);
    assert_refused(&["run", "--out", "run/series.csv", "--force"], &["no report of siloflow"]);
    done(here.path(), &["report", "run"]);
    assert_refused(&["run"], &["report.html exists", "--force"]);
    let first = read(&here.path().join("run/report.html"));
    fs::write(here.path().join("run/report.html"), first.replace("<h1>", "<h1>old ")).unwrap();
    done(here.path(), &["report", "run", "--force"]);
    assert_eq!(read(&here.path().join("run/report.html")), first, "the same run has the same report");
}
