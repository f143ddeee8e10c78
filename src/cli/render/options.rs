//! Arguments of `render` as settings of pictures.

use super::args::RenderArgs;
use crate::scene::loaded::Loaded;
use crate::scene::outputs::Pictures;
use siloflow_dem::space::Dimension;
use siloflow_dem::values::{Finite, Positive};
use siloflow_text::fault::Fault;

/// Returns the settings of a scene's pictures with those of the command line. Colours need the frames and are set later.
pub(super) fn pictures(args: &RenderArgs, loaded: &Loaded) -> Result<Pictures, Fault> {
    let fault = |message: &str, help: &str| Err(Fault::new("render::option", message).help(help));
    let mut pictures = loaded.scene.pictures.clone().unwrap_or_default();
    if loaded.scene.space == Dimension::Plane && (args.view.is_some() || args.cut.is_some()) {
        return fault("a plane has one view and no depth", "leave out --view and --cut; they are for solid space");
    }
    if let Some(direction) = args.view {
        pictures.direction = direction;
        // The corners of the scene's view are for its own direction.
        pictures.view = None;
    }
    if let Some(cut) = args.cut {
        let Ok(cut) = Finite::try_from(cut) else {
            return fault("the depth of the cut must be a finite number", "give m, for example --cut=0.02");
        };
        pictures.cut = Some(cut);
    }
    if let Some(width) = args.width {
        if !(50.0..=20_000.0).contains(&width) {
            return fault("expected a width of 50 to 20000 px", "600 is a good width");
        }
        pictures.width = Positive::try_from(width.round()).unwrap_or(pictures.width);
    }
    pictures.network = args.network.and_then(|force| Positive::try_from(force).ok()).or(pictures.network);
    Ok(pictures)
}
