//! OBJ files of Wavefront: corners (`v`) and faces (`f`).
//!
//! | line | read as |
//! |---|---|
//! | `v x y z ...` | a corner; further numbers (a weight, a colour) are not used |
//! | `f 1 2 3`, `f 1/4/7 2//8 -1` | a face; the number before the first `/` names the corner, from 1, or from -1 backwards |
//! | `curv`, `curv2`, `surf` | refused: curves and surfaces without corners |
//! | other, such as `vn`, `vt`, `g`, `o`, `usemtl`, `l`, `p`, `#` | not used: a line or a point is no wall |
//!
//! A backslash continues a line. A face of more than three corners is divided into triangles: a convex one into those at its first corner,
//! another one by ears ([`triangulation`]). Its corners have to be in one plane, up to [`FLAT`], and its edges must not cross.

use super::{Found, without_d};
use crate::space::Solid;
use crate::walls::triangulation;

/// Largest distance of a corner from the plane of its face, in sizes of the face: far above the rounding of six digits. Within it, triangles on
/// either diagonal are the same wall for a grain.
const FLAT: f64 = 1e-3;

/// A face: its line, and its corners as they stand there with the number of corners read before.
struct Face<'a> {
    line: usize,
    corners: Vec<&'a str>,
    before: usize,
}

/// Reads an OBJ file.
pub(super) fn read(text: &str) -> Result<Found, String> {
    let mut corners = Vec::new();
    let mut faces = Vec::new();
    let mut lines = (1..).zip(text.lines());
    while let Some((line, first)) = lines.next() {
        let mut words: Vec<&str> = Vec::new();
        let mut part = first;
        loop {
            let content = part.split('#').next().unwrap_or_default().trim_end();
            let continued = content.strip_suffix('\\');
            words.extend(continued.unwrap_or(content).split_whitespace());
            match continued.and_then(|_| lines.next()) {
                Some((_, next)) => part = next,
                None => break,
            }
        }
        let Some((keyword, words)) = words.split_first() else { continue };
        match keyword.to_ascii_lowercase().as_str() {
            "v" => corners.push(corner(words).map_err(|message| format!("line {line}: {message}"))?),
            "f" => faces.push(Face { line, corners: words.to_vec(), before: corners.len() }),
            "curv" | "curv2" | "surf" => {
                return Err(format!(
                    "line {line}: `{keyword}` is a curve or a curved surface; export the mesh as faces"
                ));
            }
            _ => {}
        }
    }
    let mut found = Found::default();
    for face in &faces {
        let bad = |message| format!("line {}: {message}", face.line);
        for triangle in triangles(face, &corners).map_err(bad)? {
            found.add(triangle, face.line)?;
        }
    }
    Ok(found)
}

fn corner(words: &[&str]) -> Result<Solid, String> {
    let [x, y, z, ..] = words else {
        return Err(format!("a corner has three numbers, and here are {}", words.len()));
    };
    let mut corner = Solid::ZERO;
    for (axis, word) in [x, y, z].into_iter().enumerate() {
        corner[axis] = match without_d(word).parse::<f64>() {
            Ok(number) if number.is_finite() => number,
            _ => return Err(format!("a finite number such as -1.5e-3 should stand here, not `{word}`")),
        };
    }
    Ok(corner)
}

/// Returns the number of a corner, from 0.
fn index(word: &str, before: usize, count: usize) -> Result<usize, String> {
    let number = word.split('/').next().unwrap_or_default();
    let from_one = match number.parse::<i64>() {
        Ok(number) if number < 0 => i64::try_from(before).unwrap_or(i64::MAX).saturating_add(number).saturating_add(1),
        Ok(number) => number,
        Err(_) => return Err(format!("the number of a corner should stand here, not `{word}`")),
    };
    let index = usize::try_from(from_one).ok().and_then(|from_one| from_one.checked_sub(1));
    index
        .filter(|&index| index < count)
        .ok_or_else(|| format!("`{word}` names a corner that does not exist: the file has {count}, counted from 1"))
}

fn triangles(face: &Face<'_>, corners: &[Solid]) -> Result<Vec<[Solid; 3]>, String> {
    let indices = face.corners.iter().map(|word| index(word, face.before, corners.len()));
    let mut indices = indices.collect::<Result<Vec<_>, _>>()?;
    // Some programs write a triangle as a face of four corners, two of them the same.
    indices.dedup();
    while indices.len() > 1 && indices.first() == indices.last() {
        indices.pop();
    }
    let points: Vec<Solid> = indices.iter().map(|&index| corners[index]).collect();
    match points[..] {
        [a, b, c] => Ok(vec![[a, b, c]]),
        [_, _, _, ..] => triangulation::of_face(&points, FLAT)
            .map_err(|message| format!("the face of {} corners: {message}", points.len())),
        _ => Err(format!("a face has three corners or more, and here are {} different ones", points.len())),
    }
}
