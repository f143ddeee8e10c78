//! Mesh files as other programs write them, and the messages about those that are refused.

use std::fs;
use std::num::NonZeroUsize;
use std::path::Path;

use siloflow::prelude::*;
use siloflow::text::fault::Fault;

use crate::command_line::{siloflow, text};

/// A floor with a slot, as one polygon, and two triangles of STL.
const FLOOR: &str = "v -0.1 -0.1 0\nv 0.1 -0.1 0\nv 0.1 0.1 0\nv 0.03 0.1 0\nv 0.03 -0.05 0\nv -0.03 -0.05 0\nv -0.03 0.1 0\nv -0.1 0.1 0\n";

fn loaded(directory: &Path, file: &str, content: impl AsRef<[u8]>) -> Result<Loaded, Fault> {
    fs::write(directory.join(file), content).unwrap();
    let rows = "id,radius,mass,x,y,z,vx,vy,vz\n1,0.004,0.00067,0.0,0.05,0.01,0,0,0\n2,0.004,0.00067,0.08,0.05,0.01,0,0,0\n\
                3,0.004,0.00067,-0.08,0.05,0.01,0,0,0\n4,0.004,0.00067,0.0,-0.08,0.01,0,0,0\n";
    fs::write(directory.join("drop.csv"), rows).unwrap();
    let scene = format!(
        "(space: Solid, gravity: (0.0, 0.0, -9.81), contact: Linear(k: 1.0e4, damping: Restitution(0.3)), step: Fixed(5.0e-5), on_loss: Continue,
        walls: [Mesh(file: \"{file}\", unit: Metre)], grains: (file: \"drop.csv\"), until: 0.25, pictures: None, checkpoint: None)"
    );
    load::from_text("m.ron", "m", directory, scene, &[])
}

/// Height of the grains at the end, by id.
fn heights(loaded: &Loaded) -> Vec<f64> {
    let mut run = Simulation::new(loaded, &Registry::default(), NonZeroUsize::MIN).unwrap();
    run.run();
    let world = run.world_mut();
    let mut grains: Vec<_> =
        world.query::<(&GrainId, &Position<Solid>)>().iter(world).map(|(id, x)| (id.number(), x.0.z)).collect();
    grains.sort_by_key(|grain| grain.0);
    grains.into_iter().map(|grain| grain.1).collect()
}

#[test]
fn grains_fall_through_the_slot_of_a_concave_face_and_rest_beside_it() {
    let here = tempfile::tempdir().unwrap();
    for face in
        ["f 1 2 3 4 5 6 7 8", "f -5 -4 -3 -2 -1 -8 -7 -6", "f 5 4 3 2 1 8 7 6", "f 3/1/1 4//2 5/3 \\\n6 7 8 1 2"]
    {
        let loaded =
            loaded(here.path(), "floor.obj", format!("# a floor\n{FLOOR}vn 0 0 1\nvt 0 0\n{face}\nl 1 2\np 1\n"))
                .unwrap();
        let heights = heights(&loaded);
        // By the law a grain of 0.67 g sinks 6.6e-7 m into a floor of 1e4 N/m.
        let rest = |z: f64| (z - 0.004).abs() < 1e-5;
        assert!(heights[0] < -0.1 && heights[1..].iter().all(|&z| rest(z)), "{face}: {heights:?}");
    }
}

#[test]
fn faces_that_are_no_polygons_are_refused_with_their_line() {
    let here = tempfile::tempdir().unwrap();
    for (file, words) in [
        (format!("{FLOOR}f 1 3 2 4 5\n"), &["line 9", "cross"][..]),
        (format!("{FLOOR}f 1 2 3\nf 1 2 3 9\n"), &["line 10", "`9`", "8"]),
        (format!("{FLOOR}f 1 2 0\n"), &["line 9", "`0`"]),
        (format!("{FLOOR}f -9 2 1\n"), &["line 9", "`-9`"]),
        (format!("{FLOOR}f 1 2 x/1\n"), &["line 9", "`x/1`"]),
        (format!("{FLOOR}f 1 2\n"), &["line 9", "three corners"]),
        (format!("{FLOOR}f 1 2 2 1\n"), &["line 9", "three corners"]),
        (format!("{FLOOR}v 0 0 0.1\nf 1 2 3 9\n"), &["line 10", "corner", "plane"]),
        (format!("{FLOOR}v 0 0\nf 1 2 3\n"), &["line 9", "three numbers"]),
        (format!("{FLOOR}v 0 0 1,5\nf 1 2 3\n"), &["line 9", "`1,5`"]),
        (format!("{FLOOR}v 0 -0.1 0\nf 1 2 9\n"), &["triangle 1", "line 10", "no area"]),
        (format!("{FLOOR}f 1 2 3\nf 1 3 2\n"), &["triangle 2", "line 10", "comes twice"]),
        (format!("{FLOOR}surf 0 1 0 1 1 2 3\n"), &["line 9", "`surf`"]),
        (FLOOR.to_owned(), &["no triangle"]),
    ] {
        let fault = loaded(here.path(), "floor.obj", &file).unwrap_err();
        let message = fault.to_string();
        assert!(words.iter().all(|word| message.contains(word)) && message.contains("floor.obj"), "{file}: {message}");
        assert_eq!((fault.code(), fault.scene_key()), ("scene::mesh", Some("walls[0].file")));
    }
}

const STL: &str = "solid plate
  facet normal 0 0 1
    outer loop
      vertex -1.0e-1 -1.0e-1 0
      vertex 1.0e-1 -1.0e-1 0
      vertex 1.0e-1 1.0e-1 0
    endloop
  endfacet
  facet normal 0 0 1
    outer loop
      vertex -1.0e-1 -1.0e-1 0
      vertex 1.0e-1 1.0e-1 0
      vertex -1.0e-1 1.0e-1 0
    endloop
  endfacet
endsolid plate
";

fn triangles(loaded: &Loaded) -> Vec<[Solid; 3]> {
    loaded.scene.walls[0].shape.triangles().unwrap().to_vec()
}

#[test]
fn every_dialect_of_stl_is_the_same_mesh() {
    let here = tempfile::tempdir().unwrap();
    let read = |content: &[u8]| loaded(here.path(), "plate.stl", content).map(|loaded| triangles(&loaded));
    let expected = read(STL.as_bytes()).unwrap();
    assert_eq!(expected.len(), 2);
    let corner = f64::from(0.1f32);
    assert_eq!(expected[0][2], Solid::new(corner, corner, 0.0));
    let (one, other) = STL.split_at(
        STL.find("  facet normal 0 0 1\n    outer loop\n      vertex -1.0e-1 -1.0e-1 0\n      vertex 1.0e-1 1.0")
            .unwrap(),
    );
    let dialects = [
        STL.to_uppercase(),
        STL.replace(" plate", ""),
        format!("\n\n \r\n{STL}\n\n"),
        STL.replace("endloop", "end loop").replace("endfacet", "end facet").replace("endsolid", "end solid"),
        STL.replace('\n', "\r\n"),
        STL.replace('\n', "\r"),
        STL.replace("  ", "\t"),
        STL.replace("e-1", "D-01"),
        STL.replace(" 1.0e-1", " +.1").replace("-1.0e-1", "-.1"),
        STL.replace("normal 0 0 1", "normal nan nan nan"),
        STL.replace("normal 0 0 1", "normal -1.#IND 0 0"),
        STL.replace(" normal 0 0 1", ""),
        STL.replace("plate", "facet of a plate, endsolid"),
        STL.replace("  facet", "  color 0.5 0.5 0.5\n  facet"),
        format!("{one}endsolid plate\n\nsolid another\n{other}"),
        STL.split_whitespace().collect::<Vec<_>>().join("\n").replace("solid\nplate", "solid plate"),
    ];
    for dialect in dialects {
        assert_eq!(read(dialect.as_bytes()).map_err(|fault| fault.to_string()), Ok(expected.clone()), "{dialect}");
    }
    for encoded in [
        [b"\xef\xbb\xbf", STL.as_bytes()].concat(),
        format!("\u{feff}{STL}").encode_utf16().flat_map(u16::to_le_bytes).collect(),
    ] {
        assert_eq!(read(&encoded).unwrap(), expected);
    }
}

/// A binary file with this header and number of triangles, and normals that are no numbers.
fn binary(header: &[u8], count: u32, triangles: &[[Solid; 3]]) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, b' ');
    bytes.extend(count.to_le_bytes());
    for triangle in triangles {
        bytes.extend(f32::NAN.to_le_bytes().repeat(3));
        bytes.extend(triangle.iter().flat_map(Solid::to_array).flat_map(|x| (x as f32).to_le_bytes()));
        bytes.extend([255, 255]);
    }
    bytes
}

#[test]
fn binary_files_are_told_by_their_length_and_not_by_their_header() {
    let here = tempfile::tempdir().unwrap();
    let read = |content: &[u8]| loaded(here.path(), "plate.stl", content).map(|loaded| triangles(&loaded));
    let expected = read(STL.as_bytes()).unwrap();
    for header in [
        &b"made by a program"[..],
        b"solid made by a program",
        b"solid\nfacet normal 0 0 1\n",
        b"\xef\xbb\xbfsolid",
        b"\xff\xfes\0",
    ] {
        assert_eq!(read(&binary(header, 2, &expected)).unwrap(), expected);
    }
    // Some programs add bytes at the end.
    for header in [&b"x"[..], b"solid x"] {
        assert_eq!(read(&[binary(header, 2, &expected), vec![0; 3]].concat()).unwrap(), expected);
    }
    for (content, words) in [
        (binary(b"x", 3, &expected), &["announces 3 triangles", "ends in triangle 3"][..]),
        (binary(b"solid x", u32::MAX, &expected), &["announces 4294967295 triangles", "ends in triangle 3"]),
        (binary(b"x", 0, &expected), &["announces no triangle", "100 bytes"]),
        (binary(b"x", 2, &expected)[..130].to_vec(), &["ends in triangle 1"]),
        (vec![0; 90], &["no triangle"]),
    ] {
        let message = read(&content).unwrap_err().to_string();
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    }
}

#[test]
fn wrong_stl_files_are_refused_with_their_line() {
    let here = tempfile::tempdir().unwrap();
    for (content, words) in [
        (STL.replacen("endloop", "endlop", 1), &["triangle 1", "line 7", "`endloop`", "`endlop`"][..]),
        (STL.replacen("    endloop", "      vertex 0 0 0\n    endloop", 1), &["triangle 1", "line 7", "three corners"]),
        (STL.replacen("      vertex 1.0e-1 -1.0e-1 0\n", "", 1), &["triangle 1", "line 6", "`vertex`", "`endloop`"]),
        (STL.replacen("1.0e-1 0\n", "1.0e-1 0,0\n", 1), &["triangle 1", "line 4", "`0,0`"]),
        (STL.replacen("1.0e-1 0\n", "1.0e-1 nan\n", 1), &["triangle 1", "line 4", "`nan`"]),
        (STL.replacen("1.0e-1 0\n", "1.0e-1 1e99\n", 1), &["triangle 1", "line 4", "`1e99`"]),
        (STL.replacen("    outer loop\n", "", 1), &["triangle 1", "line 3", "`outer loop`", "`vertex`"]),
        (STL.replace("endsolid plate", ""), &["`endsolid`", "end of the file"]),
        (STL[..STL.len() * 3 / 4].to_owned(), &["triangle 2", "line "]),
        (STL.replacen("solid", "sold", 1), &["not an STL file", "line 1", "`solid`", "`sold`"]),
        (FLOOR.to_owned(), &["not an STL file", "`solid`", "`v`"]),
    ] {
        let message = loaded(here.path(), "plate.stl", &content).unwrap_err().to_string();
        assert!(words.iter().all(|word| message.contains(word)) && message.contains("plate.stl"), "{message}");
    }
}

#[test]
fn a_wrong_mesh_is_an_error_of_the_input() {
    let here = tempfile::tempdir().unwrap();
    loaded(here.path(), "floor.obj", format!("{FLOOR}f 1 2 3\n")).unwrap();
    let scene = "(space: Solid, gravity: (0.0, 0.0, -9.81), contact: Linear(k: 1.0e4, damping: B(0.0)), step: Fixed(5.0e-5), until: 0.1,
        walls: [Mesh(file: \"floor.obj\", unit: Metre)])";
    fs::write(here.path().join("m.ron"), scene).unwrap();
    fs::write(here.path().join("floor.obj"), [FLOOR.as_bytes(), b"# gr\xf6\xdfer\nf 1 2 3\n"].concat()).unwrap();
    let output = siloflow(here.path(), &["check", "m.ron"]);
    let message = text(&output.stderr).replace("\n  │ ", " ");
    assert_eq!(output.status.code(), Some(2));
    assert!(
        ["floor.obj", "line 9, column 5", "0xf6", "Latin-1", "UTF-8"].iter().all(|word| message.contains(word)),
        "{message}"
    );
}
