//! The pictures of a run of the lattice gas, which has no grains to draw, as data of a player.
//!
//! | part | content |
//! |---|---|
//! | first | length of the description (4 bytes); the description in JSON; for each picture its step (8-byte float) and its length (4 bytes) |
//! | second | the pictures as SVG, one after the other |
//!
//! The step is read from the header of a picture. Only `frames/NNNNN.svg` are read.

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use flate2::write::ZlibEncoder;
use serde::Serialize;

use super::bytes::length;
use super::grains::damaged;
use super::packing::{compression, join};
use super::thinning::Thinning;
use siloflow_files::own_files;

/// Largest picture that is read, bytes.
const LARGEST: u64 = 32 << 20;

/// The description of a run that the script needs besides the pictures.
#[derive(Serialize)]
struct Description {
    is_pictures: bool,
    title: &'static str,
    frames: usize,
    frames_of_run: usize,
}

/// Packs the pictures of the run in directory `run` into about `most` characters; `None` if it has none, or is no run of the lattice gas.
///
/// # Errors
/// If a picture cannot be read, or has no step.
pub(super) fn pack(run: &Path, most: usize) -> io::Result<Option<String>> {
    let Some((files, content)) = files(&run.join("frames"))? else { return Ok(None) };
    // The header of a picture of grains has a time.
    if step_of(&own_files::read_text(&files[0], LARGEST)?).is_none() {
        return Ok(None);
    }
    let mut thinning = Thinning::new(files.len(), content);
    // Base64 has four characters for three bytes.
    let most = most / 4 * 3;
    loop {
        let (pictures, steps, lengths) = pack_files(&files, thinning)?;
        if pictures.len() > most && thinning.thin(pictures.len(), steps.len(), most) {
            continue;
        }
        let description = Description {
            is_pictures: true,
            title: "Pictures of the lattice gas",
            frames: steps.len(),
            frames_of_run: files.len(),
        };
        let description = serde_json::to_vec(&description).map_err(io::Error::other)?;
        let mut first = ZlibEncoder::new(Vec::new(), compression());
        first.write_all(&length(description.len()).to_le_bytes())?;
        first.write_all(&description)?;
        first.write_all(&steps.iter().flat_map(|step| step.to_le_bytes()).collect::<Vec<u8>>())?;
        first.write_all(&lengths.iter().flat_map(|length| length.to_le_bytes()).collect::<Vec<u8>>())?;
        return Ok(Some(join(&first.finish()?, &pictures)));
    }
}

/// Returns the pictures of a directory in order, and the number of their bytes; `None` without any.
fn files(directory: &Path) -> io::Result<Option<(Vec<PathBuf>, u64)>> {
    if !own_files::is_directory(directory) {
        return Ok(None);
    }
    let mut files = Vec::new();
    let mut content = 0_u64;
    for entry in own_files::entries(directory)? {
        let entry = entry?;
        let path = entry.path();
        let found = entry.metadata()?;
        if path.extension().is_some_and(|ending| ending == "svg") && found.is_file() {
            if found.len() > LARGEST {
                return Err(damaged(&format!("the picture {} is too large", path.display())));
            }
            content = content.saturating_add(found.len());
            files.push(path);
        }
    }
    files.sort_unstable();
    Ok((!files.is_empty()).then_some((files, content)))
}

fn pack_files(files: &[PathBuf], thinning: Thinning) -> io::Result<(Vec<u8>, Vec<f64>, Vec<u32>)> {
    let mut encoder = ZlibEncoder::new(Vec::new(), compression());
    let mut steps = Vec::new();
    let mut lengths = Vec::new();
    for (_, path) in files.iter().enumerate().filter(|(number, _)| thinning.takes(*number)) {
        let text = own_files::read_text(path, LARGEST)?;
        let step = step_of(&text);
        steps.push(step.ok_or_else(|| damaged(&format!("the picture {} has no step in its header", path.display())))?);
        lengths.push(length(text.len()));
        encoder.write_all(text.as_bytes())?;
    }
    Ok((encoder.finish()?, steps, lengths))
}

/// Returns the step in the header of a picture.
fn step_of(svg: &str) -> Option<f64> {
    let number = svg.split_once(">step ")?.1;
    number.split(|c: char| !c.is_ascii_digit()).next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::super::Packed;
    use super::*;

    fn write(run: &Path, name: &str, text: &str) {
        fs::create_dir_all(run.join("frames")).unwrap();
        fs::write(run.join("frames").join(name), text).unwrap();
    }

    #[test]
    fn pictures_are_in_order_with_their_steps() {
        let run = tempfile::tempdir().unwrap();
        assert!(Packed::of(run.path()).unwrap().is_none());
        for number in [3, 0, 2, 1] {
            write(
                run.path(),
                &format!("0000{number}.svg"),
                &format!("<svg>{}<text>step {}, 3 since</text></svg>", "<path/>".repeat(9000), 200 * number),
            );
        }
        write(run.path(), "00000.png", "no picture of interest");
        let text = pack(run.path(), 1_000_000).unwrap().unwrap();
        let (first, second) = super::super::unpack::parts(&text);
        let from = 4 + u32::from_le_bytes(first[..4].try_into().unwrap()) as usize;
        let description: serde_json::Value = serde_json::from_slice(&first[4..from]).unwrap();
        assert_eq!((&description["title"], &description["frames"]), (&"Pictures of the lattice gas".into(), &4.into()));
        let steps: Vec<f64> =
            first[from..from + 32].as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
        assert_eq!(steps, [0.0, 200.0, 400.0, 600.0]);
        assert_eq!(first.len(), from + 32 + 16);
        assert!(second.starts_with(b"<svg><path/>") && second.ends_with(b"step 600, 3 since</text></svg>"));
        // Two pictures are shown whatever they need.
        assert!(pack(run.path(), 8).unwrap().is_some());
    }

    #[test]
    fn other_pictures_are_left_out_or_errors() {
        let run = tempfile::tempdir().unwrap();
        write(run.path(), "00000.svg", "<svg><text>t = 3 s</text></svg>");
        assert!(pack(run.path(), 1000).unwrap().is_none());
        write(run.path(), "00000.svg", "<svg><text>step 3</text></svg>");
        write(run.path(), "00001.svg", "<svg><text>t = 3 s</text></svg>");
        assert!(pack(run.path(), 1000).is_err());
        fs::write(run.path().join("frames/00001.svg"), [0xff, 0xfe]).unwrap();
        assert!(pack(run.path(), 1000).is_err());
    }
}
