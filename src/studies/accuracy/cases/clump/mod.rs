//! Rigid bodies of equal discs: impacts off the centre, a cross that spins, a pair that slides, a pair that topples.

mod body;
mod cross;
mod impacts;
mod slide;
mod topple;

use super::super::case::Case;

pub(super) fn cases() -> Vec<Case> {
    let mut cases = impacts::cases();
    cases.extend(cross::cases());
    cases.extend([slide::case(), topple::case()]);
    cases
}
