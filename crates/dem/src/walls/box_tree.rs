//! A tree of boxes in D dimensions, for searches among walls before and beside a run: a search skips whole branches.
//!
//! A branch is halved along the axis on which the centres of its boxes lie farthest apart, so the tree has log2(n) levels whatever the
//! places are. An axis need not be a place: with the radius of a disc, or the direction of a triangle, as another axis, a search can skip
//! branches by these too.

use std::ops::{ControlFlow, Range};

/// The lowest and the highest corner of a box.
pub(crate) type Bounds<const D: usize> = [[f64; D]; 2];

/// Most boxes of a leaf.
const LEAF: usize = 6;

/// A tree of boxes.
#[derive(Clone, Debug)]
pub(crate) struct BoxTree<const D: usize> {
    /// Numbers of the boxes. A branch has a range of them.
    numbers: Vec<usize>,
    branches: Vec<Branch<D>>,
}

#[derive(Clone, Debug)]
struct Branch<const D: usize> {
    bounds: Bounds<D>,
    numbers: Range<usize>,
    /// Its two parts; a leaf has none.
    parts: Option<[usize; 2]>,
}

impl<const D: usize> BoxTree<D> {
    /// Makes the tree of some boxes.
    pub(crate) fn new(boxes: &[Bounds<D>]) -> Self {
        let mut tree = Self { numbers: (0..boxes.len()).collect(), branches: Vec::new() };
        if !boxes.is_empty() {
            tree.grow(boxes, 0..boxes.len());
        }
        tree
    }

    /// Adds the branch of a range of the numbers, and returns its place.
    fn grow(&mut self, boxes: &[Bounds<D>], range: Range<usize>) -> usize {
        let place = self.branches.len();
        let numbers = &mut self.numbers[range.clone()];
        let bounds = around(numbers.iter().map(|&number| boxes[number]));
        self.branches.push(Branch { bounds, numbers: range.clone(), parts: None });
        if range.len() > LEAF {
            let centre = |number: usize, axis: usize| 0.5 * boxes[number][0][axis] + 0.5 * boxes[number][1][axis];
            let centres: Bounds<D> =
                around(numbers.iter().map(|&number| [std::array::from_fn(|axis| centre(number, axis)); 2]));
            let extent = |axis: &usize| centres[1][*axis] - centres[0][*axis];
            let widest = (0..D).max_by(|a, b| extent(a).total_cmp(&extent(b))).unwrap_or(0);
            let half = range.len() / 2;
            numbers
                .select_nth_unstable_by(half, |&a, &b| centre(a, widest).total_cmp(&centre(b, widest)).then(a.cmp(&b)));
            let middle = range.start + half;
            let parts = [self.grow(boxes, range.start..middle), self.grow(boxes, middle..range.end)];
            self.branches[place].parts = Some(parts);
        }
        place
    }

    /// Visits boxes until `visit` breaks. `enters` says of the bounds of a branch whether to look into it.
    pub(crate) fn search(
        &self,
        mut enters: impl FnMut(&Bounds<D>) -> bool,
        mut visit: impl FnMut(usize) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        self.search_with(&mut (), |_| 0.0, |(), bounds| enters(bounds), |(), number| visit(number))
    }

    /// Like [`Self::search`], with what was found so far. Of the two parts of a branch the one with the lower rank comes first.
    pub(crate) fn search_with<F>(
        &self,
        found: &mut F,
        rank: impl Fn(&Bounds<D>) -> f64,
        mut enters: impl FnMut(&F, &Bounds<D>) -> bool,
        mut visit: impl FnMut(&mut F, usize) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let mut open: Vec<usize> = if self.branches.is_empty() { Vec::new() } else { vec![0] };
        while let Some(place) = open.pop() {
            let branch = &self.branches[place];
            if !enters(found, &branch.bounds) {
                continue;
            }
            match branch.parts {
                None => self.numbers[branch.numbers.clone()].iter().try_for_each(|&number| visit(found, number))?,
                Some([a, b]) => {
                    let [of_a, of_b] = [a, b].map(|part| rank(&self.branches[part].bounds));
                    open.extend(if of_b < of_a { [a, b] } else { [b, a] });
                }
            }
        }
        ControlFlow::Continue(())
    }
}

/// Returns the box around some boxes.
fn around<const D: usize>(boxes: impl Iterator<Item = Bounds<D>>) -> Bounds<D> {
    let nothing = [[f64::INFINITY; D], [f64::NEG_INFINITY; D]];
    boxes.fold(nothing, |[low, high], [its_low, its_high]| {
        [
            std::array::from_fn(|axis| low[axis].min(its_low[axis])),
            std::array::from_fn(|axis| high[axis].max(its_high[axis])),
        ]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_search_finds_all_boxes_that_meet_a_box(
            corners in prop::collection::vec((prop::array::uniform3(0..20i32), prop::array::uniform3(0..6i32)), 0..120),
            low in prop::array::uniform3(0..20i32),
            size in 0..9i32,
        ) {
            let number = |n: i32| f64::from(n);
            let boxes: Vec<Bounds<3>> = corners
                .iter()
                .map(|(low, size)| [low.map(number), std::array::from_fn(|axis| number(low[axis] + size[axis]))])
                .collect();
            let wanted = [low.map(number), low.map(|n| number(n + size))];
            let meets = |[low, high]: &Bounds<3>| (0..3).all(|axis| low[axis] <= wanted[1][axis] && high[axis] >= wanted[0][axis]);
            let mut found = Vec::new();
            let whole = BoxTree::new(&boxes).search(
                meets,
                |number| {
                    found.extend(meets(&boxes[number]).then_some(number));
                    ControlFlow::Continue(())
                },
            );
            found.sort_unstable();
            let expected: Vec<_> = (0..boxes.len()).filter(|&number| meets(&boxes[number])).collect();
            prop_assert_eq!(found, expected);
            prop_assert!(whole.is_continue());
        }
    }

    #[test]
    fn equal_boxes_make_a_tree_of_few_levels_and_a_search_can_end() {
        let tree = BoxTree::new(&vec![[[1.0; 2]; 2]; 100_000]);
        let mut visited = 0;
        let found = tree.search(
            |_| true,
            |_| {
                visited += 1;
                if visited == 10 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            },
        );
        assert!(found.is_break() && visited == 10);
    }
}
