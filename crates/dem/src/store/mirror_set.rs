//! Sets of mirrored components: [`Position`](crate::particle::Position), [`Velocity`](crate::particle::Velocity),
//! [`Force`](crate::particle::Force), [`Spin`](crate::spin::Spin), [`Torque`](crate::spin::Torque) and
//! [`Orientation`](crate::bodies::Orientation).

/// A set of mirrored components, kept separately for free and fixed particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct MirrorSet(u16);

/// Number of mirrored components.
const KINDS: u16 = 6;

impl MirrorSet {
    pub(crate) const NONE: Self = Self(0);
    pub(crate) const POSITION: Self = Self::free_and_fixed(0);
    pub(crate) const VELOCITY: Self = Self::free_and_fixed(1);
    pub(crate) const FORCE: Self = Self::free_and_fixed(2);
    pub(crate) const SPIN: Self = Self::free_and_fixed(3);
    pub(crate) const TORQUE: Self = Self::free_and_fixed(4);
    pub(crate) const ORIENTATION: Self = Self::free_and_fixed(5);
    pub(crate) const ALL: Self = Self((1 << (2 * KINDS)) - 1);
    /// All components of free particles.
    pub(crate) const FREE: Self = Self((1 << KINDS) - 1);
    /// All components of fixed particles.
    pub(crate) const FIXED: Self = Self(Self::ALL.0 & !Self::FREE.0);

    const fn free_and_fixed(kind: u16) -> Self {
        Self(1 << kind | 1 << (kind + KINDS))
    }

    pub(crate) const fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    pub(crate) const fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    pub(crate) const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    pub(crate) const fn is_none(self) -> bool {
        self.0 == 0
    }

    /// Whether the two sets have a common element.
    pub(crate) const fn meets(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    pub(crate) fn add(&mut self, other: Self) {
        *self = self.or(other);
    }
}
