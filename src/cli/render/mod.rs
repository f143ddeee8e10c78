//! `siloflow render`: converts SVG snapshots to PNG, and draws pictures and movies from the frames of a run.
//!
//! | part | content |
//! |---|---|
//! | `svg_files.rs` | SVG snapshots to PNG |
//! | `options.rs` | options of the command line as settings of pictures |
//! | `selection.rs`, `colours.rs` | which frames are drawn; colours and the ends of their scales |
//! | `from_frames.rs` | pictures and movies from `frames.bin` |

mod colours;
mod from_frames;
mod options;
mod selection;
mod svg_files;

use std::path::PathBuf;

use clap::Args;

use self::options::{ColourOption, colour, positive};
use crate::cli::exit_status::ExitStatus;
use siloflow_results::pictures::camera::Direction;
use siloflow_text::fault::Fault;

/// Arguments of `render`.
#[derive(Args, Debug)]
#[command(after_help = "\
Without further options, SVG files become PNGs beside them. With any of them, pictures are drawn from frames.bin of one run.

  siloflow run scenes/silo1.ron
  siloflow render out/silo1                                    # PNGs of out/silo1/frames
  siloflow render out/silo1 --at 20 --colour speed=0..2        # out/silo1/pictures/t_20.00.png
  siloflow render out/silo1 --movie                            # out/silo1/movie.png, an animated PNG for a slide
  siloflow render out/silo3d --at 0.5 --view iso --cut --out hopper.png")]
pub(super) struct RenderArgs {
    /// SVG files, directories of them, or run directories; one run directory with the options below.
    #[arg(required = true)]
    paths: Vec<PathBuf>,
    /// Write PNG. It is the default, so this changes nothing.
    #[arg(long)]
    png: bool,
    /// Draw the frame nearest to this time, s. May be repeated. Default: the last frame.
    #[arg(long, value_name = "T", conflicts_with = "every")]
    at: Vec<f64>,
    /// Draw a frame every so many seconds.
    #[arg(long, value_name = "S", value_parser = positive)]
    every: Option<f64>,
    /// Colour grains by species, speed, pressure, or a column of the grains, with the ends of the scale: `speed`, `speed=0..2`,
    /// `coordination=0..6`. Default: as the scene says. Without ends, the scale covers the frames that are drawn.
    #[arg(long, value_name = "COLOUR", value_parser = colour)]
    colour: Option<ColourOption>,
    /// Look from here, in solid space: front, back, left, right (or side), top, bottom, iso, or along a vector such as 1,2,-1.
    #[arg(long, value_name = "DIRECTION", value_parser = Direction::read, allow_hyphen_values = true)]
    view: Option<Direction>,
    /// Leave out what is in front of a plane across the direction of looking: `--cut` through the middle, `--cut=0.02` that many m
    /// behind it.
    #[arg(long, value_name = "M", num_args = 0..=1, require_equals = true, default_missing_value = "0", allow_hyphen_values = true)]
    cut: Option<f64>,
    /// Draw contact forces as bonds; a bond of this force, N, is as wide as the smallest radius.
    #[arg(long, value_name = "N", value_parser = positive)]
    network: Option<f64>,
    /// Width, px. Default: as the scene says; a movie fits into 960 x 720 px.
    #[arg(long, value_name = "PX", value_parser = positive)]
    width: Option<f64>,
    /// Write a movie: an animated PNG, which browsers and presentation programs play. Without --every it has at most 200 frames.
    #[arg(long)]
    movie: bool,
    /// Frames per second of the movie, at most 50. Default: 20.
    #[arg(long, value_name = "N", value_parser = positive, requires = "movie", conflicts_with = "duration")]
    fps: Option<f64>,
    /// Duration of the movie, s, instead of --fps.
    #[arg(long, value_name = "S", value_parser = positive, requires = "movie")]
    duration: Option<f64>,
    /// The file to write (.png, or .svg for one picture), or the directory for several pictures. Default: pictures/ or movie.png in
    /// the run directory.
    #[arg(long, value_name = "PATH")]
    out: Option<PathBuf>,
    /// Replace what --out names, if siloflow has drawn it.
    #[arg(long)]
    force: bool,
}

impl RenderArgs {
    fn is_from_frames(&self) -> bool {
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

pub(super) fn render(args: &RenderArgs, quiet: bool) -> Result<ExitStatus, Fault> {
    if !args.is_from_frames() {
        return svg_files::render(&args.paths);
    }
    let [run] = &args.paths[..] else {
        return Err(Fault::new("render::one_run", "pictures are drawn from the frames of one run at a time")
            .help("give one run directory"));
    };
    from_frames::render(args, run, quiet)
}
