//! The studies of figures 6 to 8 against the reference, to its digits.

use super::cycloid_studies::{Studies, Study};
use crate::theory::parameter::nominal_values;
use crate::theory::{CycloidBall, TheoreticalModel};

fn check(name: &str, study: &Study, expected: &[[f64; 4]]) {
    assert_eq!(study.len(), expected.len());
    for (i, (row, wanted)) in study.iter().zip(expected).enumerate() {
        for (got, wanted) in row.iter().zip(wanted) {
            // Half of the last printed digit and as much for the rounding of the reference.
            assert!((got - wanted).abs() <= 6e-4, "{name} {i}: {got} {wanted}");
        }
    }
}

#[test]
fn roots_over_the_geometry_are_the_reference() {
    let model = CycloidBall::new("B").expect("a set of the paper");
    let values = nominal_values(model.parameters());
    let studies = Studies {
        model: &model,
        values: &values,
    };
    check(
        "K",
        &studies.over_ratio().expect("roots"),
        &[
            [13716.135, 14508.744, 58673.646, 65949.279],
            [13736.272, 14508.738, 58947.475, 65647.124],
            [13765.426, 14508.704, 59382.320, 65492.213],
            [13785.081, 14508.659, 59661.214, 65467.513],
            [13796.776, 14508.623, 59814.917, 65468.823],
        ],
    );
    check(
        "r0",
        &studies.over_radius().expect("roots"),
        &[
            [13708.677, 14508.704, 58589.064, 66161.229],
            [13730.562, 14508.704, 58864.597, 65708.183],
            [13749.495, 14508.704, 59144.037, 65552.052],
            [13765.426, 14508.704, 59382.320, 65492.213],
            [13785.029, 14508.704, 59661.225, 65467.550],
            [13825.336, 14508.704, 60147.546, 65500.994],
            [13972.045, 14508.704, 61073.199, 65792.353],
            [14508.704, 14576.174, 61963.584, 66522.985],
        ],
    );
    check(
        "Z2",
        &studies.over_balls().expect("roots"),
        &[
            [13920.975, 14645.503, 59136.891, 65607.854],
            [13842.434, 14577.597, 59260.955, 65560.829],
            [13765.426, 14508.704, 59382.320, 65492.213],
            [13689.056, 14439.871, 59499.658, 65413.974],
            [13613.763, 14370.959, 59611.981, 65331.710],
            [13466.799, 14233.631, 59819.929, 65167.516],
        ],
    );
}

/// The fitted set, whose balls need not sit as the geometry of its numbers has them.
#[test]
fn roots_over_the_geometry_of_the_fitted_set_are_the_reference() {
    let model = CycloidBall::new("D").expect("a set of the paper");
    let values = nominal_values(model.parameters());
    let studies = Studies {
        model: &model,
        values: &values,
    };
    // The rolling circle kept; 0.6 to 1.1 of the K of the set, to three digits. The reference has
    // 1.15, too, 0.995, which is beyond the bounds of the parameter.
    let circle = studies.value("half_eccentricity").expect("a parameter")
        / studies.value("trochoid_ratio").expect("a parameter");
    let over_ratio = [0.519, 0.692, 0.866, 0.952].map(|k| {
        let changes = [("trochoid_ratio", k), ("half_eccentricity", k * circle)];
        studies.roots(&changes).expect("roots")
    });
    check(
        "K",
        &over_ratio.into(),
        &[
            [13718.985, 14505.851, 58753.719, 65998.501],
            [13757.235, 14489.172, 59019.553, 65674.563],
            [13846.404, 14437.158, 59441.538, 65467.795],
            [13915.550, 14396.543, 59703.501, 65411.361],
        ],
    );
    check(
        "r0",
        &studies.over_radius().expect("roots"),
        &[
            [13781.411, 14437.368, 58669.452, 66054.362],
            [13806.461, 14437.368, 58933.500, 65645.257],
            [13828.038, 14437.368, 59206.138, 65513.520],
            [13846.052, 14437.368, 59440.110, 65468.221],
            [13867.939, 14437.368, 59714.927, 65456.711],
            [13911.518, 14437.368, 60195.575, 65507.526],
            [14048.431, 14437.368, 61113.239, 65822.507],
            [14437.368, 14479.316, 61999.084, 66570.245],
        ],
    );
    check(
        "Z2",
        &studies.over_balls().expect("roots"),
        &[
            [14018.439, 14561.246, 59195.208, 65468.031],
            [13792.958, 14621.200, 59344.375, 65667.668],
            [13846.052, 14437.368, 59440.110, 65468.221],
            [13641.939, 14482.689, 59576.154, 65499.827],
            [13679.544, 14311.574, 59667.425, 65350.257],
            [13519.823, 14184.767, 59872.337, 65205.130],
        ],
    );
}

#[test]
fn roots_over_the_stiffnesses_are_the_reference() {
    for (set, over_x, over_y) in [
        (
            "B",
            [
                [13642.027, 14508.704, 51868.527, 62984.901],
                [13687.830, 14508.704, 52576.457, 63114.340],
                [13715.662, 14508.704, 53584.942, 63295.761],
                [13734.301, 14508.704, 54939.204, 63561.715],
                [13747.637, 14508.704, 56537.197, 63967.770],
                [13765.426, 14508.704, 59382.320, 65492.213],
                [13776.740, 14508.704, 60787.996, 67706.881],
            ],
            [
                [13765.426, 14502.399, 59382.320, 62236.562],
                [13765.426, 14505.027, 59382.320, 63583.833],
                [13765.426, 14506.441, 59382.320, 65161.803],
                [13765.426, 14507.325, 59382.320, 65492.213],
                [13765.426, 14507.930, 59382.320, 65492.213],
                [13765.426, 14508.704, 59382.320, 65492.213],
                [13765.426, 14509.178, 59382.320, 65492.213],
            ],
        ),
        (
            "D",
            [
                [13693.882, 14437.368, 51733.466, 62857.669],
                [13753.210, 14437.368, 52447.171, 62984.627],
                [13787.579, 14437.368, 53477.147, 63164.569],
                [13809.916, 14437.368, 54876.466, 63432.539],
                [13825.573, 14437.368, 56535.486, 63850.449],
                [13846.052, 14437.368, 59440.110, 65468.221],
                [13858.841, 14437.368, 60798.523, 67765.481],
            ],
            [
                [13846.052, 14433.735, 59440.110, 63297.558],
                [13846.052, 14435.284, 59440.110, 64659.715],
                [13846.052, 14436.134, 59440.110, 65468.221],
                [13846.052, 14436.672, 59440.110, 65468.221],
                [13846.052, 14437.043, 59440.110, 65468.221],
                [13846.052, 14437.520, 59440.110, 65468.221],
                [13846.052, 14437.815, 59440.110, 65468.221],
            ],
        ),
    ] {
        let model = CycloidBall::new(set).expect("a set of the paper");
        let values = nominal_values(model.parameters());
        let studies = Studies {
            model: &model,
            values: &values,
        };
        check(
            "k03x",
            &studies.over_stiffness("k_03x").expect("roots"),
            &over_x,
        );
        check(
            "k03y",
            &studies.over_stiffness("k_03y").expect("roots"),
            &over_y,
        );
    }
}

#[test]
fn the_quantities_state_rises_falls_and_the_jump() {
    let model = CycloidBall::new("B").expect("a set of the paper");
    let values = nominal_values(model.parameters());
    let all = model.quantities(&values).expect("values of the model");
    let value = |name: &str| {
        let found = all
            .iter()
            .find(|quantity| quantity.name == name)
            .expect("a quantity of the model");
        found.value.expect("a value")
    };
    for (name, expected) in [
        // From the reference's numbers: the first step for ω14, the third for ω4.
        ("rise_4_over_k", 14508.659 / 14508.704 - 1.0),
        ("rise_14_over_k", 65647.124 / 65949.279 - 1.0),
        ("rise_4_over_r0", 0.0),
        ("first_step_14_over_r0", 65708.183 / 66161.229 - 1.0),
        ("last_step_14_over_r0", 66522.985 / 65792.353 - 1.0),
        ("change_3_over_k03x", 13776.740 / 13642.027 - 1.0),
        ("change_4_over_k03x", 0.0),
        ("change_3_over_k03y", 0.0),
        ("rise_14_below_jump", 63583.833 / 62236.562 - 1.0),
        ("change_14_above_jump", 0.0),
        ("rise_14_over_z2", 65560.829 / 65607.854 - 1.0),
    ] {
        // Two numbers of three decimals; sums of steps are a little more than their whole.
        let limit = if name == "change_3_over_k03x" {
            6e-3
        } else {
            1e-5
        };
        assert!(
            (value(name) - 100.0 * expected).abs() < limit,
            "{name}: {} {expected}",
            value(name)
        );
    }
    assert!((value("jump_k03y") / 3.192963e7 - 1.0).abs() < 3e-7);
    assert!(value("jump_coupling") < 1e-12);
    assert!(value("multiplicities_off_over_z2").abs() < 1e-12);
    let exchange = value("r0_of_exchange");
    assert!(exchange > 6.0 && exchange < 7.0, "{exchange}");
}
