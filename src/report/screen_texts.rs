//! Sentences that verbs other than `run` print, in English and Chinese.

use super::text_table::{Group, Text, group};

/// Sentences, found by their English text; `{}` stands for a name or a number.
pub(super) static SCREEN_TEXTS: &Group = group! {
    // update
    starts_of_others: "{} of {} (seed {}) reach this optimum, the lowest, of objective {}; {}.", "{} / {} (种子 {}) 到达此最优点，其目标函数最低，为 {}；{}。";
    starts_and_failed: "{} of {} (seed {}) reach this optimum; from {} the model had no modes or no derivatives.", "{} / {} (种子 {}) 到达此最优点；自 {} 个起点模型无模态或无导数。";
    starts_of_frfs: "{} of {} (seed {}) reach the optimum of the modes from which the FRFs were fitted; starts and optima are those of the modes.", "{} / {} (种子 {}) 到达按模态修正的最优点，频响函数由该点起拟合；起点与最优点均属按模态的修正。";
    fits_as_well: "Fits as well: {}.", "同样符合：{}。";
    fits_as_well_and_differs: "Fits as well: {}; model mode {} differs most: {} Hz against {} Hz, MAC {}.", "同样符合：{}；模型第 {} 阶模态差别最大：{} Hz 与 {} Hz，MAC {}。";
    proposed: "Proposed: {} (the smallest set that brings the residual to its uncertainty).", "建议：{} (使残差降到其不确定度的最小参数组)。";
    proposed_by_bic: "Proposed: {} (no set brings the residual to its uncertainty; this one has the smallest BIC).", "建议：{} (没有参数组能使残差降到其不确定度；此组的 BIC 最小)。";
    mode_without_partner: "Test mode {} ({} Hz) has no partner in the model and was not used.", "试验模态 {} ({} Hz) 在模型中无配对，未采用。";
    modes_without_partner: "Model modes without partner: {}.", "无配对的模型模态：{}。";
    // inspect
    geometry: "geometry: {}", "几何：{}";
    damaged: "damaged: {}", "损坏：{}";
    further_damage: "{} further damaged parts: --full.", "另有 {} 处损坏：--full。";
    further_not_used: "{} further files not used: --full.", "另有 {} 个文件未采用：--full。";
    one_further_not_used: "{} further file not used: --full.", "另有 {} 个文件未采用：--full。";
    further_files: "{} further files: --full.", "另有 {} 个文件：--full。";
    further_file: "{} further file: --full.", "另有 {} 个文件：--full。";
    channel_of_response: "A channel, no point: the response {} (--response DOF names the point).", "为通道而非测点：响应 {} (以 --response DOF 给出测点)。";
    channel_of_reference: "A channel, no point: the reference {} (--reference DOF names the point).", "为通道而非测点：参考点 {} (以 --reference DOF 给出测点)。";
    channels_of_responses: "Channels, no points: the responses {}.", "为通道而非测点：响应 {}。";
    channels_of_references: "Channels, no points: the references {}.", "为通道而非测点：参考点 {}。";
    next_correlate_or_new: "Next: modalign correlate --test FILE --theory MODEL, or modalign new DIR FILE...", "下一步：modalign correlate --test FILE --theory MODEL，或 modalign new DIR FILE...";
    // new
    nothing_left_to_fill_in: "{}: nothing is left to fill in.", "{}：无需再填写。";
    complete_but_alike: "{}: complete, but several files have the same DOFs (below).", "{}：已完整，但多个文件的自由度相同 (见下)。";
    lines_to_fill_in: "{}: {} lines to be filled in:", "{}：需填写 {} 行：";
    line_to_fill_in: "{}: {} line to be filled in:", "{}：需填写 {} 行：";
    open_lines: "  lines {}: {}: {}", "  第 {} 行：{}：{}";
    open_line: "  line {}: {}: {}", "  第 {} 行：{}：{}";
    options_of_new: "Options of `modalign new` fill in such lines, in a new folder: {}.", "`modalign new` 的选项可填写这些行 (在新文件夹中)：{}。";
    unnamed_columns: "Columns without a heading also need (`run` asks once their roles are stated):", "没有表头的列还需要 (说明其用途后 `run` 会询问)：";
    unit_of_columns: "  unit of each force, response or FRF: --unit N,m/s2, or of FRFs --unit '(m/s2)/N'", "  每个力、响应或频响函数的单位：--unit N,m/s2，频响函数则为 --unit '(m/s2)/N'";
    response_of_columns: "  point and direction of each response: --response DOF,...", "  每个响应的测点与方向：--response DOF,...";
    reference_of_columns: "  point and direction of the hit: --reference DOF, or one for each file", "  锤击的位置与方向：--reference DOF，或每个文件一个";
    rate_of_columns: "  samples per second, where no column is time or frequency: --sampling-rate HZ", "  每秒采样数 (没有时间或频率列时)：--sampling-rate HZ";
    same_pair: "{} files have the same response and reference: FRFs of one pair, measured again.", "{} 个文件的响应与参考点相同：同一对测点的重复测量。";
    roving_reference: "A roving test needs one DOF for each file: --reference DOF,DOF,...", "移动测量时每个文件需一个自由度：--reference DOF,DOF,...";
    roving_reference_or_response: "A roving test needs one DOF for each file: --reference DOF,DOF,... or --response DOF,DOF,...", "移动测量时每个文件需一个自由度：--reference DOF,DOF,... 或 --response DOF,DOF,...";
    no_positions: "No positions are stated: figures of shapes have the points in a row (--points FILE with lines POINT,X,Y,Z in metres).", "未给出位置：振型图中各点排成一行 (--points FILE，每行 POINT,X,Y,Z，单位米)。";
    large_extent: "The points extend over {} m.", "各点的范围达 {} m。";
    positions_in_metres: "Positions are in metres: write 0.25 for 250 mm.", "位置以米为单位：250 mm 应写作 0.25。";
    no_position_of_points: "No position is stated for: {}.", "未给出位置的点：{}。";
    optional_files: "SOURCE.md (where the data come from) and expected.toml (published results) are optional.", "SOURCE.md (数据来源) 与 expected.toml (文献结果) 可不填写。";
    values_of_an_example: "{}: the values are those of an example; state those of the structure.", "{}：其中为示例的数值；请填写结构的数值。";
    length_is_a_guess: "{}: its length of {} m is a guess, the distance of the outermost points: state the true ends, from_m and to_m; bending is that of the hits; the other values are those of an example; state those of the structure.", "{}：长度 {} m 为猜测 (最外两点的距离)：请填写真实的两端 from_m 与 to_m；弯曲方向取锤击方向；其他为示例的数值；请填写结构的数值。";
    then_comparison: "Then: modalign run {} prints the comparison table.", "然后：modalign run {} 给出对比表。";
    then_modes: "Then: modalign run {} prints the modes; a [model] makes them a comparison.", "然后：modalign run {} 给出模态；加入 [model] 即可对比。";
    // frf and identify
    frfs: "FRFs: {} ({} by {}), {}; {} by {} Hz; usable band {} to {} Hz.", "频响函数：{} ({}，{})，{}；{}，间隔 {} Hz；可用频带 {} 至 {} Hz。";
    coherence_of_each: "Coherence in that band, median of each FRF: {} to {}, lowest at {}.", "该频带内各频响函数相干的中位数：{} 至 {}，最低者 {}。";
    no_line_in_band: "Coherence: none, no line is in the usable band.", "相干：无，可用频带内没有谱线。";
    no_averages: "Coherence: none, it takes two averages or more.", "相干：无，至少需要两次平均。";
    no_hits: "Hits: none, excitation by a shaker.", "锤击：无，为激振器激励。";
    hit_again_for_reasons: "- {}: {}.", "- {}：{}。";
    no_modes_found: "{}: no modes were found.", "{}：没有找到模态。";
    no_modes_found_in_band: "{}: no modes were found between {} and {} Hz.", "{}：在 {} 至 {} Hz 之间没有找到模态。";
    // theory
    further_roots: "{} further roots from {} Hz: --full, or --band LO:HI.", "另有 {} 个特征根，自 {} Hz 起：--full，或 --band LO:HI。";
    further_root: "{} further root from {} Hz: --full, or --band LO:HI.", "另有 {} 个特征根，自 {} Hz 起：--full，或 --band LO:HI。";
    further_rows: "{} further rows: --full.", "另有 {} 行：--full。";
    further_row: "{} further row: --full.", "另有 {} 行：--full。";
    further_notes: "{} further notes: --full.", "另有 {} 条说明：--full。";
    further_note: "{} further note: --full.", "另有 {} 条说明：--full。";
    without_value: "Without a value: {} tables (--full).", "没有数值：{} 个表格 (--full)。";
    one_without_value: "Without a value: {} table (--full).", "没有数值：{} 个表格 (--full)。";
    further_tables: "Further tables (--full): {}.", "其他表格 (--full)：{}。";
    energy_fractions: "T: fraction of the kinetic energy by body; U: fraction of the strain energy by spring or group of matrices; mean over the modes of a repeated root.", "T：各物体的动能占比；U：各弹簧或矩阵组的应变能占比；重根取其模态的平均。";
    energy_and_stiffness: "For a spring of stiffness k, or a group that k scales: df/f = U/2 dk/k where k scales stiffness alone.", "刚度为 k 的弹簧，或以 k 为系数的矩阵组：k 仅影响刚度时 df/f = U/2 dk/k。";
    relative_sensitivities: "(df/f)/(dp/p), in closed form from the derivatives of the matrices; mean over the branches of a repeated root.", "(df/f)/(dp/p)，由矩阵的导数解析求得；重根取各分支的平均。";
    no_derivative: "—: the parameter is 0, or an integer, which has no derivative.", "—：参数为 0，或为整数而没有导数。";
    loci_tracked: "Loci are tracked by mode shape; {} eigenproblems.", "轨迹按振型跟踪；求解 {} 个特征值问题。";
    values_in_ratios: "Values in equal ratios.", "取值按等比。";
    values_in_steps: "Values in equal steps.", "取值按等差。";
    class_of_locus: "Locus {}, at the first value: {}.", "轨迹 {}，在首个取值处：{}。";
    crossing: "Crossing: the frequencies coincide and the shapes are unchanged.", "交叉：频率重合，振型不变。";
    veering: "Veering: the frequencies approach each other without coinciding, and the shapes are exchanged.", "转向：频率相互靠近而不重合，振型互换。";
    coupling: "Coupling: c²/(c² + (s_a − s_b)²/4), c = φ_aᵀ(dK/dp − λ dM/dp)φ_b, s = dλ/dp.", "耦合：c²/(c² + (s_a − s_b)²/4)，c = φ_aᵀ(dK/dp − λ dM/dp)φ_b，s = dλ/dp。";
    width_of_veering: "Width: gap in λ over 2c.", "宽度：λ 的间隙除以 2c。";
    tracked_by_shape: "Modes are tracked by shape; in a veering f follows its locus and the MAC falls.", "模态按振型跟踪；转向处频率沿其轨迹，MAC 下降。";
    paired_by_mac: "Modes are paired by MAC alone: not all could be tracked by shape.", "模态仅按 MAC 配对：并非都能按振型跟踪。";
    no_uncertainty: "No uncertainty is known: no update.json beside the model; --uncertainty FILE.", "不确定度未知：模型旁没有 update.json；可用 --uncertainty FILE。";
    cost_by_logarithms: "Cost: sum of squared logarithms of the ratios of the values.", "代价：数值之比的对数的平方和。";
    cost_by_priors: "Cost: sum of squared changes in prior standard deviations.", "代价：以先验标准差计的变化的平方和。";
    short_by: "Short by: of the frequency.", "差额：相对于频率。";
    not_within_bounds: "Not within the bounds alone: {} of {} parameters.", "在界限内单独无法达到：{} / {} 个参数。";
    first_order: "First order: by the sensitivities of the model as it is; f after is solved again.", "一阶：按现有模型的灵敏度；修正后频率为重新求解。";
    targets_not_met: "The targets cannot be met within the bounds; the combination comes nearest.", "在界限内无法达到目标；所列组合最为接近。";
    distance_over_periods: "By |a − b|/|b| over the recorded periods; the costs are in the table of details.", "按记录周期上的 |a − b|/|b|；代价见详细程度的表格。";
    percent_of_detail: "Percent: distance from {}, |a − b|/|b| over the recorded periods.", "百分数：与 {} 的距离，按记录周期上的 |a − b|/|b|。";
    no_such_signal: "—: the detail has no such signal.", "—：该模型没有此信号。";
    costly_functions: "Functions: sines, square roots and similar.", "函数：正弦、平方根等。";
    simpler_error: "Error = (simpler − whole)/whole, matched by shape.", "误差 = (简化 − 完整)/完整，按振型对应。";
    no_such_mode: "—: the model has no such mode.", "—：该模型没有此模态。";
    // correlate
    mac_definition: "MAC = |a^H b|²/(a^H a · b^H b) (Allemang and Brown 1982); {} degrees of freedom.", "MAC = |a^H b|²/(a^H a · b^H b) (Allemang 与 Brown 1982)；{} 个自由度。";
    sensors_cannot_distinguish: "These sensors cannot distinguish modes whose MAC with each other is far from 0.", "互 MAC 远大于 0 的模态，这些测点无法区分。";
    no_duplicates: "Duplicates: a MAC of {} or more within {} % in frequency: none.", "重复模态 (MAC 至少 {}，频率相差至多 {} %)：无。";
    duplicates: "Duplicates: a MAC of {} or more within {} % in frequency: {}.", "重复模态 (MAC 至少 {}，频率相差至多 {} %)：{} 对。";
    frac: "FRAC = |Σ a* b|²/(Σ |a|² · Σ |b|²) over the lines (Heylen and Lammens 1996); level: rms of the second over the first.", "FRAC = |Σ a* b|²/(Σ |a|² · Σ |b|²)，对谱线求和 (Heylen 与 Lammens 1996)；幅值比：后者与前者的均方根之比。";
    frfs_on_lines: "{} FRFs, {} lines from {} to {} Hz, both in {}.", "{} 个频响函数，{} 条谱线，{} 至 {} Hz，单位均为 {}。";
    by_line: "At each line, a and b the FRFs as vectors: shape = |a^H b|²/(a^H a · b^H b), independent of amplitude; amplitude = 2|a^H b|/(a^H a + b^H b), 1 for equal vectors (Zang, Grafe and Imregun 2001).", "在每条谱线上以频响函数为向量 a、b：形状 = |a^H b|²/(a^H a · b^H b)，与幅值无关；幅值 = 2|a^H b|/(a^H a + b^H b)，向量相等时为 1 (Zang、Grafe 与 Imregun 2001)。";
    frfs_in_vector: "{} FRFs in each vector.", "每个向量含 {} 个频响函数。";
    frfs_without_partner: "FRFs without a partner: {} of the first, {} of the second.", "无对应的频响函数：前者 {} 个，后者 {} 个。";
    // check
    rows_met_and_nearest: "{} of {} met, {} in all; nearest {}.", "{} / {} 满足，共 {}；最接近的是 {}。";
    rows_met_of: "{} of {} met, {} in all: {}.", "{} / {} 满足，共 {}：{}。";
    // convert and synth
    written_contents: "{}: {} records and functions{}", "{}：{} 个记录与函数{}";
    bad_parts: "{} bad parts left out:", "略去 {} 处损坏：";
    synthetic_hits: "{} synthetic hits of {} samples at {} Hz: {}; truth: {}", "{} 次合成锤击，每次 {} 个样本，采样率 {} Hz：{}；真值：{}";
    synthetic_note: "Synthetic: computed from a model, not measured.", "合成：由模型计算，并非实测。";
    // study
    sufficient_method: "{}: use {}, which is enough for all {} observable modes.", "{}：采用 {}，对全部 {} 阶可观测模态已足够。";
    nothing_simpler: "Theory: nothing simpler to compare with: the model has no small bodies whose mass may be neglected, and no response over time.", "理论：没有更简的模型可比较：模型没有质量可忽略的小物体，也没有时间响应。";
    parameters_that_change: "Parameters: {} of {} have to change ({}), which explains the misfit: χ² of {} residuals is {} before and {} after.", "参数：{} / {} 个须修正 ({})，可解释偏差：{} 个残差的 χ² 由 {} 降至 {}。";
    chi_square_far_below: "χ² this far below its {} degrees of freedom means that the stated uncertainties are about {} times the errors.", "χ² 远小于其 {} 个自由度，说明规定的不确定度约为误差的 {} 倍。";
    lowest_order: "Lowest order: the least with every observable mode of ml and no other.", "最低阶数：恰含 ml 的全部可观测模态的最小阶数。";
    enough: "Enough: within {} % in frequency and {} % in damping of ml, or within two standard deviations.", "足够：与 ml 的频率相差 {} % 以内、阻尼相差 {} % 以内，或在两倍标准差以内。";
    rest_of_order: "Reasons, and each mode with each method: --full.", "原因，以及各方法的每阶模态：--full。";
    rest_with_files: "With figures and files: -o DIR.", "图与文件：-o DIR。";
};
