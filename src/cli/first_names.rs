//! Lists of names on one line.

/// Names that a line lists one by one.
const MAX_LISTED_NAMES: usize = 8;

/// The names, of many the first and their number.
pub(super) fn first_names(names: &[String]) -> String {
    match names.get(..MAX_LISTED_NAMES) {
        Some(first) if names.len() > MAX_LISTED_NAMES => {
            format!("{}, … ({} in all)", first.join(", "), names.len())
        }
        _ => names.join(", "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_many_names_the_first_and_their_number_are_listed() {
        let names: Vec<String> = (1..=9).map(|n| n.to_string()).collect();
        assert_eq!(first_names(&names[..8]), "1, 2, 3, 4, 5, 6, 7, 8");
        assert_eq!(first_names(&names), "1, 2, 3, 4, 5, 6, 7, 8, … (9 in all)");
    }
}
