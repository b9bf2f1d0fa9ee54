//! Frequency axes of other programs: two-sided, conjugate, uneven, mixed.

use num_complex::Complex64;

use super::universal_file::{
    AxisLabel, Function, OneFile, RESIDUES, Values, accelerance_at, accelerances, even_lines,
    file_of, finds_the_mode, noisy_accelerance, on_file,
};

/// The accelerances with their values changed.
fn changed(change: impl Fn(usize, Vec<Complex64>) -> Vec<Complex64>) -> Vec<Function> {
    let mut functions = accelerances();
    for (i, function) in functions.iter_mut().enumerate() {
        if let Values::Complex(values) = &function.values {
            function.values = Values::Complex(change(i, values.clone()));
        }
    }
    functions
}

#[test]
fn conjugate_functions_are_turned() {
    let conjugate = |values: Vec<Complex64>| values.iter().map(Complex64::conj).collect();
    for count in [3, 1] {
        let functions = changed(|i, values| match i < count {
            true => conjugate(values),
            false => values,
        });
        let file = OneFile::new("conj.uff", file_of(&functions));
        let ran = finds_the_mode(&file.path(), &[]);
        assert!(ran.findings().contains("conjugate-turned"), "{count}");
        let real = ran.json()["modes"][0]["mpc"].as_f64().unwrap();
        assert!(real > 0.99, "{count}: {real}");
    }
}

#[test]
fn conjugate_mobilities_and_receptances_are_turned() {
    for (data_type, unit, order) in [(11, "m/s", 1), (8, "m", 2)] {
        let mut functions = changed(|_, values| {
            let lines = even_lines().into_iter().zip(values);
            let scaled = lines.map(|(hz, value)| {
                let s = Complex64::new(0.0, std::f64::consts::TAU * hz);
                (value * s.powi(-order)).conj()
            });
            scaled.collect()
        });
        for function in &mut functions {
            (function.ordinate.data_type, function.ordinate.unit) = (data_type, unit.to_owned());
        }
        let file = OneFile::new("conj.uff", file_of(&functions));
        let ran = finds_the_mode(&file.path(), &[]);
        assert!(ran.findings().contains("conjugate-turned"));
    }
}

/// Accelerances of all lines of a transform, from this line.
fn two_sided(lines: usize, first: usize, step_hz: f64) -> OneFile {
    let mut functions = accelerances();
    for (i, function) in functions.iter_mut().enumerate() {
        let value = |line: usize| match 2 * line > lines {
            true => accelerance_at((lines - line) as f64 * step_hz, RESIDUES[i]).conj(),
            false => accelerance_at(line as f64 * step_hz, RESIDUES[i]),
        };
        function.values = Values::Complex((first..lines).map(value).collect());
        function.axis = (first as f64 * step_hz, step_hz);
    }
    OneFile::new("two.uff", file_of(&functions))
}

#[test]
fn the_mirror_image_of_a_two_sided_frf_is_left_out() {
    for (lines, first, step_hz) in [(512, 0, 0.25), (513, 0, 0.25), (600, 1, 0.2)] {
        let file = two_sided(lines, first, step_hz);
        let ran = finds_the_mode(&file.path(), &[]);
        assert!(ran.findings().contains("two-sided"), "{lines} {first}");
    }
}

#[test]
fn lines_of_a_stepped_sine_are_interpolated() {
    let coarse_and_fine = || {
        let coarse = (0..71).map(|line| 5.0 + 0.5 * f64::from(line));
        let fine = (0..101).map(|line| 15.0 + 0.1 * f64::from(line));
        let mut lines: Vec<f64> = coarse.chain(fine).collect();
        lines.sort_by(f64::total_cmp);
        lines.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
        lines
    };
    let sweep = || (0..400).map(|line| 5.0 * 1.005_f64.powi(line)).collect();
    let down = || coarse_and_fine().into_iter().rev().collect();
    let lists: [Vec<f64>; 3] = [coarse_and_fine(), sweep(), down()];
    for lines in lists {
        let mut functions = accelerances();
        for (function, (residue, seed)) in functions.iter_mut().zip(RESIDUES.iter().zip(1..)) {
            function.values = Values::Complex(noisy_accelerance(&lines, *residue, seed));
            function.uneven = Some(lines.clone());
        }
        let file = OneFile::new("sine.uff", file_of(&functions));
        let ran = finds_the_mode(&file.path(), &[]);
        assert!(ran.findings().contains("lines-interpolated"), "{ran:?}");
    }
}

#[test]
fn even_lines_in_descending_order_are_not_interpolated() {
    let lines: Vec<f64> = even_lines().into_iter().rev().collect();
    let mut functions = accelerances();
    for function in &mut functions {
        if let Values::Complex(values) = &mut function.values {
            values.reverse();
        }
        function.uneven = Some(lines.clone());
    }
    let file = OneFile::new("down.uff", file_of(&functions));
    let ran = finds_the_mode(&file.path(), &[]);
    assert!(!ran.findings().contains("lines-interpolated"), "{ran:?}");
}

#[test]
fn coherence_of_a_stepped_sine_gives_the_deviation() {
    let lines: Vec<f64> = (0..400).map(|line| 5.0 * 1.005_f64.powi(line)).collect();
    let mut deviations = Vec::new();
    for coherence in [0.999, 0.9] {
        let mut functions = accelerances();
        for (function, (residue, seed)) in functions.iter_mut().zip(RESIDUES.iter().zip(1..)) {
            function.values = Values::Complex(noisy_accelerance(&lines, *residue, seed));
            function.uneven = Some(lines.clone());
        }
        let mut of_coherence = functions.clone();
        for function in &mut of_coherence {
            function.function_type = 6;
            function.values = Values::Real(vec![coherence; lines.len()]);
            function.ordinate = AxisLabel::new(0, "Coherence", "NONE");
            function.denominator = AxisLabel::new(0, "NONE", "NONE");
        }
        functions.extend(of_coherence);
        let file = OneFile::new("sine.uff", file_of(&functions));
        let ran = finds_the_mode(&file.path(), &["--averages", "8"]);
        let deviation = ran.json()["modes"][0]["frequency_std_hz"].as_f64().unwrap();
        deviations.push(deviation);
    }
    // √((1 − γ²)/γ²) of 0.9 over that of 0.999.
    let ratio = deviations[1] / deviations[0];
    assert!((7.0..13.0).contains(&ratio), "{deviations:?}");
}

#[test]
fn functions_of_another_axis_are_named_and_left_out() {
    let other_axis = |step_hz: f64, len: usize, residue: f64, node: i64| {
        let lines: Vec<f64> = (0..len).map(|line| 5.0 + step_hz * line as f64).collect();
        let values = noisy_accelerance(&lines, residue, 9);
        Function {
            axis: (5.0, step_hz),
            ..Function::accelerance(node, values)
        }
    };
    for (step_hz, len) in [(0.5, 71), (0.25, 161), (0.125, 281)] {
        let mut functions = accelerances();
        functions.insert(1, other_axis(step_hz, len, 0.3, 7));
        let file = OneFile::new("two.uff", file_of(&functions));
        let ran = finds_the_mode(&file.path(), &[]);
        let findings = ran.findings();
        assert!(
            findings.contains("function-left-out") && findings.contains("7:+Z"),
            "{findings}"
        );
    }
}

#[test]
fn a_sensor_a_thousand_times_off_is_named() {
    for (sensor, factor) in [(1, 1e3), (2, 1e3), (0, 250.0)] {
        let functions = changed(|i, values| {
            let factor = if i == sensor { factor } else { 1.0 };
            values.iter().map(|value| value * factor).collect()
        });
        let file = OneFile::new("k.uff", file_of(&functions));
        let ran = on_file("identify", &file.path(), &["--json"]);
        assert!(ran.findings().contains("sensor-scale"), "{sensor}: {ran:?}");
    }
}
