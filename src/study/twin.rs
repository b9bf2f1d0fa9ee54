//! The synthetic twin of a test is a [`System`] of its modes, at its degrees of freedom, on its
//! lines.

use num_complex::Complex64;

use crate::axis::{Band, FrequencyAxis};
use crate::dof::Dof;
use crate::frf::FrfSet;
use crate::linalg::sort_ascending_by;
use crate::modal::{ModalModel, Mode};

use super::StudyError;
use super::system::{System, TrueMode};

impl System {
    /// The twin of a test: these modes at the degrees of freedom of these functions, on their lines
    /// in a band. Of a roving hammer the hit points become the responses (reciprocity).
    ///
    /// # Errors
    /// [`StudyError::Value`] for a mode without damping or without the residue of a pair, for a
    /// band without lines, and for no mode.
    pub fn twin(model: &ModalModel, set: &FrfSet, band: Band) -> Result<Self, StudyError> {
        let lines = set.axis().lines(&band);
        let (mut responses, mut references) = (set.responses(), set.references());
        let swapped = responses.len() < references.len();
        if swapped {
            std::mem::swap(&mut responses, &mut references);
        }
        let kind = set.functions().first().map(|function| function.kind);
        let (Some(kind), false) = (kind, lines.is_empty()) else {
            return Err(invalid_value(
                "functions",
                "none in the band",
                "FRFs with lines in the band",
            ));
        };
        let measured = MeasuredDofs {
            responses: &responses,
            references: &references,
            swapped,
        };
        let modes = model.modes.iter().map(|mode| measured.true_mode(mode));
        let mut modes = modes.collect::<Result<Vec<_>, _>>()?;
        sort_ascending_by(&mut modes, |mode| mode.hz());
        if modes.is_empty() {
            return Err(invalid_value(
                "modes",
                "none",
                "one mode or more to make a twin of",
            ));
        }
        let twin = Self {
            modes,
            axis: *set.axis(),
            band,
            kind,
            responses,
            references,
            record_end_s: None,
        };
        twin.on_lines(*set.axis(), band)
    }

    /// The same system on the lines of an axis inside a band, which then ends at the first and the
    /// last of them.
    ///
    /// # Errors
    /// [`StudyError::Value`] for fewer than two lines.
    pub fn on_lines(self, axis: FrequencyAxis, band: Band) -> Result<Self, StudyError> {
        let lines = axis.lines(&band);
        let axis = FrequencyAxis {
            start_hz: axis.hz(lines.start),
            len: lines.len(),
            ..axis
        };
        let ends = Band::new(axis.hz(0), axis.hz(axis.len.saturating_sub(1)));
        let band = ends.map_err(|_| {
            let got = format!("{} lines of {} Hz", axis.len, axis.step_hz);
            invalid_value("band", &got, "two lines or more")
        })?;
        Ok(Self { axis, band, ..self })
    }
}

fn invalid_value(key: &str, got: &str, expected: &str) -> StudyError {
    StudyError::Value {
        key: key.to_owned(),
        got: got.to_owned(),
        expected: expected.to_owned(),
    }
}

struct MeasuredDofs<'a> {
    responses: &'a [Dof],
    references: &'a [Dof],
    /// Whether the responses here are the excitation points of the test.
    swapped: bool,
}

impl MeasuredDofs<'_> {
    /// Residues as the product of shape and participation, through the greatest of them.
    fn true_mode(&self, mode: &Mode) -> Result<TrueMode, StudyError> {
        let what = || format!("mode at {:.2} Hz", mode.frequency_hz);
        let pole = mode.pole().filter(|pole| pole.lambda.re < 0.0);
        let pole =
            pole.ok_or_else(|| invalid_value(&what(), "no damping", "a damping ratio above 0"))?;
        let mut residues: Vec<Vec<Complex64>> = Vec::new();
        for response in self.responses {
            let row = self.references.iter().map(|reference| {
                let known = self.residue(mode, response, reference);
                let pair = || format!("no residue of {response}|{reference}");
                known.ok_or_else(|| invalid_value(&what(), &pair(), "a residue of every pair"))
            });
            residues.push(row.collect::<Result<_, _>>()?);
        }
        let (o, i) = position_of_largest(&residues);
        let pivot = residues[o][i];
        let relative_to_pivot = |value: &Complex64| match pivot.norm() > 0.0 {
            true => value / pivot,
            false => Complex64::ZERO,
        };
        Ok(TrueMode {
            pole,
            shape: residues.iter().map(|row| row[i]).collect(),
            participation: residues[o].iter().map(relative_to_pivot).collect(),
        })
    }

    fn residue(&self, mode: &Mode, response: &Dof, reference: &Dof) -> Option<Complex64> {
        let (a, b) = match self.swapped {
            true => (reference, response),
            false => (response, reference),
        };
        mode.residues.get(&(a.clone(), b.clone())).copied()
    }
}

/// Row and column of the greatest value.
fn position_of_largest(values: &[Vec<Complex64>]) -> (usize, usize) {
    let positions = (0..values.len()).flat_map(|o| (0..values[o].len()).map(move |i| (o, i)));
    let size = |&(o, i): &(usize, usize)| values[o][i].norm_sqr();
    positions
        .max_by(|a, b| size(a).total_cmp(&size(b)))
        .unwrap_or((0, 0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frf::{modal_terms, synthesise};
    use crate::modal::{ModeShape, Pole, Scaling};
    use crate::quantity::FrfKind;

    /// Two modes with residues of rank one at pairs of points.
    fn model(pairs: &[(Dof, Dof)]) -> ModalModel {
        let mode = |hz: f64, zeta: f64| {
            let value = |dof: &Dof| {
                let point: f64 = dof.point().parse().unwrap();
                Complex64::new((hz * point).sin(), 0.1)
            };
            let residue = |(a, b): &(Dof, Dof)| ((a.clone(), b.clone()), value(a) * value(b));
            let mut mode = Mode::new(hz, Some(zeta), ModeShape::default(), Scaling::Unknown);
            mode.residues = pairs.iter().map(residue).collect();
            mode
        };
        ModalModel {
            modes: vec![mode(30.0, 0.01), mode(42.0, 0.03)],
            ..ModalModel::default()
        }
    }

    #[test]
    fn the_twin_has_the_functions_of_its_modes_whichever_side_is_hit() {
        let dof = |point: usize| -> Dof { format!("{point}:+Z").parse().unwrap() };
        let axis = FrequencyAxis {
            start_hz: 0.0,
            step_hz: 0.25,
            len: 241,
        };
        for turned in [false, true] {
            let pairs = (1..=3).flat_map(|o| (1..=2).map(move |i| (o, i)));
            let pair = |(o, i)| {
                if turned {
                    (dof(i), dof(o))
                } else {
                    (dof(o), dof(i))
                }
            };
            let pairs: Vec<(Dof, Dof)> = pairs.map(pair).collect();
            let model = model(&pairs);
            let terms = modal_terms(&model).unwrap();
            let set = synthesise(&terms, axis, &pairs, FrfKind::Mobility, 0.0).unwrap();
            let twin = System::twin(&model, &set, Band::new(20.1, 50.0).unwrap()).unwrap();
            assert_eq!((twin.responses.len(), twin.references.len()), (3, 2));
            assert_eq!((twin.axis.start_hz, twin.axis.len), (20.25, 120));
            let exact = twin.exact().unwrap();
            for (i, function) in exact.functions().iter().enumerate() {
                let (a, b) = (&function.response, &function.reference);
                let pair_of_test = if turned { (b, a) } else { (a, b) };
                let same = pairs
                    .iter()
                    .position(|pair| (&pair.0, &pair.1) == pair_of_test);
                let wanted = &set.values(same.unwrap())[81..201];
                let close = |(x, y): (&Complex64, &Complex64)| (x - y).norm() < 1e-12 * y.norm();
                assert!(exact.values(i).iter().zip(wanted).all(close));
            }
            let known = Pole::from_frequency(30.0, 0.01);
            assert_eq!(twin.modes[0].pole, known);
        }
    }

    #[test]
    fn a_mode_without_damping_or_residue_is_reported() {
        let dof = |point: usize| -> Dof { format!("{point}:+Z").parse().unwrap() };
        let pairs = [(dof(1), dof(1)), (dof(2), dof(1))];
        let full = model(&pairs);
        let axis = FrequencyAxis {
            start_hz: 0.0,
            step_hz: 0.25,
            len: 241,
        };
        let terms = modal_terms(&full).unwrap();
        let set = synthesise(&terms, axis, &pairs, FrfKind::Mobility, 0.0).unwrap();
        let band = Band::new(20.0, 50.0).unwrap();
        let error_of =
            |model: &ModalModel| System::twin(model, &set, band).unwrap_err().to_string();
        let missing = model(&pairs[..1]);
        assert!(
            error_of(&missing).contains("no residue of 2:+Z|1:+Z"),
            "{}",
            error_of(&missing)
        );
        let mut undamped = full.clone();
        undamped.modes[1].damping_ratio = None;
        assert!(error_of(&undamped).starts_with("mode at 42.00 Hz: got no damping"));
    }
}
