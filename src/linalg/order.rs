//! Elements are sorted by a number: the numbers are sorted, and the elements moved to their places,
//! so that one sort is compiled for all types of elements.

/// Sorts by ascending value ([`f64::total_cmp`]); elements of equal value keep their order. The
/// value is computed once for each element.
pub fn sort_ascending_by<T>(elements: &mut [T], value: impl Fn(&T) -> f64) {
    let values: Vec<f64> = elements.iter().map(value).collect();
    move_to_places(elements, ascending(&values));
}

/// As [`sort_ascending_by`], by descending value.
pub fn sort_descending_by<T>(elements: &mut [T], value: impl Fn(&T) -> f64) {
    sort_ascending_by(elements, |element| -value(element));
}

/// Indices of the values in ascending order.
fn ascending(values: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    order
}

/// Moves element `order[i]` to place `i`, cycle by cycle.
fn move_to_places<T>(elements: &mut [T], mut order: Vec<usize>) {
    for start in 0..order.len() {
        let mut place = start;
        loop {
            let from = std::mem::replace(&mut order[place], place);
            if from == start {
                break;
            }
            elements.swap(place, from);
            place = from;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_is_that_of_a_stable_sort_by_the_value() {
        let signed_zeros_and_nan = [0.0, -0.0, f64::NAN, f64::INFINITY, -f64::NAN];
        for count in 0..40_u64 {
            // Few different values, so that many are equal.
            let number = |i: u64| i.wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(9) % 7;
            let values = (0..count).map(|i| number(i + 31 * count) as f64 - 3.0);
            let values = values.chain(signed_zeros_and_nan);
            let elements: Vec<(f64, usize)> = values.zip(0..).collect();
            let numbers = |sorted: &[(f64, usize)]| -> Vec<usize> {
                sorted.iter().map(|(_, number)| *number).collect()
            };
            let (mut expected, mut sorted) = (elements.clone(), elements.clone());
            expected.sort_by(|a, b| a.0.total_cmp(&b.0));
            sort_ascending_by(&mut sorted, |element| element.0);
            assert_eq!(numbers(&sorted), numbers(&expected));
            let (mut expected, mut sorted) = (elements.clone(), elements);
            expected.sort_by(|a, b| b.0.total_cmp(&a.0));
            sort_descending_by(&mut sorted, |element| element.0);
            assert_eq!(numbers(&sorted), numbers(&expected));
        }
    }
}
