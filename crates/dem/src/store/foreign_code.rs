//! Code without an access list: observers, and hooks of components, that belong to no crate of siloflow or of Bevy. They may read every
//! mirrored component when commands are applied.

use bevy_ecs::component::{ComponentInfo, Components};
use bevy_ecs::lifecycle::ComponentHooks;
use bevy_ecs::observer::Observer;
use bevy_ecs::prelude::*;

use crate::store::access_markers::OwnObserver;

/// Observers of other crates.
pub(super) type ForeignObservers = QueryState<(), (With<Observer>, Without<OwnObserver>)>;

/// Whether a component of another crate has a hook.
pub(super) fn have_foreign_hooks(components: &Components) -> bool {
    let is_foreign_hook =
        |(_, info): (_, &ComponentInfo)| has_hook(info.hooks()) && is_foreign(&info.name().to_string());
    components.iter_registered().any(is_foreign_hook)
}

/// Whether a component has any hook.
fn has_hook(hooks: &ComponentHooks) -> bool {
    type Hook = bevy_ecs::lifecycle::ComponentHook;
    const NOTHING: Hook = |_, _| {};
    let mut copy = hooks.clone();
    copy.try_on_add(NOTHING).is_none()
        || copy.try_on_insert(NOTHING).is_none()
        || copy.try_on_discard(NOTHING).is_none()
        || copy.try_on_remove(NOTHING).is_none()
        || copy.try_on_despawn(NOTHING).is_none()
}

/// The crates of siloflow.
const OWN_CRATES: [&str; 3] = ["siloflow", "siloflow_dem", "siloflow_lattice"];

/// The crates of Bevy that siloflow depends on, also through others. Their hooks read no mirrored component. Other crates take names that
/// begin with `bevy_` too.
const CRATES_OF_BEVY: [&str; 7] =
    ["bevy_app", "bevy_ecs", "bevy_platform", "bevy_ptr", "bevy_reflect", "bevy_tasks", "bevy_utils"];

/// Returns the path of a type or function without the name of its crate, if it is one of siloflow's crates.
#[must_use]
pub fn path_in_siloflow(name: &str) -> Option<&str> {
    path_in(&OWN_CRATES, name)
}

/// Returns the path of a type without the name of its crate, if it is one of `crates`.
fn path_in<'a>(crates: &[&str], name: &'a str) -> Option<&'a str> {
    let (of, path) = name.split_once("::")?;
    crates.contains(&of).then_some(path)
}

/// Whether hooks of a component type of this name may read mirrored components. A name without a known crate counts.
fn is_foreign(name: &str) -> bool {
    path_in_siloflow(name).or_else(|| path_in(&CRATES_OF_BEVY, name)).is_none()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn components_of_this_crate_are_not_foreign() {
        let name = std::any::type_name::<crate::particle::Radius>();
        assert_eq!(path_in_siloflow(name), Some("particle::Radius"));
        assert_eq!(path_in_siloflow("siloflow_of_a_user::Heat"), None);
        assert_eq!(path_in_siloflow("siloflow_lattice::sites::Sites"), Some("sites::Sites"));
        assert_eq!(path_in_siloflow("siloflow::door::DoorPlugin"), Some("door::DoorPlugin"));
        assert_eq!(path_in_siloflow("siloflow"), None);
    }

    #[test]
    fn crates_that_only_look_like_those_of_bevy_are_foreign() {
        let of_bevy = [std::any::type_name::<ChildOf>(), std::any::type_name::<Observer>()];
        assert!(of_bevy.iter().all(|name| !is_foreign(name)), "{of_bevy:?}");
        for name in ["bevy_heat::Warm", "bevy_ecs_tilemap::Tile", "bevy_ecs", "bevy::Heat", "&bevy_ecs::name::Name", ""]
        {
            assert!(is_foreign(name), "{name}");
        }
    }

    #[test]
    fn the_crates_of_bevy_are_those_that_siloflow_depends_on() {
        let lock = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../Cargo.lock")).unwrap();
        let names = lock.lines().filter_map(|line| line.strip_prefix("name = \"")?.strip_suffix('"'));
        // Macros are not in a program.
        let of_bevy =
            names.filter(|name| name.starts_with("bevy_") && !name.contains("macro") && !name.contains("derive"));
        assert_eq!(of_bevy.collect::<Vec<_>>(), CRATES_OF_BEVY);
    }
}
