//! Walls: half-spaces, segments and panels, at rest, moving within their surface, or moved by forces.

use crate::free_wall::FreeWall;
use crate::vector::V;

#[derive(Clone, Copy, Debug)]
pub enum Shape {
    /// Half-space, solid behind its unit normal, moving within its surface.
    Half {
        point: V,
        normal: V,
        velocity: V,
    },
    Segment {
        from: V,
        to: V,
    },
    Panel {
        corner: V,
        along: V,
        across: V,
    },
}

/// The place on a wall that is nearest to a point.
#[derive(Clone, Copy, Debug)]
pub struct Foot {
    pub place: V,
    /// From the wall to the point, m.
    pub distance: f64,
    /// Unit vector towards the point.
    pub normal: V,
    /// Velocity of the wall there, m/s, in the middle of the step.
    pub velocity: V,
    /// Velocity that the wall gains there from the middle of the step to its end, m/s, as far as the scheme predicts it.
    pub gained: V,
}

#[derive(Clone, Copy, Debug)]
pub struct Wall {
    pub shape: Shape,
    pub species: usize,
    /// For a wall that forces move.
    pub free: Option<FreeWall>,
    /// Force of the grains, N.
    pub load: V,
    /// Torque of that force about the origin, N m.
    pub moment: V,
}

impl Shape {
    fn foot(&self, x: V) -> Foot {
        let share = |from: V, edge: V| ((x - from).dot(edge) / edge.dot(edge)).clamp(0.0, 1.0);
        let place = match *self {
            Self::Half { point, normal, velocity } => {
                let distance = (x - point).dot(normal);
                return Foot { place: x - normal * distance, distance, normal, velocity, gained: V::default() };
            }
            Self::Segment { from, to } => from + (to - from) * share(from, to - from),
            Self::Panel { corner, along, across } => {
                corner + along * share(corner, along) + across * share(corner, across)
            }
        };
        let [velocity, gained] = [V::default(); 2];
        Foot { place, distance: (x - place).length(), normal: (x - place).unit(), velocity, gained }
    }

    /// Returns the shape after a rigid motion of its points and its directions.
    #[must_use]
    pub fn moved(&self, place: impl Fn(V) -> V, turned: impl Fn(V) -> V) -> Self {
        match *self {
            Self::Half { point, normal, velocity } => {
                Self::Half { point: place(point), normal: turned(normal), velocity: turned(velocity) }
            }
            Self::Segment { from, to } => Self::Segment { from: place(from), to: place(to) },
            Self::Panel { corner, along, across } => {
                Self::Panel { corner: place(corner), along: turned(along), across: turned(across) }
            }
        }
    }
}

impl Wall {
    /// A wall that forces do not move.
    pub fn new(shape: Shape, species: usize) -> Self {
        Self { shape, species, free: None, load: V::default(), moment: V::default() }
    }

    /// Returns the place nearest to a point.
    pub fn foot(&self, x: V) -> Foot {
        let foot = self.shape.foot(x);
        let Some(free) = self.free else { return foot };
        let [velocity, gained] = [free.rate, free.gained].map(|rate| free.velocity(foot.place, rate));
        Foot { velocity: foot.velocity + velocity, gained, ..foot }
    }

    pub fn drift(&mut self, dt: f64, is_centred: bool) {
        if let Some(free) = &mut self.free {
            self.shape = free.drift(dt, is_centred);
        }
    }

    pub fn kick(&mut self, gravity: V, dt: f64) {
        if let Some(free) = &mut self.free {
            free.kick([self.load, self.moment], gravity, dt);
        }
    }
}
