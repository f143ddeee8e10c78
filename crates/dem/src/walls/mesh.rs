//! Triangle meshes from STL files, ASCII or binary, and from OBJ files.
//!
//! Normals in the file are not used: a triangle pushes grains away on both sides. Corners that should be the same may
//! differ by rounding, as far as [`seams`](crate::walls::seams) allows; otherwise a seam counts as an edge. Numbers of an STL file have
//! single precision.

mod obj;
mod stl;

use std::borrow::Cow;
use std::path::Path;

use rustc_hash::FxHashSet;

use crate::space::Solid;
use crate::values::LengthUnit;
use siloflow_text::encoding::decode;

/// Most triangles of a mesh.
pub(crate) const MOST_TRIANGLES: usize = 1_000_000;

/// Least height of a triangle, in lengths of its longest edge.
const LEAST_HEIGHT: f64 = 1e-6;

/// The triangles of a file, in its unit.
#[derive(Default)]
struct Found {
    triangles: Vec<[Solid; 3]>,
    /// The line of each triangle, from 1; 0 in a file without lines.
    lines: Vec<usize>,
}

impl Found {
    fn add(&mut self, triangle: [Solid; 3], line: usize) -> Result<(), String> {
        if self.triangles.len() == MOST_TRIANGLES {
            return Err(too_many());
        }
        self.triangles.push(triangle);
        self.lines.push(line);
        Ok(())
    }
}

/// Reads the triangles of a mesh, m. The ending of the file's name says which format it has.
///
/// # Errors
/// In words, with the number of the triangle, from 1, and of the line.
pub fn read(path: &Path, bytes: &[u8], unit: LengthUnit) -> Result<Vec<[Solid; 3]>, String> {
    let ending = path.extension().map(std::ffi::OsStr::to_ascii_lowercase);
    let mut found = match ending.as_ref().and_then(|ending| ending.to_str()) {
        Some("stl") => stl::read(bytes)?,
        Some("obj") => obj::read(&text(bytes)?)?,
        _ => return Err("the name of a mesh ends with .stl or .obj".to_owned()),
    };
    if found.triangles.is_empty() {
        return Err("the file has no triangle".to_owned());
    }
    for corner in found.triangles.iter_mut().flatten() {
        *corner /= unit.per_metre();
    }
    check(&found)?;
    Ok(found.triangles)
}

fn too_many() -> String {
    format!("the mesh has more than the limit of {MOST_TRIANGLES} triangles")
}

/// Returns the text of a file, whichever characters end its lines.
fn text(bytes: &[u8]) -> Result<String, String> {
    let text = decode(bytes)?;
    Ok(if text.contains('\n') { text } else { text.replace('\r', "\n") })
}

/// Returns a number without the `D` with which Fortran marks an exponent.
fn without_d(word: &str) -> Cow<'_, str> {
    if word.contains(['d', 'D']) { Cow::Owned(word.replace(['d', 'D'], "e")) } else { Cow::Borrowed(word) }
}

/// Refuses triangles that are not finite, have no area, or come twice.
fn check(Found { triangles, lines }: &Found) -> Result<(), String> {
    let mut known = FxHashSet::default();
    for (index, triangle) in triangles.iter().enumerate() {
        let bad = |what: &str| {
            let line = if lines[index] == 0 { String::new() } else { format!(", in line {},", lines[index]) };
            Err(format!("triangle {}{line} {what}", index + 1))
        };
        let [a, b, c] = *triangle;
        if !triangle.iter().all(|corner| corner.is_finite()) {
            return bad("has a number that is not finite");
        }
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        if (b - a).cross(c - a).length() <= LEAST_HEIGHT * longest * longest {
            return bad(&format!("has no area: it is at {}", place(a)));
        }
        let mut corners = triangle.map(|corner| (corner + Solid::ZERO).to_array().map(f64::to_bits));
        corners.sort_unstable();
        if !known.insert(corners) {
            return bad(&format!("comes twice: it is at {}", place(a)));
        }
    }
    Ok(())
}

fn place(x: Solid) -> String {
    format!("({}, {}, {}) m", x.x, x.y, x.z)
}

/// Returns the number of edges that belong to one triangle alone, and of those that belong to more than two.
pub fn open_and_crowded_edges(triangles: &[[Solid; 3]]) -> [usize; 2] {
    let bits = |corner: Solid| (corner + Solid::ZERO).to_array().map(f64::to_bits);
    let mut edges: Vec<_> = triangles
        .iter()
        .flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|ends| {
            let mut ends = ends.map(|corner| bits(*corner));
            ends.sort_unstable();
            ends
        })
        .collect();
    edges.sort_unstable();
    let counts = edges.chunk_by(|a, b| a == b).map(<[_]>::len);
    counts.fold([0; 2], |[open, crowded], count| [open + usize::from(count == 1), crowded + usize::from(count > 2)])
}

#[cfg(test)]
mod tests {
    use super::*;

    const ASCII: &str = "solid tetrahedron
        facet normal 0 0 0 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endloop endfacet
        facet normal 0 0 0 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 0 1 endloop endfacet
        facet normal 0 0 0 outer loop vertex 0 0 0 vertex 0 1 0 vertex 0 0 1 endloop endfacet
        facet normal 0 0 0 outer loop vertex 1 0 0 vertex 0 1 0 vertex 0 0 1 endloop endfacet
        endsolid tetrahedron";
    const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n";

    fn from(name: &str, bytes: &[u8]) -> Result<Vec<[Solid; 3]>, String> {
        read(Path::new(name), bytes, LengthUnit::Centimetre)
    }

    fn ascii() -> String {
        ASCII
            .replace(" outer", "\n outer")
            .replace(" vertex", "\n vertex")
            .replace(" endloop", "\n endloop")
            .replace(" endfacet", "\n endfacet")
    }

    fn binary(triangles: &[[Solid; 3]], header: &[u8]) -> Vec<u8> {
        let mut bytes = header.to_vec();
        bytes.resize(80, b' ');
        bytes.extend(u32::try_from(triangles.len()).unwrap().to_le_bytes());
        for triangle in triangles {
            bytes.extend([0u8; 12]);
            #[expect(clippy::cast_possible_truncation, reason = "the format")]
            triangle.iter().flat_map(Solid::to_array).for_each(|x| bytes.extend(((x * 100.0) as f32).to_le_bytes()));
            bytes.extend([0u8; 2]);
        }
        bytes
    }

    #[test]
    fn formats_agree() {
        let triangles = from("a.STL", ascii().as_bytes()).unwrap();
        assert_eq!(triangles.len(), 4);
        assert_eq!(triangles[3], [Solid::X / 100.0, Solid::Y / 100.0, Solid::Z / 100.0]);
        for header in [&b"made by a program"[..], b"solid, but binary"] {
            assert_eq!(from("a.stl", &binary(&triangles, header)).unwrap(), triangles);
        }
        assert_eq!(from("a.obj", OBJ.as_bytes()).unwrap(), triangles);
        assert_eq!(open_and_crowded_edges(&triangles), [0, 0]);
        assert_eq!(open_and_crowded_edges(&triangles[1..]), [3, 0]);
    }

    #[test]
    fn bad_meshes_are_refused_with_the_number_of_the_triangle() {
        let bad = |name: &str, bytes: &[u8], words: &str| {
            let message = from(name, bytes).unwrap_err();
            assert!(message.contains(words), "{message}");
        };
        bad("a.ply", b"ply", ".stl or .obj");
        bad("a.stl", b"", "STL");
        bad("a.stl", b"solid nothing\nendsolid nothing\n", "no triangle");
        bad("a.stl", ascii().replace("vertex 0 1 0", "vertex 2 0 0").as_bytes(), "triangle 1, in line 2, has no area");
        bad("a.stl", ascii().replace("vertex 0 0 1", "vertex 0 0 nan").as_bytes(), "triangle 2");
        let twice = format!("{OBJ}f 3 2 1\n");
        bad("a.obj", twice.as_bytes(), "triangle 5, in line 9, comes twice");
        bad("a.obj", b"v 0 0 0\nf 1 2 3\n", "line 2");
        let triangles = from("a.obj", OBJ.as_bytes()).unwrap();
        bad("a.stl", &binary(&triangles, b"")[..150], "triangle 2");
    }
}
