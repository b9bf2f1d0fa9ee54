//! The sentence on a model whose errors lie on one side and no single factor removes.

use crate::scene::{ErrorRange, ErrorTrend, OneSidedModes};

use super::Cell;

/// How the model is off whose errors lie on one side.
pub(super) fn lean(test_is_lower: bool) -> &'static str {
    match test_is_lower {
        true => "stiff or too light",
        false => "soft or too heavy",
    }
}

/// The course of the errors over frequency, and the usual causes of one.
pub(super) fn error_range(range: &ErrorRange) -> String {
    let percent = |value: f64| format!("{} %", Cell::signed(Some(value), 2).display());
    let course = match range.trend {
        ErrorTrend::Grows => "grow with frequency,",
        ErrorTrend::Falls => "fall with frequency,",
        ErrorTrend::Scatters => "scatter",
    };
    let cause = match range.trend {
        ErrorTrend::Scatters => "",
        _ => " A mass or joint at one place, shear, or the flexibility of a boundary does so.",
    };
    format!(
        "The model is too {}: its errors {course} from {} at {} to {} at {}, and no single factor removes them.{cause}",
        lean(range.test_is_lower),
        percent(range.first_percent),
        range.first,
        percent(range.last_percent),
        range.last,
    )
}

/// How the model is off whose modes lie on one side for the most part.
pub(super) fn one_sided_modes(modes: &OneSidedModes) -> String {
    let OneSidedModes {
        test_is_lower,
        count,
        modes,
        mean_percent,
    } = *modes;
    let relation = match test_is_lower {
        true => "below",
        false => "above",
    };
    format!(
        "The model is too {}: {count} of {modes} modes of the test lie {relation} those of the model, on average by {} %.",
        lean(test_is_lower),
        Cell::signed(Some(mean_percent), 2).display()
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::Language;

    #[test]
    fn the_course_of_errors_is_said_in_both_languages() {
        for test_is_lower in [true, false] {
            for trend in [ErrorTrend::Grows, ErrorTrend::Falls, ErrorTrend::Scatters] {
                let range = ErrorRange {
                    trend,
                    test_is_lower,
                    first: "f1".to_owned(),
                    first_percent: -1.0,
                    last: "f5".to_owned(),
                    last_percent: -12.0,
                };
                let english = error_range(&range);
                assert!(
                    english.contains("-1.00 % at f1 to -12.00 % at f5"),
                    "{english}"
                );
                let chinese = Language::Chinese.translated_text(english);
                assert!(
                    chinese.starts_with("模型") && chinese.contains("-12.00 %"),
                    "{chinese}"
                );
            }
        }
    }
}
