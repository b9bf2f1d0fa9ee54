//! A tree of boxes finds the nearest of many points; each box is halved along its longest side.

use std::cmp::Ordering;
use std::ops::{Range, RangeInclusive};

/// Maximum number of points of a box that is not halved.
const MAX_LEAF_POINTS: usize = 8;

/// Points in a tree of boxes.
pub struct PointTree {
    points: Vec<[f64; 3]>,
    /// Indices of the points; those of a box are one range.
    order: Vec<usize>,
    boxes: Vec<PointBox>,
}

/// The points of one range, between their lowest and highest coordinates.
struct PointBox {
    range: Range<usize>,
    lowest: [f64; 3],
    highest: [f64; 3],
    /// Both halves; `None` for a leaf.
    halves: Option<[usize; 2]>,
}

/// The nearest point so far.
#[derive(Clone, Copy)]
struct NearestPoint {
    squared: f64,
    index: usize,
}

impl PointTree {
    pub fn new(points: Vec<[f64; 3]>) -> Self {
        let mut tree = Self {
            order: (0..points.len()).collect(),
            points,
            boxes: Vec::new(),
        };
        tree.divide(0..tree.points.len());
        tree
    }

    /// Index of the point that is nearest to a position, the first of equally near ones; 0 without
    /// points.
    pub fn nearest(&self, at: [f64; 3]) -> usize {
        let mut best = NearestPoint {
            squared: f64::INFINITY,
            index: 0,
        };
        self.search(0, at, &mut best);
        best.index
    }

    /// Distance of a position from the nearest point; 0 without points.
    pub fn distance(&self, at: [f64; 3]) -> f64 {
        let nearest = self.points.get(self.nearest(at));
        nearest.map_or(0.0, |point| squared_distance(*point, at).sqrt())
    }

    /// Indices of the points whose distance from a position is in a range, ascending.
    pub fn at_distance(&self, at: [f64; 3], range: RangeInclusive<f64>) -> Vec<usize> {
        let (mut found, mut open) = (Vec::new(), vec![0]);
        while let Some(number) = open.pop() {
            let here = &self.boxes[number];
            let (nearest, farthest) = (here.squared(at).sqrt(), here.farthest_squared(at).sqrt());
            if nearest > *range.end() || farthest < *range.start() {
                continue;
            }
            if let Some(halves) = here.halves {
                open.extend(halves);
                continue;
            }
            let indices = self.order[here.range.clone()].iter().copied();
            let in_range =
                |&index: &usize| range.contains(&squared_distance(self.points[index], at).sqrt());
            found.extend(indices.filter(in_range));
        }
        found.sort_unstable();
        found
    }

    /// Adds the box of a range and those of its halves; returns the index of the box.
    fn divide(&mut self, range: Range<usize>) -> usize {
        let mut lowest = [f64::INFINITY; 3];
        let mut highest = [f64::NEG_INFINITY; 3];
        for &index in &self.order[range.clone()] {
            for (axis, &value) in self.points[index].iter().enumerate() {
                lowest[axis] = lowest[axis].min(value);
                highest[axis] = highest[axis].max(value);
            }
        }
        let index = self.boxes.len();
        self.boxes.push(PointBox {
            range: range.clone(),
            lowest,
            highest,
            halves: None,
        });
        if range.len() > MAX_LEAF_POINTS {
            let side = |axis: &usize| highest[*axis] - lowest[*axis];
            let longest = (0..3).max_by(|a, b| side(a).total_cmp(&side(b)));
            let middle = self.halve(&range, longest.unwrap_or(0));
            let first = self.divide(range.start..middle);
            let second = self.divide(middle..range.end);
            self.boxes[index].halves = Some([first, second]);
        }
        index
    }

    /// Orders a range so that the points before its middle are not above those after it along an
    /// axis; the middle.
    fn halve(&mut self, range: &Range<usize>, axis: usize) -> usize {
        let points = &self.points;
        let by_coordinate = |a: &usize, b: &usize| -> Ordering {
            let along = points[*a][axis].total_cmp(&points[*b][axis]);
            along.then(a.cmp(b))
        };
        let half = range.len() / 2;
        self.order[range.clone()].select_nth_unstable_by(half, by_coordinate);
        range.start + half
    }

    fn search(&self, number: usize, at: [f64; 3], best: &mut NearestPoint) {
        let here = &self.boxes[number];
        let Some([first, second]) = here.halves else {
            for &index in &self.order[here.range.clone()] {
                let squared = squared_distance(self.points[index], at);
                if squared < best.squared || (squared <= best.squared && index < best.index) {
                    *best = NearestPoint { squared, index };
                }
            }
            return;
        };
        let (to_first, to_second) = (
            self.boxes[first].squared(at),
            self.boxes[second].squared(at),
        );
        let sorted = if to_second < to_first {
            [(second, to_second), (first, to_first)]
        } else {
            [(first, to_first), (second, to_second)]
        };
        for (half, squared) in sorted {
            // A box as near as the best may hold a point of a lower index.
            if squared <= best.squared {
                self.search(half, at, best);
            }
        }
    }
}

impl PointBox {
    /// Squared distance of a position from the box, 0 inside it; a lower bound for its points.
    fn squared(&self, at: [f64; 3]) -> f64 {
        let nearest = [0, 1, 2].map(|i| at[i].max(self.lowest[i]).min(self.highest[i]));
        squared_distance(nearest, at)
    }

    /// Squared distance of a position from the farthest corner, an upper bound for the points.
    fn farthest_squared(&self, at: [f64; 3]) -> f64 {
        let farther = |i: usize| match at[i] - self.lowest[i] > self.highest[i] - at[i] {
            true => self.lowest[i],
            false => self.highest[i],
        };
        squared_distance([0, 1, 2].map(farther), at)
    }
}

fn squared_distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let apart = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn the_tree_finds_what_a_search_of_all_points_finds(
            // A coarse lattice: many points as near as each other, and several at one place.
            lattice in proptest::collection::vec((0..5i32, 0..4i32, 0..2i32), 1..120),
            at in (-12..24i32, -12..24i32, -12..24i32),
        ) {
            let point = |(x, y, z): (i32, i32, i32), step: f64| [x, y, z].map(|n| f64::from(n) * step);
            let points: Vec<[f64; 3]> = lattice.into_iter().map(|at| point(at, 1.0)).collect();
            let at = point(at, 0.5);
            let all = 0..points.len();
            let apart = |i: &usize| squared_distance(points[*i], at);
            let tree = PointTree::new(points.clone());
            let within: Vec<usize> = all.clone().filter(|i| (1.0..=9.0).contains(&apart(i))).collect();
            prop_assert_eq!(tree.at_distance(at, 1.0..=3.0), within);
            let expected = all.min_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap();
            prop_assert_eq!(tree.nearest(at), expected);
            let difference = tree.distance(at) - apart(&expected).sqrt();
            prop_assert!(difference.abs() < 1e-12);
        }
    }
}
