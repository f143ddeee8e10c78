use super::*;
use crate::colour::viridis;
use crate::png;

fn picture(width: f64) -> Picture {
    Picture {
        low: Vector::ZERO,
        high: Vector::new(2.0, 1.0),
        width,
        header: vec!["a < b & c ]]> \u{1b}".to_owned()],
        cells: vec![([0, 0, 255], vec![(Vector::ZERO, Vector::splat(0.5))])],
        labels: vec![(Vector::new(1.0, 0.5), "half".to_owned())],
        discs: vec![(Vector::new(0.5, 0.25), 0.1, [255, 0, 0])],
        ..Picture::default()
    }
}

#[test]
fn metres_map_to_pixels_with_y_up() {
    let svg = picture(200.0).to_svg();
    // The header has (1.35 + 0.7) lines of 5.6 px; the disc is 75 px below the top of a view of 100 px.
    assert!(svg.contains(r##"<circle cx="50.00" cy="86.48" r="10.00" fill="#ff0000"/>"##), "{svg}");
    assert!(svg.contains(r##"<path d="M0.0 111.5H50.0V61.5H0.0Z" fill="#0000ff""##), "{svg}");
    assert!(svg.contains(r#"<text x="100.00" y="61.48""#) && svg.contains(">half<"), "{svg}");
    assert!(svg.contains("a &lt; b &amp; c ]]&gt; \u{fffd}"));
    assert!(svg.contains(">0.5 m<"));
    let lines = 2.05 + 2.6;
    let area = pixels(200.0, (Vector::ZERO, Vector::new(2.0, 1.0)), 1);
    assert!((area - 200.0 * (lines * 5.6 + 100.0)).abs() < 1e-9);
}

#[test]
fn every_title_can_be_drawn() {
    let titles =
        ["]]>", "<!--", "\u{0}\u{1b}[2J\u{ffff}", "\u{202e}\u{200d}\u{301}", "🌾 صومعة 谷仓", &"&".repeat(100_000)];
    for title in titles {
        let svg = Picture { header: vec![title.to_owned()], ..picture(100.0) }.to_svg();
        assert!(svg.len() < 5_000, "{}", svg.len());
        png::encode(&svg).unwrap_or_else(|error| panic!("{title:?}: {error}"));
    }
}

/// Returns the columns and rows of pixels that are not white.
fn ink(svg: &str) -> Vec<(u32, u32)> {
    let bytes = png::encode(svg).unwrap();
    let mut reader = ::png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    let places = (0..info.height).flat_map(|y| (0..info.width).map(move |x| (x, y)));
    places.zip(pixels.chunks(3)).filter(|(_, pixel)| pixel.iter().any(|&c| c < 250)).map(|(place, _)| place).collect()
}

#[test]
fn margins_cover_no_shape_and_their_texts_stay_inside() {
    let long = "a title that is far too long for the space beside a legend, at any width of a picture".to_owned();
    for width in [60.0, 200.0, 600.0] {
        let scale = Legend::Scale { from: 0.0, to: 1.25e-4, title: long.clone(), map: viridis };
        let classes = Legend::Classes(vec![(long.clone(), [0, 0, 255]); 3]);
        for legend in [scale, classes] {
            let empty =
                Picture { header: vec![long.clone(); 3], legend, cells: vec![], labels: vec![], ..picture(width) };
            let empty = Picture { discs: vec![], ..empty };
            let top = top(width, 3);
            let pixels = ink(&empty.to_svg());
            let in_view = pixels.iter().find(|&&(_, y)| (top + 1.0..top + 0.5 * width - 1.0).contains(&f64::from(y)));
            assert_eq!(in_view, None, "{width}, header of {top} px");
            // Texts do not touch the sides, and there is a gap between header and legend.
            let head: Vec<_> = pixels.iter().filter(|&&(_, y)| f64::from(y) < top).collect();
            let side = 0.2 * TEXT * width;
            assert!(head.iter().all(|&&(x, _)| f64::from(x) >= side && f64::from(x) <= width - side), "{width}");
            let columns: std::collections::BTreeSet<u32> = head.iter().map(|&&(x, _)| x).collect();
            let gaps = columns.iter().zip(columns.iter().skip(1)).map(|(a, b)| b - a).max().unwrap();
            assert!(f64::from(gaps) > 0.4 * TEXT * width, "{width}: {gaps}");
        }
    }
}

#[test]
fn outlines_end_at_the_edge_of_their_disc_and_small_discs_have_none() {
    let outlined = Picture { finish: Finish::Outlined, ..picture(200.0) };
    // A disc of 10 px with an outline of 0.32 px.
    assert!(outlined.to_svg().contains(r#"stroke-width="0.32""#) && outlined.to_svg().contains(r#"r="9.84""#));
    let small = Picture { discs: vec![(Vector::ZERO, 0.01, [0; 3])], ..outlined };
    assert!(!small.to_svg().contains("stroke-opacity"));
}

#[test]
fn bonds_of_the_same_width_are_one_path_and_have_a_halo() {
    let bond = |y: f64, width: f64| (Vector::new(0.0, y), Vector::new(2.0, y), width, [0x22; 3]);
    let svg = Picture { bonds: vec![bond(0.1, 0.1), bond(0.2, 0.1), bond(0.3, 1e-9)], ..picture(200.0) }.to_svg();
    assert_eq!(svg.matches(r##"stroke="#ffffff""##).count(), 1, "{svg}");
    assert_eq!(svg.matches(r##"stroke="#222222" stroke-width="10.00""##).count(), 1, "{svg}");
}

#[test]
fn polygons_of_a_patch_are_one_translucent_path() {
    let triangle = vec![Vector::ZERO, Vector::X, Vector::Y];
    let patch = Patch {
        colour: [255, 0, 0],
        opacity: 0.2,
        polygons: vec![triangle.clone(), triangle],
        edges: vec![[Vector::ZERO, Vector::X]],
    };
    let svg = Picture { front: vec![patch], finish: Finish::Shaded, ..picture(200.0) }.to_svg();
    assert_eq!(svg.matches(r#"fill-opacity="0.20""#).count(), 1);
    assert!(svg.contains("url(#sfc0404)") && png::encode(&svg).is_ok(), "{svg}");
}
