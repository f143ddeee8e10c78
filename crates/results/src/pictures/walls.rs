//! Walls of a frame: lines in the plane, translucent surfaces with edges in solid space.
//!
//! A surface is behind the grains if their mean place lies on the observer's side of it, and in front of them otherwise. Surfaces in
//! front are fainter, so that they hardly change the colours of grains. Surfaces without ends are shown inside the box of the
//! scene. A cut leaves out what is in front of it.

use super::clip::{self, HalfSpace};
use super::edges::{Face, edges};
use super::style::Style;
use glam::{DVec2, DVec3};
use siloflow_figures::colour::{self, Rgb};
use siloflow_figures::svg::Patch;
use siloflow_files::frames::{Header, WallGeometry};

/// Opacity of surfaces behind and in front of the grains.
const OPACITY: [f64; 2] = [0.16, 0.05];

/// Most faces of a wall whose surface is drawn. Of larger meshes only edges are.
const MOST_FACES: usize = 20_000;

/// Translucent surfaces: one patch for each colour.
#[derive(Default)]
pub(super) struct Surfaces {
    pub behind: Vec<Patch>,
    pub front: Vec<Patch>,
}

/// The colour of a wall: `usual`, unless it is a door.
fn colour_of(wall: &WallGeometry, usual: Rgb) -> Rgb {
    if wall.is_door { colour::DOOR } else { usual }
}

/// Returns the walls of a plane as lines. A line without ends goes through the whole view.
pub(super) fn lines(walls: &[&WallGeometry], style: &Style) -> Vec<(DVec2, DVec2, Rgb)> {
    let mut lines = Vec::new();
    for wall in walls {
        let point = |place: u32| wall.points.get(place as usize).map(|&point| DVec3::from_array(point));
        for [from, to] in &wall.lines {
            let (Some(from), Some(to)) = (point(*from), point(*to)) else { continue };
            let [mut from, mut to] = [from, to].map(|end| style.camera.on_paper(end));
            if style.endless.contains(&wall.number) {
                let along = (to - from).try_normalize().unwrap_or(DVec2::X);
                let middle = 0.5 * (style.view.0 + style.view.1);
                let reach = style.view.0.distance(style.view.1);
                let foot = from + (middle - from).dot(along) * along;
                (from, to) = (foot - reach * along, foot + reach * along);
            }
            lines.push((from, to, colour_of(wall, colour::WALL)));
        }
    }
    lines
}

/// Returns the walls of solid space as surfaces. `grains` is the mean place of the grains, m.
pub(super) fn surfaces(header: &Header, walls: &[&WallGeometry], style: &Style, grains: Option<DVec3>) -> Surfaces {
    let domain = header.domain.map(DVec3::from_array);
    let middle = grains.unwrap_or(0.5 * (domain[0] + domain[1]));
    let size = (domain[1] - domain[0]).length().max(f64::MIN_POSITIVE);
    let cut = style.depth_of_cut(header).map(|level| HalfSpace { normal: style.camera.depth, level });
    let mut surfaces = Surfaces::default();
    for wall in walls {
        let faces = faces(wall, style, domain, cut, middle);
        let edges = edges(&faces, style.camera.depth, size);
        let is_drawn = faces.len() <= MOST_FACES;
        for (is_front, patches) in [(false, &mut surfaces.behind), (true, &mut surfaces.front)] {
            let patch = patch_of(patches, colour_of(wall, colour::SURFACE), OPACITY[usize::from(is_front)]);
            let shown = faces.iter().filter(|face| is_drawn && face.is_front == is_front);
            let on_paper = |face: &Face| face.corners.iter().map(|&corner| style.camera.on_paper(corner)).collect();
            patch.polygons.extend(shown.map(on_paper).map(anticlockwise));
            let of_layer = edges.iter().filter(|edge| edge.is_front == is_front);
            patch.edges.extend(of_layer.map(|edge| edge.ends.map(|end| style.camera.on_paper(end))));
        }
    }
    surfaces
}

/// Returns the patch of a colour.
fn patch_of(patches: &mut Vec<Patch>, colour: Rgb, opacity: f64) -> &mut Patch {
    let place = patches.iter().position(|patch| patch.colour == colour).unwrap_or_else(|| {
        patches.push(Patch { colour, opacity, ..Patch::default() });
        patches.len() - 1
    });
    &mut patches[place]
}

/// Returns the triangles of a wall that are shown.
fn faces(wall: &WallGeometry, style: &Style, domain: [DVec3; 2], cut: Option<HalfSpace>, grains: DVec3) -> Vec<Face> {
    let is_endless = style.endless.contains(&wall.number);
    let mut faces = Vec::with_capacity(wall.triangles.len());
    for triangle in &wall.triangles {
        let points = triangle.map(|place| wall.points.get(place as usize).map(|&point| DVec3::from_array(point)));
        let [Some(a), Some(b), Some(c)] = points else { continue };
        let Some(normal) = (b - a).cross(c - a).try_normalize() else { continue };
        let mut corners = vec![a, b, c];
        if is_endless {
            corners = clip::inside(domain).into_iter().fold(corners, |corners, half| clip::polygon(&corners, half));
        }
        if let Some(cut) = cut {
            corners = clip::polygon(&corners, cut);
        }
        if !corners.is_empty() {
            // The observer is where the depth is lower.
            let is_front = normal.dot(style.camera.depth) * normal.dot(grains - a) > 0.0;
            let is_front = is_front && normal.dot(style.camera.depth).abs() > 1e-6;
            faces.push(Face { corners, normal, is_front });
        }
    }
    faces
}

/// Returns a polygon with its corners in anticlockwise order, so that overlaps of polygons in a path are filled.
fn anticlockwise(mut corners: Vec<DVec2>) -> Vec<DVec2> {
    let area: f64 = (0..corners.len()).map(|n| corners[n].perp_dot(corners[(n + 1) % corners.len()])).sum();
    if area < 0.0 {
        corners.reverse();
    }
    corners
}
