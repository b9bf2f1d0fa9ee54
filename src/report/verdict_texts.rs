//! The sentences of the screens of `run` and `update`, in English and Chinese.

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
        "next_update_support",
        Text {
            english: "Next, as supports of test and model differ: correct the wrong one ({}).",
            chinese: "下一步 (试验与模型的支承不同)：请更正其中有误的一个 ({})。",
        },
    ),
    (
        "next_at_bound",
        Text {
            english: "Next, as {} is at its bound and the model does not fit: wider bounds of it, if they are possible; else what the form of the model neglects.",
            chinese: "下一步 ({} 到达界限，模型不符)：若界限可以放宽，请放宽；否则请检查模型形式所忽略的因素。",
        },
    ),
    (
        "next_limits",
        Text {
            english: "Next, limits that the updated model has to meet: [limits] in {}; then modalign check {}/comparison-after.json --against {}.",
            chinese: "下一步：在 {} 的 [limits] 中给出修正后模型应满足的限值；然后 modalign check {}/comparison-after.json --against {}。",
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
            english: "Next, before an update: correct the support that is wrong ({}): support in [test.state] of {}, or the springs to ground of the model ({}).",
            chinese: "下一步，修正之前：请改正有误的支承 ({})：{} 中 [test.state] 的 support，或模型的对地弹簧 ({})。",
        },
    ),
    (
        "next_ambiguous",
        Text {
            english: "Next, before an update: {} of {} ambiguous: hits or sensors at more points or in more directions, and the frame and positions of [[sensor]] in {}.",
            chinese: "下一步，修正之前：{} / {} 不明确：在更多测点或更多方向锤击或布置传感器，并检查 {} 中 [[sensor]] 的坐标系与位置。",
        },
    ),
    (
        "next_low_mac",
        Text {
            english: "Next, before an update: {} of {} without a MAC of {}: the frame, positions and directions of [[sensor]] in {}, then more points.",
            chinese: "下一步，修正之前：{} / {} 的 MAC 未达 {}：请检查 {} 中 [[sensor]] 的坐标系、位置与方向，然后增加测点。",
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
            english: "Limits of the scene: {} of {} met{}.",
            chinese: "限值：{} / {} 满足{}。",
        },
    ),
    (
        "limits_met_of_kinds",
        Text {
            english: "Limits of the scene: {} of {} met, on {}.",
            chinese: "限值：{} / {} 满足，关于 {}。",
        },
    ),
    (
        "limits_not_on_errors",
        Text {
            english: "Limits of the scene: {} of {} met, on {}; none is on errors or MAC.",
            chinese: "限值：{} / {} 满足，关于 {}；没有关于误差或 MAC 的限值。",
        },
    ),
    (
        "model_agrees",
        Text {
            english: "The model agrees with {}: rms error {} %, largest {}.",
            chinese: "模型与 {} 相符：均方根误差 {} %，最大 {}。",
        },
    ),
    (
        "model_differs",
        Text {
            english: "The model differs from {}: rms error {} %, largest {}.",
            chinese: "模型与 {} 不符：均方根误差 {} %，最大 {}。",
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
            english: "Limits of the scene: {} of {} met; nearest: {}.",
            chinese: "限值：{} / {} 满足；最接近的是：{}。",
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
    (
        "limits_met_of_kinds_nearest",
        Text {
            english: "Limits of the scene: {} of {} met, on {}; nearest: {}.",
            chinese: "限值：{} / {} 满足，关于 {}；最接近的是：{}。",
        },
    ),
    (
        "within_criterion",
        Text {
            english: "Within {} % and MAC {}: {} of {} modes.",
            chinese: "在 {} % 与 MAC {} 以内：{} / {} 阶。",
        },
    ),
    (
        "line_statement_not_reproduced",
        Text {
            english: "Not reproduced: {}: printed {}, here {}.",
            chinese: "未复现：{}：文献 {}，此处 {}。",
        },
    ),
    (
        "first_statement_not_reproduced",
        Text {
            english: "Not reproduced: {}: printed {}, here {}; {} more (--full).",
            chinese: "未复现：{}：文献 {}，此处 {}；另有 {} 条 (--full)。",
        },
    ),
    (
        "peak_would_stand",
        Text {
            english: "{}: from {} to {} its peak would stand {} dB over the noise.",
            chinese: "{}：从 {} 到 {}，其峰值应高于噪声 {} dB。",
        },
    ),
    (
        "error_of_theory",
        Text {
            english: "Error = (test - theory)/theory.",
            chinese: "误差 = (试验 - 理论)/理论。",
        },
    ),
    (
        "error_of_test",
        Text {
            english: "Error = (theory - test)/test.",
            chinese: "误差 = (理论 - 试验)/试验。",
        },
    ),
    (
        "mark_by_frequency",
        Text {
            english: "~: paired by frequency alone.",
            chinese: "~：仅按频率配对。",
        },
    ),
    (
        "mark_ambiguous",
        Text {
            english: "?: ambiguous.",
            chinese: "?：不明确。",
        },
    ),
    (
        "mark_doubtful",
        Text {
            english: "!: doubtful mode ({}).",
            chinese: "!：存疑的模态 ({})。",
        },
    ),
    (
        "mark_unmatched",
        Text {
            english: "unmatched: no partner, should have been seen.",
            chinese: "未配对：无配对，本应观测到。",
        },
    ),
    (
        "mark_unknown",
        Text {
            english: "unknown: unmatched, observability unknown.",
            chinese: "未知：无配对，可观测性未知。",
        },
    ),
    (
        "mark_near",
        Text {
            english: "near: unmatched, near a paired mode.",
            chinese: "邻近：无配对，靠近已配对的模态。",
        },
    ),
    (
        "mark_not_observable",
        Text {
            english: "not obs.: not observable at these points.",
            chinese: "不可观测：在这些点处不可观测。",
        },
    ),
    (
        "mark_test_only",
        Text {
            english: "test only: unmatched test mode.",
            chinese: "仅试验：无配对的试验模态。",
        },
    ),
    (
        "mac_of_few_dofs",
        Text {
            english: "A MAC beside ~ is of too few DOFs to be evidence.",
            chinese: "~ 旁的 MAC 自由度太少，不足为据。",
        },
    ),
    (
        "further_modes",
        Text {
            english: "{} further modes, those with the smallest errors first: --full.",
            chinese: "另有 {} 阶，先略去误差最小者：--full。",
        },
    ),
    (
        "further_mode",
        Text {
            english: "{} further mode, those with the smallest errors first: --full.",
            chinese: "另有 {} 阶，先略去误差最小者：--full。",
        },
    ),
    (
        "further_columns",
        Text {
            english: "{} further columns ({}): --full.",
            chinese: "另有 {} 列 ({})：--full。",
        },
    ),
    (
        "further_column",
        Text {
            english: "{} further column ({}): --full.",
            chinese: "另有 {} 列 ({})：--full。",
        },
    ),
    (
        "modes_of_further_tests",
        Text {
            english: "Modes of {} further tests: --full.",
            chinese: "其他 {} 个试验的模态：--full。",
        },
    ),
    (
        "modes_of_further_test",
        Text {
            english: "Modes of {} further test: --full.",
            chinese: "其他 {} 个试验的模态：--full。",
        },
    ),
    (
        "is_a_mode",
        Text {
            english: "is a mode: of the structure, not of noise; uncertain: its values to check before use.",
            chinese: "是否模态：属于结构而非噪声；不可靠的量：使用前须核对的数值。",
        },
    ),
    (
        "chi_square_unexplained",
        Text {
            english: "Chi-square per degree of freedom {} ({} degrees of freedom; noise alone reaches {}): noise does not explain the residuals.",
            chinese: "每自由度卡方 {} ({} 个自由度；仅噪声可达 {})：噪声不能解释残差。",
        },
    ),
    (
        "chi_square_of_kinds",
        Text {
            english: "Chi-square per degree of freedom of all residuals {} ({} degrees of freedom; noise alone reaches {}){}: noise does not explain the residuals.",
            chinese: "每自由度卡方：全部残差 {} ({} 个自由度；仅噪声可达 {}){}：噪声不能解释残差。",
        },
    ),
    (
        "larger_deviations",
        Text {
            english: "Deviations are taken as larger, {}; std and verdicts include this model error.",
            chinese: "因此放大标准差：{}；标准差与结论已包含此模型误差。",
        },
    ),
    (
        "no_support_by_data",
        Text {
            english: "Not supported by the data: {}.",
            chinese: "数据不支持：{}。",
        },
    ),
    (
        "fit_before",
        Text {
            english: "Before: {} of {} modes paired; largest error {}, rms {}, chi-square {} of {} residuals.",
            chinese: "修正前：{} / {} 阶已配对；最大误差 {}，均方根 {}，卡方 {} ({} 个残差)。",
        },
    ),
    (
        "fit_after",
        Text {
            english: "After: {} of {} modes paired; largest error {}, rms {}, chi-square {} of {} residuals.",
            chinese: "修正后：{} / {} 阶已配对；最大误差 {}，均方根 {}，卡方 {} ({} 个残差)。",
        },
    ),
    (
        "left_out_of_update",
        Text {
            english: "Left out: {}.",
            chinese: "未采用：{}。",
        },
    ),
    (
        "pairs_of_comparison",
        Text {
            english: "The comparison has {}: {}.",
            chinese: "对比表有 {}：{}。",
        },
    ),
    (
        "converged_without_step",
        Text {
            english: "Converged: no step lowers the objective after {}.",
            chinese: "已收敛：经 {} 后没有步能降低目标函数。",
        },
    ),
    (
        "converged_to_rounding",
        Text {
            english: "Converged: the steps have become as small as rounding after {}.",
            chinese: "已收敛：经 {} 后步长已小到舍入误差。",
        },
    ),
    (
        "nothing_changed",
        Text {
            english: "Nothing changed: the test sees none of the free parameters after {}.",
            chinese: "未改变：经 {}，试验看不到任何自由参数。",
        },
    ),
    (
        "not_converged",
        Text {
            english: "Not converged: the stated number of iterations is reached after {}.",
            chinese: "未收敛：经 {} 达到规定的迭代次数。",
        },
    ),
    (
        "starts_at_optimum",
        Text {
            english: "{} of {} (seed {}) reach this optimum.",
            chinese: "{} / {} (种子 {}) 到达此最优点。",
        },
    ),
    (
        "arrays_not_stated",
        Text {
            english: "The names of {} do not state the contents: state `role` in the scene.",
            chinese: "{} 的名称未说明内容：在场景中给出 `role`。",
        },
    ),
    (
        "meaning_of_dof",
        Text {
            english: "DOF: point and direction, such as 1:+Z.",
            chinese: "DOF：测点与方向，如 1:+Z。",
        },
    ),
    (
        "meaning_of_dofs",
        Text {
            english: "DOF: point and direction, such as 1:+Z; one for all files, or one for each (1:+Z,2:+Z).",
            chinese: "DOF：测点与方向，如 1:+Z；全部文件一个，或每个文件一个 (1:+Z,2:+Z)。",
        },
    ),
    (
        "not_stated",
        Text {
            english: "Not stated: {}.",
            chinese: "未说明：{}。",
        },
    ),
    (
        "one_coherence",
        Text {
            english: "Coherence in that band, median: {}.",
            chinese: "该频带内相干的中位数：{}。",
        },
    ),
    (
        "no_shapes_to_compare",
        Text {
            english: "AutoMAC of {}: shapes of one degree of freedom cannot be compared.",
            chinese: "{} 的自 MAC：单个自由度的振型无法比较。",
        },
    ),
    (
        "to_observe",
        Text {
            english: "To observe {} in {}: {}.",
            chinese: "要观测 {} (试验 {})：{}。",
        },
    ),
    (
        "all_synthetic",
        Text {
            english: "The recordings are synthetic, not measured: computed from {}.",
            chinese: "记录为合成，并非实测：由 {} 计算。",
        },
    ),
    (
        "synthetic_recordings",
        Text {
            english: "Synthetic recordings, not measured: {}; computed from {}.",
            chinese: "合成记录，并非实测：{}；由 {} 计算。",
        },
    ),
    (
        "assumed_in_model",
        Text {
            english: "Assumed in the model: {}.",
            chinese: "模型中的假定：{}。",
        },
    ),
    (
        "published_frequencies",
        Text {
            english: "Published frequencies: {} single roots of the model against the publication, rms error {} %, largest {} % at {}.",
            chinese: "文献频率：模型的 {} 个单根与文献比较，均方根误差 {} %，最大 {} % (位于 {})。",
        },
    ),
    (
        "published_frequency",
        Text {
            english: "Published frequencies: {} single root of the model against the publication, rms error {} %, largest {} % at {}.",
            chinese: "文献频率：模型的 {} 个单根与文献比较，均方根误差 {} %，最大 {} % (位于 {})。",
        },
    ),
    (
        "published_statements",
        Text {
            english: "Published statements: {} reproduced, {} not reproduced, {} not checkable.",
            chinese: "文献论述：{} 条已复现，{} 条未复现，{} 条无法核对。",
        },
    ),
    (
        "statements_not_reproduced",
        Text {
            english: "Not reproduced: {}.",
            chinese: "未复现：{}。",
        },
    ),
    (
        "next_points",
        Text {
            english: "Further points of {}: unknown, {}.",
            chinese: "可增加的测点，{}：未知，{}。",
        },
    ),
    (
        "rest_of_run",
        Text {
            english: "All tables, columns and notes: --full; report and files: -o DIR; a [code]: --explain CODE.",
            chinese: "全部表格、列与说明：--full；报告与文件：-o DIR；[] 中的代码：--explain CODE。",
        },
    ),
    (
        "rest_of_run_in_folder",
        Text {
            english: "All tables, columns and notes: --full, or {}; a [code]: --explain CODE.",
            chinese: "全部表格、列与说明：--full，或 {}；[] 中的代码：--explain CODE。",
        },
    ),
    (
        "near_band_edge",
        Text {
            english: "Near the edge of the band: {}. Widen the band: --band LO:HI, or band_hz of the scene.",
            chinese: "靠近频带边缘：{}。请加宽频带：--band LO:HI，或场景中的 band_hz。",
        },
    ),
    (
        "peaks_without_mode",
        Text {
            english: "Peaks without a mode: {}. Reasons: --explain peak-without-mode.",
            chinese: "没有模态的峰：{}。原因：--explain peak-without-mode。",
        },
    ),
    (
        "no_model",
        Text {
            english: "The scene has no model, so that nothing is compared.",
            chinese: "场景中没有模型，因此没有比较。",
        },
    ),
];
