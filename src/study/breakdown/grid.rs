//! The cells of a slice form a grid over two factors, halved where a success rate crosses its
//! level.

use std::collections::{BTreeMap, BTreeSet};

use super::Axis;

/// A node of the finest grid: column and row.
pub type Node = (usize, usize);

/// A grid over two axes that can be halved a number of times.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    /// First axis, columns.
    pub x: Axis,
    /// Second axis, rows.
    pub y: Axis,
    /// Number of halvings.
    pub levels: u32,
}

impl Grid {
    /// Columns and rows of the finest grid.
    pub fn size(&self) -> (usize, usize) {
        let of = |axis: &Axis| ((axis.count - 1) << self.levels) + 1;
        (of(&self.x), of(&self.y))
    }

    /// The values of a node. Halving makes the same shares of an axis bit for bit, so that they do
    /// not depend on the levels.
    pub fn values(&self, node: Node) -> (f64, f64) {
        let (columns, rows) = self.size();
        let share = |at: usize, of: usize| at as f64 / (of - 1) as f64;
        (
            self.x.at(share(node.0, columns)),
            self.y.at(share(node.1, rows)),
        )
    }

    /// The nodes before any halving.
    pub fn base_nodes(&self) -> BTreeSet<Node> {
        let step = 1 << self.levels;
        let (columns, rows) = self.size();
        let column = |i: usize| (0..rows).step_by(step).map(move |j| (i, j));
        (0..columns).step_by(step).flat_map(column).collect()
    }

    /// The nodes that the halving of a level, from 1, adds: those of every cell of the level before
    /// that has computed corners on both sides. A value that is already there, of a factor of whole
    /// numbers, is not added again.
    pub fn nodes_of_halving(&self, level: u32, inside: &BTreeMap<Node, bool>) -> BTreeSet<Node> {
        let step = 1usize << (self.levels + 1 - level);
        let half = step / 2;
        let (columns, rows) = self.size();
        let mut wanted = BTreeSet::new();
        for i in (0..columns - 1).step_by(step) {
            for j in (0..rows - 1).step_by(step) {
                let corners = [(i, j), (i + step, j), (i, j + step), (i + step, j + step)];
                let computed = || corners.iter().filter_map(|corner| inside.get(corner));
                if computed().any(|above| *above) && computed().any(|above| !above) {
                    let new = [
                        (i + half, j),
                        (i, j + half),
                        (i + half, j + half),
                        (i + step, j + half),
                        (i + half, j + step),
                    ];
                    let missing = |node: &Node| !inside.contains_key(node);
                    wanted.extend(new.into_iter().filter(missing));
                }
            }
        }
        wanted.retain(|node| self.is_new(*node));
        wanted
    }

    /// Whether both values of a node differ from those of the adjacent coarser nodes.
    fn is_new(&self, (i, j): Node) -> bool {
        self.differs_from_coarser_values(i, |i| self.values((i, j)).0)
            && self.differs_from_coarser_values(j, |j| self.values((i, j)).1)
    }

    /// A node added by halving lies between two coarser ones, at a distance of its lowest bit.
    fn differs_from_coarser_values(&self, at: usize, value: impl Fn(usize) -> f64) -> bool {
        if at.is_multiple_of(1 << self.levels) {
            return true;
        }
        let step = 1 << at.trailing_zeros();
        let differs = |other: usize| value(at).to_bits() != value(other).to_bits();
        differs(at - step) && differs(at + step)
    }

    /// Values on the whole finest grid, by column: computed ones unchanged, the others as the mean
    /// of their neighbours in the level before. The base nodes must be computed.
    pub fn interpolate(&self, known: &BTreeMap<Node, f64>) -> Field {
        let (columns, rows) = self.size();
        let mut values = vec![vec![f64::NAN; rows]; columns];
        for ((i, j), value) in known {
            values[*i][*j] = *value;
        }
        for level in 1..=self.levels {
            let half = 1usize << (self.levels - level);
            fill(&mut values, half);
        }
        Field { values }
    }
}

/// Fills the nodes between those of the level before, edges first.
fn fill(values: &mut [Vec<f64>], half: usize) {
    let (columns, rows) = (values.len(), values[0].len());
    let odd = |at: usize| !at.is_multiple_of(2 * half);
    for middles in [false, true] {
        for i in (0..columns).step_by(half) {
            for j in (0..rows).step_by(half) {
                let on_edge = odd(i) != odd(j);
                let in_middle = odd(i) && odd(j);
                if !values[i][j].is_nan() || !(if middles { in_middle } else { on_edge }) {
                    continue;
                }
                let mut ends = Vec::new();
                if odd(i) {
                    ends.extend([values[i - half][j], values[i + half][j]]);
                }
                if odd(j) {
                    ends.extend([values[i][j - half], values[i][j + half]]);
                }
                values[i][j] = ends.iter().sum::<f64>() / ends.len() as f64;
            }
        }
    }
}

/// Values on the finest grid, by column.
#[derive(Clone, Debug)]
pub struct Field {
    /// By column, then row.
    pub values: Vec<Vec<f64>>,
}

#[cfg(test)]
mod tests {
    use super::super::{Factor, Scale};
    use super::*;

    fn axis(factor: Factor, hi: f64, count: usize) -> Axis {
        Axis {
            factor,
            lo: 1.0,
            hi,
            count,
            scale: Scale::Linear,
        }
    }

    fn grid(levels: u32) -> Grid {
        Grid {
            x: axis(Factor::Noise, 9.0, 5),
            y: axis(Factor::Separation, 5.0, 3),
            levels,
        }
    }

    /// Halves where `x + y` crosses a limit, as a slice does.
    fn refined(grid: &Grid, limit: f64) -> BTreeMap<Node, bool> {
        let node_state = |node: &Node| {
            let (x, y) = grid.values(*node);
            (*node, x + y < limit)
        };
        let mut inside: BTreeMap<Node, bool> = grid.base_nodes().iter().map(node_state).collect();
        for level in 1..=grid.levels {
            let new = grid.nodes_of_halving(level, &inside);
            inside.extend(new.iter().map(node_state));
        }
        inside
    }

    #[test]
    fn cells_are_halved_along_the_contour_alone() {
        let grid = grid(2);
        assert_eq!(grid.size(), (17, 9));
        let inside = refined(&grid, 6.1);
        assert!(
            inside.len() > 15 && inside.len() < 17 * 9 / 2,
            "{}",
            inside.len()
        );
        let step = |node: &Node| {
            let (x, y) = grid.values(*node);
            // A base cell that the contour crosses reaches 4 from it.
            (x + y - 6.1).abs() < 4.1 || (node.0 % 4, node.1 % 4) == (0, 0)
        };
        assert!(inside.keys().all(step));
        // On the finest level some edge of each row has computed nodes on both sides of the
        // contour.
        for j in 0..9 {
            let crossed = (0..16).any(|i| {
                let pair = [inside.get(&(i, j)), inside.get(&(i + 1, j))];
                matches!(pair, [Some(true), Some(false)])
            });
            assert!(crossed, "row {j}");
        }
    }

    #[test]
    fn values_do_not_depend_on_the_levels() {
        let (coarse, fine) = (grid(0), grid(3));
        for (i, j) in coarse.base_nodes() {
            assert_eq!(coarse.values((i, j)), fine.values((i << 3, j << 3)));
        }
    }

    #[test]
    fn whole_numbers_are_not_drawn_twice() {
        let grid = Grid {
            x: axis(Factor::Hits, 5.0, 5),
            ..grid(2)
        };
        let inside = refined(&grid, 4.6);
        let mut seen = BTreeSet::new();
        for node in inside.keys() {
            let (x, y) = grid.values(*node);
            assert!(seen.insert((x.to_bits(), y.to_bits())), "{x} {y}");
        }
    }

    #[test]
    fn nodes_between_computed_ones_are_interpolated() {
        let grid = grid(1);
        let known = grid.base_nodes().into_iter();
        let known = known.map(|node| (node, grid.values(node).0));
        let field = grid.interpolate(&known.collect());
        for (i, column) in field.values.iter().enumerate() {
            for value in column {
                assert!((value - grid.values((i, 0)).0).abs() < 1e-12);
            }
        }
    }
}
