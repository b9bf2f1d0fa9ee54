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
            rigid_body: "rigid body", "刚体";
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
    (
        "event",
        group! {
            crossing: "crossing", "交叉";
            veering: "veering", "转向";
        },
    ),
    (
        "target",
        group! {
            met: "met", "达到";
            not_met: "not met", "未达到";
        },
    ),
    (
        "proposal",
        group! {
            combination: "combination", "组合";
            alone: "{} alone", "仅 {}";
        },
    ),
    (
        "meaning",
        group! {
            deflection_at_sun: "deflection of the mesh of sun and planet 1", "太阳轮与行星轮 1 的啮合变形";
            deflection_at_ring: "deflection of the mesh of ring and planet 1", "齿圈与行星轮 1 的啮合变形";
            sharing_at_sun: "load sharing of planet 1 at the sun, 4 k δ / sum of k δ", "行星轮 1 在太阳轮处的载荷分配，4 k δ / Σ k δ";
            sharing_at_ring: "load sharing of planet 1 at the ring", "行星轮 1 在齿圈处的载荷分配";
        },
    ),
    (
        "detail",
        group! {
            constant_angle: "constant angle", "恒定压力角";
            angle_as_printed: "varying angle as printed", "变压力角 (按原文)";
            exact_angle: "varying angle, exact", "变压力角 (精确)";
        },
    ),
    (
        "simplest_model_head",
        group! {
            constant_angle: "constant angle", "恒定压力角";
            angle_as_printed: "varying angle as printed", "变压力角 (按原文)";
            exact_angle: "varying angle, exact", "变压力角 (精确)";
        },
    ),
    (
        "what",
        group! {
            frequency_change: "frequency change (%)", "频率变化 (%)";
            damping_change: "damping change (%)", "阻尼比变化 (%)";
            frequency_std_change_factor: "frequency std change (factor)", "频率标准差之比";
            hz_std_change_factor: "hz_std change (factor)", "频率标准差之比";
            damping_std_change_factor: "damping std change (factor)", "阻尼比标准差之比";
            frequency_change_of_the_test: "frequency change of the test (%)", "试验频率变化 (%)";
            frequency_change_of_the_model: "frequency change of the model (%)", "模型频率变化 (%)";
            value_change: "value change (%)", "数值变化 (%)";
            std_change_factor: "std change (factor)", "标准差之比";
            reduced_chi_square_change_factor: "reduced chi-square change (factor)", "每自由度卡方之比";
            status_changed: "status changed", "状态改变";
            in_the_baseline: "in the baseline", "在基线中";
            verdict_changed: "verdict changed", "结论改变";
            unit_initial_value_prior_or_bounds_changed: "unit, initial value, prior or bounds changed", "单位、初值、先验或界限改变";
            stop_reason_changed: "stop reason changed", "停止原因改变";
            assumptions_changed: "assumptions changed", "假定改变";
            kind_of_residuals_changed: "kind of residuals changed", "残差种类改变";
            change_of_paired_modes: "change of paired modes", "配对模态数的变化";
            change_of_degrees_of_freedom: "change of degrees of freedom", "自由度的变化";
        },
    ),
];
