//! `siloflow export`: converts the frames of a run to formats of other programs.

use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::PossibleValuesParser;

use crate::cli::exit_status::ExitStatus;
use crate::cli::export_scene::{self, LAMMPS};
use crate::cli::{SceneArgs, help_to_write, say, setting};
use crate::scene::extent::most_bytes;
use crate::scene::load;
use crate::scene::loaded::AnyScene;
use siloflow_files::frames::columns::Columns;
use siloflow_files::frames::reader::FrameReader;
use siloflow_files::frames::reader::OF_UNKNOWN_SCENE;
use siloflow_files::own_files;
use siloflow_files::run_directory::{Depth, frame_data_of, refuse_odd, scene_of};
use siloflow_results::export::Format;
use siloflow_results::export::{self, Target};
use siloflow_text::fault::Fault;

/// Arguments of `export`.
#[derive(Args, Debug)]
#[command(after_help = "\
The frames of a run that goes on or was killed are exported up to the last whole one.

  siloflow run scenes/silo1.ron
  siloflow export out/silo1 --to vtk      # then open out/silo1/vtk/grains.pvd in ParaView
  siloflow export out/silo1 --to extxyz   # then open out/silo1/frames.xyz in OVITO
  siloflow export out/silo1 --to csv      # then read out/silo1/csv/grains.csv in a notebook

A scene is written as an input of LAMMPS, for runs on many ranks. Keys that LAMMPS cannot do are refused.

  siloflow export scenes/silo3d.ron --to lammps
  cd out/silo3d-lammps && mpirun -np 2 lmp -in in.silo

Parquet needs a program that was built with it: cargo build --release --features parquet")]
pub(super) struct ExportArgs {
    /// A run directory with frames.bin: of a scene with pictures, or with `data_frames`. For LAMMPS a scene, a RON file.
    #[arg(value_name = "RUN|SCENE")]
    run: PathBuf,
    /// The format: VTK PolyData for ParaView, extended XYZ for OVITO and ASE, a dump of LAMMPS for OVITO, or tables for notebooks in
    /// CSV or Parquet; `lammps` writes a scene as an input of LAMMPS.
    #[arg(long, value_name = "FORMAT", value_parser = PossibleValuesParser::new(formats()))]
    to: String,
    /// The directory (vtk, csv, parquet, lammps) or file to write, which must not exist. Default: vtk, frames.xyz, frames.dump, csv or
    /// parquet in the run directory; for LAMMPS out/<scene name>-lammps.
    #[arg(long, value_name = "PATH")]
    out: Option<PathBuf>,
    /// Change a key of the scene, as for `run`. Only with `--to lammps`. May be repeated.
    #[arg(long = "set", value_name = "PATH=VALUE", value_parser = setting)]
    set: Vec<(String, String)>,
    /// Seed of all random numbers. Only with `--to lammps`.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
}

/// The names of all formats.
fn formats() -> Vec<&'static str> {
    Target::ALL.into_iter().map(|(name, _)| name).chain([LAMMPS]).collect()
}

pub(super) fn export(args: &ExportArgs, quiet: bool) -> Result<ExitStatus, Fault> {
    if args.to == LAMMPS {
        let scene = SceneArgs { scene: args.run.clone(), set: args.set.clone(), seed: args.seed };
        return export_scene::export(&scene, args.out.clone(), quiet);
    }
    if !args.set.is_empty() || args.seed.is_some() {
        return Err(Fault::new(
            "export::set",
            format!("--set and --seed change a scene, and --to {} reads a run", args.to),
        )
        .help("give them to `siloflow run`"));
    }
    let vtk = Target::Live(Format::Vtk);
    let format = Target::ALL.into_iter().find(|(name, _)| *name == args.to).map_or(vtk, |(_, format)| format);
    if !format.is_available() {
        return Err(Fault::new("export::feature", format!("this siloflow was built without the format {}", args.to))
            .help("build it with `cargo build --release --features parquet`, or export `--to csv`"));
    }
    refuse_odd(&args.run, Depth::Top)?;
    let path = frame_data_of(&args.run);
    if !own_files::is_file(&path) {
        return Err(without_frames(
            &args.run,
            ["export::missing", "export::no_run", "export::method", "export::no_frames"],
        ));
    }
    let target = args.out.clone().unwrap_or_else(|| args.run.join(format.file_name()));
    if target.symlink_metadata().is_ok() {
        return Err(Fault::new("export::exists", format!("{} exists", target.display()))
            .help("remove it, or give another place with --out"));
    }
    let most = load::any(&scene_of(&args.run), &[]).map_or(OF_UNKNOWN_SCENE, |scene| most_bytes(&scene));
    let unreadable = |error: io::Error| {
        Fault::new("export::read", format!("could not read {}: {error}", path.display()))
            .help("is it a run of this version of siloflow? Else run its scene.ron again")
    };
    // The file is read twice: for the columns of all frames, then for the frames. A run that goes on may add frames in between.
    let columns = FrameReader::open_within(&path, most).and_then(Columns::of).map_err(unreadable)?;
    let reader = FrameReader::open_within(&path, most).map_err(unreadable)?;
    let header = reader.header.clone();
    let count = export::export(format, &header, &columns, reader, &args.run, &target).map_err(|error| {
        if error.kind() == ErrorKind::InvalidData {
            return Fault::new("export::read", format!("could not read {}: {error}", path.display()))
                .help("nothing was written; the file has been changed since the run: run its scene.ron again");
        }
        Fault::new("export::write", format!("could not export {} to {}: {error}", path.display(), target.display()))
            .help(help_to_write(&error))
    })?;
    let shown = match format {
        Target::Live(Format::Vtk) => target.join("grains.pvd"),
        Target::Live(_) => target,
        Target::Csv => target.join("grains.csv"),
        Target::Parquet => target.join("grains.parquet"),
    };
    say(&format!("{}: {count} frames\n", shown.display()));
    Ok(ExitStatus::Done)
}

/// The fault of a directory without frames, with the codes of no directory, no run, a lattice gas, and no frames.
pub(super) fn without_frames(run: &Path, codes: [&'static str; 4]) -> Fault {
    let shown = run.display();
    if !run.exists() {
        return Fault::new(codes[0], format!("there is no {shown}"))
            .help("give a run directory such as out/silo1, which `siloflow run` makes");
    }
    let scene = scene_of(run);
    if !own_files::is_file(&scene) {
        return Fault::new(codes[1], format!("{shown} is no run directory: it has no scene.ron"))
            .help("`siloflow run SCENE --out DIR` makes one");
    }
    if matches!(load::any(&scene, &[]), Ok(AnyScene::Lattice(_))) {
        return Fault::new(codes[2], format!("{shown} is a run of the lattice gas, which has no grains"))
            .help("its particles are in state.csv and flow.csv");
    }
    Fault::new(codes[3], format!("the run in {shown} kept no frames: there is no frames.bin"))
        .help("run its scene again with frames, for example with --set \"data_frames=(interval: 0.1)\"")
}
