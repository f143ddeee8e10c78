use super::style::{Colouring, Style};
use super::*;
use crate::pictures::camera::{Camera, Direction};
use glam::DVec2;
use siloflow_figures::svg::Legend;
use siloflow_files::frames::{Column, FORMAT, Table, Values, WallGeometry};

fn header(dimension: u8) -> Header {
    Header {
        format: FORMAT,
        version: "0.1.0".to_owned(),
        scene: "box".to_owned(),
        title: String::new(),
        dimension,
        species: vec![("small".to_owned(), [1, 2, 3]), ("large".to_owned(), [4, 5, 6])],
        periodic: [Some((0.0, 4.0)), None, None],
        domain: [[0.0; 3], [4.0, 4.0, if dimension == 2 { 0.0 } else { 4.0 }]],
        walls: Vec::new(),
        columns: Vec::new(),
    }
}

fn style(direction: Direction) -> Style {
    Style {
        width: 200.0,
        colour: Colouring::Species,
        network: None,
        camera: Camera::towards(direction),
        cut: None,
        view: (DVec2::ZERO, DVec2::splat(4.0)),
        smallest_radius: 0.5,
        decimals: 2,
        endless: Vec::new(),
    }
}

fn column(name: &str, components: u8, values: Values) -> Column {
    Column { name: name.to_owned(), unit: "m".to_owned(), components, values }
}

/// A frame of grains of radius 0.5 m with their ids, kinds and places.
fn frame(grains: &[(i32, u8, &[f64])]) -> Frame {
    let columns = vec![
        column("id", 1, Values::I32(grains.iter().map(|grain| grain.0).collect())),
        column("kind", 1, Values::U8(grains.iter().map(|grain| grain.1).collect())),
        column("species", 1, Values::U8(vec![1; grains.len()])),
        column("radius", 1, Values::F64(vec![0.5; grains.len()])),
        column("position", 3, Values::F64(grains.iter().flat_map(|grain| grain.2.iter().copied()).collect())),
        column("heat_flow", 1, Values::F64(vec![3.0; grains.len()])),
    ];
    let table = Table { name: "grains".to_owned(), rows: grains.len(), columns };
    Frame { counts: [3, 2, 1, 0], tables: vec![table], ..Frame::default() }
}

fn contacts(rows: &[(i32, i32, f64, u8)]) -> Table {
    Table {
        name: "contacts".to_owned(),
        rows: rows.len(),
        columns: vec![
            column("grain", 1, Values::I32(rows.iter().map(|row| row.0).collect())),
            column("partner", 1, Values::I32(rows.iter().map(|row| row.1).collect())),
            column("normal_force", 1, Values::F64(rows.iter().map(|row| row.2).collect())),
            column("sliding", 1, Values::U8(rows.iter().map(|row| row.3).collect())),
        ],
    }
}

#[test]
fn spheres_are_drawn_from_back_to_front_and_a_cut_opens_the_scene() {
    let grains = frame(&[(0, 0, &[1.0, 1.0, 1.0]), (1, 0, &[2.0, 3.0, 1.0]), (-1, 1, &[3.0, 2.5, 1.0])]);
    let mut front = style(Direction::Front);
    let places = |style: &Style| draw(&header(3), &grains, style).discs.iter().map(|disc| disc.0.x).collect::<Vec<_>>();
    assert_eq!(places(&front), [2.0, 3.0, 1.0]);
    // The middle of the scene is at y = 2 m.
    front.cut = Some(0.0);
    assert_eq!(places(&front), [2.0, 3.0]);
    front.cut = Some(0.7);
    assert_eq!(places(&front), [2.0]);
    let mut back = style(Direction::Back);
    back.view = (DVec2::new(-4.0, 0.0), DVec2::new(0.0, 4.0));
    assert_eq!(places(&back), [-1.0, -3.0, -2.0]);
}

#[test]
fn legend_names_what_is_there() {
    let species = draw(&header(3), &frame(&[(0, 0, &[1.0; 3])]), &style(Direction::Front));
    let Legend::Classes(classes) = species.legend else { panic!("{:?}", species.legend) };
    assert_eq!(classes, [("large".to_owned(), [4, 5, 6])]);
    assert_eq!((species.legend_rows, species.header[2].as_str()), (2, "inside 2, out 1, lost 0 grains"));
    let colour = Colouring::Column { name: "heat_flow".to_owned(), from: 2.0, to: 4.0 };
    let by_column = Style { colour, ..style(Direction::Front) };
    let picture = draw(&header(3), &frame(&[(0, 0, &[1.0; 3])]), &by_column);
    assert!(matches!(&picture.legend, Legend::Scale { from: 2.0, to: 4.0, title, .. } if title == "heat flow, m"));
    assert_eq!(picture.discs[0].2, siloflow_figures::colour::viridis(0.5));
}

#[test]
fn a_column_that_is_not_there_is_refused_with_the_others() {
    for name in ["heat", "position", "velocity"] {
        let colour = Colouring::Column { name: name.to_owned(), from: 0.0, to: 1.0 };
        let style = Style { colour, ..style(Direction::Front) };
        let message = style.check(&frame(&[])).unwrap_err();
        assert!(message.contains("id, kind, species, radius, heat_flow"), "{message}");
    }
    let pressure = Colouring::Pressure(1.0);
    assert!(Style { colour: pressure, ..style(Direction::Front) }.check(&frame(&[])).is_err());
}

#[test]
fn bonds_take_the_short_way_and_the_key_names_the_kinds_that_occur() {
    let mut all = frame(&[(0, 0, &[0.2, 1.0, 1.0]), (1, 0, &[3.4, 1.0, 1.0]), (2, 0, &[2.5, 1.0, 1.0])]);
    all.tables.push(contacts(&[(0, 1, 2.0, 0), (1, 2, 8.0, 0), (0, 2, 0.39, 0), (0, 7, 1.0, 1)]));
    let network = Style { network: Some(4.0), ..style(Direction::Front) };
    let picture = draw(&header(3), &all, &network);
    // Through the periodic side at 0 m, and at most as wide as a radius; no bond below a tenth of the widest, or without partner.
    let ends: Vec<_> = picture.bonds.iter().map(|bond| (bond.0.x, bond.1.x, bond.2)).collect();
    assert_eq!(ends.len(), 2, "{ends:?}");
    assert!((ends[0].1 + 0.6).abs() < 1e-12 && (ends[0].2 - 0.25).abs() < 1e-12, "{ends:?}");
    assert_eq!(ends[1], (3.4, 2.5, 0.5));
    let words = |picture: Picture| picture.key.into_iter().map(|entry| entry.2).collect::<Vec<_>>();
    assert_eq!(words(picture), ["force 0.4 to 4 N"]);
    all.tables[1] = contacts(&[(0, 1, 2.0, 1)]);
    assert_eq!(words(draw(&header(3), &all, &network)), ["sliding, force 0.4 to 4 N"]);
    all.tables[1] = contacts(&[]);
    assert!(words(draw(&header(3), &all, &network)).is_empty());
}

/// A wall of two triangles: the square from (low, low) to (high, high) in x and z at a depth y, m.
fn square(number: u32, y: f64, [low, high]: [f64; 2]) -> WallGeometry {
    let points = vec![[low, y, low], [high, y, low], [high, y, high], [low, y, high]];
    WallGeometry { number, points, triangles: vec![[0, 1, 2], [0, 2, 3]], ..WallGeometry::default() }
}

#[test]
fn walls_are_behind_or_in_front_of_the_grains_and_show_their_borders() {
    let mut header = header(3);
    header.walls = vec![square(1, 0.0, [1.0, 2.0]), square(2, 4.0, [1.0, 3.0])];
    let grains = frame(&[(0, 0, &[2.0; 3])]);
    let front = style(Direction::Front);
    let picture = draw(&header, &grains, &front);
    let area = |patches: &[siloflow_figures::svg::Patch]| {
        let polygons = patches.iter().flat_map(|patch| &patch.polygons);
        polygons.map(|p| 0.5 * (p[1] - p[0]).perp_dot(p[2] - p[0])).sum::<f64>()
    };
    assert!((area(&picture.front) - 1.0).abs() < 1e-12 && (area(&picture.behind) - 4.0).abs() < 1e-12);
    // Four borders; the diagonal is no edge.
    let edges = |patches: &[siloflow_figures::svg::Patch]| patches.iter().map(|patch| patch.edges.len()).sum::<usize>();
    assert_eq!((edges(&picture.front), edges(&picture.behind)), (4, 4));
    // A cut leaves out the wall in front; a wall without ends fills the box of the scene.
    let cut = Style { cut: Some(0.0), endless: vec![2], ..front };
    header.walls[1] = square(2, 4.0, [-90.0, 90.0]);
    let picture = draw(&header, &grains, &cut);
    assert_eq!(edges(&picture.front), 0);
    assert!((picture.behind[0].polygons.len(), edges(&picture.behind)) == (2, 4));
}
