//! Conversion of SVG to PNG. The font is part of the program, so labels do not depend on fonts of the machine.
//!
//! A document may come from elsewhere. Nothing but its text is read, and only what siloflow's own pictures consist of is drawn. A
//! document is refused if it has
//!
//! * more than 64 MiB, more than [`MOST_PIXELS`], or about a million elements (a limit of usvg);
//! * elements other than [`ELEMENTS`], so no images, links, styles, masks and patterns; or opacity or filters of groups. A short
//!   document can nest such effects so that it takes any time and memory;
//! * a label of more than [`LONGEST_LABEL`] characters, whose time grows with the square of its length;
//! * coordinates beyond [`FARTHEST`], for which tiny-skia panics.
//!
//! [`render_file`] also gives up after [`LONGEST_DRAWING`].

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use ::png::{ColorType, Compression, Encoder, EncodingError};
use resvg::tiny_skia::{Pixmap, PremultipliedColorU8, Transform};
use resvg::usvg::roxmltree::{self, Document};
use resvg::usvg::{Group, ImageHrefResolver, Node, Options, Tree, fontdb};

use siloflow_files::whole_file;
use siloflow_text::fault::Fault;
use siloflow_text::file;

/// Most pixels of a PNG. While it is drawn, a pixel takes up to 8 bytes.
pub const MOST_PIXELS: f64 = 5.0e7;

/// Most shapes of a PNG, below the limit of usvg, 1,000,000 elements.
pub const MOST_SHAPES: usize = 900_000;

/// Most pixels along a side of a PNG.
const LONGEST_SIDE: u32 = 200_000;

/// Elements of siloflow's pictures and figures.
pub const ELEMENTS: [&str; 13] = [
    "svg",
    "g",
    "rect",
    "circle",
    "line",
    "path",
    "polygon",
    "polyline",
    "text",
    "tspan",
    "linearGradient",
    "radialGradient",
    "stop",
];

/// Most characters of a label.
pub const LONGEST_LABEL: usize = 1000;

/// Largest coordinate of a shape, px. [`svg`](crate::svg) writes no larger ones.
pub const FARTHEST: f64 = 1.0e7;

/// Longest time for which [`render_file`] draws a file.
pub const LONGEST_DRAWING: Duration = Duration::from_mins(1);

/// Stack of the thread that draws a file. usvg follows up to 1024 nested elements.
const STACK: usize = 64 << 20;

fn options() -> &'static Options<'static> {
    static OPTIONS: OnceLock<Options<'static>> = OnceLock::new();
    OPTIONS.get_or_init(|| {
        let mut fonts = fontdb::Database::new();
        fonts.load_font_data(epaint_default_fonts::UBUNTU_LIGHT.to_vec());
        let family = fonts.faces().next().and_then(|face| face.families.first()).map(|(name, _)| name.clone());
        if let Some(family) = family {
            fonts.set_sans_serif_family(family);
        }
        let no_images =
            ImageHrefResolver { resolve_data: Box::new(|_, _, _| None), resolve_string: Box::new(|_, _| None) };
        Options { fontdb: Arc::new(fonts), image_href_resolver: no_images, ..Options::default() }
    })
}

/// Returns an SVG document as PNG, with the width and height of the document.
///
/// # Errors
/// If it is not a valid SVG document, or has something that is not drawn.
pub fn encode(svg: &str) -> Result<Vec<u8>, String> {
    compressed(draw(svg)?).map_err(|error| error.to_string())
}

/// Returns an SVG document as pixels: width and height, and red, green and blue of each pixel, by rows from above.
/// Transparent pixels are black.
///
/// # Errors
/// As [`encode`].
pub fn pixels(svg: &str) -> Result<([u32; 2], Vec<u8>), String> {
    let pixels = draw(svg)?;
    let colours = pixels.pixels().iter().flat_map(|pixel| [pixel.red(), pixel.green(), pixel.blue()]).collect();
    Ok(([pixels.width(), pixels.height()], colours))
}

fn draw(svg: &str) -> Result<Pixmap, String> {
    let document = Document::parse(svg).map_err(|error| error.to_string())?;
    check_elements(&document)?;
    let tree = Tree::from_xmltree(&document, options()).map_err(|error| error.to_string())?;
    check_groups(&tree)?;
    let size = tree.size().to_int_size();
    let width = size.width();
    let height = size.height();
    if width.max(height) > LONGEST_SIDE || f64::from(width) * f64::from(height) > MOST_PIXELS {
        return Err(format!("{width} x {height} pixels are more than the limit of {MOST_PIXELS:e}"));
    }
    let mut pixels = Pixmap::new(width, height).ok_or("the picture has no area")?;
    // A defect of the renderer is an error of this picture only.
    let render = AssertUnwindSafe(|| resvg::render(&tree, Transform::identity(), &mut pixels.as_mut()));
    catch_unwind(render).map_err(|_| "the renderer failed".to_owned())?;
    Ok(pixels)
}

/// Checks the elements of a document, and the lengths of its labels.
fn check_elements(document: &Document) -> Result<(), String> {
    for element in document.descendants().filter(roxmltree::Node::is_element) {
        let name = element.tag_name().name();
        if !ELEMENTS.contains(&name) {
            return Err(format!(
                "the element `{name}` is not drawn; pictures of siloflow have only {}",
                ELEMENTS.join(", ")
            ));
        }
        let texts = || element.descendants().filter(roxmltree::Node::is_text).filter_map(|text| text.text());
        if name == "text" && texts().map(|text| text.chars().count()).sum::<usize>() > LONGEST_LABEL {
            return Err(format!("a label has more than {LONGEST_LABEL} characters"));
        }
    }
    Ok(())
}

/// Checks that no group needs a layer of pixels of its own, and that shapes are not too far away.
fn check_groups(tree: &Tree) -> Result<(), String> {
    let mut groups: Vec<&Group> = vec![tree.root()];
    while let Some(group) = groups.pop() {
        if group.should_isolate() {
            return Err("filters and opacity of groups are not drawn".to_owned());
        }
        for node in group.children() {
            let bounds = node.abs_bounding_box();
            let farthest = [bounds.left(), bounds.top(), bounds.right(), bounds.bottom()].map(|x| f64::from(x.abs()));
            // A circle at the limit reaches twice as far.
            if farthest.into_iter().fold(0.0, f64::max) > 2.5 * FARTHEST {
                return Err(format!("a shape reaches farther than {FARTHEST:e} px"));
            }
            if let Node::Group(group) = node {
                groups.push(group);
            }
        }
    }
    Ok(())
}

/// Calls [`encode`] in a thread of its own, and waits for it at most `longest`. A thread that takes longer goes on until the
/// process ends.
///
/// # Errors
/// As [`encode`]; also if the time is over.
pub fn encode_within(svg: String, longest: Duration) -> Result<Vec<u8>, String> {
    let (sender, result) = channel();
    let draw = move || {
        // After the time is over, nobody waits for the result.
        let _ = sender.send(encode(&svg));
    };
    let thread = std::thread::Builder::new().stack_size(STACK).spawn(draw);
    thread.map_err(|error| format!("could not start a thread: {error}"))?;
    result.recv_timeout(longest).unwrap_or_else(|error| match error {
        RecvTimeoutError::Timeout => Err(format!("it takes longer than {} s", longest.as_secs_f64())),
        RecvTimeoutError::Disconnected => Err("the drawing failed".to_owned()),
    })
}

/// Encodes pixels as PNG with fast compression, which is sufficient for a few colours on white.
fn compressed(pixels: Pixmap) -> Result<Vec<u8>, EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, pixels.width(), pixels.height());
    encoder.set_compression(Compression::Fast);
    let is_opaque = pixels.pixels().iter().all(PremultipliedColorU8::is_opaque);
    encoder.set_color(if is_opaque { ColorType::Rgb } else { ColorType::Rgba });
    let colours = if is_opaque {
        pixels.pixels().iter().flat_map(|pixel| [pixel.red(), pixel.green(), pixel.blue()]).collect()
    } else {
        pixels.take_demultiplied()
    };
    encoder.write_header()?.write_image_data(&colours)?;
    Ok(bytes)
}

/// Renders an SVG file to a PNG beside it and returns its path.
///
/// # Errors
/// If the file cannot be read, is not SVG, is beyond the limits, or the PNG cannot be written.
pub fn render_file(path: &Path) -> Result<PathBuf, Fault> {
    let path_text = path.display();
    let svg = file::read_text(path, file::RESULT_BYTES).map_err(|error| {
        Fault::new("render::read", format!("could not read {path_text}: {error}"))
            .help(file::remedy(&error, "give SVG files, or run directories"))
    })?;
    let png = encode_within(svg, LONGEST_DRAWING).map_err(|error| {
        Fault::new("render::svg", format!("could not draw {path_text}: {error}"))
            .help("is it an SVG picture of siloflow?")
    })?;
    let target = path.with_extension("png");
    whole_file::write(&target, &png).map_err(|error| {
        Fault::new("render::write", format!("could not write {}: {error}", target.display()))
            .help("check free disk space and write permission")
    })?;
    Ok(target)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dark_pixels(body: &str) -> usize {
        let svg = format!(r#"<svg xmlns="http://www.w3.org/2000/svg" width="80" height="20">{body}</svg>"#);
        let pixels = Pixmap::decode_png(&encode(&svg).unwrap()).unwrap();
        pixels.pixels().iter().filter(|pixel| pixel.alpha() > 128).count()
    }

    #[test]
    fn labels_are_drawn_without_fonts_of_the_machine() {
        let label = r#"<text x="2" y="15" font-size="14" font-family="sans-serif">t = 1.0 s</text>"#;
        assert!(dark_pixels(label) > 50, "{}", dark_pixels(label));
        assert_eq!(dark_pixels(""), 0);
    }

    fn document(body: &str) -> String {
        format!(r#"<svg xmlns="http://www.w3.org/2000/svg" width="80" height="20">{body}</svg>"#)
    }

    #[test]
    fn no_other_file_is_read() {
        let here = tempfile::tempdir().unwrap();
        let other = here.path().join("other.svg");
        std::fs::write(&other, document(r#"<rect width="80" height="20"/>"#)).unwrap();
        for href in [other.to_str().unwrap(), "/dev/zero"] {
            let image = document(&format!(r#"<image width="80" height="20" href="{href}"/>"#));
            assert!(encode(&image).unwrap_err().contains("`image` is not drawn"), "{href}");
            let tree = Tree::from_str(&image, options()).unwrap();
            assert!(tree.root().children().is_empty(), "the resolver itself reads nothing");
        }
        let entity = format!(r#"<!DOCTYPE svg [<!ENTITY a SYSTEM "{}">]>"#, other.display());
        assert!(encode(&(entity + &document("<text>&a;</text>"))).is_err());
    }

    #[test]
    fn documents_beyond_the_limits_are_refused() {
        let large = document("").replace("80", "8000000");
        assert!(encode(&large).unwrap_err().contains("more than the limit"));
        for layer in [
            r#"<g opacity="0.5"><rect width="9" height="9"/></g>"#,
            r#"<clipPath id="a"><rect width="5" height="5"/></clipPath><rect width="9" height="9" clip-path="url(#a)"/>"#,
            r#"<g filter="blur(5)"><rect width="9" height="9"/></g>"#,
            r##"<g id="a"/><use href="#a"/>"##,
            "<style>rect { fill: red }</style>",
        ] {
            assert!(encode(&document(layer)).unwrap_err().contains("not drawn"), "{layer}");
        }
        let deep = document(&format!("{}{}", "<g>".repeat(20_000), "</g>".repeat(20_000)));
        assert!(encode_within(deep, LONGEST_DRAWING).is_err());
        assert!(encode(&document(&format!("<text>{}</text>", "a".repeat(2000)))).unwrap_err().contains("label"));
        for shape in [r#"<circle r="1e30"/>"#, r#"<line x1="0" y1="0" x2="1e9" y2="9" stroke="red"/>"#] {
            assert!(encode(&document(shape)).unwrap_err().contains("farther"), "{shape}");
        }
        let thin = r#"<svg xmlns="http://www.w3.org/2000/svg" width="1e-3" height="1e10"><circle r="9"/></svg>"#;
        assert!(encode(thin).unwrap_err().contains("limit"));
        let slow = encode_within(document(&"<rect width='80' height='20'/>".repeat(100_000)), Duration::from_nanos(1));
        assert!(slow.unwrap_err().contains("longer than"));
    }

    #[test]
    fn invalid_svg_is_an_error() {
        assert!(encode("hello").is_err());
    }
}
