//! The mark of a measured mode tells its number in the test from the number of a mode of the model.

/// Name of the published frequencies among the tests.
const PUBLISHED: &str = "published";

/// A mode as texts name it by its label: `hammer #2` is the second mode of the test. Published
/// roots have the numbers of the model's modes, `published f2`.
pub fn measured_mode(label: &str) -> String {
    match label.rsplit_once(" f") {
        Some((test, number)) if test != PUBLISHED => format!("{test} #{number}"),
        _ => label.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_test_modes_and_of_model_modes_have_different_marks() {
        assert_eq!(measured_mode("hammer f2 f12"), "hammer f2 #12");
        assert_eq!(measured_mode("published f3"), "published f3");
    }
}
