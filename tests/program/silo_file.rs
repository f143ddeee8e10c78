//! Reconstructs the silo files in `assets` from their descriptions and compares them.

use siloflow::dem::space::Vector;
use siloflow::dem::values::LengthUnit;
use siloflow::dem::walls::enclosure::Enclosure;
use siloflow::dem::walls::silo_file::{Disc, parse};

/// Returns the disc centres of `silo1.dat`, cm. Two sides x = +-130 from y = 400 down to 200, every 5; slopes of 46
/// further discs each, ending at (+-15, 0). A roof of 9 discs around its apex (0, 260), falling at 45 degrees, every 5.
/// A door from x = -10 to 10, every 5, at y = 0. All radii are 3 cm.
fn described() -> Vec<Vector> {
    let mut centres = Vec::new();
    for side in [-1.0, 1.0] {
        centres.extend((0..41).map(|k| Vector::new(side * 130.0, 400.0 - 5.0 * f64::from(k))));
        centres.extend(
            (1..47).map(|k| f64::from(k) / 46.0).map(|t| Vector::new(side * (130.0 - 115.0 * t), 200.0 - 200.0 * t)),
        );
    }
    let step = 5.0 / 2f64.sqrt();
    centres.push(Vector::new(0.0, 260.0));
    for side in [-1.0, 1.0] {
        centres.extend((1..5).map(|k| f64::from(k) * step).map(|d| Vector::new(side * d, 260.0 - d)));
    }
    centres.extend((-2..3).map(|k| Vector::new(5.0 * f64::from(k), 0.0)));
    centres
}

#[test]
fn silo1_file_matches_its_description() {
    let text = std::fs::read_to_string(crate::root().join("assets/silo1.dat")).unwrap();
    let silo = parse("silo1.dat", &text, LengthUnit::Centimetre).unwrap();
    assert_eq!((silo.wall.len(), silo.door.len()), (183, 5));
    let discs: Vec<Disc> = silo.wall.iter().chain(&silo.door).copied().collect();
    for (disc, centre) in discs.iter().zip(described()) {
        // The file has four digits: half a unit of the last digit is 0.05 cm at 100 to 400 cm.
        assert!((disc.centre - 0.01 * centre).abs().max_element() <= 0.000_501, "{disc:?} {centre}");
        assert_eq!(disc.radius, 0.03);
    }
    assert!(text.starts_with("183 5\n-1.300e+02 4.000e+02 3.000e+00\n-1.300e+02 3.950e+02 3.000e+00\n-1.300e+02 3.900e+02 3.000e+00\n-1.300e+02 3.850e+02 3.000e+00\n"));
}

#[test]
fn outline_of_silo1_is_two_chains_and_a_roof_with_one_orifice() {
    let text = std::fs::read_to_string(crate::root().join("assets/silo1.dat")).unwrap();
    let silo = parse("silo1.dat", &text, LengthUnit::Centimetre).unwrap();
    let outline = Enclosure::new(&silo.wall, &silo.door, &[], 0.03);
    // 87 discs per side and 9 in the roof: chains of 86, 86 and 8 links, without chords.
    assert_eq!(outline.links().len(), 86 + 86 + 8);
    let orifice = outline.orifice().unwrap();
    assert_eq!((orifice.from.x.abs(), orifice.to.x, orifice.from.y, orifice.to.y), (0.15, -orifice.from.x, 0.0, 0.0));
}

/// Returns the disc centres of the mass-flow silo, m. Its wall grains of 1 cm are behind the faces. On each side there
/// are 101 steps from the flank, which touches the face and the vertical line through (0.1, 0), to the corner. From
/// there to the top there are 200 steps. The door is from x = -9 to 9 cm, every cm, with its top at y = 0.
fn mass_flow_described() -> Vec<Vector> {
    let r = 0.01;
    let tan_15 = 2.0 - 3f64.sqrt();
    let flank = Vector::new(0.1 + r, -r * tan_15);
    let corner = Vector::new(0.602 + r, 0.8695 - r * tan_15);
    let top = Vector::new(0.602 + r, 2.865);
    let slope = (0..=101).map(|k| flank.lerp(corner, f64::from(k) / 101.0));
    let side: Vec<_> = slope.chain((1..=200).map(|k| corner.lerp(top, f64::from(k) / 200.0))).collect();
    let mirrored = side.iter().map(|x| Vector::new(-x.x, x.y));
    let door = (-9..=9).map(|k| Vector::new(0.01 * f64::from(k), -r));
    mirrored.chain(side.iter().copied()).chain(door).collect()
}

#[test]
fn mass_flow_silo_file_matches_its_description() {
    let text = std::fs::read_to_string(crate::root().join("assets/silo2d.dat")).unwrap();
    let silo = parse("silo2d.dat", &text, LengthUnit::Metre).unwrap();
    assert_eq!((silo.wall.len(), silo.door.len()), (604, 19));
    let discs: Vec<Disc> = silo.wall.iter().chain(&silo.door).copied().collect();
    for (disc, centre) in discs.iter().zip(mass_flow_described()) {
        // The file has six digits: half a unit of the last digit at 1 to 3 m.
        assert!((disc.centre - centre).abs().max_element() <= 0.000_005_01, "{disc:?} {centre}");
        assert_eq!(disc.radius, 0.01);
    }
    let outline = Enclosure::new(&silo.wall, &silo.door, &[], 0.009);
    assert_eq!(outline.links().len(), 2 * 301);
    let orifice = outline.orifice().unwrap();
    assert_eq!((orifice.from.x.abs(), orifice.to.x), (0.11, -orifice.from.x));
}

#[test]
fn faces_of_the_mass_flow_silo_are_its_polygon() {
    let text = std::fs::read_to_string(crate::root().join("assets/silo2d.dat")).unwrap();
    let silo = parse("silo2d.dat", &text, LengthUnit::Metre).unwrap();
    let foot = Vector::new(0.1, 0.0);
    let corner = Vector::new(0.602, 0.8695);
    let along = (corner - foot).normalize();
    for disc in &silo.wall {
        let x = Vector::new(disc.centre.x.abs(), disc.centre.y);
        let from_slope = (x - foot).dot(-along.perp());
        let from_side = x.x - corner.x;
        // Each disc touches the slope or the side from outside, to half a digit of the file.
        assert!((from_slope.max(from_side) - 0.01).abs() < 1e-5, "{disc:?} {from_slope} {from_side}");
        assert!(x.x - 0.01 > 0.1 - 1e-9, "the outlet is less than 0.2 m wide: {disc:?}");
    }
}
