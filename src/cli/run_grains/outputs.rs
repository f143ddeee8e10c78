//! The outputs of a run of grains.

use std::io;
use std::marker::PhantomData;

use bevy_ecs::prelude::*;

use crate::assembly::Assembly;
use crate::output::fields::FieldsPlugin;
use crate::output::flow::{FlowOfGrains, FlowPlugin};
use crate::output::frame_recording::FrameDataPlugin;
use crate::output::free_walls::FreeWallsFilePlugin;
use crate::output::losses::LossesPlugin;
use crate::output::outflow::OutflowPlugin;
use crate::output::pictures::PicturesPlugin;
use crate::output::profiles::ProfilesPlugin;
use crate::output::series::SeriesPlugin;
use crate::output::slopes::SlopesPlugin;
use crate::output::wall_bands::WallBandsPlugin;
use crate::output::walls::WallForcesPlugin;
use crate::scene::loaded::Loaded;
use siloflow_dem::space::Space;
use siloflow_files::run_directory::{RunDirectory, names};
use siloflow_text::fault::Fault;

/// The files that grow while a scene runs.
pub(super) struct Outputs<V: Space> {
    series: SeriesPlugin<V>,
    walls: Option<WallForcesPlugin<V>>,
    free_walls: Option<FreeWallsFilePlugin<V>>,
    wall_bands: Option<WallBandsPlugin<V>>,
    profiles: Option<ProfilesPlugin<V>>,
    fields: Option<FieldsPlugin<V>>,
    slopes: Option<SlopesPlugin<V>>,
    flow: Option<FlowPlugin<FlowOfGrains>>,
    frame_data: Option<FrameDataPlugin<V>>,
}

impl<V: Space> Outputs<V> {
    /// Creates the files with their headers, or continues them.
    pub(super) fn create(loaded: &Loaded, world: &World, directory: &RunDirectory) -> io::Result<Self> {
        let names = loaded.wall_names();
        let bands = loaded.wall_bands::<V>();
        let profiles = loaded.profiles();
        let species = u8::try_from(loaded.largest_species()).unwrap_or(u8::MAX);
        let tracks_energy = loaded.scene.energy_balance;
        Ok(Self {
            series: SeriesPlugin::create(loaded.scene.series, tracks_energy, world, &directory.rows(names::SERIES))?,
            walls: if names.is_empty() {
                None
            } else {
                Some(WallForcesPlugin::create(
                    &names,
                    &directory.rows(names::WALLS),
                    &directory.rows(names::WALL_GROUPS),
                )?)
            },
            free_walls: if loaded.scene.free_walls.is_empty() {
                None
            } else {
                Some(FreeWallsFilePlugin::create(&directory.rows(names::FREE_WALLS))?)
            },
            wall_bands: if bands.is_empty() {
                None
            } else {
                Some(WallBandsPlugin::create(bands, &directory.rows(names::WALL_BANDS))?)
            },
            profiles: if profiles.is_empty() {
                None
            } else {
                Some(ProfilesPlugin::create(
                    &profiles,
                    species,
                    !loaded.shapes.is_empty(),
                    &directory.rows(names::PROFILES),
                    &directory.rows(names::CENTRES),
                )?)
            },
            fields: if loaded.scene.fields.is_empty() {
                None
            } else {
                Some(FieldsPlugin::create(loaded.fields(), &directory.rows(names::FIELDS))?)
            },
            slopes: if loaded.scene.slopes.is_empty() {
                None
            } else {
                Some(SlopesPlugin::create(&loaded.scene.slopes, &directory.rows(names::SLOPES))?)
            },
            flow: loaded.scene.flow.map(|flow| FlowPlugin::create(flow, &directory.rows(names::FLOW))).transpose()?,
            frame_data: FrameDataPlugin::create(loaded, world, &directory.rows(names::FRAME_DATA))?,
        })
    }

    /// Adds the plugins that write the files, each with the scene key that asks for it.
    pub(super) fn add_to(self, app: &mut Assembly, loaded: &Loaded, directory: &RunDirectory) -> Result<(), Fault> {
        app.add("series", self.series);
        app.add("on_loss", LossesPlugin { place: directory.losses(), space: V::DIMENSION });
        if let Some(walls) = self.walls {
            app.add("walls", walls);
        }
        if let Some(free_walls) = self.free_walls {
            app.add("free_walls", free_walls);
        }
        if let Some(bands) = self.wall_bands {
            app.add("wall_bands", bands);
        }
        if let Some(profiles) = self.profiles {
            app.add("profiles", profiles);
        }
        if let Some(fields) = self.fields {
            app.add("fields", fields);
        }
        if let Some(slopes) = self.slopes {
            app.add("slopes", slopes);
        }
        if let Some(window) = loaded.scene.outflow {
            app.add("outflow", OutflowPlugin::<V> { window, species: loaded.largest_species(), space: PhantomData });
        }
        if let Some(flow) = self.flow {
            app.add("flow", flow);
        }
        if let Some(frame_data) = self.frame_data {
            let is_asked = loaded.source.value_of("data_frames").is_some();
            app.add(if is_asked { "data_frames" } else { "pictures" }, frame_data);
        }
        if let Some(pictures) = PicturesPlugin::<V>::of(loaded, app.world(), directory.frames())? {
            app.add("pictures", pictures);
        }
        Ok(())
    }
}
