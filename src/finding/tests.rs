//! Sentences and codes.

use super::*;

#[test]
fn numbers_in_a_sentence_have_at_most_four_digits() {
    for (value, expected) in [
        (7e10, "7e10"),
        (2e6, "2e6"),
        (1_234_567.0, "1234567"),
        (2.5, "2.500"),
    ] {
        assert_eq!(format_number(value), expected);
    }
    assert_eq!(format_with_std(0.566_12, 0.008_378), "0.5661 ± 0.0084");
    assert_eq!(format_with_std(1.234, 0.0), "1.234 ± 0");
}

#[test]
fn the_sentence_has_location_value_and_limit() {
    let finding = Finding::new(Severity::Warning, Code::FewLines, Location::Mode(123.456))
        .value(2.5, "")
        .limit(5.0);
    let text = finding.to_string();
    assert!(
        text.starts_with("mode at 123.46 Hz: The half-power band holds too few"),
        "{text}"
    );
    assert!(text.ends_with("(2.500, limit at least 5)"), "{text}");
    let pure = Finding::new(Severity::Info, Code::FewLines, Location::Mode(1.0)).value(0.3, "1");
    assert!(pure.to_string().ends_with("(0.300)"), "{pure}");
    // A missed limit never reads as met.
    let near = pure.value(0.49996, "").limit(0.5).to_string();
    assert!(near.ends_with("(0.49996, limit at least 0.5)"), "{near}");
    let bare = Finding::new(Severity::Info, Code::FewLines, Location::Mode(1.0));
    assert!(bare.to_string().ends_with("a damping value."), "{bare}");
    let detailed = bare.detail("one line").to_string();
    assert!(
        detailed.ends_with("a damping value; one line"),
        "{detailed}"
    );
}

#[test]
fn a_limit_says_what_it_asks_of_the_value() {
    for (code, english, chinese) in [
        (Code::ModelMisfit, "limit at most 2 Hz", "限值：至多 2 Hz"),
        (Code::LowMac, "limit at least 2 Hz", "限值：至少 2 Hz"),
        (Code::ChannelDelay, "limit ±2 Hz", "限值：±2 Hz"),
        (Code::ByteCountWrong, "expected 2 Hz", "应为 2 Hz"),
        (Code::BandCut, "data end at 2 Hz", "数据止于 2 Hz"),
    ] {
        let finding = Finding::new(Severity::Warning, code, Location::Whole);
        let finding = finding.value(1.0, "Hz").limit(2.0);
        let (text, translated) = (finding.to_string(), finding.chinese());
        assert!(text.ends_with(&format!("(1 Hz, {english})")), "{text}");
        assert!(
            translated.ends_with(&format!("（1 Hz，{chinese}）")),
            "{translated}"
        );
    }
}

#[test]
fn truncation_and_decay_state_their_criteria() {
    let [truncated, decay] = [Code::Truncated, Code::NotDecayed];
    assert!(!truncated.sentence().contains("decayed"));
    assert!(truncated.explanation().contains("slowest fall"));
    for text in [truncated.explanation(), decay.explanation()] {
        assert!(text.contains("the last eighth of the record"), "{text}");
    }
}

#[test]
fn every_code_has_a_name_and_an_explanation() {
    for code in Code::ALL {
        let explained = code.explanation().len() > 40;
        assert!(explained && !code.name().is_empty(), "{code:?}");
    }
}
