//! The Pareto front holds the methods that no other method undercuts in time and error.

/// Indices of the points (time, error, mistakes) on the Pareto front of time and error among the
/// points with the fewest mistakes, fastest first; points without time or error are not on it.
pub fn front(points: &[(Option<f64>, Option<f64>, usize)]) -> Vec<usize> {
    let complete = |(number, point): (usize, &(Option<f64>, Option<f64>, usize))| {
        Some((number, point.0?, point.1?, point.2))
    };
    let mut complete: Vec<_> = points.iter().enumerate().filter_map(complete).collect();
    let fewest = complete.iter().map(|point| point.3).min();
    complete.retain(|point| Some(point.3) == fewest);
    complete.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.2.total_cmp(&b.2)));
    let mut best = f64::INFINITY;
    complete.retain(|point| {
        let better = point.2 < best;
        best = best.min(point.2);
        better
    });
    complete.into_iter().map(|point| point.0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_point_of_the_front_is_undercut_in_time_and_error() {
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
