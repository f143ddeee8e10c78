//! Describes the shapes of a scene: size, mass, moments of inertia, and how close their spheres come to the surface asked for.

use std::fmt::Write as _;

use crate::scene::loaded::Loaded;
use siloflow_dem::bodies::{RigidShape, ShapeSphere};
use siloflow_dem::space::{Dimension, Linear, Plane, Solid, Space};

/// Adds the lines about all shapes. Writing to a string cannot fail.
pub(super) fn describe(loaded: &Loaded, text: &mut String) {
    match loaded.scene.space {
        Dimension::Plane => describe_in::<Plane>(loaded, text),
        Dimension::Solid => describe_in::<Solid>(loaded, text),
    }
}

fn describe_in<V: Space>(loaded: &Loaded, text: &mut String) {
    let [sphere, size, unit] = match V::DIMENSION {
        Dimension::Plane => ["disc", "area", "m^2"],
        Dimension::Solid => ["sphere", "volume", "m^3"],
    };
    for (shape, facts) in loaded.shapes.rigid::<V>().iter().zip(&loaded.shapes.facts) {
        let RigidShape { name, spheres, gyration, mobility, .. } = shape;
        let [largest, smallest] = shape.sphere_radii();
        let radius = shape.equivalent_radius();
        let count = spheres.len();
        let several = if count == 1 { "" } else { "s" };
        let _ = writeln!(
            text,
            "shape {name}: {count} {sphere}{several}, radii {smallest:.6e} to {largest:.6e} m; {size} {:.12e} {unit}, \
             diameter of equal {size} {:.12e} m",
            shape.size,
            2.0 * radius
        );
        if let Some(mass) = loaded.scene.mass.map(|law| law.of(radius)) {
            let moments: Vec<_> =
                (0..V::Principal::COUNT).map(|axis| format!("{:.12e}", mass * gyration.component(axis))).collect();
            let _ = writeln!(
                text,
                "  mass {mass:.12e} kg, principal moments of inertia {} kg m^2; a contact sees at least 1/{mobility:.3} of the mass",
                moments.join(", ")
            );
        }
        if let Some(deviation) = facts.deviation {
            let _ = writeln!(
                text,
                "  the surface is within {:.3e} m of the one asked for, root mean square {:.3e} m",
                deviation.largest, deviation.rms
            );
        }
        let places: Vec<_> =
            spheres.iter().map(|ShapeSphere { at, radius }| format!("{} {radius:.12e}", place(*at))).collect();
        let _ = writeln!(text, "  {sphere}s in principal axes, place and radius, m: {}", places.join("; "));
    }
    if !loaded.shapes.is_empty() {
        text.push('\n');
    }
}

fn place<V: Space>(at: V) -> String {
    let numbers: Vec<_> = at.components().iter().map(|number| format!("{number:.12e}")).collect();
    format!("({})", numbers.join(", "))
}
