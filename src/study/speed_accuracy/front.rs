//! The Pareto front of time and error.

/// Numbers of the points (time, error, mistakes) of the fewest mistakes that no other such point
/// undercuts in time and error, fastest first; points without time or error are on no front.
pub fn front(points: &[(Option<f64>, Option<f64>, usize)]) -> Vec<usize> {
    let known = |(number, point): (usize, &(Option<f64>, Option<f64>, usize))| {
        Some((number, point.0?, point.1?, point.2))
    };
    let mut known: Vec<_> = points.iter().enumerate().filter_map(known).collect();
    let fewest = known.iter().map(|point| point.3).min();
    known.retain(|point| Some(point.3) == fewest);
    known.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.2.total_cmp(&b.2)));
    let mut best = f64::INFINITY;
    known.retain(|point| {
        let better = point.2 < best;
        best = best.min(point.2);
        better
    });
    known.into_iter().map(|point| point.0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_has_who_is_not_both_slower_and_worse() {
        let points = [
            (Some(3.0), Some(1.0), 0),
            (Some(1.0), Some(9.0), 0),
            (Some(2.0), Some(9.0), 0),
            (Some(2.0), Some(4.0), 0),
            (Some(0.5), Some(0.1), 1),
            (None, Some(0.1), 0),
            (Some(4.0), Some(2.0), 0),
        ];
        assert_eq!(front(&points), [1, 3, 0]);
        assert!(front(&[(Some(1.0), None, 0)]).is_empty());
    }
}
