//! Which frames of a run are packed, if there is no room for all: evenly spaced by number, from the first to the last.

/// Most bytes of all frames before they are compressed, in the memory of a browser.
const LARGEST_CONTENT: u64 = 256 << 20;

/// A choice of frames.
#[derive(Clone, Copy, Debug)]
pub(super) struct Thinning {
    /// Number of frames of the run.
    pub all: usize,
    /// Number of frames to pack.
    pub kept: usize,
}

impl Thinning {
    /// Chooses as many frames as fit into the memory of a browser, of a run with about so many bytes before compression.
    pub fn new(all: usize, content: u64) -> Self {
        Self { all, kept: share(all, LARGEST_CONTENT, content) }
    }

    /// Whether a frame of this number is packed.
    pub fn takes(self, number: usize) -> bool {
        let rank = |number: usize| (number as u128 * (self.kept.max(2) - 1) as u128) / (self.all.max(2) - 1) as u128;
        number == 0 || (self.kept > 1 && rank(number) > rank(number - 1))
    }

    /// Chooses fewer frames, after `bytes` of `packed` ones where `most` bytes are allowed. Returns `false` if two frames are left, which
    /// stay whatever they need.
    pub fn thin(&mut self, bytes: usize, packed: usize, most: usize) -> bool {
        if self.kept <= 2 {
            return false;
        }
        let estimate = (bytes as u64).saturating_mul(self.kept as u64) / packed.max(1) as u64;
        // Differences between frames further apart are longer.
        self.kept = share(self.kept, most as u64 / 20 * 19, estimate).min(self.kept - 1);
        true
    }
}

/// Returns the number of frames of which `allowed` bytes consist, if all have `bytes`; at least two.
fn share(frames: usize, allowed: u64, bytes: u64) -> usize {
    if bytes <= allowed {
        return frames;
    }
    let part = frames as u128 * u128::from(allowed) / u128::from(bytes);
    usize::try_from(part).unwrap_or(frames).max(2).min(frames)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kept_frames_are_evenly_spaced() {
        for (all, kept) in [(1, 1), (2, 2), (1000, 1000), (1000, 999), (1000, 501), (1000, 500), (17, 5), (1000, 2)] {
            let thinning = Thinning { all, kept };
            let taken: Vec<usize> = (0..all).filter(|number| thinning.takes(*number)).collect();
            assert_eq!((taken.len(), taken[0], taken[taken.len() - 1]), (kept, 0, all - 1));
            let gaps: Vec<usize> = taken.windows(2).map(|pair| pair[1] - pair[0]).collect();
            assert!(gaps.iter().max() <= gaps.iter().min().map(|gap| gap + 1).as_ref(), "{gaps:?}");
        }
    }

    #[test]
    fn there_are_fewer_frames_until_they_fit() {
        assert_eq!(Thinning::new(1000, LARGEST_CONTENT).kept, 1000);
        assert_eq!(Thinning::new(1000, 4 * LARGEST_CONTENT).kept, 250);
        assert_eq!(Thinning::new(1000, u64::MAX).kept, 2);
        let mut thinning = Thinning { all: 1000, kept: 1000 };
        // 100 frames already have as many bytes as are allowed.
        assert!(thinning.thin(2000, 100, 2000));
        assert_eq!(thinning.kept, 95);
        assert!(thinning.thin(1000, 95, 2000) && thinning.kept == 94);
        while thinning.thin(2000, 1, 2) {}
        assert_eq!(thinning.kept, 2);
    }
}
