//! Conversion of SVG to PNG. The font is part of the program, so labels do not depend on fonts of the machine.
//!
//! A document may come from elsewhere. Nothing but its text is read: links to images are not followed, and images inside the
//! document are left out. A document is refused if it has
//!
//! * more than 64 MiB, or more than [`MOST_PIXELS`], or more than about a million elements (a limit of usvg);
//! * effects that draw into layers of their own: filters, masks, clip paths, patterns, and opacity of groups. siloflow's
//!   pictures have none of them, and a short document can nest them so that it takes any time and memory.
//!
//! [`render_file`] also gives up after [`LONGEST_DRAWING`].

use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use ::png::{ColorType, Compression, Encoder, EncodingError};
use resvg::tiny_skia::{Pixmap, PremultipliedColorU8, Transform};
use resvg::usvg::{Group, ImageHrefResolver, Node, Options, Tree, fontdb};

use crate::fault::Fault;
use crate::source::files;
use crate::writers::whole_file;

/// Most pixels of a PNG. While it is drawn, a pixel takes up to 8 bytes.
pub const MOST_PIXELS: f64 = 5.0e7;

/// Most shapes of a PNG, below the limit of usvg, 1,000,000 elements.
pub const MOST_SHAPES: usize = 900_000;

/// Longest time for which [`render_file`] draws a file.
pub const LONGEST_DRAWING: Duration = Duration::from_secs(60);

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
/// If it is not a valid SVG document, too large to draw, or has effects that are not drawn.
pub fn encode(svg: &str) -> Result<Vec<u8>, String> {
    let tree = Tree::from_str(svg, options()).map_err(|error| error.to_string())?;
    if has_layers(&tree) {
        return Err("filters, masks, clip paths, patterns and opacity of groups are not drawn".to_owned());
    }
    let size = tree.size();
    if f64::from(size.width()) * f64::from(size.height()) > MOST_PIXELS {
        return Err(format!("{} x {} pixels are more than the limit of {MOST_PIXELS:e}", size.width(), size.height()));
    }
    let size = size.to_int_size();
    let mut pixels = Pixmap::new(size.width(), size.height()).ok_or("the picture has no area")?;
    resvg::render(&tree, Transform::identity(), &mut pixels.as_mut());
    compressed(pixels).map_err(|error| error.to_string())
}

/// Whether a document has effects that need a layer of pixels of their own.
fn has_layers(tree: &Tree) -> bool {
    let mut groups: Vec<&Group> = vec![tree.root()];
    while let Some(group) = groups.pop() {
        if group.should_isolate() {
            return true;
        }
        groups.extend(group.children().iter().filter_map(|node| match node {
            Node::Group(group) => Some(&**group),
            _ => None,
        }));
    }
    !(tree.filters().is_empty()
        && tree.masks().is_empty()
        && tree.clip_paths().is_empty()
        && tree.patterns().is_empty())
}

/// Calls [`encode`] in a thread of its own, and waits for it at most `longest`. A thread that takes longer goes on until the
/// process ends.
fn encode_within(svg: String, longest: Duration) -> Result<Vec<u8>, String> {
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
    let svg = files::read_text(path, files::RESULT_BYTES).map_err(|error| {
        Fault::new("render::read", format!("could not read {path_text}: {error}"))
            .help("give SVG files, or run directories")
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
        // The same rectangle inside the document.
        let inside = "data:image/svg+xml;base64,PHN2ZyB4bWxucz0iaHR0cDovL3d3dy53My5vcmcvMjAwMC9zdmciIHdpZHRoPSI4MCIgaGVpZ2h0PSIyMCI+PHJlY3Qgd2lkdGg9IjgwIiBoZWlnaHQ9IjIwIi8+PC9zdmc+";
        for href in [other.to_str().unwrap(), "/dev/zero", inside] {
            assert_eq!(dark_pixels(&format!(r#"<image width="80" height="20" href="{href}"/>"#)), 0, "{href}");
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
            r##"<clipPath id="a"><rect width="5" height="5"/></clipPath><rect width="9" height="9" clip-path="url(#a)"/>"##,
            r##"<filter id="a"><feGaussianBlur stdDeviation="5"/></filter><rect width="9" height="9" filter="url(#a)"/>"##,
        ] {
            assert!(encode(&document(layer)).unwrap_err().contains("not drawn"), "{layer}");
        }
        let deep = document(&format!("{}{}", "<g>".repeat(20_000), "</g>".repeat(20_000)));
        assert!(encode_within(deep, LONGEST_DRAWING).is_err());
        let slow = encode_within(document(&"<rect width='80' height='20'/>".repeat(100_000)), Duration::from_nanos(1));
        assert!(slow.unwrap_err().contains("longer than"));
    }

    #[test]
    fn invalid_svg_is_an_error() {
        assert!(encode("hello").is_err());
    }
}
