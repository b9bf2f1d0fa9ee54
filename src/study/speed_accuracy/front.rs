//! The Pareto front holds the methods that no other method undercuts in time and error.

/// A method in the comparison by time and error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrontPoint {
    /// Processor time, s; `None` where it was not measured.
    pub cpu_s: Option<f64>,
    /// Error of its frequencies; `None` where it found no mode.
    pub error: Option<f64>,
    /// Missed and spurious modes.
    pub mistakes: usize,
}

/// Indices of the points on the Pareto front of time and error among the points with the fewest
/// mistakes, fastest first; points without time or error are not on it.
pub fn pareto_front(points: &[FrontPoint]) -> Vec<usize> {
    let complete = |(number, point): (usize, &FrontPoint)| {
        Some((number, point.cpu_s?, point.error?, point.mistakes))
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
        let point = |(cpu_s, error, mistakes)| FrontPoint {
            cpu_s,
            error,
            mistakes,
        };
        let points = [
            (Some(3.0), Some(1.0), 0),
            (Some(1.0), Some(9.0), 0),
            (Some(2.0), Some(9.0), 0),
            (Some(2.0), Some(4.0), 0),
            (Some(0.5), Some(0.1), 1),
            (None, Some(0.1), 0),
            (Some(4.0), Some(2.0), 0),
        ];
        assert_eq!(pareto_front(&points.map(point)), [1, 3, 0]);
        assert!(pareto_front(&[point((Some(1.0), None, 0))]).is_empty());
    }
}
