//! The pictures of a run: `frames/NNNNN.svg` every `pictures.interval` seconds and at the end, and PNGs if the scene wants them.
//!
//! A picture is drawn by the thread that writes it, from the frame of the same step that goes into `frames.bin`. If there is no
//! such frame, or it lacks the contacts or walls of the picture, a frame is made for the picture.

pub mod style;

#[cfg(test)]
mod tests;

use std::marker::PhantomData;
use std::path::PathBuf;
use std::sync::Arc;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use bevy_ecs::system::RunSystemOnce as _;

use crate::measure::outputs;
use crate::measure::times::Times;
use crate::measure::{ObserveStage, due, observe_every};
use crate::output::frame_recording::{self, Content, FramesRecorded, Observed, Recording};
use crate::scene::loaded::Loaded;
use crate::scene::outputs::{Colour, DataFrames, Pictures};
use crate::writers::picture_writer::PictureWriter;
use crate::writers::run_path::RunPath;
use siloflow_dem::outcome::{Failure, Outcome};
use siloflow_dem::space::Space;
use siloflow_dem::step::Step;
use siloflow_figures::svg::Picture;
use siloflow_files::frames::Header;
use siloflow_results::pictures::draw;
use siloflow_results::pictures::style::Style;
use siloflow_text::fault::Fault;

/// Draws the pictures of a run.
pub struct PicturesPlugin<V: Space> {
    pictures: Pictures,
    /// Directory of the pictures.
    directory: PathBuf,
    drawing: Drawing,
    /// Whether the columns of behaviours are computed for the pictures.
    has_own_columns: bool,
    space: PhantomData<V>,
}

/// The data that the pictures of a run share.
#[derive(Resource, Clone)]
struct Drawing {
    header: Arc<Header>,
    style: Arc<Style>,
    /// The content that a picture needs of a frame.
    content: Content,
}

impl<V: Space> PicturesPlugin<V> {
    /// Returns the plugin of a scene, whose pictures go to `directory`; `None` if the scene wants no pictures. The world has the
    /// columns that behaviours have registered.
    ///
    /// # Errors
    /// If grains have no column of the name that the scene gives as their colour.
    pub fn of(loaded: &Loaded, world: &World, directory: PathBuf) -> Result<Option<Self>, Fault> {
        let Some(pictures) = loaded.scene.pictures.clone() else { return Ok(None) };
        let header = frame_recording::header::<V>(loaded, &DataFrames::default(), world);
        check_colour(loaded, &pictures.colour, &header)?;
        let style = self::style::style(loaded, &pictures);
        let is_measured = matches!(pictures.colour, Colour::Pressure(_) | Colour::Column(..));
        let content = Content::new(&header, style.network.is_some(), true, is_measured);
        let drawing = Drawing { header: Arc::new(header), style: Arc::new(style), content };
        // Where frames are recorded at the same times, they compute the columns of behaviours.
        let is_recorded = loaded.data_frames().is_some_and(|(_, times)| times == Times::every(pictures.interval.get()));
        let has_own_columns = is_measured && !is_recorded;
        Ok(Some(Self { pictures, directory, drawing, has_own_columns, space: PhantomData }))
    }
}

/// Draws the grains of a world as they are, with the scene's `pictures` or, without that key, as its default has them.
///
/// # Errors
/// If grains have no column of the name that the scene gives as their colour.
pub fn of_world<V: Space>(loaded: &Loaded, world: &mut World) -> Result<Picture, Fault> {
    let pictures = loaded.scene.pictures.clone().unwrap_or_default();
    let header = frame_recording::header::<V>(loaded, &DataFrames::default(), world);
    check_colour(loaded, &pictures.colour, &header)?;
    let style = self::style::style(loaded, &pictures);
    let is_measured = matches!(pictures.colour, Colour::Pressure(_) | Colour::Column(..));
    let content = Content::new(&header, style.network.is_some(), true, is_measured);
    let frame = world.run_system_once(move |observed: Observed<V>| observed.frame(&content));
    let frame = frame.map_err(|error| error.to_string()).and_then(|frame| style.check(&frame).map(|()| frame));
    let frame = frame.map_err(|reason| loaded.fault("picture::colour", "pictures.colour", reason))?;
    Ok(draw(&header, &frame, &style))
}

fn check_colour(loaded: &Loaded, colour: &Colour, header: &Header) -> Result<(), Fault> {
    let Colour::Column(name, ..) = colour else { return Ok(()) };
    let registered = header.columns.iter().map(|column| column.name.as_str());
    let columns: Vec<_> = Colour::COLUMNS.into_iter().chain(registered).collect();
    if columns.contains(&name.as_str()) {
        return Ok(());
    }
    let message = format!("grains have no column `{name}` of one number");
    let help = format!("the columns are {}", columns.join(", "));
    Err(loaded.fault("scene::no_such_column", "pictures.colour", message).help(help))
}

fn draw_frame<V: Space>(
    observed: Observed<V>,
    recording: Option<Res<Recording>>,
    drawing: Res<Drawing>,
    mut picture_writer: ResMut<PictureWriter>,
    mut outcome: ResMut<Outcome>,
) {
    let wanted = &drawing.content;
    let has_all = |recording: &Recording| {
        (recording.content.contacts || !wanted.contacts) && (recording.content.walls || !wanted.walls)
    };
    let recorded = recording.filter(|recording| has_all(recording)).and_then(|recording| recording.latest.clone());
    let recorded = recorded.filter(|frame| frame.step == observed.clock.steps);
    let frame = recorded.unwrap_or_else(|| Arc::new(observed.frame(wanted)));
    if let Err(reason) = drawing.style.check(&frame) {
        outcome.fail(Failure::Output { path: "a picture with the scene's `pictures.colour`".to_owned(), reason });
        return;
    }
    let Drawing { header, style, .. } = drawing.clone();
    picture_writer.add(move || draw(&header, &frame, &style), &mut outcome);
}

impl<V: Space> Plugin for PicturesPlugin<V> {
    fn build(&self, app: &mut App) {
        observe_every::<Pictures>(app, self.pictures.interval.get());
        if self.has_own_columns {
            outputs::compute_grain_columns(app, due::<Pictures>);
        }
        PictureWriter::persist(app);
        let writer = PictureWriter::new(self.directory.clone(), self.pictures.png);
        let writer = writer.recorded_in(app.world().get_resource::<RunPath>().map(|run| &run.files));
        let draw = draw_frame::<V>.in_set(ObserveStage::Write).after(FramesRecorded);
        app.insert_resource(self.drawing.clone())
            .insert_resource(writer)
            .add_systems(Step, draw.run_if(due::<Pictures>));
    }
}
