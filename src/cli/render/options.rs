//! Options of `render` as settings of pictures.

use super::RenderArgs;
use crate::scene::loaded::Loaded;
use crate::scene::outputs::Pictures;
use siloflow_dem::space::Dimension;
use siloflow_dem::values::{Finite, Positive};
use siloflow_text::fault::Fault;

/// The colour that the command line asks for: a name, and the ends of the scale if they are given.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ColourOption {
    pub name: String,
    pub ends: Option<(f64, f64)>,
}

/// Reads `name`, or `name=LOW..HIGH`.
pub(super) fn colour(text: &str) -> Result<ColourOption, String> {
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
pub(super) fn positive(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| format!("expected a number, got `{text}`"))?;
    Positive::try_from(number).map(Positive::get)
}

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
