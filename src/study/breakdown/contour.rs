//! A contour follows a level of a field on a grid: lines for figures, crossings along a row or
//! column for sentences.
//!
//! Positions are fractions of the axes, 0 to 1.

use std::collections::BTreeMap;

use super::Field;

/// A point as shares of both axes.
pub type Point = [f64; 2];

/// An edge of the grid: its first node, and whether it runs along the first axis.
type Edge = (usize, usize, bool);

impl Field {
    /// Lines along which the field crosses a level, by linear interpolation between nodes (marching
    /// squares).
    ///
    /// # Reference
    /// Lorensen and Cline (1987), Marching cubes, Computer Graphics 21(4), in two dimensions.
    pub fn contour(&self, level: f64) -> Vec<Vec<Point>> {
        let (columns, rows) = (self.values.len(), self.values[0].len());
        let mut neighbours: BTreeMap<Edge, Vec<Edge>> = BTreeMap::new();
        for i in 0..columns - 1 {
            for j in 0..rows - 1 {
                for [a, b] in self.segments(i, j, level) {
                    neighbours.entry(a).or_default().push(b);
                    neighbours.entry(b).or_default().push(a);
                }
            }
        }
        let crossing = |edge: &Edge| self.crossing(edge, level);
        let lines = joined(neighbours).into_iter();
        lines
            .map(|line| line.iter().map(crossing).collect())
            .collect()
    }

    /// Pairs of crossed edges of one square.
    fn segments(&self, i: usize, j: usize, level: f64) -> Vec<[Edge; 2]> {
        let above = |i: usize, j: usize| self.values[i][j] >= level;
        let edges = [
            (above(i, j) != above(i + 1, j), (i, j, true)),
            (above(i + 1, j) != above(i + 1, j + 1), (i + 1, j, false)),
            (above(i, j + 1) != above(i + 1, j + 1), (i, j + 1, true)),
            (above(i, j) != above(i, j + 1), (i, j, false)),
        ];
        let crossed = edges.iter().filter(|(crosses, _)| *crosses);
        let crossed: Vec<Edge> = crossed.map(|(_, edge)| *edge).collect();
        match crossed.as_slice() {
            [a, b] => vec![[*a, *b]],
            // A saddle: the corners that are above stay apart where the middle is below.
            [a, b, c, d] => {
                let corners = [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)];
                let sum: f64 = corners.iter().map(|(i, j)| self.values[*i][*j]).sum();
                let joined = (0.25 * sum >= level) == above(i, j);
                match joined {
                    true => vec![[*a, *b], [*c, *d]],
                    false => vec![[*a, *d], [*b, *c]],
                }
            }
            _ => Vec::new(),
        }
    }

    fn crossing(&self, &(i, j, along): &Edge, level: f64) -> Point {
        let (columns, rows) = (self.values.len(), self.values[0].len());
        let next = if along { (i + 1, j) } else { (i, j + 1) };
        let (a, b) = (self.values[i][j], self.values[next.0][next.1]);
        let share = (level - a) / (b - a);
        let (x, y) = match along {
            true => (i as f64 + share, j as f64),
            false => (i as f64, j as f64 + share),
        };
        [x / (columns - 1) as f64, y / (rows - 1) as f64]
    }

    /// The value at a point inside, linear between nodes.
    pub fn at(&self, [x, y]: Point) -> f64 {
        let part = |share: f64, count: usize| {
            let at = share.clamp(0.0, 1.0) * (count - 1) as f64;
            let first = (at.floor() as usize).min(count.saturating_sub(2));
            (first, at - first as f64)
        };
        let (i, u) = part(x, self.values.len());
        let (j, v) = part(y, self.values[0].len());
        let row = |j: usize| (1.0 - u) * self.values[i][j] + u * self.values[i + 1][j];
        (1.0 - v) * row(j) + v * row(j + 1)
    }

    /// Intervals of an axis, the other one fixed at a share, in which the field is at or above a
    /// level.
    pub fn intervals_above(&self, along_x: bool, fixed: f64, level: f64) -> Vec<(f64, f64)> {
        let count = if along_x {
            self.values.len()
        } else {
            self.values[0].len()
        };
        let position = |k: usize| k as f64 / (count - 1) as f64;
        let value = |k: usize| match along_x {
            true => self.at([position(k), fixed]),
            false => self.at([fixed, position(k)]),
        };
        let mut intervals = Vec::new();
        let mut begin = (value(0) >= level).then_some(0.0);
        for k in 1..count {
            let (a, b) = (value(k - 1), value(k));
            if (a >= level) != (b >= level) {
                let cross = position(k - 1) + (level - a) / (b - a) / (count - 1) as f64;
                match begin.take() {
                    Some(from) => intervals.push((from, cross)),
                    None => begin = Some(cross),
                }
            }
        }
        intervals.extend(begin.map(|from| (from, 1.0)));
        intervals
    }

    /// Distance along an axis from a point to the nearest crossing of a level, with its sign;
    /// `None` where the field does not cross there.
    pub fn distance_to_crossing(&self, point: Point, along_x: bool, level: f64) -> Option<f64> {
        let (position, fixed) = match along_x {
            true => (point[0], point[1]),
            false => (point[1], point[0]),
        };
        let ends = self.intervals_above(along_x, fixed, level).into_iter();
        let ends = ends.flat_map(|(a, b)| [a, b]);
        let inner = ends.filter(|end| *end > 0.0 && *end < 1.0);
        inner
            .map(|end| end - position)
            .min_by(|a, b| a.abs().total_cmp(&b.abs()))
    }
}

/// Chains of edges, open ones from their ends.
fn joined(mut neighbours: BTreeMap<Edge, Vec<Edge>>) -> Vec<Vec<Edge>> {
    let mut lines = Vec::new();
    loop {
        let open = neighbours.iter().find(|(_, to)| to.len() == 1);
        let any = open.or_else(|| neighbours.iter().find(|(_, to)| !to.is_empty()));
        let Some((&start, _)) = any else {
            return lines;
        };
        let mut line = vec![start];
        let mut at = start;
        while let Some(next) = neighbours.get_mut(&at).and_then(Vec::pop) {
            if let Some(back) = neighbours.get_mut(&next) {
                let index = back.iter().position(|edge| *edge == at);
                index.map(|index| back.swap_remove(index));
            }
            line.push(next);
            at = next;
        }
        lines.push(line);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A field of a function of the shares.
    fn field(columns: usize, rows: usize, f: impl Fn(f64, f64) -> f64) -> Field {
        let share = |k: usize, count: usize| k as f64 / (count - 1) as f64;
        let column = |i: usize| {
            let values = (0..rows).map(|j| f(share(i, columns), share(j, rows)));
            values.collect()
        };
        Field {
            values: (0..columns).map(column).collect(),
        }
    }

    #[test]
    fn a_plane_has_a_straight_contour_in_one_piece() {
        let field = field(9, 7, |x, y| x + 0.5 * y);
        let lines = field.contour(0.8);
        assert_eq!(lines.len(), 1);
        for [x, y] in &lines[0] {
            assert!((x + 0.5 * y - 0.8).abs() < 1e-12);
        }
        let ends = [lines[0][0], lines[0][lines[0].len() - 1]];
        assert!(ends.iter().all(|[_, y]| y.min(1.0 - y).abs() < 1e-15));
    }

    #[test]
    fn a_hill_has_a_closed_contour() {
        let field = field(21, 21, |x, y| 1.0 - (x - 0.5).hypot(y - 0.5));
        let lines = field.contour(0.7);
        assert_eq!(lines.len(), 1);
        assert_eq!(lines[0].first(), lines[0].last());
        for [x, y] in &lines[0] {
            // Linear interpolation in squares of 0.05 is off by h²/8r.
            assert!(((x - 0.5).hypot(y - 0.5) - 0.3).abs() < 0.05 * 0.05 / 8.0 / 0.3);
        }
    }

    #[test]
    fn two_corners_are_two_lines() {
        let field = field(2, 2, |x, y| if (x - y).abs() < 0.5 { 0.0 } else { 1.0 });
        assert_eq!(field.contour(0.9).len(), 2);
        assert!(field.contour(2.0).is_empty());
    }

    #[test]
    fn intervals_and_distances_are_those_of_the_crossing() {
        let field = field(11, 5, |x, _| 1.0 - (x - 0.4).abs());
        let inside = field.intervals_above(true, 0.3, 0.85);
        assert_eq!(inside.len(), 1);
        assert!((inside[0].0 - 0.25).abs() < 1e-12 && (inside[0].1 - 0.55).abs() < 1e-12);
        let distance = field.distance_to_crossing([0.9, 0.3], true, 0.85).unwrap();
        assert!((distance + 0.35).abs() < 1e-12);
        assert_eq!(field.distance_to_crossing([0.9, 0.3], false, 0.85), None);
        assert_eq!(field.intervals_above(false, 0.4, 0.5), [(0.0, 1.0)]);
        assert!((field.at([0.43, 0.9]) - 0.97).abs() < 1e-12);
    }
}
