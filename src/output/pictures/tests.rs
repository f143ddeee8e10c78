use crate::output::frame_recording::geometry::{SECTORS, walls};
use siloflow_dem::particle::Species;
use siloflow_dem::space::{Solid, Vector};
use siloflow_dem::walls::shapes::revolved::Revolved;
use siloflow_dem::walls::surface::Surface;
use siloflow_dem::walls::surface_wall::SurfaceWall;
use siloflow_files::frames::{Column, FORMAT, Frame, Header, Table, Values};
use siloflow_results::pictures::camera::{Camera, Direction};
use siloflow_results::pictures::draw;
use siloflow_results::pictures::style::{Colouring, Style};

#[test]
fn a_round_wall_shows_its_rims_and_its_outline() {
    let cylinder = Revolved::between(Solid::new(2.0, 2.0, 1.0), Solid::new(2.0, 2.0, 3.0), [1.0, 1.0]);
    let wall = SurfaceWall::still(Surface::Revolved(cylinder), Species(0));
    let header = Header {
        format: FORMAT,
        dimension: 3,
        domain: [[0.0; 3], [4.0; 3]],
        walls: walls(&[wall], [Solid::ZERO, Solid::splat(4.0)]),
        ..Header::default()
    };
    let column = |name: &str, values: Vec<f64>| Column {
        name: name.to_owned(),
        unit: "m".to_owned(),
        components: u8::try_from(values.len()).unwrap(),
        values: Values::F64(values),
    };
    let columns = vec![column("radius", vec![0.5]), column("position", vec![2.0; 3])];
    let frame = Frame { tables: vec![Table { name: "grains".to_owned(), rows: 1, columns }], ..Frame::default() };
    let style = Style {
        width: 200.0,
        colour: Colouring::Species,
        network: None,
        camera: Camera::towards(Direction::Iso),
        cut: None,
        view: (Vector::ZERO, Vector::splat(4.0)),
        smallest_radius: 0.5,
        decimals: 2,
        endless: Vec::new(),
    };
    let picture = draw(&header, &frame, &style);
    let edges = picture.front.iter().chain(&picture.behind).map(|patch| patch.edges.len()).sum::<usize>();
    // Two rims of as many edges as there are sectors, and two lines of the outline.
    assert_eq!(edges, 2 * SECTORS as usize + 2);
}
