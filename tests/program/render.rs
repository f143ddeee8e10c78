//! `siloflow render`: pictures and movies from the frames of a run, and what it refuses.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use crate::command_line::{siloflow, text};

/// Runs a scene with settings into `run`.
fn run(here: &Path, scene: &str, settings: &[&str]) {
    let set: Vec<_> = settings.iter().flat_map(|setting| ["--set", setting]).collect();
    let path = crate::scene(scene).display().to_string();
    let output = siloflow(here, &[&["run", &path, "--quiet", "--force", "--out", "run"], &set[..]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
}

fn render(here: &Path, options: &[&str]) -> String {
    let output = siloflow(here, &[&["render", "run"], options].concat());
    assert!(output.status.success(), "{options:?}: {}", text(&output.stderr));
    text(&output.stdout)
}

/// Checks that a call is refused, names all of `words`, and writes nothing.
fn refused(here: &Path, options: &[&str], words: &[&str]) {
    let before = fs::read_dir(here).unwrap().count() + fs::read_dir(here.join("run")).map_or(0, Iterator::count);
    let output = siloflow(here, &[&["render"], options].concat());
    let said = text(&output.stderr).split_whitespace().collect::<Vec<_>>().join(" ");
    assert_eq!(output.status.code(), Some(2), "{options:?}: {said}");
    assert!(words.iter().all(|word| said.contains(word)) && !said.contains("panicked"), "{options:?}: {said}");
    let after = fs::read_dir(here).unwrap().count() + fs::read_dir(here.join("run")).map_or(0, Iterator::count);
    assert_eq!(after, before, "{options:?} wrote something");
}

#[test]
fn pictures_of_a_run_and_of_its_frames_are_the_same_bytes() {
    let here = tempfile::tempdir().unwrap();
    for (scene, settings) in [
        (
            "couette.ron",
            ["until=0.05", "pictures.interval=0.02", "pictures.png=true", "pictures.view=((-0.1, -0.1), (1.0, 1.0))"],
        ),
        ("silo3d.ron", ["until=0.002", "pictures.interval=0.001", "pictures.direction=Iso", "pictures.width=500"]),
        (
            "column.ron",
            ["until=0.3", "pictures.interval=0.1", "pictures.png=true", "pictures.view=((-1.0, -0.1), (1.0, 2.0))"],
        ),
    ] {
        run(here.path(), scene, &settings);
        let frames = here.path().join("run/frames");
        let count = fs::read_dir(&frames)
            .unwrap()
            .filter(|entry| entry.as_ref().unwrap().path().extension().is_some_and(|ending| ending == "svg"));
        let count = count.count();
        assert!(count >= 3, "{scene}");
        for (number, time) in [(0, "0"), (1, &settings[1]["pictures.interval=".len()..]), (count - 1, "99")] {
            let drawn = fs::read(frames.join(format!("{number:05}.svg"))).unwrap();
            let _ = fs::remove_file(here.path().join("again.svg"));
            render(here.path(), &["--at", time, "--out", "again.svg"]);
            assert!(fs::read(here.path().join("again.svg")).unwrap() == drawn, "{scene} at {time} s");
        }
        if settings[2].ends_with("png=true") {
            render(here.path(), &["--at", "0", "--force", "--out", "again.png"]);
            let drawn = fs::read(frames.join("00000.png")).unwrap();
            assert!(fs::read(here.path().join("again.png")).unwrap() == drawn, "{scene}");
        }
    }
}

#[test]
fn drawings_show_where_the_grains_of_a_run_have_been() {
    let here = tempfile::tempdir().unwrap();
    let scene = "(title: \"wide floor\", gravity: (0.0, -9.81), walls: [Segment(from: (-5.0, 0.0), to: (5.0, 0.0))], \
        contact: Linear(k: 1.0e5, damping: Restitution(0.5)), mass: Disc(1000.0), step: Fixed(1.0e-4), until: 0.2, \
        spawner: (point: (0.0, 0.5), velocity: (0.0, 0.0), interval: 0.05, count: 3, radius: Fixed(0.05)), pictures: (interval: 0.1))";
    fs::write(here.path().join("floor.ron"), scene).unwrap();
    let output = siloflow(here.path(), &["run", "floor.ron", "--quiet", "--out", "run"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    // Radius on the picture, px. 600 px are 10 m or more in the run's own pictures, and less than 1 m in a drawing.
    let radius = |svg: &str| svg.split(" r=\"").nth(1).unwrap().split('"').next().unwrap().parse::<f64>().unwrap();
    let own = radius(&fs::read_to_string(here.path().join("run/frames/00002.svg")).unwrap());
    for time in ["0.1", "0.2"] {
        render(here.path(), &["--at", time, "--force", "--out", "one.svg"]);
        let drawn = radius(&fs::read_to_string(here.path().join("one.svg")).unwrap());
        assert!(own <= 3.0 && drawn >= 30.0, "{own} {drawn}");
    }
}

#[test]
fn options_change_what_is_drawn() {
    let here = tempfile::tempdir().unwrap();
    run(here.path(), "silo3d.ron", &["until=0.002", "pictures.interval=0.001"]);
    let draw = |options: &[&str]| {
        render(here.path(), &[options, &["--force", "--out", "one.svg"]].concat());
        fs::read_to_string(here.path().join("one.svg")).unwrap()
    };
    let plain = draw(&[]);
    assert!(plain.contains("speed, m/s") && plain.contains("t = 0.0020 s"), "{}", &plain[..2000]);
    assert!(draw(&["--at", "0"]).contains("t = 0.0000 s"));
    assert!(draw(&["--colour", "coordination=0..6"]).contains(">coordination<"));
    assert!(draw(&["--colour", "mass"]).contains(">mass, kg<"));
    assert!(draw(&["--colour", "pressure=0..300"]).contains(">pressure, N/m²<"));
    assert!(!draw(&["--colour", "species"]).contains("linearGradient"));
    assert!(draw(&["--width", "300"]).contains(r#"width="300""#));
    let spheres = |svg: &str| svg.matches("<circle").count();
    let side = draw(&["--view", "side"]);
    let cut = draw(&["--view", "side", "--cut=0.05"]);
    assert!(side != plain && spheres(&cut) > 0 && cut != side);
    assert_eq!(draw(&["--view", "-1,0,0"]), side);
    // Every picture of an interval, named after its time.
    let said = render(here.path(), &["--every", "0.001"]);
    let names: Vec<_> = said.lines().collect();
    assert_eq!(names, ["run/pictures/t_0.0000.png", "run/pictures/t_0.0010.png", "run/pictures/t_0.0020.png"]);
    assert!(names.iter().all(|name| fs::read(here.path().join(name)).unwrap().starts_with(b"\x89PNG")));
    // A replaced run takes its drawings along.
    render(here.path(), &["--movie"]);
    run(here.path(), "free-fall.ron", &["until=0.1"]);
    assert!(!here.path().join("run/pictures").exists() && !here.path().join("run/movie.png").exists());
}

#[test]
fn a_movie_is_read_back_with_all_frames_and_their_delay() {
    let here = tempfile::tempdir().unwrap();
    run(here.path(), "couette.ron", &["until=0.05", "data_frames=(interval: 0.01)"]);
    let said = render(here.path(), &["--movie", "--duration", "1.2"]);
    assert!(said.starts_with("run/movie.png: 6 frames, "), "{said}");
    let read = |name: &str| {
        let file = Cursor::new(fs::read(here.path().join(name)).unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        let frames = reader.info().animation_control().unwrap().num_frames;
        let size = (reader.info().width, reader.info().height);
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        for _ in 0..frames {
            reader.next_frame(&mut pixels).unwrap();
            let control = reader.info().frame_control().unwrap();
            assert_eq!(
                (control.delay_num, control.delay_den),
                if name == "few.png" { (100, 1000) } else { (200, 1000) }
            );
        }
        assert!(reader.next_frame(&mut pixels).is_err());
        (frames, size)
    };
    let (frames, (width, height)) = read("run/movie.png");
    // The scene is taller than a slide.
    assert!(frames == 6 && width < 960 && (700..=720).contains(&height), "{width} x {height}");
    render(here.path(), &["--movie", "--every", "0.02", "--fps", "10", "--width", "200", "--out", "few.png"]);
    assert_eq!((read("few.png").0, read("few.png").1.0), (3, 200));
}

#[test]
fn a_run_that_was_killed_is_drawn_up_to_its_last_whole_frame() {
    let here = tempfile::tempdir().unwrap();
    run(here.path(), "couette.ron", &["until=0.05", "data_frames=(interval: 0.01)"]);
    let path = here.path().join("run/frames.bin");
    let whole = fs::read(&path).unwrap();
    fs::write(&path, &whole[..whole.len() - 1]).unwrap();
    assert!(render(here.path(), &["--movie", "--width", "100"]).contains("5 frames"));
    let mut wrong = whole.clone();
    wrong[whole.len() / 2] ^= 1;
    fs::write(&path, wrong).unwrap();
    refused(here.path(), &["run", "--movie", "--out", "other.png"], &["render::read", "a part of it has changed"]);
    fs::write(&path, &whole[..whole.len() / 20]).unwrap();
    refused(here.path(), &["run", "--at", "0"], &["render::"]);
}

#[test]
fn what_cannot_be_drawn_is_refused_with_a_remedy() {
    let here = tempfile::tempdir().unwrap();
    refused(here.path(), &["run", "--movie"], &["render::missing", "siloflow run"]);
    fs::create_dir(here.path().join("empty")).unwrap();
    refused(here.path(), &["empty", "--movie"], &["render::no_run"]);
    run(here.path(), "free-fall.ron", &["data_frames=None", "pictures=None", "until=0.1"]);
    refused(here.path(), &["run", "--movie"], &["render::no_frames", "data_frames"]);
    run(here.path(), "mass-flow.ron", &["until=2", "pictures=None"]);
    refused(here.path(), &["run", "--movie"], &["render::method", "lattice"]);
    run(here.path(), "couette.ron", &["until=0.01", "data_frames=(contacts: false)", "pictures.network=None"]);
    refused(here.path(), &["run", "--network", "5"], &["contacts: true"]);
    refused(here.path(), &["run", "--colour", "heat"], &["no column `heat`", "coordination", "pressure"]);
    refused(here.path(), &["run", "--colour", "speed=2..1"], &["LOW..HIGH"]);
    refused(here.path(), &["run", "--view", "askew"], &["front", "iso"]);
    refused(here.path(), &["run", "--view", "iso"], &["solid space"]);
    refused(here.path(), &["run", "--cut"], &["solid space"]);
    refused(here.path(), &["run", "--width", "1e9"], &["50 to 20000 px"]);
    refused(here.path(), &["run", "run", "--movie"], &["one run"]);
    refused(here.path(), &["run", "--fps", "5"], &["--movie"]);
    refused(here.path(), &["run", "--every", "0.001", "--out", "one.png"], &["do not fit into one file"]);
    refused(here.path(), &["run", "--movie", "--out", "no/such/place.png"], &["render::write"]);
}

#[test]
fn what_exists_is_replaced_only_with_force_and_only_if_it_is_a_drawing() {
    let here = tempfile::tempdir().unwrap();
    run(here.path(), "couette.ron", &["until=0.01"]);
    render(here.path(), &["--at", "0"]);
    refused(here.path(), &["run", "--at", "0"], &["run/pictures exists", "--force"]);
    assert_eq!(render(here.path(), &["--at", "9", "--force"]).lines().count(), 1);
    assert_eq!(fs::read_dir(here.path().join("run/pictures")).unwrap().count(), 1);
    fs::write(here.path().join("run/pictures/notes.txt"), "mine").unwrap();
    refused(here.path(), &["run", "--at", "0", "--force"], &["siloflow has not drawn"]);
    refused(here.path(), &["run", "--movie", "--out", "run", "--force"], &["siloflow has not drawn"]);
    assert_eq!(fs::read(here.path().join("run/pictures/notes.txt")).unwrap(), b"mine");
}

#[test]
fn colour_of_a_scene_may_be_any_column_of_one_number() {
    let here = tempfile::tempdir().unwrap();
    let path = crate::scene("couette.ron").display().to_string();
    run(
        here.path(),
        "couette.ron",
        &["until=0.01", "data_frames=None", "pictures.colour=Column(\"coordination\", 0, 6)"],
    );
    let drawn = fs::read_to_string(here.path().join("run/frames/00000.svg")).unwrap();
    assert!(drawn.contains(">coordination<"));
    for (colour, expected) in [
        ("Column(\"heat\", 0, 1)", "the columns are id, kind"),
        ("Column(\"velocity\", 0, 1)", "no column `velocity`"),
        ("Column(\"radius\", 1, 1)", "must begin below its end"),
    ] {
        let output = siloflow(here.path(), &["check", &path, "--set", &format!("pictures.colour={colour}")]);
        let said = text(&output.stderr).split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(output.status.code() == Some(2) && said.contains(expected), "{colour}: {said}");
    }
    for setting in ["pictures.direction=Iso", "pictures.cut=0.0"] {
        let output = siloflow(here.path(), &["check", &path, "--set", setting]);
        assert!(output.status.code() == Some(2) && text(&output.stderr).contains("no depth"), "{setting}");
    }
}
