//! The contacts as users see them: who touches whom, how deep, with which forces, sticking or sliding.
//!
//! Read-only, for measurements and pictures. In a system of [`Phase::Observe`](crate::step::Phase::Observe):
//!
//! ```
//! use siloflow::prelude::*;
//!
//! fn strongest(contacts: ContactView) {
//!     let forces = contacts.all().into_iter().map(|contact| contact.normal_force);
//!     let largest = forces.fold(0.0, f64::max); // N
//!     # let _ = largest;
//! }
//! ```
//!
//! Forces are the law's at the positions and velocities of the full step, with the springs as the force pass left them;
//! a contact slides if the law, moved on by the time step that was, cuts its friction.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

use crate::contact::{Memory, Pair};
use crate::particle::GrainId;
use crate::space::{Plane, Space};
use crate::step::Clock;
use crate::survey::{Partner, Scenery, Survey};

/// With whom a grain is in contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Touched {
    /// A grain or a wall grain.
    Particle(GrainId),
    /// A flat wall, by its number in the scene, from 1, discs not counted.
    Wall(usize),
}

/// One contact, SI.
#[derive(Clone, Copy, Debug)]
pub struct ContactState<V: Space = Plane> {
    /// The grain from whose side it is seen.
    pub grain: GrainId,
    /// What it touches.
    pub with: Touched,
    /// Centre of the grain, m.
    pub from: V,
    /// From there to the centre of the partner, or to the foot on the wall, m.
    pub to_partner: V,
    /// Overlap, m.
    pub overlap: f64,
    /// Unit vector from the partner to the grain.
    pub normal: V,
    /// Normal force, N; positive where it pushes.
    pub normal_force: f64,
    /// Friction on the grain, N.
    pub friction: V,
    /// |F_t| over mu |F_n|, from 0 to 1; 0 without friction.
    pub mobilised: f64,
    /// Whether friction is at its cap.
    pub is_sliding: bool,
    /// What it remembers.
    pub memory: Memory<V>,
}

impl<V: Space> Survey<'_, V> {
    /// All contacts, in ascending order of the ids; contacts with flat walls come after all others. `dt` in s.
    #[must_use]
    pub fn view(&self, dt: f64) -> Vec<ContactState<V>> {
        let mut all = Vec::new();
        self.contacts(|i, partner, pair, memory| {
            // Seen from the grain of lower id, whichever has the lower slot.
            all.push(match partner {
                Partner::Particle(j) if self.columns.id[j] < self.columns.id[i] => {
                    self.state(j, Partner::Particle(i), &pair.turned(), &memory.turned(), dt)
                }
                _ => self.state(i, partner, pair, memory, dt),
            });
        });
        all.sort_by_key(|contact| match contact.with {
            Touched::Particle(partner) => (false, contact.grain, Some(partner), 0),
            Touched::Wall(wall) => (true, contact.grain, None, wall),
        });
        all
    }

    fn state(&self, i: usize, partner: Partner, pair: &Pair<V>, memory: &Memory<V>, dt: f64) -> ContactState<V> {
        let force = self.law.force(pair, &mut memory.clone());
        let moved_on = self.law.force(&Pair { dt, ..*pair }, &mut memory.clone());
        let normal_force = force.smooth.dot(pair.normal);
        let cap = self.law.friction(pair) * normal_force.abs();
        let friction = force.turning.friction;
        let distance = match partner {
            Partner::Particle(_) => pair.radii[0] + pair.radii[1] - pair.overlap,
            Partner::Wall(_) => pair.radii[0] - pair.overlap,
        };
        ContactState {
            grain: self.columns.id[i],
            with: match partner {
                Partner::Particle(j) => Touched::Particle(self.columns.id[j]),
                Partner::Wall(wall) => Touched::Wall(wall + 1),
            },
            from: self.columns.body[i].position,
            to_partner: pair.normal * -distance,
            overlap: pair.overlap,
            normal: pair.normal,
            normal_force,
            friction,
            mobilised: if cap > 0.0 { (friction.length() / cap).min(1.0) } else { 0.0 },
            is_sliding: moved_on.turning.is_sliding,
            memory: *memory,
        }
    }
}

/// The contacts, for systems.
#[derive(SystemParam)]
pub struct ContactView<'w, V: Space = Plane> {
    scenery: Scenery<'w, V>,
    clock: Res<'w, Clock>,
}

impl<V: Space> ContactView<'_, V> {
    /// All contacts, in ascending order of the ids.
    #[must_use]
    pub fn all(&self) -> Vec<ContactState<V>> {
        self.scenery.survey().view(self.clock.dt)
    }
}
