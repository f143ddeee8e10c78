//! `siloflow export SCENE --to lammps`: writes a scene as an input of LAMMPS.

use std::path::PathBuf;

use crate::cli::exit_status::ExitStatus;
use crate::cli::{SceneArgs, say, say_aside, unwritable};
use crate::lammps::{self, BODIES, DATA, SCRIPT};
use crate::scene::loaded::AnyScene;
use siloflow_files::run_directory;
use siloflow_text::fault::Fault;

/// The name of the format on the command line.
pub(super) const LAMMPS: &str = "lammps";

/// Writes the scene of `args` into the directory `out`, by default `out/<scene name>-lammps`.
pub(super) fn export(args: &SceneArgs, out: Option<PathBuf>, quiet: bool) -> Result<ExitStatus, Fault> {
    if args.scene.is_dir() {
        let shown = args.scene.display();
        return Err(Fault::new("export::not_a_scene", format!("{shown} is a directory; --to {LAMMPS} takes a scene"))
            .help(format!("for the scene of a run, write `siloflow export {shown}/scene.ron --to {LAMMPS}`")));
    }
    let AnyScene::Grains(loaded) = args.load()? else {
        return Err(Fault::new(
            "export::method",
            "a lattice gas has no grains, and LAMMPS has no lattice gas of its kind",
        )
        .help("give a scene of grains"));
    };
    let target = out.unwrap_or_else(|| PathBuf::from("out").join(format!("{}-{LAMMPS}", loaded.source.name)));
    if target.symlink_metadata().is_ok() {
        return Err(Fault::new("export::exists", format!("{} exists", target.display()))
            .help("remove it, or give another place with --out"));
    }
    let written = lammps::export(&loaded)?;
    let mut files =
        vec![(SCRIPT.to_owned(), written.script.into_bytes()), (DATA.to_owned(), written.data.into_bytes())];
    files.extend(written.bodies.map(|bodies| (BODIES.to_owned(), bodies.into_bytes())));
    run_directory::write_results(&target, &files).map_err(|error| unwritable(&target, &error))?;
    if !quiet {
        say_aside("not the same in LAMMPS:");
        written.differences.iter().for_each(|sentence| say_aside(&format!("  {sentence}")));
        say(&format!(
            "{}: {} grains. Run it: cd {} && mpirun -np 2 lmp -in {SCRIPT}\n",
            target.join(SCRIPT).display(),
            written.grains,
            target.display()
        ));
    }
    Ok(ExitStatus::Done)
}
