//! Pictures and movies from the frames of a run.
//!
//! The file of frames is read twice: for the times and the ends of colour scales, then for the pictures. So one group of frames is
//! in memory, as many as there are processors.

use std::io;
use std::path::{Path, PathBuf};
use std::thread;

use super::args::RenderArgs;
use super::colours::wanted;
use super::options;
use super::selection::FrameIndex;
use crate::cli::exit_status::ExitStatus;
use crate::cli::export::without_frames;
use crate::cli::progress::Progress;
use crate::cli::{help_to_write, say};
use crate::output::pictures::style::style;
use crate::scene::extent::most_bytes;
use crate::scene::load;
use crate::scene::loaded::{AnyScene, Loaded};
use crate::scene::view;
use siloflow_figures::movie::MovieWriter;
use siloflow_figures::{png, svg};
use siloflow_files::frames::columns::Columns;
use siloflow_files::frames::reader::FrameReader;
use siloflow_files::frames::{Frame, Header};
use siloflow_files::own_files;
use siloflow_files::run_directory::names::PICTURES;
use siloflow_files::run_directory::{
    Depth, PartDirectory, frame_data_of, is_drawn, movie_of, pictures_of, refuse_odd, scene_of,
};
use siloflow_files::whole_file;
use siloflow_results::pictures;
use siloflow_results::pictures::style::Style;
use siloflow_text::fault::Fault;

/// Space of a movie on a slide, px.
const SLIDE: [f64; 2] = [960.0, 720.0];

/// Frames per second of a movie.
const FPS: f64 = 20.0;

/// Shortest and longest time of a frame, ms: programs show a shorter one for longer, and the format has no longer one.
const DELAY_MS: [f64; 2] = [20.0, 60_000.0];

/// The frames to draw, and their style.
struct RenderPlan {
    path: PathBuf,
    /// Most bytes of a frame.
    most: u64,
    style: Style,
    selected: Vec<usize>,
    times: Vec<f64>,
    columns: Columns,
    /// Decimals of the times in file names.
    decimals: usize,
    quiet: bool,
}

pub(super) fn render(args: &RenderArgs, run: &Path, quiet: bool) -> Result<ExitStatus, Fault> {
    refuse_odd(run, Depth::Top)?;
    let path = frame_data_of(run);
    if !own_files::is_file(&path) {
        return Err(without_frames(run, ["render::missing", "render::no_run", "render::method", "render::no_frames"]));
    }
    let scene = load::any(&scene_of(run), &[])?;
    let most = most_bytes(&scene);
    let AnyScene::Grains(loaded) = scene else {
        return Err(Fault::new("render::method", "a lattice gas has no grains").help("its pictures are in frames/"));
    };
    let mut pictures = options::pictures(args, &loaded)?;
    let target = target(args, run)?;
    let read = |error: io::Error| unreadable(&path, &error);
    let reader = FrameReader::open_within(&path, most).map_err(read)?;
    let header = reader.header.clone();
    let wanted = wanted(args.colour.as_ref(), &pictures.colour, &header);
    // The places of grains decide the view of a scene that gives none.
    let camera = pictures.view.is_none().then(|| view::camera(&loaded, &pictures));
    let survey = FrameIndex::of(&header, reader, wanted.name(), camera.as_ref()).map_err(read)?;
    let selected = survey.select(args);
    if selected.is_empty() {
        return Err(Fault::new("render::no_frames", format!("there is no whole frame in {}", path.display()))
            .help("the run was killed before its first frame: run its scene.ron again"));
    }
    if !quiet {
        survey.tell_far_times(args);
    }
    pictures.colour = wanted.colour(survey.range(&selected));
    let mut style = style(&loaded, &pictures);
    if let Some(grains) = survey.box_of_grains {
        style.view = view::around(&loaded, style.view, grains);
    }
    let style = sized(style, args, &header);
    check(&style, &survey.columns, &loaded)?;
    let decimals = decimals(&survey.times, style.decimals);
    let FrameIndex { times, columns, .. } = survey;
    let plan = RenderPlan { path, most, style, selected, times, columns, decimals, quiet };
    if args.movie { movie(args, &header, &plan, &target) } else { several(args, &header, &plan, &target) }
}

/// Where the result goes. It must not exist, or be a drawing that may be replaced.
fn target(args: &RenderArgs, run: &Path) -> Result<PathBuf, Fault> {
    let default = if args.movie { movie_of(run) } else { pictures_of(run) };
    let target = args.out.clone().unwrap_or(default);
    if target.symlink_metadata().is_err() {
        return Ok(target);
    }
    let fault = |message: String, help| Err(Fault::new("render::exists", message).help(help));
    if !args.force {
        let help = "give --force to replace it, or another place with --out";
        return fault(format!("{} exists", target.display()), help);
    }
    if !is_drawn(&target) {
        let help = "remove it yourself, or give another place with --out";
        return fault(format!("{} has files that siloflow has not drawn", target.display()), help);
    }
    Ok(target)
}

/// Returns the style with the width of a movie, if none is given.
fn sized(style: Style, args: &RenderArgs, header: &Header) -> Style {
    if !args.movie || args.width.is_some() {
        return style;
    }
    // Pixels of a picture that is one pixel wide are its height over its width.
    let rows = pictures::rows(header, &style);
    let width = SLIDE[0].min(SLIDE[1] / svg::pixels(1.0, style.view, rows)).floor().max(50.0);
    Style { width, ..style }
}

/// Checks the style with the columns of all frames, before anything is written.
fn check(style: &Style, columns: &Columns, loaded: &Loaded) -> Result<(), Fault> {
    let frame = columns.frame();
    style
        .check(&frame)
        .map_err(|message| Fault::new("render::column", message).help("or give `species`, `speed` or `pressure`"))?;
    if style.network.is_some() && frame.table("contacts").is_none() {
        return Err(Fault::new("render::no_contacts", "the frames of this run hold no contacts")
            .help("run its scene again with `data_frames: (contacts: true)`"));
    }
    let pixels = svg::pixels(style.width, style.view, loaded.largest_species().saturating_add(1).max(4));
    if pixels.is_nan() || pixels > png::MOST_PIXELS {
        let most = png::MOST_PIXELS;
        return Err(Fault::new(
            "render::option",
            format!("a picture would have {pixels:.2e} pixels, more than {most:e}"),
        )
        .help("give a lower --width"));
    }
    Ok(())
}

fn unreadable(path: &Path, error: &io::Error) -> Fault {
    Fault::new("render::read", format!("could not read {}: {error}", path.display()))
        .help("is it a run of this version of siloflow? Else run its scene.ron again")
}

impl RenderPlan {
    /// Draws the selected frames, several at a time, and calls `write` with the number, the frame's time and the result of `draw`.
    fn each<T: Send>(
        &self,
        draw: impl Fn(&Frame) -> Result<T, String> + Sync,
        mut write: impl FnMut(f64, T) -> io::Result<()>,
    ) -> io::Result<()> {
        let reader = FrameReader::open_within(&self.path, self.most)?;
        let mut wanted = self.selected.iter().peekable();
        let mut frames = reader.enumerate().filter_map(|(number, frame)| {
            let is_wanted = wanted.next_if(|next| **next == number).is_some();
            if is_wanted || frame.is_err() { Some(frame.and_then(|frame| self.columns.complete(frame))) } else { None }
        });
        let at_once = thread::available_parallelism().map_or(1, std::num::NonZeroUsize::get);
        let mut progress = Progress::new(self.quiet, 0.0, 0);
        let mut done = 0_usize;
        while done < self.selected.len() {
            let group =
                frames.by_ref().take(at_once.min(self.selected.len() - done)).collect::<io::Result<Vec<_>>>()?;
            if group.is_empty() {
                return Err(io::Error::new(io::ErrorKind::InvalidData, "frames are missing"));
            }
            let drawn: Vec<_> = thread::scope(|scope| {
                let threads: Vec<_> = group.iter().map(|frame| scope.spawn(|| draw(frame))).collect();
                let join = |thread: thread::ScopedJoinHandle<'_, _>| {
                    thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
                };
                threads.into_iter().map(join).collect()
            });
            for (frame, drawn) in group.iter().zip(drawn) {
                write(frame.time, drawn.map_err(io::Error::other)?)?;
                done += 1;
            }
            progress.show(done as u64, |_| format!("{done} of {} frames", self.selected.len()));
        }
        progress.finish();
        Ok(())
    }

    fn svg(&self, header: &Header, frame: &Frame) -> String {
        pictures::draw(header, frame, &self.style).to_svg()
    }

    /// Returns the file name of a frame: its time.
    fn name(&self, time: f64) -> String {
        let decimals = self.decimals;
        let width = self.times.last().map_or(0, |last| format!("{last:.decimals$}").len());
        format!("t_{time:0width$.decimals$}.png")
    }
}

/// Decimals that distinguish the times of any run: steps are far longer than 1e-30 s.
const MOST_DECIMALS: usize = 30;

/// Returns how many decimals distinguish all times, at least `least`.
fn decimals(times: &[f64], least: usize) -> usize {
    let are_distinct = |decimals: &usize| {
        let texts: Vec<_> = times.iter().map(|time| format!("{time:.decimals$}")).collect();
        texts.windows(2).all(|pair| pair[0] != pair[1])
    };
    (least..MOST_DECIMALS).find(are_distinct).unwrap_or(MOST_DECIMALS)
}

/// The fault of a result that could not be written. Nothing has changed.
fn unwritten(path: &Path, target: &Path, error: &io::Error) -> Fault {
    if error.kind() == io::ErrorKind::InvalidData {
        return unreadable(path, error);
    }
    Fault::new("render::write", format!("could not write {}: {error}", target.display())).help(help_to_write(error))
}

fn movie(args: &RenderArgs, header: &Header, plan: &RenderPlan, target: &Path) -> Result<ExitStatus, Fault> {
    #[expect(clippy::cast_precision_loss, reason = "a number of frames")]
    let count = plan.selected.len() as f64;
    let seconds = args.duration.map_or_else(|| 1.0 / args.fps.unwrap_or(FPS), |duration| duration / count);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    let delay_ms = (1000.0 * seconds).round().clamp(DELAY_MS[0], DELAY_MS[1]) as u16;
    let draw = |frame: &Frame| png::pixels(&plan.svg(header, frame));
    let mut size = [0, 0];
    let written = whole_file::write_with(target, |file| {
        let mut writer: Option<MovieWriter<&mut dyn io::Write>> = None;
        let mut file = Some(file);
        plan.each(draw, |_, picture| {
            if let Some(file) = file.take() {
                size = picture.size;
                let frames = u32::try_from(plan.selected.len()).map_err(io::Error::other)?;
                writer = Some(MovieWriter::new(file, size, frames, delay_ms).map_err(io::Error::other)?);
            }
            writer.as_mut().map_or(Ok(()), |writer| writer.add(picture.colours)).map_err(io::Error::other)
        })?;
        writer.map_or(Ok(()), MovieWriter::finish).map_err(io::Error::other)
    });
    written.map_err(|error| unwritten(&plan.path, target, &error))?;
    let bytes = std::fs::metadata(target).map_or(0, |file| file.len());
    #[expect(clippy::cast_precision_loss, reason = "a figure for people")]
    let megabytes = bytes as f64 / 1e6;
    let shown = target.display();
    let duration = count * f64::from(delay_ms) / 1000.0;
    say(&format!("{shown}: {count} frames, {} x {} px, {duration:.1} s, {megabytes:.1} MB\n", size[0], size[1]));
    Ok(ExitStatus::Done)
}

fn several(args: &RenderArgs, header: &Header, plan: &RenderPlan, target: &Path) -> Result<ExitStatus, Fault> {
    let ending = args.out.as_ref().and_then(|out| out.extension()?.to_str());
    let is_svg = ending == Some("svg");
    let draw = |frame: &Frame| {
        let svg = plan.svg(header, frame);
        if is_svg { Ok(svg.into_bytes()) } else { png::encode(&svg) }
    };
    let fault = |error: io::Error| unwritten(&plan.path, target, &error);
    if matches!(ending, Some("svg" | "png")) {
        if plan.selected.len() > 1 {
            let count = plan.selected.len();
            return Err(Fault::new("render::option", format!("{count} pictures do not fit into one file"))
                .help("give a directory with --out, or one time with --at"));
        }
        plan.each(draw, |_, bytes| whole_file::write(target, &bytes)).map_err(fault)?;
        say(&format!("{}\n", target.display()));
        return Ok(ExitStatus::Done);
    }
    let part = PartDirectory::create(target, PICTURES).map_err(fault)?;
    plan.each(draw, |time, bytes| std::fs::write(part.path().join(plan.name(time)), bytes)).map_err(fault)?;
    part.publish(true).map_err(fault)?;
    let names = plan.selected.iter().map(|&number| target.join(plan.name(plan.times[number])));
    for name in names {
        say(&format!("{}\n", name.display()));
    }
    Ok(ExitStatus::Done)
}
