//! The title of a test marks synthetic data.

/// The name of a test, with `(synthetic)` where its data are computed from a model.
pub(super) fn test_title(name: &str, synthetic: bool) -> String {
    match synthetic {
        true => format!("{name} (synthetic)"),
        false => name.to_owned(),
    }
}
