//! The sentences of the verdict of `run` and of the next step, in English and Chinese.

use super::text_table::{Group, Text};

/// Sentences, found by their English text; `{}` stands for a name or a number.
pub(super) static VERDICT_TEXTS: &Group = &[
    (
        "next_still",
        Text {
            english: "Next, as no mode is paired: the model does not move at {}: [[sensor]] in {}, or free directions of the model ({}).",
            chinese: "下一步 (没有配对的模态)：模型在 {} 处不运动：请检查 {} 中的 [[sensor]]，或模型的自由方向 ({})。",
        },
    ),
    (
        "next_model",
        Text {
            english: "Next, as no mode is paired: model, its support, and points and directions of [[sensor]] in {}.",
            chinese: "下一步 (没有配对的模态)：请检查模型、其支承，以及 {} 中 [[sensor]] 的位置与方向。",
        },
    ),
    (
        "next_ends",
        Text {
            english: "Next, as no mode is paired: {} of {}, a guess of the draft: state from_m and to_m in the model; then points and directions of [[sensor]] in {}.",
            chinese: "下一步 (没有配对的模态)：{} ({}) 为起草时的猜测：请在模型中填写 from_m 与 to_m；然后检查 {} 中 [[sensor]] 的位置与方向。",
        },
    ),
    (
        "next_units",
        Text {
            english: "Next, as no mode is paired: the units of the values in the model (m, kg, N, Pa; density in kg/m3).",
            chinese: "下一步 (没有配对的模态)：请检查模型中数值的单位 (m、kg、N、Pa；密度为 kg/m3)。",
        },
    ),
    (
        "next_shapes",
        Text {
            english: "Next, as no mode is paired: by shape alone, test {}. Frequencies of the test are {} times those of the model: check its dimensions and material.",
            chinese: "下一步 (没有配对的模态)：仅按振型，试验 {}。试验频率为模型的 {} 倍：请检查其尺寸与材料。",
        },
    ),
    (
        "next_values",
        Text {
            english: "Next, before anything else: the values of the structure in model.toml, whose values are those of an example ({}).",
            chinese: "下一步，首先：在 model.toml 中填写结构的数值，现为示例的数值 ({})。",
        },
    ),
    (
        "next_test",
        Text {
            english: "Next, a test: modalign new DIR FILE... --model {}.",
            chinese: "下一步，加入试验：modalign new DIR FILE... --model {}。",
        },
    ),
    (
        "next_modes",
        Text {
            english: "Next, as no modes were found: band_hz of [[test]], then method and order of [identify] in {}; check units and coherence.",
            chinese: "下一步 (没有找到模态)：请更改 {} 中 [[test]] 的 band_hz，再更改 [identify] 的 method 与 order；并检查单位与相干。",
        },
    ),
    (
        "next_compared",
        Text {
            english: "Next, a model to compare with: [model] in {}, or modalign new NEW-DIR FILE... --model beam (or lumped) --points FILE.",
            chinese: "下一步，加入用于比较的模型：{} 中的 [model]，或 modalign new NEW-DIR FILE... --model beam (或 lumped) --points FILE。",
        },
    ),
    (
        "next_frequency",
        Text {
            english: "Next, as all pairs are by frequency alone: mode shapes at more points, which confirm the pairs by MAC.",
            chinese: "下一步 (仅按频率配对)：在更多测点测量振型，以 MAC 确认配对。",
        },
    ),
    (
        "next_frequency_update",
        Text {
            english: "Next, as all pairs are by frequency alone: mode shapes at more points, which confirm the pairs by MAC. An update of frequencies alone: modalign update {}.",
            chinese: "下一步 (仅按频率配对)：在更多测点测量振型，以 MAC 确认配对。仅按频率修正：modalign update {}。",
        },
    ),
    (
        "next_not_converged",
        Text {
            english: "Next, as the update did not converge: fewer parameters or tighter bounds in [update], or a higher max_iterations.",
            chinese: "下一步 (修正未收敛)：减少 [update] 中的参数、收紧其界限，或增大 max_iterations。",
        },
    ),
    (
        "next_not_fitting",
        Text {
            english: "Next, as the updated model does not fit: support, positions and directions of sensors, and what the form of the model neglects; {}.",
            chinese: "下一步 (修正后的模型不符)：请检查支承、测点的位置与方向，以及模型形式所忽略的因素；{}。",
        },
    ),
    (
        "next_check",
        Text {
            english: "Next, whether the updated model meets the limits: modalign check {}/comparison-after.json --against {}.",
            chinese: "下一步，检查修正后的模型是否满足限值：modalign check {}/comparison-after.json --against {}。",
        },
    ),
    (
        "next_undetermined",
        Text {
            english: "Next, as the test determines no parameter: more modes or points, parameters that its modes depend on, or prior_std in [[update.parameter]].",
            chinese: "下一步 (试验未能确定任何参数)：增加模态或测点，选取模态所依赖的参数，或在 [[update.parameter]] 中给出 prior_std。",
        },
    ),
    (
        "next_sensor",
        Text {
            english: "Next, before an update: check {} in {} ({}).",
            chinese: "下一步，修正之前：请检查 {} (位于 {}) ({})。",
        },
    ),
    (
        "next_positions",
        Text {
            english: "Next, before an update: at_m of [[sensor]] in {}, of which several are one ({}).",
            chinese: "下一步，修正之前：请检查 {} 中 [[sensor]] 的 at_m，其中有几个相同 ({})。",
        },
    ),
    (
        "next_support",
        Text {
            english: "Next, before an update: one support ({}): support in [test.state] of {}, or the springs to ground of the model ({}).",
            chinese: "下一步，修正之前：支承须一致 ({})：{} 中 [test.state] 的 support，或模型的对地弹簧 ({})。",
        },
    ),
    (
        "next_ambiguous",
        Text {
            english: "Next, before an update: {} of {} pairs are ambiguous: hits or sensors at more points or in more directions, and the frame and positions of [[sensor]] in {}.",
            chinese: "下一步，修正之前：{} / {} 个配对不明确：在更多测点或更多方向锤击或布置传感器，并检查 {} 中 [[sensor]] 的坐标系与位置。",
        },
    ),
    (
        "next_low_mac",
        Text {
            english: "Next, before an update: {} of {} pairs have no MAC of {}: the frame, positions and directions of [[sensor]] in {}, then more points.",
            chinese: "下一步，修正之前：{} / {} 个配对的 MAC 未达 {}：请检查 {} 中 [[sensor]] 的坐标系、位置与方向，然后增加测点。",
        },
    ),
    (
        "next_update",
        Text {
            english: "Next, the parameters that bring the model to the test: modalign update {}.",
            chinese: "下一步，使模型与试验一致的参数：modalign update {}。",
        },
    ),
    (
        "no_limits",
        Text {
            english: "Limits of the scene: none stated.",
            chinese: "限值：未给出。",
        },
    ),
    (
        "limits_met",
        Text {
            english: "Limits of the scene: all met ({}).",
            chinese: "限值：全部满足 ({})。",
        },
    ),
    (
        "limits_met_of_kinds",
        Text {
            english: "Limits of the scene: all met ({}, on {}).",
            chinese: "限值：全部满足 ({} 个，关于 {})。",
        },
    ),
    (
        "limits_not_on_errors",
        Text {
            english: "Limits of the scene: all met ({}, on {}; none on errors or MAC).",
            chinese: "限值：全部满足 ({} 个，关于 {}；没有关于误差或 MAC 的限值)。",
        },
    ),
    (
        "model_agrees",
        Text {
            english: "The model agrees with {}: {} of {} modes within {} % and MAC {}; rms error {} %, largest {}.",
            chinese: "模型与 {} 相符：{} / {} 阶在 {} % 与 MAC {} 以内；均方根误差 {} %，最大 {}。",
        },
    ),
    (
        "model_differs",
        Text {
            english: "The model differs from {}: {} of {} modes within {} % and MAC {}; rms error {} %, largest {}.",
            chinese: "模型与 {} 不符：{} / {} 阶在 {} % 与 MAC {} 以内；均方根误差 {} %，最大 {}。",
        },
    ),
    (
        "agreement_not_shown",
        Text {
            english: "Agreement is not shown for {}: all pairs are by frequency alone; rms error {} %, largest {}.",
            chinese: "{} 未能证明相符：全部仅按频率配对；均方根误差 {} %，最大 {}。",
        },
    ),
    (
        "stiff_for_the_most_part",
        Text {
            english: "The model is too stiff or too light: {} of {} modes of the test lie below those of the model, on average by {} %.",
            chinese: "模型过刚或过轻：试验的 {} / {} 阶低于模型，平均 {} %。",
        },
    ),
    (
        "soft_for_the_most_part",
        Text {
            english: "The model is too soft or too heavy: {} of {} modes of the test lie above those of the model, on average by {} %.",
            chinese: "模型过软或过重：试验的 {} / {} 阶高于模型，平均 {} %。",
        },
    ),
    (
        "no_mode_in_band",
        Text {
            english: "The model has no mode in the band of a test: modes of the model from {}, of the test from {}.",
            chinese: "模型在试验频带内没有模态：模型的模态 {}，试验的模态 {}。",
        },
    ),
    (
        "no_mode_in_band_by_a_unit",
        Text {
            english: "The model has no mode in the band of a test: modes of the model from {}, of the test from {}. Its lowest is {} times that of the test: a unit of the model may be wrong.",
            chinese: "模型在试验频带内没有模态：模型的模态 {}，试验的模态 {}。其最低阶为试验的 {} 倍：模型的某个单位可能有误。",
        },
    ),
    (
        "far_from_the_test",
        Text {
            english: "The model is far from the test: modes of the model from {}, of the test from {}. Its lowest is {} times that of the test: a unit of the model may be wrong.",
            chinese: "模型与试验相差甚远：模型的模态 {}，试验的模态 {}。其最低阶为试验的 {} 倍：模型的某个单位可能有误。",
        },
    ),
    (
        "model_is_still",
        Text {
            english: "Warning: The model does not move at {}: {}.",
            chinese: "警告：模型在 {} 处不运动：{}。",
        },
    ),
    (
        "not_reproduced",
        Text {
            english: "Not reproduced:",
            chinese: "未复现：",
        },
    ),
    (
        "statement_not_reproduced",
        Text {
            english: "- {}: printed {}, here {}",
            chinese: "- {}：文献 {}，此处 {}",
        },
    ),
    (
        "model_too_stiff_on_screen",
        Text {
            english: "The model is too stiff or too light: one factor {} on all stiffnesses removes the mean error.",
            chinese: "模型过刚或过轻：所有刚度乘以 {} 可消除平均误差。",
        },
    ),
    (
        "model_too_soft_on_screen",
        Text {
            english: "The model is too soft or too heavy: one factor {} on all stiffnesses removes the mean error.",
            chinese: "模型过软或过重：所有刚度乘以 {} 可消除平均误差。",
        },
    ),
    (
        "too_stiff_growing",
        Text {
            english: "The model is too stiff or too light: its errors grow with frequency, from {} at {} to {} at {}, and no single factor removes them. A mass or joint at one place, shear, or the flexibility of a boundary does so.",
            chinese: "模型过刚或过轻：误差随频率增大，由 {} ({}) 至 {} ({})，单一系数无法消除。某处的质量或连接、剪切或边界柔度会如此。",
        },
    ),
    (
        "too_stiff_falling",
        Text {
            english: "The model is too stiff or too light: its errors fall with frequency, from {} at {} to {} at {}, and no single factor removes them. A mass or joint at one place, shear, or the flexibility of a boundary does so.",
            chinese: "模型过刚或过轻：误差随频率减小，由 {} ({}) 至 {} ({})，单一系数无法消除。某处的质量或连接、剪切或边界柔度会如此。",
        },
    ),
    (
        "too_stiff_scattered",
        Text {
            english: "The model is too stiff or too light: its errors scatter from {} at {} to {} at {}, and no single factor removes them.",
            chinese: "模型过刚或过轻：误差在 {} ({}) 与 {} ({}) 之间分散，单一系数无法消除。",
        },
    ),
    (
        "too_soft_growing",
        Text {
            english: "The model is too soft or too heavy: its errors grow with frequency, from {} at {} to {} at {}, and no single factor removes them. A mass or joint at one place, shear, or the flexibility of a boundary does so.",
            chinese: "模型过软或过重：误差随频率增大，由 {} ({}) 至 {} ({})，单一系数无法消除。某处的质量或连接、剪切或边界柔度会如此。",
        },
    ),
    (
        "too_soft_falling",
        Text {
            english: "The model is too soft or too heavy: its errors fall with frequency, from {} at {} to {} at {}, and no single factor removes them. A mass or joint at one place, shear, or the flexibility of a boundary does so.",
            chinese: "模型过软或过重：误差随频率减小，由 {} ({}) 至 {} ({})，单一系数无法消除。某处的质量或连接、剪切或边界柔度会如此。",
        },
    ),
    (
        "too_soft_scattered",
        Text {
            english: "The model is too soft or too heavy: its errors scatter from {} at {} to {} at {}, and no single factor removes them.",
            chinese: "模型过软或过重：误差在 {} ({}) 与 {} ({}) 之间分散，单一系数无法消除。",
        },
    ),
    (
        "limits_met_nearest",
        Text {
            english: "Limits of the scene: all met ({}), nearest {}.",
            chinese: "限值：全部满足 ({})，最接近的是 {}。",
        },
    ),
    (
        "limits_missed",
        Text {
            english: "Limits of the scene: {} of {} MISSED ({}).",
            chinese: "限值：{} / {} 未满足 ({})。",
        },
    ),
    (
        "nothing_is_compared",
        Text {
            english: "No mode of a test has a partner in the model, so that nothing is compared: exit code 1.",
            chinese: "试验的模态在模型中均无配对，因此没有比较：退出码 1。",
        },
    ),
    (
        "pairs_in_numbers",
        Text {
            english: "Pairs: {} of {}, {} by shape, {} by frequency{}.",
            chinese: "配对：{} / {}，按振型 {}，仅按频率 {}{}。",
        },
    ),
    (
        "no_test",
        Text {
            english: "The scene has no test, so that nothing is compared.",
            chinese: "场景中没有试验，因此没有比较。",
        },
    ),
    (
        "mac_of_an_update",
        Text {
            english: "MAC as weighted by the update: real parts alone, as those of an undamped model, each component over its standard deviation. A comparison uses the complex shapes, all components with equal weight.",
            chinese: "修正所用的 MAC：只取实部 (与无阻尼模型一致)，各分量除以其标准差。对比表用复振型，各分量等权。",
        },
    ),
    (
        "next_sensors_of_a_model",
        Text {
            english: "Next, as {} states no sensors and pairs are by frequency alone: --theory FOLDER of the scene with its [[sensor]], or [[sensor]] in the model file.",
            chinese: "下一步 ({} 没有测点，仅按频率配对)：--theory 使用带 [[sensor]] 的场景文件夹，或在模型文件中加入 [[sensor]]。",
        },
    ),
];
