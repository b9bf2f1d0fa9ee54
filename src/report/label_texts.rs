//! Labels in the cells of a column, in English and Chinese.

use super::text_table::{Group, Text, group};

/// Labels, found by their English text; the column by the key of its head.
pub(super) static LABELS: &[(&str, &Group)] = &[
    (
        "is_mode",
        group! {
            is_a_mode: "yes", "是";
            doubtful_mode: "doubtful", "存疑";
            no_mode: "no", "否";
        },
    ),
    (
        "uncertain",
        group! {
            uncertain_frequency: "f", "频率";
            uncertain_damping: "damping", "阻尼";
            uncertain_shape: "shape", "振型";
            uncertain_frequency_and_damping: "f, damping", "频率、阻尼";
            uncertain_frequency_and_shape: "f, shape", "频率、振型";
            uncertain_damping_and_shape: "damping, shape", "阻尼、振型";
            all_uncertain: "f, damping, shape", "频率、阻尼、振型";
        },
    ),
    (
        "last_mode_added",
        group! {
            out_of_band_terms_alone: "out-of-band terms alone", "仅带外项";
            identified: "identified", "已识别";
            stable_pole: "stable pole", "稳定极点";
        },
    ),
    (
        "enough",
        group! {
            none_alone: "none alone", "单独均不足";
        },
    ),
    (
        "verdict",
        group! {
            paired: "paired", "已配对";
            ambiguous: "ambiguous", "不明确";
            expected_miss: "unmatched, near a paired mode", "漏检(预期)";
            unexpected_miss: "unmatched model mode, should have been seen", "漏检(非预期)";
            miss_of_unknown_observability: "unmatched, observability unknown", "漏检(未判定)";
            not_observable: "not-observable", "不可观测";
            outside_band: "outside-band", "频带外";
            unmatched_test_mode: "unmatched test mode", "多余";
            paired_by_shape: "paired by shape", "按振型配对";
            paired_by_frequency: "paired by frequency", "按频率配对";
            near_a_paired_mode: "near a paired mode", "漏检(预期)";
            should_have_been_seen: "should have been seen", "漏检(非预期)";
                            not_observable_mode: "not observable", "不可观测";
            outside_the_band: "outside the band", "频带外";
            used: "used", "采用";
            used_with_remark: "used, with a remark", "采用(有备注)";
            used_stated: "used (stated)", "采用(指定)";
            rejected: "rejected", "剔除";
            rejected_stated: "rejected (stated)", "剔除(指定)";
            met: "met", "满足";
            missed: "MISSED", "未满足";
            reproduced: "reproduced", "已复现";
            not_reproduced: "NOT reproduced", "未复现";
            not_checkable: "not checkable", "无法核对";
            identified: "identified", "可识别";
            identified_within_model_error: "identified within model error", "在模型误差内可识别";
            at_bound: "at bound", "位于边界";
            not_supported: "not supported by the data", "数据不支持";
            not_supported_and_held: "not supported by the data; held", "数据不支持；保持不变";
        },
    ),
    (
        "basis",
        group! {
            shape: "shape", "振型";
            frequency: "frequency", "频率";
        },
    ),
    (
        "status",
        group! {
            printed: "printed", "原文给出";
            inferred: "inferred", "推断";
            assumed: "assumed", "假定";
        },
    ),
    (
        "mode",
        group! {
            max_error: "max |error|", "最大 |误差|";
            mean_error: "mean |error|", "平均 |误差|";
            rms_error: "rms error", "均方根误差";
            repeated_root: "{} ({}-fold)", "{} ({} 重)";
            paired: "paired", "已配对";
            rms_and_mac: "rms, min MAC", "均方根，最小 MAC";
        },
    ),
    (
        "error_percent",
        group! {
            unmatched: "unmatched", "未配对";
            unknown: "unknown", "未知";
            near: "near", "邻近";
            not_observable: "not obs.", "不可观测";
            test_only: "test only", "仅试验";
        },
    ),
];
