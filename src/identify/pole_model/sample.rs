//! A sample of the FRFs of a pole model, in which each mode is as visible as in any: for tests of
//! the line shape of modes.

use num_complex::Complex64;

use crate::identify::data::frf_matrix::FrfMatrix;
use crate::identify::data::model_pole::ModelPole;
use crate::identify::pole_model::PoleModel;
use crate::linalg::sort_descending_by;

/// Minimum number of outputs of a sample, where many inputs would leave one or two, of which each
/// may be a node of a mode.
const MIN_OUTPUTS: usize = 8;

impl PoleModel {
    /// The model of the outputs that have the largest residues over the noise, of each pole in
    /// turn, with all inputs that they have: some `max_functions` FRFs. The force noise that FRFs
    /// have in common is left out.
    pub fn sample(&self, max_functions: usize) -> Self {
        let outputs = self.strongest_outputs(max_functions);
        let mut functions = Vec::new();
        let mut renumbered = Vec::new();
        for output in outputs {
            let frfs = self.frf_matrix.outputs[output].iter();
            let places = functions.len()..;
            renumbered.push(
                places
                    .zip(frfs.clone())
                    .map(|(place, (input, _))| (*input, place))
                    .collect(),
            );
            functions.extend(frfs.map(|(_, number)| *number));
        }
        let frf_matrix = FrfMatrix {
            inputs: self.frf_matrix.inputs,
            outputs: renumbered,
        };
        let data = self.data.sample(&functions);
        let mut sample = Self::new(data, frf_matrix, self.options);
        sample.fixed = self.fixed;
        sample.poles = self.poles.clone();
        for pole in &mut sample.poles {
            keep_residues(pole, &functions);
        }
        sample
    }

    /// Outputs of a sample, ascending.
    fn strongest_outputs(&self, max_functions: usize) -> Vec<usize> {
        let outputs = &self.frf_matrix.outputs;
        let wanted = max_functions / self.frf_matrix.inputs.max(1);
        if wanted.max(MIN_OUTPUTS) >= outputs.len() {
            return (0..outputs.len()).collect();
        }
        let ranking = |pole: &ModelPole| {
            let lines = self.data.frfs.lines_around(pole.lambda, 1.0);
            let of_frf = |(_, f): &(usize, usize)| {
                pole.residues[*f].norm_sqr() / self.data.noise.mean_variance(*f, lines.clone())
            };
            let strength = |output: &usize| outputs[*output].iter().map(of_frf).sum::<f64>();
            let mut ranking: Vec<usize> = (0..outputs.len()).collect();
            sort_descending_by(&mut ranking, strength);
            ranking
        };
        let rankings: Vec<Vec<usize>> = self.poles.iter().map(ranking).collect();
        let mut chosen = std::collections::BTreeSet::new();
        let in_turn = (0..outputs.len()).flat_map(|rank| rankings.iter().map(move |r| r[rank]));
        for output in in_turn {
            if chosen.len() >= wanted.max(MIN_OUTPUTS) {
                break;
            }
            chosen.insert(output);
        }
        chosen.into_iter().collect()
    }
}

fn keep_residues(pole: &mut ModelPole, functions: &[usize]) {
    let residues = functions.iter().map(|f| pole.residues[*f]);
    pole.residues = residues.collect::<Vec<Complex64>>();
    let variances = functions
        .iter()
        .filter_map(|f| pole.residue_variances.get(*f));
    pole.residue_variances = variances.copied().collect();
}

#[cfg(test)]
mod tests {
    use crate::axis::FrequencyAxis;
    use crate::identify::data::band_frfs::whole_band;
    use crate::identify::data::frf_matrix::FrfMatrix;
    use crate::identify::data::model_pole::ModelPole;
    use crate::identify::estimator::MethodOptions;
    use crate::identify::fit::fit_data::FitData;
    use crate::identify::pole_model::PoleModel;
    use crate::identify::synthetic::{Measurement, Structure};
    use crate::modal::Pole;

    #[test]
    fn sample_has_both_inputs_of_the_outputs_at_which_each_mode_is_largest() {
        let sensors = 30;
        let wave = |p: usize| 1.2 + (0.3 * p as f64).sin();
        let mut local = vec![0.0; sensors];
        (local[0], local[1], local[16], local[19]) = (0.1, 0.2, 1.0, -0.8);
        let structure = Structure {
            modes: vec![
                (40.0, 0.01, (0..sensors).map(wave).collect()),
                (70.0, 0.01, local),
            ],
        };
        let axis = FrequencyAxis {
            start_hz: 20.0,
            step_hz: 0.1,
            len: 800,
        };
        let mut how = Measurement {
            snr_db: Some(80.0),
            ..Measurement::of_sensors(sensors, axis)
        };
        let dofs: Vec<_> = how.pairs.iter().map(|pair| pair.0.clone()).collect();
        // Hit by hit, so that the FRFs of an output are not neighbours.
        let of_hit = |hit: usize| dofs.iter().map(move |dof| (dof.clone(), hit));
        let pairs = (0..2).flat_map(of_hit);
        how.pairs = pairs.map(|(dof, hit)| (dof, dofs[hit].clone())).collect();
        let set = structure.measured(&how);
        let data = FitData::guarded(&set, whole_band(&set).unwrap()).unwrap();
        let frf_matrix = FrfMatrix::new(set.functions());
        let mut whole = PoleModel::new(data, frf_matrix, MethodOptions::default());
        let pole = |(hz, zeta, shape): &(f64, f64, Vec<f64>)| {
            let participation = [shape[0], shape[1]].map(Into::into);
            let lambda = Pole::from_frequency(*hz, *zeta).lambda;
            ModelPole::single(lambda, &participation, set.len())
        };
        whole.poles = structure.modes.iter().map(pole).collect();
        whole.residues();
        let mut sample = whole.sample(20);
        let outputs = whole.strongest_outputs(20);
        assert!(outputs.len() == 10 && outputs.contains(&16) && outputs.contains(&19));
        let functions: Vec<usize> = outputs.iter().flat_map(|o| [*o, sensors + o]).collect();
        assert_eq!(sample.data.frfs.functions(), functions.len());
        sample.residues();
        for (place, f) in functions.iter().enumerate() {
            let (sampled, all) = (&sample.data.frfs.values, &whole.data.frfs.values);
            assert_eq!(sampled.all_of(place), all.all_of(*f));
            for (sampled, pole) in sample.poles.iter().zip(&whole.poles) {
                let largest = pole.residues.iter().map(|a| a.norm()).fold(0.0, f64::max);
                let error = (sampled.residues[place] - pole.residues[*f]).norm();
                assert!(error < 1e-2 * largest, "{f}: {error} {largest}");
            }
        }
    }
}
