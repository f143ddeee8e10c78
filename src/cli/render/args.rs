//! The arguments of `render`.

use std::path::PathBuf;

use clap::Args;

use siloflow_dem::values::Positive;
use siloflow_results::pictures::camera::Direction;

/// Arguments of `render`.
#[derive(Args, Debug)]
#[command(after_help = "\
Without further options, SVG files become PNGs beside them. With any of them, pictures are drawn from frames.bin of one run.

  siloflow run scenes/silo1.ron
  siloflow render out/silo1                                    # PNGs of out/silo1/frames
  siloflow render out/silo1 --at 20 --colour speed=0..2        # out/silo1/pictures/t_20.00.png
  siloflow render out/silo1 --movie                            # out/silo1/movie.png, an animated PNG for a slide
  siloflow render out/silo3d --at 0.5 --view iso --cut --out hopper.png")]
pub(in crate::cli) struct RenderArgs {
    /// SVG files, directories of them, or run directories; one run directory with the options below.
    #[arg(required = true)]
    pub(super) paths: Vec<PathBuf>,
    /// Write PNG. It is the default, so this changes nothing.
    #[arg(long)]
    pub(super) png: bool,
    /// Draw the frame nearest to this time, s. May be repeated. Default: the last frame.
    #[arg(long, value_name = "T", conflicts_with = "every")]
    pub(super) at: Vec<f64>,
    /// Draw a frame every so many seconds.
    #[arg(long, value_name = "S", value_parser = positive)]
    pub(super) every: Option<f64>,
    /// Colour grains by species, speed, pressure, or a column of the grains, with the ends of the scale: `speed`, `speed=0..2`,
    /// `coordination=0..6`. Default: as the scene says. Without ends, the scale covers the frames that are drawn.
    #[arg(long, value_name = "COLOUR", value_parser = colour)]
    pub(super) colour: Option<ColourOption>,
    /// Look from here, in solid space: front, back, left, right (or side), top, bottom, iso, or along a vector such as 1,2,-1.
    #[arg(long, value_name = "DIRECTION", value_parser = Direction::read, allow_hyphen_values = true)]
    pub(super) view: Option<Direction>,
    /// Leave out what is in front of a plane across the direction of looking: `--cut` through the middle, `--cut=0.02` that many m
    /// behind it.
    #[arg(long, value_name = "M", num_args = 0..=1, require_equals = true, default_missing_value = "0", allow_hyphen_values = true)]
    pub(super) cut: Option<f64>,
    /// Draw contact forces as bonds; a bond of this force, N, is as wide as the smallest radius, and forces below a tenth of it are left out.
    #[arg(long, value_name = "N", value_parser = positive)]
    pub(super) network: Option<f64>,
    /// Width, px. Default: as the scene says; a movie fits into 960 x 720 px.
    #[arg(long, value_name = "PX", value_parser = positive)]
    pub(super) width: Option<f64>,
    /// Write a movie: an animated PNG, which browsers and presentation programs play. Without --every it has at most 200 frames.
    #[arg(long)]
    pub(super) movie: bool,
    /// Frames per second of the movie, at most 50. Default: 20.
    #[arg(long, value_name = "N", value_parser = positive, requires = "movie", conflicts_with = "duration")]
    pub(super) fps: Option<f64>,
    /// Duration of the movie, s, instead of --fps.
    #[arg(long, value_name = "S", value_parser = positive, requires = "movie")]
    pub(super) duration: Option<f64>,
    /// The file to write (.png, or .svg for one picture), or the directory for several pictures. Default: pictures/ or movie.png in
    /// the run directory.
    #[arg(long, value_name = "PATH")]
    pub(super) out: Option<PathBuf>,
    /// Replace what --out names, if siloflow has drawn it.
    #[arg(long)]
    pub(super) force: bool,
}

impl RenderArgs {
    pub(super) fn is_from_frames(&self) -> bool {
        !self.at.is_empty()
            || self.every.is_some()
            || self.colour.is_some()
            || self.view.is_some()
            || self.cut.is_some()
            || self.network.is_some()
            || self.width.is_some()
            || self.movie
            || self.out.is_some()
    }
}

/// The colour that the command line asks for: a name, and the ends of the scale if they are given.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ColourOption {
    pub name: String,
    pub ends: Option<(f64, f64)>,
}

/// Reads `name`, or `name=LOW..HIGH`.
fn colour(text: &str) -> Result<ColourOption, String> {
    let Some((name, ends)) = text.split_once('=') else {
        return Ok(ColourOption { name: text.trim().to_owned(), ends: None });
    };
    let expected = "expected the ends of the scale as LOW..HIGH, for example speed=0..2";
    let (low, high) = ends.split_once("..").ok_or(expected)?;
    let [low, high]: [Result<f64, _>; 2] = [low, high].map(|end| end.trim().parse());
    match (low, high) {
        (Ok(low), Ok(high)) if low.is_finite() && high.is_finite() && low < high => {
            Ok(ColourOption { name: name.trim().to_owned(), ends: Some((low, high)) })
        }
        _ => Err(expected.to_owned()),
    }
}

/// Reads a number greater than 0.
fn positive(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| format!("expected a number, got `{text}`"))?;
    Positive::try_from(number).map(Positive::get)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_have_a_name_and_maybe_ends() {
        let option = |name: &str, ends| Ok(ColourOption { name: name.to_owned(), ends });
        assert_eq!(colour("speed"), option("speed", None));
        assert_eq!(colour("heat=-1.5..2e3"), option("heat", Some((-1.5, 2e3))));
        for wrong in ["speed=2", "speed=2..1", "speed=0..inf", "speed=..", "speed=a..b"] {
            assert!(colour(wrong).is_err(), "{wrong}");
        }
    }
}
