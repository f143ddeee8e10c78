//! Texts as other programs write them: with byte order marks, in UTF-16, in Latin-1. Every text that a scene or a command names goes through one reader.

use std::fs;
use std::path::Path;

use crate::command_line::{siloflow, text};

const SCENE: &str = "(
    gravity: (0.0, -9.81), mass: Disc(20.0), step: Fixed(2.0e-5), until: 0.01, pictures: None, title: \"Möhren\",
    contact: Linear(k: 1.0e4, damping: Restitution(0.3), tangential: Spring(k: 3.0e3, damping: OfNormal(0.5), friction: 0.5)),
    walls: [Segment(from: (-0.1, 0.0), to: (0.1, 0.0), name: \"floor\")],
    motions: [(walls: \"floor\", translate: Table(file: \"shift.csv\"))],
    silo: (file: \"silo.dat\", unit: Metre),
    grains: (file: \"grains.csv\", contacts: \"contacts.csv\"),
)
";

const FILES: [(&str, &str); 5] = [
    ("scene.ron", SCENE),
    ("shift.csv", "time_s,x,y\r\n0,0,0\r\n1,0,0.01\r\n"),
    ("silo.dat", "1 0\r\n0.05 -0.05 0.01\r\n"),
    ("grains.csv", "id,radius,mass,x,y,vx,vy\r\n1,0.002,0.01,0,0.0019,0.1,-0.1\r\n2,0.002,0.01,0.01,0.0019,0,0\r\n"),
    (
        "contacts.csv",
        "grain,with,number,spring_x,spring_y,spring_z,rolling_x,rolling_y,rolling_z,stiffness\r\n1,wall,1,1e-5,0,0,0,0,0,3000\r\n",
    ),
];

fn encodings() -> [fn(&str) -> Vec<u8>; 4] {
    [
        |text| text.as_bytes().to_vec(),
        |text| [b"\xef\xbb\xbf", text.as_bytes()].concat(),
        |text| format!("\u{feff}{text}").encode_utf16().flat_map(u16::to_le_bytes).collect(),
        |text| format!("\u{feff}{text}").encode_utf16().flat_map(u16::to_be_bytes).collect(),
    ]
}

/// Writes the files, `changed` in place of the one with its name.
fn write(directory: &Path, changed: (&str, Vec<u8>)) {
    for (name, content) in FILES {
        fs::write(directory.join(name), content).unwrap();
    }
    fs::write(directory.join(changed.0), changed.1).unwrap();
}

fn state(directory: &Path) -> Vec<u8> {
    let output = siloflow(directory, &["run", "scene.ron", "--out", "run", "--force", "--quiet"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    fs::read(directory.join("run/state.csv")).unwrap()
}

#[test]
fn a_text_is_the_same_in_every_encoding_with_a_mark() {
    let here = tempfile::tempdir().unwrap();
    write(here.path(), ("scene.ron", SCENE.into()));
    let expected = state(here.path());
    for (name, content) in FILES {
        for encode in &encodings()[1..] {
            write(here.path(), (name, encode(content)));
            assert!(state(here.path()) == expected, "{name}");
        }
    }
    // The last scene was in UTF-16 or had such a file; its run can be read, and another one can start from it.
    write(here.path(), ("scene.ron", encodings()[2](SCENE)));
    state(here.path());
    let again = siloflow(here.path(), &["run", "scene.ron", "--from", "run", "--out", "again", "--quiet"]);
    assert!(again.status.success(), "{}", text(&again.stderr));
    let report = siloflow(here.path(), &["report", "run", "--quiet"]);
    assert!(report.status.success(), "{}", text(&report.stderr));
}

#[test]
fn a_text_in_latin_1_is_refused_with_its_place() {
    let here = tempfile::tempdir().unwrap();
    for (name, content) in FILES {
        let mut bytes = b"# gr\xf6\xdfer\n".to_vec();
        if name != "shift.csv" && name != "scene.ron" {
            bytes = content.as_bytes().to_vec();
            bytes.extend(b"\xf6\n");
        }
        write(here.path(), (name, bytes));
        let output = siloflow(here.path(), &["check", "scene.ron"]);
        // The renderer breaks lines.
        let message = text(&output.stderr).replace("\n  │ ", " ");
        let is_good = ["0xf6", "Latin-1", "UTF-8", "line ", name].iter().all(|word| message.contains(word));
        assert!(output.status.code() == Some(2) && is_good, "{name}: {message}");
    }
}

#[test]
fn a_sweep_file_and_a_picture_may_have_a_mark() {
    let here = tempfile::tempdir().unwrap();
    write(here.path(), ("scene.ron", SCENE.into()));
    let sweep = "(scene: \"scene.ron\", axes: [Values(key: \"until\", values: [0.001, 0.002])], seeds: Count(1), figures: [\"time_s\"])";
    let picture = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"4\" height=\"4\"/>";
    for encode in &encodings()[1..] {
        fs::write(here.path().join("many.ron"), encode(sweep)).unwrap();
        fs::write(here.path().join("a.svg"), encode(picture)).unwrap();
        for arguments in [&["sweep", "many.ron", "--list"][..], &["render", "a.svg"]] {
            let output = siloflow(here.path(), arguments);
            assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
        }
    }
}
