//! The direction from which a picture shows solid space: orthographic, so that equal lengths are equal wherever they are.
//!
//! | axis of the picture | direction |
//! |---|---|
//! | depth | the direction of looking |
//! | right | depth x z; depth x y if the direction of looking is vertical |
//! | up | right x depth |
//!
//! A plane is seen with x to the right and y up.

use serde::{Deserialize, Serialize};

use glam::{DVec2, DVec3};

/// The scene's `pictures.direction`: where the observer looks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub enum Direction {
    /// Along y: x is to the right, z up.
    #[default]
    Front,
    /// Against y.
    Back,
    /// Along x, from the left: y is to the left.
    Left,
    /// Against x, from the right: y is to the right.
    Right,
    /// Down.
    Top,
    /// Up, from below.
    Bottom,
    /// From above, right and front, with all axes equally long.
    Iso,
    /// Along this vector (x, y, z) of any length, from the observer to the scene.
    Towards(f64, f64, f64),
}

impl Direction {
    /// Names of the command line. `side` is `right`.
    pub const NAMES: [(&'static str, Self); 8] = [
        ("front", Self::Front),
        ("back", Self::Back),
        ("left", Self::Left),
        ("right", Self::Right),
        ("side", Self::Right),
        ("top", Self::Top),
        ("bottom", Self::Bottom),
        ("iso", Self::Iso),
    ];

    /// Reads one of [`Direction::NAMES`], or three numbers with commas between them.
    ///
    /// # Errors
    /// If it is neither, or the vector has no direction.
    pub fn read(text: &str) -> Result<Self, String> {
        if let Some((_, direction)) = Self::NAMES.into_iter().find(|(name, _)| *name == text.trim()) {
            return Ok(direction);
        }
        let numbers: Vec<f64> = text.split(',').filter_map(|number| number.trim().parse().ok()).collect();
        let direction = match numbers[..] {
            [x, y, z] if text.split(',').count() == 3 => Self::Towards(x, y, z),
            _ => {
                let names = Self::NAMES.map(|(name, _)| name).join(", ");
                return Err(format!("expected {names}, or a vector such as 1,2,-1, got `{text}`"));
            }
        };
        direction.is_valid().then_some(direction).ok_or_else(|| format!("the vector {text} has no direction"))
    }

    /// Whether it has a length that is neither zero nor infinite.
    #[must_use]
    pub fn is_valid(self) -> bool {
        let length = self.vector().length();
        length.is_finite() && length > 0.0
    }

    fn vector(self) -> DVec3 {
        match self {
            Self::Front => DVec3::Y,
            Self::Back => -DVec3::Y,
            Self::Left => DVec3::X,
            Self::Right => -DVec3::X,
            Self::Top => -DVec3::Z,
            Self::Bottom => DVec3::Z,
            Self::Iso => DVec3::new(-1.0, 1.0, -1.0),
            Self::Towards(x, y, z) => DVec3::new(x, y, z),
        }
    }
}

/// Axes of a picture as unit vectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// To the right.
    pub right: DVec3,
    /// Up.
    pub up: DVec3,
    /// Away from the observer.
    pub depth: DVec3,
}

impl Camera {
    /// The camera of a plane.
    pub const PLANE: Self = Self { right: DVec3::X, up: DVec3::Y, depth: DVec3::NEG_Z };

    /// Returns the camera that looks in this direction of solid space.
    #[must_use]
    pub fn towards(direction: Direction) -> Self {
        let depth = direction.vector().try_normalize().unwrap_or(DVec3::Y);
        let upright = if depth.z.abs() > 0.999 { DVec3::Y } else { DVec3::Z };
        let right = depth.cross(upright).try_normalize().unwrap_or(DVec3::X);
        Self { right, up: right.cross(depth), depth }
    }

    /// Returns the place on the picture of a point in space, m.
    #[must_use]
    pub fn on_paper(&self, x: DVec3) -> DVec2 {
        DVec2::new(self.right.dot(x), self.up.dot(x))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(direction: Direction) -> Camera {
        Camera::towards(direction)
    }

    #[test]
    fn names_show_the_axes_that_they_say() {
        let x = DVec3::new(1.0, 2.0, 3.0);
        for (direction, expected) in [
            (Direction::Front, (1.0, 3.0)),
            (Direction::Back, (-1.0, 3.0)),
            (Direction::Right, (2.0, 3.0)),
            (Direction::Left, (-2.0, 3.0)),
            (Direction::Top, (1.0, 2.0)),
            (Direction::Bottom, (-1.0, 2.0)),
        ] {
            assert_eq!(camera(direction).on_paper(x), DVec2::from(expected), "{direction:?}");
        }
        assert_eq!(Camera::PLANE.on_paper(x), DVec2::new(1.0, 2.0));
    }

    #[test]
    fn lengths_are_kept_across_the_direction_of_looking() {
        for direction in [Direction::Iso, Direction::Towards(1.0, -2.0, 0.3), Direction::Towards(0.01, 0.0, 9.0)] {
            let Camera { right, up, depth } = camera(direction);
            for (a, b, product) in [(right, right, 1.0), (up, up, 1.0), (right, up, 0.0), (up, depth, 0.0)] {
                assert!((a.dot(b) - product).abs() < 1e-12, "{direction:?}");
            }
        }
        let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| camera(Direction::Iso).on_paper(axis).length());
        assert!((x - y).abs() < 1e-12 && (y - z).abs() < 1e-12);
    }

    #[test]
    fn directions_are_read() {
        assert_eq!(Direction::read("side"), Ok(Direction::Right));
        assert_eq!(Direction::read("1, 2,-1"), Ok(Direction::Towards(1.0, 2.0, -1.0)));
        for wrong in ["askew", "1,2", "1,2,x,3", "0,0,0", "1,nan,0", ""] {
            assert!(Direction::read(wrong).is_err(), "{wrong}");
        }
        assert!(Direction::read("askew").unwrap_err().contains("iso"));
    }
}
