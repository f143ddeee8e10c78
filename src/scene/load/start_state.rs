//! Loads a scene that starts with the grains and contacts of another run.

use std::path::Path;

use crate::grains::file;
use crate::grains::fill::Fill;
use crate::scene::load::contacts::Stray;
use crate::scene::load::{CONTACTS, any, read_all};
use crate::scene::loaded::{AnyScene, Loaded};
use siloflow_dem::contact::history::remembered;
use siloflow_dem::space::Dimension;
use siloflow_text::fault::{Fault, Warning};
use siloflow_text::source::Source;

/// The state of another run, from which a scene starts.
#[derive(Debug)]
pub struct StartState {
    /// Space of the other run.
    pub space: Dimension,
    /// Its grains, as the text of a grain file.
    pub grains: String,
    /// Its contacts, as the text of a file of contacts.
    pub contacts: String,
}

/// Loads a scene of grains that starts with the grains and contacts of another run. They replace the scene's own grains at the start;
/// fixed grains of `fill` stay. Contacts with walls that the scene lacks are left out, with a note, and so are spins if its grains do not
/// spin. `note` is a comment for the scene's text.
///
/// # Errors
/// Like [`load`](super::load); also if the other run has another space.
pub fn started_from(
    path: &Path,
    settings: &[(String, String)],
    state: StartState,
    note: &str,
) -> Result<Box<Loaded>, Fault> {
    let AnyScene::Grains(loaded) = any(path, settings)? else {
        return Err(Fault::new("scene::method", "a run of the lattice gas cannot start from grains")
            .help("give a scene of grains"));
    };
    let StartState { space, mut grains, contacts } = state;
    if space != loaded.scene.space {
        let word = |space| if space == Dimension::Plane { "planar" } else { "in solid space" };
        let message = format!("the run is {}, and this scene is {}", word(space), word(loaded.scene.space));
        return Err(loaded.fault("scene::dimension", "space", message).help("start from a run with the same `space`"));
    }
    let mut notes = Vec::new();
    if !loaded.grains_spin() {
        let spinning;
        (grains, spinning) = file::without_spin(&grains)?;
        notes.extend((spinning > 0).then(|| Warning {
            code: "from::spins_left_out",
            message: format!(
                "the spins of {spinning} grains are left out, and friction at all contacts with them: the contact law of this \
                 scene has no friction, and its grains do not spin"
            ),
            help: "give `contact` a `tangential` part to keep them".to_owned(),
        }));
    }
    // Random numbers of a fill depend on its number, so that fills without grains hold the places of the others.
    let count = loaded.scene.fill.iter().rposition(|fill| fill.fixed).map_or(0, |last| last + 1);
    // The radii of a fill with a `scale` are known by now, and a fill has only one of the two.
    let keep = |fill: &Fill| {
        let count = if fill.fixed { fill.count } else { Some(0) };
        Fill { count, scale: None, ..fill.clone() }
    };
    let fixed: Vec<_> = loaded.scene.fill[..count].iter().map(keep).collect();
    let fill = ron::to_string(&fixed).map_err(|error| Fault::new("scene::fill", error.to_string()))?;
    let mut more = settings.to_vec();
    let files = "(file: \"grains.csv\", contacts: \"contacts.csv\")";
    more.push(("grains".to_owned(), files.to_owned()));
    if !loaded.scene.fill.is_empty() {
        more.push(("fill".to_owned(), fill));
    }
    let mut source = Source::read(path)?;
    source.texts = vec![("grains.file", grains), (CONTACTS, contacts)];
    let mut started = read_all(source, &more)?;
    let strays = started.find_partners();
    notes.extend(left_out(&strays));
    // The run directory keeps what the run starts with.
    let rest =
        remembered::write(&started.contacts_at_start).map_err(|problem| Fault::new("scene::contacts", problem))?;
    started.source.texts.iter_mut().filter(|(key, _)| *key == CONTACTS).for_each(|(_, text)| text.clone_from(&rest));
    started.notes = notes;
    started.choose_scheme();
    started.source.text.insert_str(0, &format!("// {note}\n"));
    Ok(Box::new(started))
}

/// Tells that contacts of the other run are left out.
fn left_out(strays: &[(usize, Stray)]) -> Option<Warning> {
    let [(_, first), ..] = strays else { return None };
    let of_walls = strays.iter().filter(|(_, stray)| stray.is_wall).count();
    Some(Warning {
        code: "from::contacts_left_out",
        message: format!(
            "the memories of {} contacts are left out, {of_walls} of them with walls that are gone or stand elsewhere: {}",
            strays.len(),
            first.reason
        ),
        help: "their friction begins anew where the grains still touch; this is right if a wall was taken away"
            .to_owned(),
    })
}
