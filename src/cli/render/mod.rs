//! `siloflow render`: converts SVG snapshots to PNG, and draws pictures and movies from the frames of a run.
//!
//! | part | content |
//! |---|---|
//! | `svg_files.rs` | SVG snapshots to PNG |
//! | `args.rs` | the arguments |
//! | `options.rs` | arguments as settings of pictures |
//! | `selection.rs`, `colours.rs` | which frames are drawn; colours and the ends of their scales |
//! | `from_frames.rs` | pictures and movies from `frames.bin` |

pub(super) mod args;
mod colours;
mod from_frames;
mod options;
mod selection;
mod svg_files;

use self::args::RenderArgs;
use crate::cli::exit_status::ExitStatus;
use siloflow_text::fault::Fault;

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
