//! Modal models for the tests.

use num_complex::Complex64;

use crate::dof::Dof;
use crate::modal::{ModalModel, Mode, ModeShape, Scaling};

/// A model of modes at `1:+Z`, `2:+Z`, ... with these frequencies (Hz) and shapes.
pub fn model(modes: &[(f64, &[f64])]) -> ModalModel {
    let complex = modes.iter().map(|(hz, shape)| {
        let values = shape.iter().map(|v| Complex64::new(*v, 0.0));
        (*hz, values.collect::<Vec<_>>())
    });
    complex_model(&complex.collect::<Vec<_>>())
}

/// The same with complex shapes.
pub fn complex_model(modes: &[(f64, Vec<Complex64>)]) -> ModalModel {
    let mode = |(hz, shape): &(f64, Vec<Complex64>)| {
        let values = (1..).zip(shape).map(|(n, v)| (dof(n), *v));
        Mode {
            // The zeros of these shapes are values, and not directions without a sensor.
            method: Some("theory".to_owned()),
            ..Mode::new(*hz, None, ModeShape::new(values), Scaling::Unknown)
        }
    };
    ModalModel {
        modes: modes.iter().map(mode).collect(),
        ..ModalModel::default()
    }
}

/// `n:+Z`.
pub fn dof(n: usize) -> Dof {
    format!("{n}:+Z").parse().unwrap()
}
