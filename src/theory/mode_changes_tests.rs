//! Modified models and their tracked modes agree with parameters, with closed forms and with
//! difference quotients.

use super::*;

/// The torsional planetary gear with parts on its coordinates: kind, coordinate, amount.
fn modified(parts: &[(AddedKind, usize, f64)]) -> ModifiedModel {
    let base = built_in("torsional-planetary").unwrap();
    let size = base
        .assemble(&nominal_values(base.parameters()))
        .unwrap()
        .coordinates
        .len();
    let addition = |&(kind, at, amount): &(AddedKind, usize, f64)| Addition {
        kind,
        rows: vec![(0..size).map(|i| f64::from(u8::from(i == at))).collect()],
        amount,
    };
    ModifiedModel::new(base, parts.iter().map(addition).collect()).unwrap()
}

fn frequencies(model: &dyn TheoreticalModel, values: &[f64]) -> Vec<f64> {
    modes(model, values, &[], &ModeOptions::default())
        .unwrap()
        .omega_rad_s
}

fn with(values: &[f64], last: f64) -> Vec<f64> {
    values.iter().copied().chain([last]).collect()
}

#[test]
fn an_added_mass_is_the_mass_parameter_of_its_body() {
    let model = modified(&[(AddedKind::Mass, 1, 0.3)]);
    let base = built_in("torsional-planetary").unwrap();
    let mut values = nominal_values(base.parameters());
    let added = frequencies(&model, &with(&values, 1.0));
    let ring = base
        .parameters()
        .iter()
        .position(|spec| spec.name == "m_r")
        .unwrap();
    values[ring] += 0.3;
    let expected = frequencies(base.as_ref(), &values);
    for (a, b) in added.iter().zip(&expected) {
        assert!((a - b).abs() <= 1e-9 * b.max(1.0), "{a} {b}");
    }
}

#[test]
fn a_repeated_root_that_an_added_mass_splits_is_tracked_into_its_parts() {
    let model = modified(&[(AddedKind::Mass, 3, 0.5)]);
    let values = nominal_values(built_in("torsional-planetary").unwrap().parameters());
    let [before, after] = [0.0, 1.0].map(|share| with(&values, share));
    let found = mode_changes(&model, &before, &after, None).unwrap();
    assert!(found.tracked);
    let split = found.modes.iter().filter(|change| {
        let state = change.before.as_ref().unwrap();
        state.root == 2
    });
    let counts: Vec<usize> = split
        .map(|change| change.after.as_ref().unwrap().vectors.ncols())
        .collect();
    assert_eq!(counts, [1, 2]);
    assert!(found.modes.iter().all(|change| change.mac.unwrap() > 0.99));
    let mut omega: Vec<f64> = found
        .modes
        .iter()
        .flat_map(|change| {
            let state = change.after.as_ref().unwrap();
            vec![state.omega_rad_s; state.vectors.ncols()]
        })
        .collect();
    omega.sort_by(f64::total_cmp);
    let expected = frequencies(&model, &after);
    for (a, b) in omega.iter().zip(&expected) {
        assert!((a - b).abs() <= 1e-9 * b.max(1.0), "{a} {b}");
    }
}

#[test]
fn slopes_of_frequencies_are_difference_quotients() {
    let model = modified(&[(AddedKind::Mass, 0, 0.4), (AddedKind::Spring, 2, 3e7)]);
    let values = with(
        &nominal_values(built_in("torsional-planetary").unwrap().parameters()),
        0.7,
    );
    let found = mode_changes(&model, &values, &values, None).unwrap();
    let states: Vec<&RootState> = found
        .modes
        .iter()
        .map(|c| c.after.as_ref().unwrap())
        .collect();
    let by = [0, 4, 5, values.len() - 1];
    let slopes = frequency_slopes(&model, &values, &by, &states).unwrap();
    for (k, &j) in by.iter().enumerate() {
        let at = |sign: f64| {
            let mut moved = values.clone();
            moved[j] *= 1.0 + sign * 1e-5;
            frequencies(&model, &moved)
        };
        let (upper, lower) = (at(1.0), at(-1.0));
        let mut place = 0;
        for (state, slopes) in states.iter().zip(&slopes) {
            let quotient = (upper[place] - lower[place]) / (2e-5 * values[j]);
            let size = state.omega_rad_s / values[j];
            let difference = (slopes[k] - quotient).abs();
            assert!(difference < 1e-6 * size, "{j} {} {quotient}", slopes[k]);
            place += state.vectors.ncols();
        }
    }
}

#[test]
fn matrices_are_linear_in_the_share_of_the_added_parts() {
    let kinds = [AddedKind::Mass, AddedKind::Spring, AddedKind::Damper];
    let parts: Vec<_> = kinds.iter().map(|kind| (*kind, 1, 2.0)).collect();
    let model = modified(&parts);
    let values = nominal_values(built_in("torsional-planetary").unwrap().parameters());
    let [none, all] = [0.0, 1.0].map(|share| model.assemble(&with(&values, share)).unwrap());
    let by = model.derivative(&with(&values, 0.5), values.len()).unwrap();
    let pairs = [
        (&none.mass, &all.mass, &by.mass),
        (&none.stiffness, &all.stiffness, &by.stiffness),
        (
            none.damping.as_ref().unwrap(),
            all.damping.as_ref().unwrap(),
            by.damping.as_ref().unwrap(),
        ),
    ];
    for (before, after, slope) in pairs {
        let difference = after - before;
        let scale = after.norm_max();
        assert!((difference - slope).norm_max() <= 1e-15 * scale);
        assert!((slope[(1, 1)] - 2.0).abs() < 1e-15);
    }
    let spring = all.springs.last().unwrap();
    assert!((spring.stiffness - 2.0).abs() < 1e-15);
}

#[test]
fn a_mode_that_only_the_changed_model_has_is_listed_as_new() {
    // A coordinate without mass has no mode until a mass is added to it.
    let text = r#"
        schema = "modalign-model/1"
        [[body]]
        name = "a"
        at_m = [0.0, 0.0, 0.0]
        mass_kg = 1.0
        free = ["x"]
        [[body]]
        name = "b"
        at_m = [1.0, 0.0, 0.0]
        mass_kg = 0.0
        free = ["x"]
        [[point]]
        name = "pa"
        body = "a"
        at_m = [0.0, 0.0, 0.0]
        [[point]]
        name = "pb"
        body = "b"
        at_m = [1.0, 0.0, 0.0]
        [[spring]]
        name = "s"
        from = "ground"
        to = "pa"
        direction = [1.0, 0.0, 0.0]
        stiffness_n_per_m = 100.0
        [[spring]]
        name = "t"
        from = "pa"
        to = "pb"
        direction = [1.0, 0.0, 0.0]
        stiffness_n_per_m = 100.0
    "#;
    let file = toml::from_str::<LumpedFile>(text).unwrap();
    let base = Box::new(LumpedModel::new(file).unwrap());
    let addition = Addition {
        kind: AddedKind::Mass,
        rows: vec![vec![0.0, 1.0]],
        amount: 0.2,
    };
    let model = ModifiedModel::new(base, vec![addition]).unwrap();
    let found = mode_changes(&model, &[0.0], &[1.0], None).unwrap();
    assert!(!found.tracked);
    assert_eq!(found.modes.len(), 2);
    assert!(found.modes[0].before.is_some() && found.modes[0].after.is_some());
    assert!(found.modes[1].before.is_none() && found.modes[1].after.is_some());
}
