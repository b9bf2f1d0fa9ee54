//! The accepted names and bounds, as the text of an error lists them.

/// The known name most like a given one, when it is like it at all (Jaro-Winkler similarity 0.7 or
/// more).
pub(super) fn nearest_name<'a>(
    got: &str,
    known: impl IntoIterator<Item = &'a str>,
) -> Option<String> {
    known
        .into_iter()
        .map(|name| (strsim::jaro_winkler(got, name), name))
        .filter(|(similarity, _)| *similarity >= 0.7)
        .max_by(|a, b| a.0.total_cmp(&b.0).then_with(|| b.1.cmp(a.1)))
        .map(|(_, name)| name.to_owned())
}

pub(super) fn expected_nearest(nearest: Option<&str>) -> String {
    nearest.map_or_else(String::new, |name| format!("; did you mean `{name}`?"))
}

/// Maximum number of names that an error lists.
const MAX_LISTED_NAMES: usize = 12;

pub(super) fn expected_name(nearest: Option<&str>, known: &[String]) -> String {
    let list = match known {
        [] => "none, since none is declared".to_owned(),
        few if few.len() <= MAX_LISTED_NAMES => format!("one of {}", few.join(", ")),
        many => format!(
            "one of {} and {} more",
            many[..MAX_LISTED_NAMES].join(", "),
            many.len() - MAX_LISTED_NAMES
        ),
    };
    list + &expected_nearest(nearest)
}

pub(super) fn expected_bounds(lower: Option<f64>, upper: Option<f64>, unit: &str) -> String {
    match (lower, upper) {
        (None, None) => String::new(),
        (Some(lower), None) => format!(" from {lower} {unit} (its bound `lower`)"),
        (None, Some(upper)) => format!(" up to {upper} {unit} (its bound `upper`)"),
        (Some(lower), Some(upper)) => {
            format!(" from {lower} to {upper} {unit} (its bounds `lower` and `upper`)")
        }
    }
}
