//! Rules on grains that a scene creates: enough room and ids, radii and masses.

use crate::grains::MOST_GRAINS;
use crate::grains::feed::MOST_TRIES;
use crate::grains::fill::{Fill, Placement};
use crate::grains::mass::MassLaw;
use crate::grains::sizes::RadiusLaw;
use crate::scene::expected::BYTES_PER_GRAIN;
use crate::scene::loaded::Loaded;
use crate::scene::rules::directions::is_box;
use crate::writers::memory::available_memory;
use siloflow_dem::particle::GrainId;
use siloflow_text::fault::Fault;

/// Checks all fills before their grains are created.
///
/// # Errors
/// The first entry that is wrong, or with which the grains become too many.
pub fn fill(loaded: &Loaded) -> Result<(), Fault> {
    let scene = &loaded.scene;
    let mut total = loaded.grains.len();
    for (index, fill) in scene.fill.iter().enumerate() {
        let key = |name: &str| format!("fill[{index}].{name}");
        if !is_box(fill.low, fill.high) {
            return Err(loaded
                .fault("scene::empty_box", &key("low"), "the lower corner must be below the upper one along every axis")
                .help("corners are in m"));
        }
        placement(loaded, index, fill)?;
        walls(loaded, index, fill)?;
        let size = fill.size(scene.space).map_or(usize::MAX, |size| size as usize);
        // Each sphere of a fixed grain is a wall grain.
        total = total.saturating_add(size.saturating_mul(if fill.fixed { fill.most_spheres() } else { 1 }));
        if total > MOST_GRAINS as usize {
            return Err(too_many(loaded, index, fill));
        }
        let wanted = fill.count.unwrap_or(1) as usize;
        if size < wanted {
            let message = format!("{wanted} grains are wanted, but {size} fit");
            return Err(loaded
                .fault("scene::out_of_range", &key("high"), message)
                .help("raise the box, or lower the spacing"));
        }
        let mass = fill.mass.or(scene.mass);
        if !fill.fixed && mass.is_none() {
            return Err(loaded
                .fault("scene::missing_key", "mass", "`fill` needs to know how heavy its grains are")
                .help("add for example `mass: Sphere(2500.0)`, m = rho 4/3 pi R^3 in kg/m^3"));
        }
        radii(loaded, &key("radius"), &fill.radius, fill.species, mass)?;
    }
    memory(loaded, total)
}

/// A lattice needs its spacing, and random places a count.
fn placement(loaded: &Loaded, index: usize, fill: &Fill) -> Result<(), Fault> {
    let missing = |name: &str, value: &str| {
        let message = format!("the key `{name}` is missing");
        let fault = loaded.fault("scene::missing_key", &format!("fill[{index}].{name}"), message);
        Err(fault.help(format!("add `{name}: ...` here; its value: {value}")))
    };
    let is_given = match fill.place {
        Placement::Lattice if fill.spacing.is_none() => return missing("spacing", "m"),
        Placement::Random if fill.count.is_none() => return missing("count", "grains"),
        Placement::Lattice => return Ok(()),
        Placement::Random => {
            [("spacing", fill.spacing.is_some()), ("jitter", fill.jitter.is_some()), ("fixed", fill.fixed)]
        }
    };
    match is_given.into_iter().find(|(_, is_given)| *is_given) {
        Some((name, _)) => Err(loaded
            .fault("scene::no_lattice", &format!("fill[{index}].{name}"), "this key belongs to grains on a lattice")
            .help("remove it, or write `place: Lattice`")),
        None => Ok(()),
    }
}

/// Fixed grains that are walls need no velocity, and grains that move are no walls.
fn walls(loaded: &Loaded, index: usize, fill: &Fill) -> Result<(), Fault> {
    if !fill.makes_walls() {
        return Ok(());
    }
    let name = if fill.name.is_some() { "name" } else { "door" };
    let moving = [("velocity", fill.velocity.is_some()), ("agitation", fill.agitation.is_some())];
    let (key, message, help) = if !fill.fixed {
        (name, "only fixed grains have a name or are a door", "add `fixed: true`, or remove this key")
    } else if let Some((key, _)) = moving.into_iter().find(|(_, is_given)| *is_given) {
        (
            key,
            "fixed grains with a name, or of a door, are walls, which have no velocity of their own",
            "remove it, and move the walls of this name by `motions`",
        )
    } else {
        return Ok(());
    };
    Err(loaded.fault("scene::fixed_grains", &format!("fill[{index}].{key}"), message).help(help))
}

/// The grains of the start must fit into the memory that is available.
fn memory(loaded: &Loaded, grains: usize) -> Result<(), Fault> {
    #[expect(clippy::cast_precision_loss, reason = "a number of grains and of bytes")]
    let needed = grains as f64 * BYTES_PER_GRAIN;
    #[expect(clippy::cast_precision_loss, reason = "a rounded result suffices")]
    let available = available_memory().map_or(f64::INFINITY, |bytes| bytes as f64);
    if needed <= available {
        return Ok(());
    }
    let sizes = loaded.scene.fill.iter().map(|fill| fill.size(loaded.scene.space).unwrap_or(0) as usize);
    let largest = sizes.enumerate().max_by_key(|&(_, size)| size).filter(|&(_, size)| size > loaded.grains.len());
    let key = largest.map_or_else(|| "grains.file".to_owned(), |(index, _)| format!("fill[{index}]"));
    let message = format!(
        "{grains} grains need about {:.1} GB of memory, and {:.1} GB are available",
        needed / 1e9,
        available / 1e9
    );
    Err(loaded.fault("scene::memory", &key, message).help("start with fewer grains"))
}

/// The fault for the entry of `fill` with which a scene has more grains than the limit.
fn too_many(loaded: &Loaded, index: usize, fill: &Fill) -> Fault {
    let (key, what) = match fill.count {
        Some(count) => ("count", format!("{count} more grains")),
        None => ("spacing", format!("as many grains as fit, {:.3e},", fill.capacity(loaded.scene.space))),
    };
    let message = format!("with {what} the scene starts with more than {MOST_GRAINS} grains, the limit");
    loaded
        .fault("scene::out_of_range", &format!("fill[{index}].{key}"), message)
        .help("is the spacing, in m, right? A `count` bounds the number of grains of a fill")
}

/// Every grain of the fills must have got an id.
pub(super) fn ids(loaded: &Loaded) -> Result<(), Fault> {
    let scene = &loaded.scene;
    let free = scene.fill.iter().enumerate().filter(|(_, fill)| !fill.fixed);
    let mut wanted: usize = 0;
    for (index, fill) in free {
        wanted += fill.size(scene.space).unwrap_or(0) as usize;
        if wanted > loaded.grains.len() {
            return Err(loaded
                .fault(
                    "scene::out_of_range",
                    &format!("fill[{index}].count"),
                    "there are not enough ids left for these grains",
                )
                .help("ids go up to 2147483647: give the grains of the file lower ones"));
        }
    }
    Ok(())
}

pub(super) fn spawner(loaded: &Loaded) -> Result<(), Fault> {
    let Some(spawner) = &loaded.scene.spawner else { return Ok(()) };
    if loaded.scene.mass.is_none() {
        return Err(loaded
            .fault("scene::missing_key", "mass", "the spawner needs to know how heavy its grains are")
            .help("add for example `mass: ArealSquare(100.0)`, m = rho R^2 in kg/m^2"));
    }
    radii(loaded, "spawner.radius", &spawner.radius, 0, loaded.scene.mass)?;
    let room = (GrainId::MAX_GRAIN + 1).saturating_sub(loaded.first_free_id());
    if spawner.count > room {
        let message = format!("{} grains are more than there are ids left, {room}", spawner.count);
        return Err(loaded.fault("scene::out_of_range", "spawner.count", message).help("release fewer grains"));
    }
    Ok(())
}

/// Every feed needs masses, a region that is not inverted, an end where something waits for it, and spins only where grains spin.
pub(super) fn feed(loaded: &Loaded) -> Result<(), Fault> {
    let scene = &loaded.scene;
    let mut room = f64::from((GrainId::MAX_GRAIN + 1).saturating_sub(loaded.first_free_id()));
    for (index, feed) in scene.feed.iter().enumerate() {
        let key = |name: &str| format!("feed[{index}]{name}");
        let Some(mass) = scene.mass else {
            return Err(loaded
                .fault("scene::missing_key", "mass", "the feed needs to know how heavy its grains are")
                .help("add for example `mass: Sphere(2500.0)`, m = rho 4/3 pi R^3 in kg/m^3"));
        };
        radii(loaded, &key(".radius"), &feed.radius, feed.species, feed.mass.or(scene.mass))?;
        let (low, high) = feed.region.bounds();
        let count = feed.count(mass);
        let (code, name, message, help) = if scene.spawner.is_some() {
            let message = "a scene has a spawner or feeds: each looks only at its own new grains of a step";
            ("scene::two_sources", "", message, "a feed whose box is a point releases grains as the spawner does")
        } else if !low.cmple(high).all() {
            let help = "corners are in m; equal coordinates make a flat region";
            ("scene::empty_box", ".region", "the lower corner must not be above the upper one along any axis", help)
        } else if !(1..=MOST_TRIES).contains(&feed.tries) {
            ("scene::out_of_range", ".tries", "expected 1 to 10000 tries", "the default is 100")
        } else if feed.spin.is_some() && !loaded.grains_spin() {
            let message = "the grains of this scene do not spin";
            ("scene::no_spin", ".spin", message, "add `tangential` to the contact law, or remove `spin`")
        } else if count.is_none() && (scene.rest.is_some() || loaded.source.value_of("rest").is_some()) {
            let help = "give a `total`, or remove `rest` and open the door `At(...)`";
            ("scene::endless_feed", ".total", "rest comes after the last grain, and this feed has no end", help)
        } else if count.is_some_and(|count| !(1.0..=room).contains(&count)) {
            let help = "give a total of at least one grain, and of fewer than 2147483648";
            ("scene::out_of_range", ".total", "the total is less than a grain, or more than there are ids left", help)
        } else {
            room -= count.unwrap_or(0.0);
            continue;
        };
        return Err(loaded.fault(code, &key(name), message).help(help));
    }
    Ok(())
}

/// Shares must sum to one, and a range must begin at its smaller end.
fn radii(loaded: &Loaded, key: &str, law: &RadiusLaw, first_species: u8, mass: Option<MassLaw>) -> Result<(), Fault> {
    if matches!(law, RadiusLaw::Mixture(sizes) if sizes.is_empty()) {
        return Err(loaded
            .fault("scene::out_of_range", key, "the mixture has no sizes")
            .help("write (radius in m, share) for each size"));
    }
    if let RadiusLaw::Mixture(sizes) = law
        && sizes.len() + usize::from(first_species) > 256
    {
        return Err(loaded
            .fault("scene::out_of_range", key, format!("{} sizes are more than there are species, 256", sizes.len()))
            .help("use `Uniform(smallest, largest)` for many sizes"));
    }
    let (smallest, largest) = law.range();
    let masses = mass.map(|mass| [mass.of(smallest), mass.of(largest)]);
    if masses.is_some_and(|masses| !masses.into_iter().all(f64::is_normal)) {
        return Err(loaded
            .fault("scene::out_of_range", key, "grains of this size have no mass that a double can hold")
            .help("radii are in m"));
    }
    match law {
        RadiusLaw::Mixture(sizes) => {
            let sum: f64 = sizes.iter().map(|(_, share)| share.get()).sum();
            if (sum - 1.0).abs() > 1e-9 {
                let message = format!("the shares of the mixture sum to {sum}, not to 1");
                return Err(loaded
                    .fault("scene::shares", key, message)
                    .help("write (radius in m, share) for each size"));
            }
        }
        RadiusLaw::Uniform(low, high) if low > high => {
            let message = format!("the smaller radius comes first, got {} and {}", low.get(), high.get());
            return Err(loaded.fault("scene::out_of_range", key, message).help("exchange the two"));
        }
        _ => {}
    }
    Ok(())
}
