//! Warnings about contacts so soft that bodies overlap too much.

use crate::ending::watchdog::overlap::LARGE_OVERLAP;
use crate::scene::check::quantities::Estimates;
use crate::scene::loaded::Loaded;
use siloflow_dem::walls::enclosure::Enclosure;
use siloflow_text::fault::Warning;

/// Adds the warnings about impacts on walls, impacts of grains, adhesion, and the weight of the bed.
pub(super) fn examine(loaded: &Loaded, estimates: &Estimates, warnings: &mut Vec<Warning>) {
    let stiffness = estimates.stiffness;
    let carried = 0.5 * estimates.mass * estimates.impact_speed.powi(2);
    if let Some(barrier) = weakest_link(loaded, estimates.radius, stiffness).filter(|&barrier| barrier < carried) {
        warnings.push(Warning {
            code: "check::soft_walls",
            message: format!(
                "a grain arrives with up to {carried:.2} J ({:.1} m/s), and {barrier:.2} J squeeze it between two wall \
                 grains: grains will pass through the walls",
                estimates.impact_speed
            ),
            help: format!(
                "raise the stiffness, now {stiffness} N/m, about {:.0} times; is its unit right?",
                (carried / barrier).ceil()
            ),
        });
    }
    if estimates.impact_overlap > LARGE_OVERLAP {
        warnings.push(Warning {
            code: "check::deep_impacts",
            message: format!(
                "a grain that arrives at {:.1} m/s overlaps by up to {:.2} of its radius; the contact law is meant for small \
                 overlaps",
                estimates.impact_speed, estimates.impact_overlap
            ),
            help: "raise the stiffness, or let grains fall less far, if the impacts matter to you".to_owned(),
        });
    }
    if estimates.adhesive_overlap > LARGE_OVERLAP {
        warnings.push(Warning {
            code: "check::strong_adhesion",
            message: format!(
                "two bodies that touch at rest are pulled together by {:.2} of their radius; the contact law is meant for small overlaps",
                estimates.adhesive_overlap
            ),
            help: "raise the stiffness, or lower `contact.adhesion`".to_owned(),
        });
    }
    if estimates.static_overlap > LARGE_OVERLAP {
        warnings.push(Warning {
            code: "check::soft_bed",
            message: format!(
                "the weight of the grains presses those at the bottom together by {:.2} of their radius",
                estimates.static_overlap
            ),
            help: "raise the stiffness: the contact law is meant for small overlaps".to_owned(),
        });
    } else if estimates.caught_overlap > LARGE_OVERLAP {
        warnings.push(Warning {
            code: "check::caught_grains",
            message: format!(
                "the weight of the heaviest grain on a single smallest grain, of radius {} m, presses it together by {:.2} of \
                 its radius",
                estimates.radius, estimates.caught_overlap
            ),
            help: "raise the stiffness, or let sizes differ less: small grains that are caught between large ones may slip through"
                .to_owned(),
        });
    }
}

/// The least energy, J, that squeezes a grain of this radius (m) between two neighbouring wall or door grains.
fn weakest_link(loaded: &Loaded, radius: f64, stiffness: f64) -> Option<f64> {
    let mut discs = loaded.wall_discs();
    discs.extend(&loaded.silo.door);
    let thinnest = discs.iter().map(|disc| disc.radius).fold(f64::INFINITY, f64::min);
    let outline = Enclosure::new(&discs, &[], &[], radius);
    let barrier = |distance: f64| stiffness * (radius + thinnest - 0.5 * distance).max(0.0).powi(2);
    outline.links().iter().map(|link| barrier(link.from.distance(link.to))).min_by(f64::total_cmp)
}
