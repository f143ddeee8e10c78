use std::fs;
use std::path::Path;

use super::marker::MARKER;
use super::names::SERIES;
use super::*;

fn source(text: &str) -> Source {
    Source::new("scene.ron", "scene", Path::new("."), text.to_owned())
}

/// Creates, publishes and finishes a run.
fn run(path: &Path, scene: &str, replace: bool) -> Result<RunDirectory, Fault> {
    let mut directory = RunDirectory::create(path, &source(scene), replace)?;
    fs::write(directory.rows(SERIES).path, "rows").unwrap();
    fs::write(directory.frames().join("00000.svg"), scene).unwrap();
    directory.publish()?;
    directory.write_state(|file| file.write_all(b"state")).unwrap();
    directory.write_summary(&scene).unwrap();
    Ok(directory)
}

fn names(directory: &Path) -> Vec<String> {
    let entries = fs::read_dir(directory).unwrap();
    let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

const COMPLETE: [&str; 6] = [MARKER, FRAMES, SCENE, SERIES, STATE, SUMMARY];

#[test]
fn names_of_own_files() {
    for own in [
        "scene.ron",
        "state.csv.part",
        "frames",
        "frames/00012.svg",
        "frames/123456.png.part",
        "summary.json",
        "vtk/walls-00001.vtp",
        "plots/discharge.svg",
        "plots/mean_temperature_k.png",
        "vtk/grains.pvd",
        "pictures/t_012.50.png",
        "movie.png",
    ] {
        assert!(is_own(Path::new(own)), "{own}");
    }
    for other in [
        "notes.txt",
        "frames/film.mp4",
        "frames/1.svg",
        "vtk/state.pvsm",
        "pictures/t_1.svg",
        "pictures/slide.png",
        "vtk/grains-1.vtp",
        "frames/00001.jpg",
        "frames.part",
        "scene",
        ".part",
        "a/scene.ron",
    ] {
        assert!(!is_own(Path::new(other)), "{other}");
    }
}

#[test]
fn a_run_is_replaced_only_on_request_and_files_of_others_are_kept() {
    let here = tempfile::tempdir().unwrap();
    let path = here.path().join("out/run");
    drop(run(&path, "(old: 1)", false).unwrap());
    assert_eq!(names(&path), COMPLETE);
    fs::write(path.join("notes.txt"), "mine").unwrap();
    fs::write(path.join("frames/film.mp4"), "film").unwrap();
    fs::create_dir(path.join("plots")).unwrap();
    fs::write(path.join("plots/series.csv"), "mine too").unwrap();
    fs::write(path.join("plots/energy.svg"), "old").unwrap();
    fs::write(path.join("frames/00007.png"), "old").unwrap();
    let refused = run(&path, "(new: 1)", false).unwrap_err();
    assert!(refused.code() == "run::exists" && refused.to_string().contains("a finished run"), "{refused}");
    drop(run(&path, "(new: 1)", true).unwrap());
    assert_eq!(fs::read_to_string(path.join(SCENE)).unwrap(), "(new: 1)");
    assert_eq!(names(&path.join(FRAMES)), ["00000.svg", "film.mp4"]);
    let all: Vec<_> = COMPLETE.into_iter().chain(["notes.txt", "plots"]).collect();
    assert!(all.iter().all(|name| names(&path).contains(&(*name).to_owned())) && all.len() == names(&path).len());
    assert_eq!(names(&path.join("plots")), ["series.csv"]);
    assert_eq!(fs::read_to_string(path.join("plots/series.csv")).unwrap(), "mine too");
    assert_eq!(names(&here.path().join("out")), ["run"]);
}

#[test]
fn a_directory_that_is_not_published_leaves_no_trace() {
    let here = tempfile::tempdir().unwrap();
    drop(RunDirectory::create(&here.path().join("a/b/run"), &source("()"), false).unwrap());
    assert_eq!(names(here.path()), [""; 0]);
    let path = here.path().join("run");
    drop(run(&path, "(old: 1)", false).unwrap());
    fs::write(path.join("notes.txt"), "mine").unwrap();
    drop(RunDirectory::create(&path, &source("(new: 1)"), true).unwrap());
    assert_eq!(fs::read_to_string(path.join(SCENE)).unwrap(), "(old: 1)");
    assert_eq!((names(here.path()), names(&path).len()), (vec!["run".to_owned()], 7));
}

#[test]
fn a_directory_in_use_is_refused() {
    let here = tempfile::tempdir().unwrap();
    let path = here.path().join("run");
    // Both prepare; the second to publish is refused.
    let [mut first, mut second] = [(); 2].map(|()| RunDirectory::create(&path, &source("()"), true).unwrap());
    first.publish().unwrap();
    let own = format!("process {}", std::process::id());
    let in_use = |fault: &Fault| fault.code() == "run::in_use" && fault.to_string().contains(&own);
    assert!(in_use(&second.publish().unwrap_err()));
    drop(second);
    assert!(in_use(&RunDirectory::create(&path, &source("()"), true).unwrap_err()));
    assert!(in_use(&RunDirectory::reopen(&path).unwrap_err()));
    drop(first);
    let killed = RunDirectory::create(&path, &source("()"), false).unwrap_err();
    assert!(killed.to_string().contains("a run that was killed"), "{killed}");
    let mut reopened = RunDirectory::reopen(&path).unwrap();
    reopened.publish().unwrap();
    reopened.write_summary(&"first part").unwrap();
    reopened.remove_results().unwrap();
    assert!(!path.join(SUMMARY).exists());
    reopened.write_summary(&"whole").unwrap();
    assert!(in_use(&RunDirectory::create(&path, &source("()"), true).unwrap_err()));
    drop(reopened);
    assert_eq!(RunDirectory::reopen(here.path()).unwrap_err().code(), "run::directory");
    assert_eq!(names(here.path()), ["run"]);
}

#[test]
fn remainders_of_killed_processes_are_removed() {
    let here = tempfile::tempdir().unwrap();
    let path = here.path().join("run");
    drop(run(&path, "(old: 1)", false).unwrap());
    let stale = |end: &str, files: &[&str]| {
        let stale = here.path().join(format!(".run.siloflow-{end}"));
        fs::create_dir_all(stale.join(FRAMES)).unwrap();
        for file in files {
            fs::write(stale.join(file), "left").unwrap();
        }
    };
    stale("1-1", &[MARKER, SCENE, "frames/00001.svg", "notes.txt"]);
    fs::create_dir(here.path().join(".run.siloflow-2-1")).unwrap();
    // This has no marker, so it is not siloflow's.
    stale("3-1", &[SCENE]);
    let running = RunDirectory::create(&path, &source("()"), true).unwrap();
    let left = names(here.path());
    assert_eq!(left.len(), 3, "{left:?}");
    assert!(left[0].starts_with(".run.siloflow-") && left.contains(&".run.siloflow-3-1".to_owned()));
    assert_eq!(fs::read_to_string(path.join("notes.txt")).unwrap(), "left");
    // The stage of a process that is alive stays.
    drop(RunDirectory::create(&path, &source("()"), true).unwrap());
    assert_eq!(names(here.path()), left);
    drop(running);
    // An exchange in two renames was interrupted between them.
    fs::rename(&path, here.path().join(".run.siloflow-9-1.old")).unwrap();
    drop(RunDirectory::create(&path, &source("()"), true).unwrap());
    assert_eq!(fs::read_to_string(path.join(SCENE)).unwrap(), "(old: 1)");
}

#[test]
fn other_directories_are_refused() {
    let here = tempfile::tempdir().unwrap();
    let refused =
        |name: &str| RunDirectory::create(&here.path().join(name), &source("()"), true).unwrap_err().to_string();
    fs::create_dir(here.path().join("thesis")).unwrap();
    fs::write(here.path().join("thesis/thesis.tex"), "years").unwrap();
    assert!(refused("thesis").contains("thesis.tex"));
    fs::write(here.path().join("file"), "").unwrap();
    refused("file");
    refused("nowhere/..");
    assert_eq!(names(here.path()), ["file", "thesis"]);
}

#[test]
fn a_directory_that_was_moved_away_is_not_written_to() {
    let here = tempfile::tempdir().unwrap();
    let path = here.path().join("run");
    let mut directory = RunDirectory::create(&path, &source("()"), false).unwrap();
    directory.publish().unwrap();
    fs::rename(&path, here.path().join("moved")).unwrap();
    let second = run(&path, "(second: 1)", false).unwrap();
    assert!(directory.write_summary(&"first").is_err() && directory.write_state(|_| Ok(())).is_err());
    assert_eq!(fs::read_to_string(path.join(SUMMARY)).unwrap(), "\"(second: 1)\"\n");
    drop(second);
}

#[test]
#[cfg(unix)]
fn symbolic_links_are_not_followed() {
    use std::os::unix::fs::symlink;
    let here = tempfile::tempdir().unwrap();
    let path = here.path().join("run");
    drop(run(&path, "(old: 1)", false).unwrap());
    let pictures = here.path().join("pictures");
    fs::rename(path.join(FRAMES), &pictures).unwrap();
    symlink("../pictures", path.join(FRAMES)).unwrap();
    let refused = run(&path, "(new: 1)", true).unwrap_err();
    assert!(refused.to_string().contains(FRAMES), "{refused}");
    assert_eq!(names(&pictures), ["00000.svg"]);
    // A link to the run directory itself is followed, because the caller names it.
    fs::remove_file(path.join(FRAMES)).unwrap();
    symlink("run", here.path().join("link")).unwrap();
    drop(run(&here.path().join("link"), "(new: 1)", true).unwrap());
    assert!(here.path().join("link").is_symlink());
    assert_eq!(fs::read_to_string(path.join(SCENE)).unwrap(), "(new: 1)");
}

#[test]
fn results_are_replaced_together_and_other_files_are_kept() {
    let here = tempfile::tempdir().unwrap();
    let path = here.path().join("out/compare");
    let files = |text: &str| ["a.csv", "b.svg"].map(|name| (name.to_owned(), text.as_bytes().to_vec()));
    write_results(&path, &files("old")).unwrap();
    fs::write(path.join("notes.txt"), "mine").unwrap();
    write_results(&path, &files("new")).unwrap();
    assert_eq!(names(&path), ["a.csv", "b.svg", "notes.txt"]);
    // A directory that holds others is not replaced.
    fs::create_dir(path.join("plots")).unwrap();
    write_results(&path, &files("newer")).unwrap();
    assert_eq!(fs::read_to_string(path.join("a.csv")).unwrap(), "newer");
    assert_eq!((names(&path).len(), names(&here.path().join("out"))), (4, vec!["compare".to_owned()]));
}
