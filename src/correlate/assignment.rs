//! The assignment algorithm pairs rows and columns at minimum cost; pairs may be forbidden and rows
//! may stay unpaired.

/// For every row its column, so that the sum over rows of the cost, or of `alone` for a row without
/// a column, is smallest; no column twice.
///
/// `costs[row][column]` is `None` where the pair is not allowed; costs and `alone` are from 0 to
/// about 1. Costs O(n³). Of equally good answers always the same one is returned.
///
/// ```
/// let costs = [vec![Some(0.1), Some(0.2)], vec![Some(0.0), None]];
/// assert_eq!(modalign::correlate::assign(&costs, 1.0), [Some(1), Some(0)]);
/// ```
///
/// # Reference
/// Kuhn (1955), The Hungarian method for the assignment problem, Naval Research Logistics Quarterly
/// 2; in the shortest augmenting path form of Jonker and Volgenant (1987), Computing 38.
pub fn assign(costs: &[Vec<Option<f64>>], alone: f64) -> Vec<Option<usize>> {
    let rows = costs.len();
    let real = costs.iter().map(Vec::len).max().unwrap_or(0);
    // One more column for every row: a row with one of these is unpaired.
    let cost = |row: usize, column: usize| {
        let given = costs[row].get(column).copied().flatten();
        if column >= real {
            alone
        } else {
            given.unwrap_or(f64::INFINITY)
        }
    };
    let owner = shortest_augmenting_paths(rows, real + rows, cost);
    let mut column_of = vec![None; rows];
    for (column, row) in owner.into_iter().take(real).enumerate() {
        if let Some(row) = row {
            column_of[row] = Some(column);
        }
    }
    column_of
}

/// The row that owns each column when every row has one, `rows <= columns`.
///
/// `row_price + column_price <= cost` holds throughout, with equality for owned columns; each row
/// is added along the shortest path of reduced costs to a column without an owner.
fn shortest_augmenting_paths(
    rows: usize,
    columns: usize,
    cost: impl Fn(usize, usize) -> f64,
) -> Vec<Option<usize>> {
    let mut owner: Vec<Option<usize>> = vec![None; columns];
    let mut row_price = vec![0.0; rows];
    let mut column_price = vec![0.0; columns];
    for new_row in 0..rows {
        let reduced =
            |row: usize, column: usize| cost(row, column) - row_price[row] - column_price[column];
        let path = shortest_path(new_row, &owner, reduced);
        row_price[new_row] += path.length;
        for c in (0..columns).filter(|&c| path.reached[c]) {
            let gain = path.length - path.distance[c];
            column_price[c] -= gain;
            if let Some(row) = owner[c] {
                row_price[row] += gain;
            }
        }
        let mut free = path.end;
        while let Some(previous) = path.before[free] {
            owner[free] = owner[previous];
            free = previous;
        }
        owner[free] = Some(new_row);
    }
    owner
}

/// A shortest path from a new row to a column without an owner.
struct Path {
    end: usize,
    length: f64,
    /// Length of the shortest path to each column, as far as it was needed.
    distance: Vec<f64>,
    /// The column before each on its path; `None` for those next to the new row.
    before: Vec<Option<usize>>,
    /// Columns whose distance is final.
    reached: Vec<bool>,
}

/// Dijkstra's search over columns; a step leads from a column by its owner to any other, at the
/// reduced cost.
fn shortest_path(
    new_row: usize,
    owner: &[Option<usize>],
    reduced: impl Fn(usize, usize) -> f64,
) -> Path {
    let columns = owner.len();
    let mut path = Path {
        end: 0,
        length: 0.0,
        distance: vec![f64::INFINITY; columns],
        before: vec![None; columns],
        reached: vec![false; columns],
    };
    let mut from = (new_row, None);
    loop {
        let (row, column) = from;
        for next in (0..columns).filter(|&c| !path.reached[c]) {
            let distance = path.length + reduced(row, next);
            if distance < path.distance[next] {
                path.distance[next] = distance;
                path.before[next] = column;
            }
        }
        let nearest = (0..columns)
            .filter(|&c| !path.reached[c])
            .min_by(|&a, &b| path.distance[a].total_cmp(&path.distance[b]))
            .expect("there are at least as many columns as rows");
        path.length = path.distance[nearest];
        path.reached[nearest] = true;
        match owner[nearest] {
            Some(row) => from = (row, Some(nearest)),
            None => {
                path.end = nearest;
                return path;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn total(costs: &[Vec<Option<f64>>], alone: f64, chosen: &[Option<usize>]) -> f64 {
        let of_row = |(row, column): (&Vec<Option<f64>>, &Option<usize>)| match column {
            Some(c) => row[*c].expect("a pair that is allowed"),
            None => alone,
        };
        costs.iter().zip(chosen).map(of_row).sum()
    }

    /// The smallest total over every way to give the rows from `row` on.
    fn brute_force(
        costs: &[Vec<Option<f64>>],
        alone: f64,
        row: usize,
        used: &mut Vec<bool>,
    ) -> f64 {
        if row == costs.len() {
            return 0.0;
        }
        let mut best = alone + brute_force(costs, alone, row + 1, used);
        for column in 0..costs[row].len() {
            if let (Some(cost), false) = (costs[row][column], used[column]) {
                used[column] = true;
                best = best.min(cost + brute_force(costs, alone, row + 1, used));
                used[column] = false;
            }
        }
        best
    }

    proptest! {
        #[test]
        fn the_total_is_that_of_the_best_of_all_assignments(
            shape in (0..6usize, 0..6usize),
            numbers in proptest::collection::vec((0.0..1.0f64, 0..4u8), 36),
            alone in 0.05..1.0f64,
        ) {
            let entry = |i: usize, j: usize| {
                let (cost, chance) = numbers[6 * i + j];
                (chance > 0).then_some(cost)
            };
            let costs: Vec<Vec<Option<f64>>> =
                (0..shape.0).map(|i| (0..shape.1).map(|j| entry(i, j)).collect()).collect();
            let chosen = assign(&costs, alone);
            let best = brute_force(&costs, alone, 0, &mut vec![false; shape.1]);
            prop_assert!((total(&costs, alone, &chosen) - best).abs() < 1e-12);
            let mut taken: Vec<usize> = chosen.iter().copied().flatten().collect();
            taken.sort_unstable();
            taken.dedup();
            prop_assert_eq!(taken.len(), chosen.iter().flatten().count());
        }
    }

    #[test]
    fn a_pair_dearer_than_staying_alone_is_not_made() {
        let costs = [vec![Some(0.6), None], vec![None, Some(0.4)]];
        assert_eq!(assign(&costs, 0.5), [None, Some(1)]);
        assert_eq!(assign(&[], 0.5), []);
        assert_eq!(assign(&[vec![], vec![]], 0.5), [None, None]);
    }
}
