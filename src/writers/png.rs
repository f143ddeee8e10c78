//! Conversion of SVG to PNG. The font is part of the program, so labels do not depend on fonts of the machine.

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use ::png::{ColorType, Compression, Encoder, EncodingError};
use resvg::tiny_skia::{Pixmap, PremultipliedColorU8, Transform};
use resvg::usvg::{Options, Tree, fontdb};

use crate::fault::Fault;
use crate::writers::whole_file;

fn options() -> &'static Options<'static> {
    static OPTIONS: OnceLock<Options<'static>> = OnceLock::new();
    OPTIONS.get_or_init(|| {
        let mut fonts = fontdb::Database::new();
        fonts.load_font_data(epaint_default_fonts::UBUNTU_LIGHT.to_vec());
        let family = fonts.faces().next().and_then(|face| face.families.first()).map(|(name, _)| name.clone());
        if let Some(family) = family {
            fonts.set_sans_serif_family(family);
        }
        Options { fontdb: Arc::new(fonts), ..Options::default() }
    })
}

/// Returns an SVG document as PNG, with the width and height of the document.
///
/// # Errors
/// If it is not a valid SVG document, or too large to draw.
pub fn encode(svg: &str) -> Result<Vec<u8>, String> {
    let tree = Tree::from_str(svg, options()).map_err(|error| error.to_string())?;
    let size = tree.size().to_int_size();
    let mut pixels = Pixmap::new(size.width(), size.height()).ok_or("the picture has no area or is too large")?;
    resvg::render(&tree, Transform::identity(), &mut pixels.as_mut());
    compressed(pixels).map_err(|error| error.to_string())
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
/// If the file cannot be read, is not SVG, or the PNG cannot be written.
pub fn render_file(path: &Path) -> Result<PathBuf, Fault> {
    let path_text = path.display();
    let svg = std::fs::read_to_string(path).map_err(|error| {
        Fault::new("render::read", format!("could not read {path_text}: {error}"))
            .help("give SVG files, or run directories")
    })?;
    let png = encode(&svg).map_err(|error| {
        Fault::new("render::svg", format!("could not draw {path_text}: {error}")).help("is it an SVG document?")
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

    #[test]
    fn invalid_svg_is_an_error() {
        assert!(encode("hello").is_err());
    }
}
