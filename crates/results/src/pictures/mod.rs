//! Pictures of grains, drawn from a [`Frame`]: those of a run, `frames/NNNNN.svg`, and those that `siloflow render` makes later.
//!
//! A picture is a function of [`Header`], [`Frame`] and [`Style`]. The same frame gives the same picture during and after a run.
//!
//! Wall grains are red and door grains green, as the assignment requires. Grains are coloured by species or by a number. The scale
//! of a number is fixed, so that pictures of a run can be compared. With `network`, each contact is drawn as a bond between the
//! centres. The width of a bond is proportional to the normal force, and bonds of sliding contacts are orange.
//!
//! DVec3 space is drawn as an orthographic projection, from back to front: walls behind the grains, shaded spheres, walls in front
//! of the grains.
//!
//! | part | content |
//! |---|---|
//! | `style.rs` | quantities, colours and direction of looking |
//! | `grains.rs`, `hidden.rs` | discs and spheres; which spheres cannot be seen |
//! | `bonds.rs` | contact forces |
//! | `walls.rs`, `edges.rs`, `clip.rs` | walls as lines, and as translucent surfaces with edges |
//! | `shades.rs` | colours by a number |
//! | `legend.rs` | header, legend and key |
//! | `camera.rs` | the axes of a picture |

pub(crate) mod bonds;
pub mod camera;
mod clip;
mod edges;
mod grains;
mod hidden;
mod legend;
mod shades;
pub mod style;
mod walls;

#[cfg(test)]
mod tests;

pub use self::grains::box_of_grains;
use self::style::Style;
use glam::DVec3;
use siloflow_figures::svg::{Finish, Picture};
use siloflow_files::frames::{Frame, Header};

/// Returns the picture of a frame.
#[must_use]
pub fn draw(header: &Header, frame: &Frame, style: &Style) -> Picture {
    let is_solid = header.dimension == 3;
    let grains = grains::Grains::of(header, frame, style);
    let bonds = bonds::of(header, frame, style, &grains);
    let walls = frame.walls(header);
    let surfaces =
        if is_solid { walls::surfaces(header, &walls, style, grains.middle()) } else { walls::Surfaces::default() };
    Picture {
        low: style.view.0,
        high: style.view.1,
        width: style.width,
        header: legend::header(header, frame, style),
        legend: legend::legend(header, frame, style, &grains),
        legend_rows: legend::rows(header, style),
        key: legend::key(style, &bonds),
        axes: if is_solid { legend::axes(style) } else { Vec::new() },
        behind: surfaces.behind,
        front: surfaces.front,
        lines: if is_solid { Vec::new() } else { walls::lines(&walls, style) },
        discs: grains.discs(style, is_solid),
        finish: if is_solid { Finish::Shaded } else { Finish::Outlined },
        bonds: bonds.shapes,
        ..Picture::default()
    }
}

/// Returns the number of rows above the view in every picture of a run.
#[must_use]
pub fn rows(header: &Header, style: &Style) -> usize {
    // The header and a colour scale have three.
    legend::rows(header, style).max(3)
}

/// Returns a point of a column of vectors.
fn point(numbers: &[f64], dimension: u8, row: usize) -> Option<DVec3> {
    let first = row.checked_mul(dimension.into())?;
    match *numbers.get(first..first + usize::from(dimension))? {
        [x, y] => Some(DVec3::new(x, y, 0.0)),
        [x, y, z] => Some(DVec3::new(x, y, z)),
        _ => None,
    }
}
