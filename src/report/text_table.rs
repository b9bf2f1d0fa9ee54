//! The texts of the report: key, English, Chinese; `{}` stands for a name or a number.

/// A text in both languages; `{}` stands for a name or a number.
pub(super) struct Text {
    pub english: &'static str,
    pub chinese: &'static str,
}

/// Texts by key.
pub(super) type Group = [(&'static str, Text)];

/// The texts of the report.
pub(super) struct Texts {
    /// Captions and column heads of tables, found by their English text.
    pub headings: &'static Group,
    /// Paragraphs between tables, found by their English text.
    pub paragraphs: &'static Group,
    /// Labels in the cells of a column, found by their English text; the column by the key of its
    /// head.
    pub labels: &'static [(&'static str, &'static Group)],
    /// Texts of the page.
    pub page: Page,
    /// Why an update stopped, found by the English text.
    pub stop_reasons: &'static Group,
    /// Names, units and axes of the factors of maps, found by the English text.
    pub factors: &'static Group,
    /// Texts that the script of the page writes, found by their English text.
    pub script: &'static Group,
}

/// A group of texts.
macro_rules! group {
    ($($key:ident: $english:literal, $chinese:literal;)*) => {
        &[$((stringify!($key), Text { english: $english, chinese: $chinese })),*]
    };
}

/// Declares the texts of the page with a field for each.
macro_rules! page {
    ($($key:ident: $english:literal, $chinese:literal;)*) => {
        /// Texts of the page.
        pub(super) struct Page { $(pub $key: Text),* }

        #[cfg(test)]
        impl Page {
            /// Every text of the page.
            pub fn texts(&self) -> Vec<&Text> {
                vec![$(&self.$key),*]
            }
        }

        const PAGE: Page = Page { $($key: Text { english: $english, chinese: $chinese }),* };
    };
}

/// Every text of the report.
pub(super) static TEXTS: Texts = Texts {
    headings: group! {
        records_and_functions: "Records and functions: {}", "记录与函数：{}";
        roots: "Roots of {}", "{} 的特征根";
        comparison: "Theory and test compared", "理论与试验对比";
        summary: "Summary", "汇总";
        parameters_of_the_model: "Parameters of the model", "模型参数";
        limits: "Limits", "限值";
        mode: "mode", "阶次";
        theory_hz: "theory (Hz)", "理论 (Hz)";
        test_hz: "test (Hz)", "试验 (Hz)";
        std_hz: "std (Hz)", "标准差 (Hz)";
        error_of_theory_percent: "(test−theory)/theory (%)", "(试验−理论)/理论 (%)";
        error_of_test_percent: "(theory−test)/test (%)", "(理论−试验)/试验 (%)";
        normalised_deviation: "normalised deviation", "(试验−理论)/标准差";
        damping_percent: "damping (%)", "阻尼比 (%)";
        verdict: "verdict", "结论";
        before: "before", "修正前";
        after: "after", "修正后";
        modes_of_worst_test: "Modes of {}, the test with the largest error", "{} 的模态，误差最大的试验";
        number: "no.", "序号";
        shape_of_array: "shape", "维数";
        kind: "kind", "类型";
        count: "count", "数目";
        type_of_function: "type", "种类";
        responses: "responses", "响应";
        references: "references", "参考";
        axis: "axis", "坐标轴";
        names: "names", "文件";
        format: "format", "格式";
        contents: "contents", "内容";
        inspected_frequency: "frequency [Hz]", "频率 [Hz]";
        inspected_damping: "damping [%]", "阻尼比 [%]";
        inspected_mass: "modal mass [kg]", "模态质量 [kg]";
        points: "points", "点数";
        values: "values", "数值数";
        title: "title", "标题";
        arrays: "{} arrays", "{} 个数组";
        hz_in_test: "{}\n(Hz)", "{}\n(Hz)";
        error_hz_in_test: "{}\nerror (Hz)", "{}\n误差 (Hz)";
        error_percent_in_test: "{}\nerror (%)", "{}\n误差 (%)";
        verdict_in_test: "{}\nverdict", "{}\n结论";
        chance_level: "chance level", "随机水平";
        basis: "basis", "依据";
        basis_in_test: "{}\nbasis", "{}\n依据";
        test: "test", "试验";
        paired: "paired", "已配对";
        by_shape: "by shape", "按振型";
        by_frequency_alone: "by frequency alone", "仅按频率";
        missed: "missed", "漏检";
        not_observable: "not observable", "不可观测";
        unmatched_test_modes: "unmatched test modes", "多余";
        ambiguous: "ambiguous", "不明确";
        max_error_percent: "max |error| (%)", "最大 |误差| (%)";
        mean_error_percent: "mean |error| (%)", "平均 |误差| (%)";
        rms_error_percent: "rms error (%)", "均方根误差 (%)";
        min_mac: "min MAC", "最小 MAC";
        dofs_used: "DOFs used", "自由度数";
        name: "name", "名称";
        value: "value", "数值";
        unit: "unit", "单位";
        status: "status", "来源";
        mac: "MAC of {} and theory", "{} 与理论的 MAC";
        auto_mac: "AutoMAC of {}", "{} 的自 MAC";
        auto_mac_at_fewest_sensors: "AutoMAC at the fewest sensors: {}", "最少测点处的自 MAC：{}";
        auto_mac_of_theory: "AutoMAC of the theory at the sensors of {}", "理论在 {} 测点处的自 MAC";
        similar_modes: "Similar modes of {}", "{} 中相似的模态";
        fmac: "MAC over both frequencies (FMAC) of {} and theory", "{} 与理论的频率 MAC (FMAC)";
        modal_scale_factors: "Modal scale factors from theory to {}", "由理论到 {} 的模态比例因子";
        comac: "Correlation by degree of freedom of {} and theory (COMAC)", "{} 与理论的坐标模态置信准则 (COMAC)";
        subspaces: "Close modes of {} and theory as subspaces", "{} 与理论的密集模态子空间";
        cross_orthogonality: "Cross-orthogonality of {} and theory", "{} 与理论的互正交性";
        self_orthogonality: "Self-orthogonality of {}", "{} 的自正交性";
        sign_reversed_sensors: "Sign-reversed sensors", "与理论反向的传感器";
        alignment: "The test's points in the theory's frame", "试验测点在理论坐标系中的位置";
        by_shape_of_two_lines: "by\nshape", "按\n振型";
        rms_error_of_two_lines: "rms\nerror (%)", "均方根\n误差 (%)";
        largest_error: "largest\nerror (%)", "最大\n误差 (%)";
        worst_mode: "worst\nmode", "最大误差\n阶次";
        model_modes: "model\nmodes", "模型\n模态数";
        by_frequency_of_two_lines: "by fre-\nquency", "按\n频率";
        ambiguous_of_two_lines: "ambi-\nguous", "不\n明确";
        unpaired: "un-\nmatched", "未\n配对";
        not_observable_of_two_lines: "not ob-\nservable", "不可\n观测";
        unpaired_test_modes: "unmatched\ntest modes", "多余的\n试验模态";
        lowest_mac: "lowest\nMAC", "最小\nMAC";
        std_percent: "std (%)", "标准差 (%)";
        rejected_hits: "Rejected hits", "剔除的锤击";
        frequency_hz: "f (Hz)", "频率 (Hz)";
        test_mode: "test mode", "试验阶次";
        theory_mode: "theory mode", "理论阶次";
        error_percent: "error (%)", "误差 (%)";
        phase_deg: "phase (deg)", "相位 (°)";
        dof: "DOF", "自由度";
        dofs: "DOFs", "自由度数";
        direction: "direction", "方向";
        pairs: "pairs", "配对数";
        theory_modes: "theory modes", "理论阶次";
        test_modes: "test modes", "试验阶次";
        from_hz: "from (Hz)", "起始 (Hz)";
        to_hz: "to (Hz)", "终止 (Hz)";
        angles_deg: "angles (deg)", "主角 (°)";
        at_random: "at random", "随机值";
        outside_percent: "outside (%)", "降阶模态外 (%)";
        response: "response", "响应";
        reference: "reference", "参考";
        level_db: "level (dB)", "幅值比 (dB)";
        lines: "lines", "谱线数";
        shape_mean: "shape, mean", "形状，平均";
        shape_least: "shape, least", "形状，最小";
        amplitude_mean: "amplitude, mean", "幅值，平均";
        amplitude_least: "amplitude, least", "幅值，最小";
        frf_correlation: "FRFs of {} and {}", "{} 与 {} 的频响函数";
        frf_correlation_by_line: "FRFs of {} and {} over frequency", "{} 与 {} 的频响函数随频率";
        supported_modes: "{}: number of modes that the data support", "{}：数据支持的模态数";
        lowest_orders: "{}: lowest order of every method", "{}：各方法的最低阶数";
        single_mode_methods: "{}: where one mode at a time is enough", "{}：单模态方法足够之处";
        modes: "modes", "模态数";
        last_mode_added: "last mode added", "最后加入的模态";
        frfs_that_need_it: "FRFs that need it", "需要它的频响函数数";
        held_out_lines: "held-out lines", "留出谱线";
        reduced_chi_square: "reduced chi-square", "约化卡方";
        lowest: "lowest", "最低";
        automatic: "automatic", "自选";
        tried: "tried", "已试";
        enough: "enough", "足够";
        pareto_front: "{}: Pareto front of time and error", "{}：时间与误差的帕累托前沿";
        on: "on", "对象";
        frfs: "FRFs", "频响函数";
        method: "method", "方法";
        cpu_time_ms: "CPU time (ms)", "处理器时间 (ms)";
        spread_ms: "± spread (ms)", "± 离散 (ms)";
        memory_mib: "memory (MiB)", "内存 (MiB)";
        frequency_percent: "frequency (%)", "频率 (%)";
        shape_percent: "shape (%)", "振型 (%)";
        found: "found", "找到";
        of: "of", "共";
        spurious: "spurious", "虚假";
        failure_boundaries: "Where methods fail: {}", "方法的失效边界：{}";
        share_of_the_slice: "share of the slice", "图内有效占比";
        failure_mode_beyond: "failure mode beyond", "失效时的表现";
        numerical_stability: "Numerical stability: digits lost by order, and the highest order with all poles to a tenth of their half-power width", "数值稳定性：随阶数丢失的位数，以及全部极点误差小于十分之一半功率带宽的最高阶数";
        digits_order_10: "digits, order 10", "位数，10 阶";
        order_f64: "order, f64", "阶数，f64";
        data_in_f32: "data in f32", "数据为 f32";
        data_and_equations_in_f32: "data and equations in f32", "数据与方程为 f32";
        times_of_draws: "Draws per second", "每秒抽样数";
        draws: "draws", "抽样数";
        processor_time_s: "processor time (s)", "处理器时间 (s)";
        draws_per_second: "draws per second", "每秒抽样数";
        identified_modes: "Identified modes: {}", "识别的模态：{}";
        std_frequency_hz: "std f (Hz)", "频率标准差 (Hz)";
        std_damping_percent: "std damping (%)", "阻尼比标准差 (%)";
        frequency_bias_hz: "f error by out-of-band modes (Hz)", "带外模态引起的频率误差 (Hz)";
        damping_bias_percent: "damping error by out-of-band modes (%)", "带外模态引起的阻尼比误差 (%)";
        mean_phase_deg: "mean phase (°)", "平均相位 (°)";
        overlap: "overlap", "模态重叠";
        lines_in_half_power_band: "lines in −3 dB band", "−3 dB 带宽内谱线数";
        quality: "quality", "质量";
        quality_of_frequency: "quality of f", "频率质量";
        quality_of_damping: "quality of damping", "阻尼质量";
        quality_of_shape: "quality of shape", "振型质量";
        is_mode: "is a mode", "是否模态";
        uncertain: "uncertain", "不可靠的量";
        good: "good", "可信";
        doubtful: "doubtful", "存疑";
        bad: "bad", "差";
        remark: "remark", "备注";
        hits: "Hits", "锤击";
        hits_of: "Hits: {}", "锤击：{}";
        hit: "hit", "锤击";
        at: "at", "锤击点";
        points_to_hit_again: "Points to hit again", "需要重新锤击的点";
        points_to_hit_again_of: "Points to hit again: {}", "需要重新锤击的点：{}";
        number_of_hits: "hits", "锤击次数";
        good_hits: "good hits", "合格锤击";
        best_hits: "best hits", "最佳锤击";
        resonance_hz: "resonance (Hz)", "共振 (Hz)";
        std_of_frf: "std of FRF (%)", "频响函数标准差 (%)";
        with_one_more_hit: "1 more hit (%)", "再锤 1 次 (%)";
        with_three_more_hits: "3 more hits (%)", "再锤 3 次 (%)";
        peak_n: "peak (N)", "力峰值 (N)";
        why: "why", "原因";
        what: "what", "项目";
        limit: "limit", "限值";
        published_frequencies: "Published natural frequencies and the model", "文献固有频率与模型";
        root: "root", "根";
        multiplicity: "M", "重数";
        model_hz: "model (Hz)", "模型 (Hz)";
        model_rad_s: "model (rad/s)", "模型 (rad/s)";
        printed_multiplicity: "M printed", "文献重数";
        printed_hz: "printed (Hz)", "文献 (Hz)";
        printed_rad_s: "printed (rad/s)", "文献 (rad/s)";
        model_class: "class of the model", "模型类别";
        printed_class: "class as printed", "文献类别";
        kinetic_energy: "kinetic energy", "动能";
        published_comparison: "The published comparison, recomputed", "文献对比表的重算";
        label: "label", "标号";
        root_hz: "root/2π (Hz)", "根/2π (Hz)";
        test_hz_of: "{}: test (Hz)", "{}：试验 (Hz)";
        error_hz_of: "{}: error (Hz)", "{}：误差 (Hz)";
        error_of_theory_percent_of: "{}: (test−theory)/theory (%)", "{}:(试验−理论)/理论 (%)";
        error_of_test_percent_of: "{}: (theory−test)/test (%)", "{}:(理论−试验)/试验 (%)";
        published_statements: "Statements of the publication, recomputed from its tables and the model", "文献的论述：由其表格与模型重算";
        claim: "claim", "论述";
        printed: "printed", "文献值";
        recomputed: "recomputed", "重算值";
        further_quantities: "Further quantities of the theory of {}", "{} 的理论给出的其他量";
        quantity: "quantity", "量";
        meaning: "meaning", "含义";
        states: "Supports and states of tests and model", "试验与模型的支承与状态";
        support: "support", "支承";
        highest_rigid_body_hz: "highest rigid-body mode (Hz)", "最高刚体模态 (Hz)";
        mass_kg: "mass (kg)", "质量 (kg)";
        preload_n: "preload (N)", "预紧力 (N)";
        torque_nm: "torque (N m)", "扭矩 (N m)";
        shaft_angle_deg: "shaft angle (°)", "轴转角 (°)";
        temperature_c: "temperature (°C)", "温度 (°C)";
        attached: "attached", "附加件";
        date: "date", "日期";
        recommended_points: "Recommended excitation points and sensors: {}", "建议的激励点与测点：{}";
        step: "step", "步";
        sensor: "sensor", "测点";
        additionally_observable: "additionally observable", "新增可观测";
        observable_modes_by_point: "Observable modes by point: {}", "各点可观测的模态：{}";
        observable: "observable", "已可观测";
        planned: "planned", "计划后可观测";
        peak_over_noise_db: "peak over noise (dB)", "峰值高于噪声 (dB)";
        excitation_point_ranking: "Ranking of excitation points: {}", "激励点排序：{}";
        observable_modes: "observable modes", "可观测模态数";
        driving_point_residue: "driving-point residue", "原点留数";
        independence: "independence", "独立性";
        updated_parameters: "Updated parameters", "修正后的参数";
        contribution_of_configurations: "Contribution of each configuration", "各构型的贡献";
        deviation_by_configuration: "Standard deviation by each configuration", "各构型给出的标准差";
        std_by_configuration: "std by {} alone", "仅由 {} 的标准差";
        configuration: "configuration", "构型";
        residual_count: "residuals", "残差数";
        chi_square_of_residuals: "chi-square", "卡方";
        determined_alone: "determines alone", "单独确定的参数";
        parameter: "parameter", "参数";
        initial: "initial", "初值";
        updated: "updated", "修正值";
        change_percent: "change (%)", "变化 (%)";
        std: "std", "标准差";
        prior_std: "prior std", "先验标准差";
        std_over_prior: "std/prior", "标准差/先验";
        identifiable_combinations: "Identifiable combinations of the parameters, in prior standard deviations", "可识别的参数组合 (以先验标准差为单位)";
        singular_value: "singular value", "奇异值";
        combination: "combination", "组合";
        update_modes: "Modes used in the update", "参与修正的模态";
        before_hz: "before (Hz)", "修正前 (Hz)";
        after_hz: "after (Hz)", "修正后 (Hz)";
        mac_before: "MAC before", "修正前 MAC";
        mac_after: "MAC after", "修正后 MAC";
        error_of_theory_before: "before\n(test−theory)/theory (%)", "修正前\n(试验−理论)/理论 (%)";
        error_of_theory_after: "after\n(test−theory)/theory (%)", "修正后\n(试验−理论)/理论 (%)";
        error_of_test_before: "before\n(theory−test)/test (%)", "修正前\n(理论−试验)/试验 (%)";
        error_of_test_after: "after\n(theory−test)/test (%)", "修正后\n(理论−试验)/试验 (%)";
        methods_of_scene: "Methods on the FRFs of the scene", "各方法在本场景频响函数上的结果";
        cpu_time_s: "CPU time\n(s)", "CPU 时间\n(s)";
        largest_frequency_error: "frequency\nerror (%)", "频率\n误差 (%)";
        largest_damping_error: "damping\nerror (%)", "阻尼\n误差 (%)";
        times_noise_floor: "times the\nnoise floor", "噪声底的\n倍数";
        times_bound: "times the\nbound", "理论下界的\n倍数";
        where_each_method: "Where each method meets the stated error", "各方法满足规定误差的范围";
        methods_fail_of_scene: "{}: where methods fail", "{}：方法失效之处";
        least_model_of_scene: "{}: the least model and method that it needs", "{}：所需的最简模型与方法";
        numbers_of_poles: "Numbers of poles that the data support, and lowest orders", "数据支持的极点数与最低阶次";
        poles_identified: "poles\nidentified", "识别的\n极点数";
        poles_by_bic: "poles\nby BIC", "按 BIC 的\n极点数";
        poles_by_held_out: "by held-out\nlines", "按留出\n谱线";
        poles_by_residual: "by\nresidual", "按\n残差";
        order_of_method: "order\nof {}", "{} 的\n阶次";
    },
    paragraphs: group! {
        pairs: "{} paired: {} by shape, {} by frequency alone", "{} 个已配对：{} 个按振型，{} 个仅按频率";
        pairs_with_ambiguous: "{} paired: {} by shape, {} by frequency alone; {} ambiguous", "{} 个已配对：{} 个按振型，{} 个仅按频率；{} 个不明确";
        pairs_of_test: "{}: {} paired: {} by shape, {} by frequency alone", "{}：{} 个已配对：{} 个按振型，{} 个仅按频率";
        rest_of_modes: "All columns and notes: --full; modes with shapes to a file: -o modes.json.", "全部列与说明：--full；模态与振型写入文件：-o modes.json。";
        rest: "All columns and notes: --full.", "全部列与说明：--full。";
        rest_of_comparison: "All columns and notes: --full; tables to a file: -o FILE.", "全部列与说明：--full；表格写入文件：-o FILE。";
        rest_of_frfs: "All hits and FRFs: --full; FRFs to a file: -o FILE.", "全部锤击与频响函数：--full；频响函数写入文件：-o FILE。";
        rest_of_frfs_in_file: "All hits and FRFs: --full.", "全部锤击与频响函数：--full。";
        rest_of_theory: "Parameters and all columns: --full; modes with shapes to a file: -o FILE.", "参数与全部列：--full；模态与振型写入文件：-o FILE。";
        rest_of_theory_in_file: "Parameters and all columns: --full.", "参数与全部列：--full。";
        rest_of_update: "All tables and columns: --full; updated model and tables: -o DIR.", "全部表格与列：--full；修正后的模型与表格：-o DIR。";
        rest_of_update_in_folder: "All tables, columns and notes: --full, or update.txt in the folder.", "全部表格、列与说明：--full，或文件夹中的 update.txt。";
        counted_modes: "Model modes: those in the band of the test. Errors and MAC: of paired and ambiguous modes.", "理论模态：试验频带内的模态。误差与 MAC：已配对与不明确的模态。";
        configurations_disagree: "Configurations disagree: {} = {} in {}, {} elsewhere (chi-square {} less).", "各构型不一致：{} = {} ({})，其他构型为 {} (卡方降低 {})。";
        scatter_between_tests: "Scatter of the frequencies between the tests: {} % ({} degrees of freedom), part of each deviation.", "各次试验之间频率的分散度：{} % ({} 个自由度)，计入各标准差。";
        scatter_of_configuration: "Scatter of the frequencies between the tests of {}: {} % ({} degrees of freedom), part of each deviation.", "{} 的各次试验之间频率的分散度：{} % ({} 个自由度)，计入各标准差。";
        before_of_configuration: "Configuration {}, before", "构型 {}，修正前";
        after_of_configuration: "Configuration {}, after", "构型 {}，修正后";
        other_configurations: "Other configurations: {}.", "其他构型：{}。";
        chi_square: "Chi-square per degree of freedom {} ({} degrees of freedom; noise alone reaches {}).", "每自由度卡方 {} ({} 个自由度；仅噪声可达 {})。";
        next_new: "Next: modalign new {}", "下一步：modalign new {}";
        all_hits_used: "Hits: all {} used.", "锤击：{} 次全部采用。";
        hits_rejected: "Hits: {} of {} used; rejected: {}.", "锤击：采用 {} / {} 次；剔除：{}。";
        leaving_shaker: "Before you leave: excitation by a shaker, no hits to repeat.", "离开之前：激振器激励，没有需要重复的锤击。";
        leaving_complete: "Before you leave: enough good hits at {}.", "离开之前：{} 的合格锤击数足够。";
        leaving_listed: "Before you leave: hit again {} of {}.", "离开之前：需要重新锤击 {} / {}。";
        leaving_test: "Before you leave, {}: {}.", "离开之前，{}：{}。";
        leaving_other_reasons: "- {}: for other reasons, see --full.", "- {}：其他原因，见 --full。";
        one_nonlinear: "Linearity: 1 resonance changes with the force; hit all points with one force.", "线性：1 个共振随力变化；请以同一力度锤击所有点。";
        some_nonlinear: "Linearity: {} resonances change with the force; hit all points with one force.", "线性：{} 个共振随力变化；请以同一力度锤击所有点。";
        linear: "Linearity: no resonance changes with the force; {}, {} dB, at {}.", "线性：没有共振随力变化；{}，{} dB，位于 {}。";
        linearity_not_tested: "Linearity: not tested; {}, {} dB, at {}; add hits of half and of twice the force.", "线性：未检验；{}，{} dB，位于 {}；请补充一半与两倍力度的锤击。";
        reciprocity_not_tested: "Reciprocity: not tested; exchange sensor and hammer at two points.", "互易性：未检验；请在两点间交换传感器与力锤。";
        reciprocal: "Reciprocity: {} within the limit; {} differs by {} % ({} %).", "互易性：{} 在限值内；{} 相差 {} % ({} %)。";
        not_reciprocal: "Reciprocity: {} of {} above the limit; {} differs by {} % ({} %): check directions, points and calibration.", "互易性：{} / {} 超出限值；{} 相差 {} % ({} %)：请检查方向、位置与标定。";
        no_driving_point: "Driving points: none; hit beside a sensor along its axis.", "原点：无；请在传感器旁沿其轴向锤击。";
        driving_points_right: "Driving points: {} with the right sign.", "原点：{} 符号正确。";
        driving_points_wrong: "Driving points: {} of {} with the wrong sign; {} for {} % of the energy ({} %): check directions and points.", "原点：{} / {} 符号错误；{} 占能量的 {} % ({} %)：请检查方向与位置。";
        drift_not_tested: "Drift: not tested; hit the first point again at the end.", "漂移：未检验；请在结束时再次锤击第一个点。";
        drift_without_resonance: "Drift: not tested; no isolated resonance in the hits that were repeated.", "漂移：未检验；重复的锤击中没有孤立的共振。";
        no_drift: "Drift: none at {} from {} to {}; {}.", "漂移：{} 处无，从 {} 至 {}；{}。";
        drifted: "Drift: at {} from {} to {} {}: check supports, temperature and sensors, then repeat.", "漂移：{} 处，从 {} 至 {}，{}：请检查支承、温度与传感器，然后重复。";
        no_mass_line: "Mass line: not tested; it needs more sensors with positions ([[point]], [[sensor]]) than motions that they see, and a band between suspension and first elastic mode.", "质量线：未检验；需要给出位置 ([[point]]、[[sensor]]) 的传感器多于其可测的运动数，并在悬挂模态与首阶弹性模态之间有频带。";
        mass_of_mass_line: "Mass line: {} ± {} kg from {} to {} Hz.", "质量线：{} ± {} kg，频带 {} 至 {} Hz。";
        mass_with_one_left_out: "Mass line: {} ± {} kg from {} to {} Hz, with {} left out; the FRFs are unchanged.", "质量线：{} ± {} kg，频带 {} 至 {} Hz，计算时略去 {}；频响函数未改动。";
        mass_with_repaired: "Mass line: {} ± {} kg from {} to {} Hz, with {} repaired; the FRFs are unchanged.", "质量线：{} ± {} kg，频带 {} 至 {} Hz，计算时已纠正 {}；频响函数未改动。";
        mass_of_no_rigid_body: "Mass line: from {} to {} Hz, mass not determined, because the sensors do not move as one rigid body.", "质量线：频带 {} 至 {} Hz，质量未确定，因为各传感器不按同一刚体运动。";
        mass_of_few_motions: "Mass line: from {} to {} Hz, mass not determined, because the sensors see fewer than six motions; add sensors in other directions and points.", "质量线：频带 {} 至 {} Hz，质量未确定，因为传感器可测的运动少于六个；请在其他方向与位置增加传感器。";
        mass_with_suspension: "Mass line: from {} to {} Hz, mass not determined, because modes of the suspension without a clear peak are in the band; hang the structure more softly.", "质量线：频带 {} 至 {} Hz，质量未确定，因为频带内有无明显峰值的悬挂模态；请采用更软的悬挂。";
        mass_of_few_hits: "Mass line: from {} to {} Hz, mass not determined; hit three points or more in different directions (with a roving hammer: use three sensors).", "质量线：频带 {} 至 {} Hz，质量未确定；请在三个或更多点沿不同方向锤击 (移动力锤时：使用三个传感器)。";
        mass_uncertain: "Mass line: from {} to {} Hz, mass not determined, because its standard deviation is above 20 %; the band is narrow or the FRFs are noisy.", "质量线：频带 {} 至 {} Hz，质量未确定，因为其标准差超过 20 %；频带过窄或频响函数噪声过大。";
        stated_mass_not_compared: "Mass line: stated mass {} kg not compared.", "质量线：给定质量 {} kg 未比较。";
        stated_mass_agrees: "Mass line: stated mass {} kg, difference {} % ({} %).", "质量线：给定质量 {} kg，相差 {} % ({} %)。";
        stated_mass_differs: "Mass line: stated mass {} kg, difference {} % ({} %); if the stated mass is right, the FRFs are {} ± {} times what they should be; check mass_kg and attached parts, sensitivities, tip mass of the hammer, suspension.", "质量线：给定质量 {} kg，相差 {} % ({} %)；若给定质量正确，频响函数为应有值的 {} ± {} 倍；请检查 mass_kg 与附加件、灵敏度、锤头附加质量及悬挂。";
        sensors_are_rigid: "Mass line: {} move as a rigid body.", "质量线：{} 随刚体运动。";
        sensors_not_rigid: "Mass line: the sensors do not move as one rigid body, no single sensor explains it (misfit {}, limit {}): check signs, axes and sensitivities.", "质量线：各传感器不按同一刚体运动，单个传感器无法解释 (偏差 {}，限值 {})：请检查符号、轴向与灵敏度。";
        sensors_exchanged: "Mass line: {} and {} fit the rigid body in each other's place: check whether their cables or names are exchanged.", "质量线：{} 与 {} 互换后符合刚体运动：请检查其电缆或名称是否互换。";
        sensor_not_rigid: "Mass line: {} does not move with the rigid body; {}: check cable, sensitivity, direction and position.", "质量线：{} 不随刚体运动；{}：请检查电缆、灵敏度、方向与位置。";
        support_stated: "Support: {}.", "支承：{}。";
        support_not_tested: "Support: {}, not tested; state highest_rigid_body_hz in [test.state].", "支承：{}，未检验；请在 [test.state] 中给出 highest_rigid_body_hz。";
        support_without_peak: "Support: {}, not tested; no clear peak above highest_rigid_body_hz.", "支承：{}，未检验；在 highest_rigid_body_hz 之上没有明显峰值。";
        support_unstated_mode: "Support: {}; highest_rigid_body_hz is not stated in [test.state]; highest clear peak below the mass line {} Hz, first clear peak above {} Hz.", "支承：{}；[test.state] 中未给出 highest_rigid_body_hz；质量线以下最高的明显峰值 {} Hz，其上首个明显峰值 {} Hz。";
        support_modes: "Support: {}; highest rigid-body mode {} Hz, first clear peak above {} Hz.", "支承：{}；最高刚体模态 {} Hz，其上首个明显峰值 {} Hz。";
        suspension_soft: "Support: {}; highest rigid-body mode {} Hz, {} of the first clear peak above at {} Hz ({}).", "支承：{}；最高刚体模态 {} Hz，为其上首个明显峰值之 {} 倍 (位于 {} Hz，限值 {})。";
        suspension_is_stiff: "Support: {}; highest rigid-body mode {} Hz, {} of the first clear peak above at {} Hz ({}): it raises that mode; hang the structure more softly.", "支承：{}；最高刚体模态 {} Hz，为其上首个明显峰值之 {} 倍 (位于 {} Hz，限值 {})：该模态因此升高；请采用更软的悬挂。";
        watching: "Watching {} until Ctrl-C.", "正在监视 {}，按 Ctrl-C 结束。";
        not_used: "Not used: {}: {}.", "未采用：{}：{}。";
        not_compared: "Not compared with the baseline: {}.", "未与基线比较：{}。";
        rows_met: "{} of {} met, {} in all.", "{} / {} 满足，共 {}。";
        pairs_of_test_with_ambiguous: "{}: {} paired: {} by shape, {} by frequency alone; {} ambiguous", "{}：{} 个已配对：{} 个按振型，{} 个仅按频率；{} 个不明确";
    },
    labels: &[
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
    ],
    page: PAGE,
    stop_reasons: group! {
        no_decrease: "Converged: no step lowers the objective", "已收敛：没有步能降低目标函数";
        small_step: "Converged: the steps have become as small as rounding", "已收敛：步长已小到舍入误差";
        nothing_seen: "Nothing changed: the test sees none of the free parameters", "未改变：试验看不到任何自由参数";
        iteration_limit: "Not converged: the stated number of iterations is reached", "未收敛：已达到规定的迭代次数";
    },
    factors: group! {
        damping: "damping", "阻尼比";
        order: "order", "阶数";
        noise: "noise", "噪声";
        separation: "separation", "间距";
        record_length: "record_length", "记录长度";
        hits: "hits", "锤击";
        references: "references", "参考点";
        node_distance: "node_distance", "与节点的距离";
        mass_loading: "mass_loading", "附加质量";
        second_contacts: "second_contacts", "二次接触";
        quantisation: "quantisation", "量化";
        force_noise: "force_noise", "力的噪声";
        exponential_window: "exponential_window", "指数窗";
        decades: "decades", "个数量级";
        half_power_widths: "half-power widths", "半功率带宽";
        time_constants: "time constants", "时间常数";
        bits: "bits", "位";
        orders: "orders", "阶";
        noise_of_responses_db: "Signal-to-noise ratio of the responses (dB)", "响应的信噪比 (dB)";
        noise_of_frfs_db: "Signal-to-noise ratio of the FRFs (dB)", "频响函数的信噪比 (dB)";
        separation_of_pair: "Separation of the pair (half-power widths)", "两阶的间距 (半功率带宽)";
        damping_ratio: "Damping ratio (-)", "阻尼比 (-)";
        record_length_in_time_constants: "Record length (time constants)", "记录长度 (时间常数)";
        number_of_hits: "Hits averaged", "平均的锤击次数";
        number_of_references: "References (hit points)", "参考点 (锤击点)";
        distance_from_node: "Distance of the hit from a node (share of the largest component)", "锤击点与节点的距离 (占最大分量的比例)";
        drift_over_positions: "Drift over roving positions (half-power widths)", "移动测点间的频率漂移 (半功率带宽)";
        share_of_second_contacts: "Share of hits with a second contact", "有二次接触的锤击比例";
        converter_bits: "Converter (bits)", "转换器 (位)";
        noise_of_force_db: "Signal-to-noise ratio of the force (dB)", "力的信噪比 (dB)";
        window_at_end: "Exponential window at the record's end (1: none)", "记录末端的指数窗 (1：无)";
        highest_model_order: "Highest model order", "最高模型阶数";
    },
    script: group! {
        test_choice: "Test", "试验";
        frf_response_excitation: "FRF (response/excitation)", "频响函数 (响应/激励)";
        mode: "Mode", "模态";
        frequency: "frequency", "频率";
        frequency_hz: "Frequency (Hz)", "频率 (Hz)";
        magnitude: "Magnitude", "幅值";
        phase_deg: "Phase (°)", "相位 (°)";
        coherence: "Coherence", "相干";
        real_part: "Real part", "实部";
        imaginary_part: "Imaginary part", "虚部";
        data: "data", "数据";
        fit: "fit", "拟合";
        fit_with_residual_terms: "fit: identified modes and two residual terms", "拟合：识别模态与两个剩余项";
        logarithmic_frequency: "logarithmic frequency", "对数频率";
        bode: "Bode", "伯德图";
        nyquist: "Nyquist", "奈奎斯特图";
        reset: "Reset", "还原";
        zoom_in: "Zoom in", "放大";
        zoom_out: "Zoom out", "缩小";
        how_to_zoom: "drag to zoom, double-click to reset; with the keyboard + − 0 and the arrows", "拖动放大，双击还原；键盘：+ − 0 与方向键";
        lines_shown: "lines of each curve are shown: the extremes of each segment", "条谱线显示在每条曲线上：各段的极值";
        frfs_shown: "FRFs are shown; the file has all", "个频响函数已显示；文件中有全部";
        of: "of", "/";
        stabilization_diagram: "Stabilization diagram", "稳定图";
        order: "order", "阶数";
        model_order: "Model order", "模型阶数";
        damping: "damping", "阻尼比";
        cmif: "CMIF (m/(N s))", "CMIF (m/(N·s))";
        unstable: "unstable", "不稳定";
        stable: "stable", "稳定";
        selected: "selected", "已选";
        picked_by_hand: "picked by hand", "手选";
        how_to_pick_poles: "Click a pole to pick it or to drop it. With the keyboard: arrows move, Enter picks.", "单击极点可选中或取消。键盘：方向键移动，回车选择。";
        save_selection: "Save selection.json", "保存 selection.json";
        drop_all: "Drop all", "全部取消";
        pick_the_selected_poles: "Pick the selected poles", "选取已选极点";
        poles_picked: "poles picked", "个极点已选";
        then: "then", "然后";
        poles_of: "Poles of", "极点来自";
        modes_without_orders: "The modes of the run, dotted, come from a method without model orders.", "点线为本次运行的模态，来自没有模型阶数的方法。";
        frfs: "FRFs", "频响函数";
        theory_hz: "Theory (Hz)", "理论 (Hz)";
        theory: "theory", "理论";
        test: "test", "试验";
        pair: "pair", "配对";
        degrees_of_freedom: "degrees of freedom", "自由度";
        still_modes_not_shown: "modes of the theory without motion at the sensors are not shown", "阶在测点处静止的理论模态未列出";
        play: "Play", "播放";
        pause: "Pause", "暂停";
        speed: "Speed", "速度";
        amplitude: "Amplitude", "幅度";
        over_each_other: "over each other", "叠加";
        side_by_side: "side by side", "并列";
        bodies: "bodies", "物体";
        front: "Front", "正视";
        side: "Side", "侧视";
        top: "Top", "俯视";
        oblique: "Oblique", "斜视";
        without_a_partner: "without a partner", "无配对";
        theory_alone: "theory alone", "仅理论";
        undeformed: "undeformed", "未变形";
        error: "error", "误差";
        how_to_rotate: "drag to rotate, wheel to zoom; with the keyboard the arrows and + −", "拖动旋转，滚轮缩放；键盘：方向键与 + −";
        points_in_a_row: "No point has coordinates: the points are drawn in a row.", "没有测点坐标：测点排成一行。";
        dofs_not_drawn: "degrees of freedom without position or direction are not drawn", "个自由度没有位置或方向，未绘出";
        radius_of_gyration: "Discs have the radius of gyration of their body.", "圆盘半径为该物体的回转半径。";
        circle: "circle", "圆";
        resonance: "resonance", "共振点";
        damping_surface: "Damping surface: damping ratio of each pair of lines", "阻尼曲面：每对谱线的阻尼比";
        below: "below", "低于共振的谱线";
        above: "above", "高于共振的谱线";
        median: "median", "中位数";
        range: "range", "范围";
        of_which_the_window: "of which the window", "其中窗函数";
        single_mode_receptance: "receptance with the other modes subtracted", "去除其他模态的位移导纳";
        kinetic_energy: "Kinetic energy", "动能";
        strain_energy: "Strain energy", "应变能";
        rigid_body_mode: "rigid-body mode", "刚体模态";
        other: "other", "其他";
        error_percent: "Error (%)", "误差 (%)";
        frequency_error_by_mode: "Frequency error by mode", "各阶频率误差";
        unmatched_model_mode: "unmatched model mode", "漏检";
        error_of_theory_with_std: "(test−theory)/theory (%), line ±1 std", "(试验−理论)/理论 (%)，线段 ±1 标准差";
        error_of_test_with_std: "(theory−test)/test (%), line ±1 std", "(理论−试验)/试验 (%)，线段 ±1 标准差";
        mac_of_repeated_root: "a box of a repeated root has the MAC of one of its vectors; the comparison has that of their subspace", "重根的方框为其中一个向量的 MAC；子空间的 MAC 见对比表";
        pair_with_repeated_root: "pair with a repeated root: MAC of one of its vectors, not of their subspace", "与重根配对：为其中一个向量的 MAC，而非子空间的";
        no_mac: "crossed out: no MAC, because no common degree of freedom moves", "划线格：无 MAC，共有自由度均不动";
        discs_of_unknown_radius: "The radii of discs that turn by an arc are not known: their rims move by the arc.", "以弧长转动的圆盘半径未知：其边缘按弧长移动。";
        synthetic_test: "Synthetic test: computed from a model, not measured.", "合成试验：由模型计算，并非实测。";
        iteration: "Iteration", "迭代";
        objective: "Objective", "目标函数";
        before: "before", "修正前";
        after: "after", "修正后";
        objective_by_iteration: "Objective of the update by iteration", "修正的目标函数";
        initial_chi_square: "χ² of the initial model", "现有模型的 χ²";
        rejected_step: "rejected step", "被拒绝的步";
        fold: "-fold", "重根";
        data_choice: "Data", "数据";
        error_of: "Error of", "误差";
        cost: "Cost", "代价";
        errors_of_measured_frfs: "measured FRFs, against the refined solution", "实测频响函数，相对精化解";
        errors_of_twin: "synthetic twin, against its truth", "合成孪生，相对真值";
        shape: "shape", "振型";
        cpu_time: "CPU time", "处理器时间";
        peak_memory: "Peak memory", "峰值内存";
        marks_of_speed: "A dot in a mark: all observable modes found, no spurious mode. A ring: on the Pareto front of the results with the fewest missed and spurious modes. CPU time of one machine, all threads.", "标记中有点：可观测的模态全部找到且无虚假模态。圆环：位于错误最少者的前沿。处理器时间为一台机器上全部线程之和。";
        error_over_bound: "Error of the twin over its Cramér-Rao bound", "孪生误差与 Cramér-Rao 下界之比";
        marks_of_bound: "Shaded: within 20 % of the bound. A dot in a mark: no missed and no spurious mode in any draw.", "阴影：在下界的 20 % 以内。标记中有点：所有抽样均无漏检与虚假模态。";
        white_noise: "white noise", "白噪声";
        modes_outside_the_band: "modes outside the band", "频带外有模态";
        record_ends_early: "record ends early", "记录过早结束";
        nothing_was_measured: "Nothing was measured.", "未测量。";
        pareto_front: "Pareto front", "帕累托前沿";
        cramer_rao_bound: "Cramér-Rao bound", "Cramér-Rao 下界";
        refined_std: "standard deviation of the refined solution", "精化解给出的标准差";
        one_transform: "one transform", "一次变换";
        one_pass_over_the_data: "one pass over the data", "遍历一次数据";
        peak_memory_mib: "Peak memory (MiB)", "峰值内存 (MiB)";
        cpu_time_ms: "CPU time (ms)", "处理器时间 (ms)";
        frequency_error_rms_percent: "Frequency error, rms (%)", "频率误差均方根 (%)";
        damping_error_rms_percent: "Damping error, rms (%)", "阻尼比误差均方根 (%)";
        shape_error_rms_percent: "Shape error √(1−MAC), rms (%)", "振型误差 √(1−MAC) 均方根 (%)";
        twin_noise: "The twin in white noise of {} dB.", "孪生，白噪声 {} dB。";
        frfs_and_lines: "FRFs: {}, lines {} Hz apart", "频响函数：{}，谱线间隔 {} Hz";
        modes_found: "{} of {} modes found, {} spurious", "找到 {} / {} 阶，虚假 {} 阶";
        signal_to_noise_ratio_db: "Signal-to-noise ratio (dB)", "信噪比 (dB)";
        frequency_error_over_bound: "Frequency error / bound", "频率误差 / 下界";
        damping_error_over_bound: "Damping error / bound", "阻尼比误差 / 下界";
        times_the_bound: "{} times the bound", "下界的 {} 倍";
        method: "Method", "方法";
        all_methods: "all methods", "全部方法";
        map: "Map", "图";
        modes_of_this_run: "modes of this run", "本次模态";
        draws_and_contour: "{} draws for each cell; the contour is where 95 % of them meet the stated error.", "每格 {} 次抽样；等值线处 95 % 的抽样满足规定误差。";
        everywhere_here: "everywhere here", "图内处处有效";
        nowhere_here: "nowhere here", "图内处处失效";
        no_method_fails: "no method fails", "无方法失效";
        every_method_fails: "every method fails", "全部方法失效";
        no_draw_fails: "no draw fails", "无抽样失效";
        every_draw_fails: "every draw fails", "全部抽样失效";
        mode_with_frequency: "mode {} ({} Hz)", "第 {} 阶 ({} Hz)";
        distance_from_boundary: "{} is {} from the failure boundary of {}", "{}：再变 {},{} 即失效";
        holds_on_both_axes: "{}: {} holds along both axes", "{}:{} 沿两轴均有效";
        distance_inside_failure_region: "{} lies in the failure region of {}, {} from its boundary", "{}:{} 在此失效，距有效处 {}";
        inside_failure_region: "{} lies in the failure region of {}", "{}:{} 在此失效";
        holds: "holds", "有效";
        fails: "fails", "失效";
        meaning_of_distance: "the distance is that to the contour of the method", "距离为到其等值线的距离";
        modes_not_listed: "{} further modes are not listed.", "另有 {} 阶未列出。";
        modes_outside_map: "{} further modes lie outside this map.", "另有 {} 阶在此图之外。";
        digits_lost_by_order: "Digits lost by order", "随阶数丢失的有效数字";
        digits_lost: "digits lost", "丢失位数";
        digits_lost_of_condition: "Digits lost (log₁₀ of the condition)", "丢失位数 (条件数的 log₁₀)";
        error_of_poles: "Error of poles (half-power widths)", "极点误差 (半功率带宽)";
        all_in_f64: "all in f64", "全部为 f64";
        data_in_f32: "data in f32", "数据为 f32";
        data_and_equations_in_f32: "data and equations in f32", "数据与方程为 f32";
        dashes_of_precision: "Solid: all in f64; dashed: data in f32; dotted: data and equations in f32.", "实线：全部为 f64；虚线：数据为 f32；点线：数据与方程为 f32。";
    },
};

page! {
    skip_to_content: "Skip to content", "跳到正文";
    light_or_dark: "Light or dark", "浅色或深色";
    notes: "Notes", "说明";
    made_by: "Made by {}", "由 {} 生成";
    figures_need_a_script: "Figures need a script; tables do not.", "图形需要脚本；表格不需要。";
    summary: "Summary", "摘要";
    comparison: "Comparison", "对比";
    mode_shapes: "Mode shapes", "振型";
    mac: "MAC", "MAC";
    frfs: "FRFs", "频响函数";
    stabilization_diagram: "Stabilization diagram", "稳定图";
    circle_fits: "Circle fits", "圆拟合";
    modes: "Modes", "模态";
    energies: "Energies", "能量";
    update: "Update", "模型修正";
    published_results: "Published results", "文献结果";
    hits: "Hits", "锤击";
    findings: "Findings", "提示";
    provenance: "Provenance", "来源";
    modes_with_a_partner: "{} of {} modes of the model in the band have a partner", "频带内 {} / {} 阶模型模态已配对";
    rms_frequency_error: "rms frequency error", "频率误差均方根";
    largest: "largest", "最大";
    smallest_mac: "smallest MAC", "最小 MAC";
    unmatched_model: "unmatched (model)", "漏检";
    not_observable: "not observable", "不可观测";
    unmatched_test: "unmatched (test)", "多余";
    ambiguous: "ambiguous", "不明确";
    unmatched_modes: "Unmatched modes", "漏检的模态";
    no_unmatched_modes: "No unmatched modes in the band.", "频带内无漏检。";
    recommended_changes: "Recommended changes", "建议的修改";
    update_result: "Update result", "修正的结果";
    synthetic: "synthetic", "合成";
    unmatched_not_excited: "{}: model mode {} at {} Hz is unmatched, not excited or not sensed: {}", "{}：模型第 {} 阶({} Hz)无配对，符合预期：{}";
    unmatched_observability_unknown: "{}: model mode {} at {} Hz is unmatched, observability unknown: {}", "{}：模型第 {} 阶({} Hz)无配对；试验能否观测到它未知：{}";
    unmatched_but_observable: "{}: model mode {} at {} Hz is unmatched, but the test should observe it: {}", "{}：模型第 {} 阶({} Hz)无配对，而试验本应观测到它：{}";
    unmatched_test_mode: "{}: test mode at {} Hz is unmatched", "{}：试验模态({} Hz)在模型中无配对";
    unobservable_model_modes: "model modes that these sensors and excitation points cannot observe: {}", "用这些测点和锤击点无法观测的模型模态：{} 阶";
    model_too_stiff: "All paired frequencies of the test lie below the model's: the model is too stiff or too light. One factor {} on all stiffnesses would bring the mean to the test.", "试验的配对频率均低于模型：模型过刚或过轻。若所有刚度乘以 {}，平均频率与试验一致。";
    model_too_soft: "All paired frequencies of the test lie above the model's: the model is too soft or too heavy. One factor {} on all stiffnesses would bring the mean to the test.", "试验的配对频率均高于模型：模型过软或过重。若所有刚度乘以 {}，平均频率与试验一致。";
    errors_without_common_sign: "The frequency errors have no common sign, so no single stiffness factor explains them; the largest is {} at {}.", "误差没有明显偏向一侧，单一系数无法解释；最大为 {}({})。";
    parameter_change: "{}: {} → {} ± {} {}", "{}：{} → {} ± {} {}";
    limit_missed: "Limit missed: {}", "超出限值：{}";
    limits_met: "All {} stated limits are met.", "{} 项限值全部满足。";
    number_of_warnings: "Warnings among the findings: {}.", "“提示”中的警告：{} 条。";
    test_only: "Test only, no model.", "本次运行没有试验与模型的对比。";
    no_findings: "No findings.", "没有需要说明的事项。";
    whole_run: "whole run", "整体";
    more_of_this_code: "more of this code", "条同类提示";
    program: "Program", "程序";
    model: "Model", "模型";
    seed_of: "Seed of {}", "{} 的随机种子";
    run_files: "Files that state the run", "运行设置文件";
    data: "Data", "数据";
    identification: "Identification", "识别";
    test: "test", "试验";
    file: "file", "文件";
    method: "method", "方法";
    band_hz: "band (Hz)", "频带 (Hz)";
    updated_parameters: "Parameters of the model, updated", "修正后的模型参数";
    parameter: "parameter", "参数";
    unit: "unit", "单位";
    before: "before", "修正前";
    after: "after", "修正后";
    std: "std", "标准差";
    change_percent: "change (%)", "变化 (%)";
    verdict: "verdict", "结论";
    frequencies_before_and_after: "Frequencies before and after", "修正前后的频率";
    mode: "mode", "阶次";
    test_hz: "test (Hz)", "试验 (Hz)";
    model_hz: "model (Hz)", "模型 (Hz)";
    error_before_percent: "error before (%)", "修正前误差 (%)";
    error_after_percent: "error after (%)", "修正后误差 (%)";
    mac_before: "MAC before", "修正前 MAC";
    mac_after: "MAC after", "修正后 MAC";
    update_explains: "The update explains the test: χ²/ν = {}, and noise alone reaches {}.", "修正能解释试验：χ²/ν = {}，仅噪声可达 {}。";
    update_does_not_explain: "The update does not explain the test: χ²/ν = {}, and noise alone reaches {}.", "修正不能解释试验：χ²/ν = {}，仅噪声可达 {}。";
    further_sentence: " {}.", "{}。";
    rms_before_and_after: " Rms frequency error {} % before, {} % after.", "频率误差均方根：修正前 {} %，修正后 {} %。";
    further_parameters: "{} further parameters with smaller changes in standard deviations: tab Update.", "另有 {} 个参数的变化(以标准差计)较小：见“模型修正”页。";
    starts_at_this_optimum: " {} of {} starts ended at this optimum.", "{} / {} 个起点到达此最优点。";
    identifiable_combinations: "Identifiability: parameter combinations, best determined first", "可辨识性：参数组合，最确定的在前";
    combination: "combination", "组合";
    single_changes: "One parameter changed at a time", "每次改变一个参数";
    rms_error_percent: "rms error (%)", "误差均方根 (%)";
    largest_error_percent: "largest error (%)", "最大误差 (%)";
    no_change: "no change", "不变";
    smallest_explaining_set: "Proposed: {}, the smallest set that brings the residual to its uncertainty.", "建议：{}，使残差降到其不确定度的最小集合。";
    no_explaining_set: "No set brings the residual to its uncertainty; {} has the smallest BIC.", "没有集合能使残差降到其不确定度；{} 的 BIC 最小。";
    model_before_update: "This shows the model before the update.", "此处为修正前的模型。";
    tabs_before_update: "Comparison, MAC and mode shapes show the model before this update.", "对比、MAC 与振型显示的是修正前的模型。";
    update_of_another_run: "The update in this folder is of other test frequencies or of another model than this run, and is left out; run `modalign update` again.", "此文件夹中的修正来自其他试验频率或其他模型，未列出；请重新运行 `modalign update`。";
    methods: "Methods", "方法";
    speed_study: "Speed against accuracy", "速度与精度";
    breakdown_study: "Where methods fail", "方法的失效边界";
    order_study: "Required and unnecessary elements of this scene", "本场景需要什么，不需要什么";
    order_of_another_run: "The study in order.json is of another scene or of other data than this run, and is left out; run `modalign study order` again.", "order.json 中的研究来自其他场景或其他数据，未列出；请重新运行 `modalign study order`。";
    map_text: "Each map is computed from random synthetic structures. Inside its contour a method finds their modes to the stated error in 95 % of the draws; outside, it does not. Points are the modes of this run.", "反复抽取小型结构。在等值线之内，方法在 95 % 的抽样中以规定误差找到其模态；在其外则不能。点为本次运行的模态。";
    speed_of_another_run: "The study in speed-accuracy.json is of another scene or of other data than this run, and is left out; run `modalign study speed-accuracy` again.", "speed-accuracy.json 中的研究来自其他场景或其他数据，未列出；请重新运行 `modalign study speed-accuracy`。";
    breakdown_of_another_run: "The study in breakdown.json shows the modes of another scene, or other modes than this run, and is left out; run `modalign study breakdown` again: finished slices are kept.", "breakdown.json 中的模态来自其他场景或与本次运行不同，未列出；请重新运行 `modalign study breakdown`：已完成的切片会保留。";
}
