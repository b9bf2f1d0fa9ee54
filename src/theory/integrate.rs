//! Ordinary differential equations `y' = f(t, y)`, with two independent integrators, so that each
//! checks the other.
//!
//! # Reference
//! Hairer, Nørsett and Wanner (1993), Solving Ordinary Differential Equations I, 2nd ed., sections
//! II.1 and II.9.

/// A system of first-order equations.
pub(super) trait Equations {
    /// Number of equations.
    fn len(&self) -> usize;

    /// The rates `f(t, y)` into `rate`.
    fn rate(&self, time_s: f64, state: &[f64], rate: &mut [f64]);
}

/// A method that steps through time.
pub(super) trait Integrator {
    /// Advances a state from `time_s` by `step_s`.
    fn step(&mut self, equations: &dyn Equations, time_s: f64, step_s: f64, state: &mut [f64]);

    /// Evaluations of the rates in one step.
    fn evaluations(&self) -> usize;
}

/// The classical Runge-Kutta method of order 4.
#[derive(Default)]
pub(super) struct RungeKutta4 {
    rates: [Vec<f64>; 4],
    point: Vec<f64>,
}

impl Integrator for RungeKutta4 {
    fn step(&mut self, equations: &dyn Equations, time_s: f64, step_s: f64, state: &mut [f64]) {
        let n = equations.len();
        self.point.resize(n, 0.0);
        for (stage, part) in [0.0, 0.5, 0.5, 1.0].into_iter().enumerate() {
            let (done, current) = self.rates.split_at_mut(stage);
            for (i, point) in self.point.iter_mut().enumerate() {
                let last = done.last().map_or(0.0, |rate| rate[i]);
                *point = state[i] + part * step_s * last;
            }
            current[0].resize(n, 0.0);
            equations.rate(time_s + part * step_s, &self.point, &mut current[0]);
        }
        let [a, b, c, d] = &self.rates;
        for (i, value) in state.iter_mut().enumerate() {
            *value += step_s / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i]);
        }
    }

    fn evaluations(&self) -> usize {
        4
    }
}

/// Stages of the extrapolation: order 16.
const COLUMNS: usize = 8;

/// Gragg's modified midpoint rule, extrapolated to a step of 0 by the Aitken-Neville scheme: of
/// order 16 with 2, 4, ... 16 substeps, where the rates are smooth within the step.
#[derive(Default)]
pub(super) struct ExtrapolatedMidpoint {
    columns: Vec<Vec<f64>>,
    points: [Vec<f64>; 2],
    rate: Vec<f64>,
}

impl ExtrapolatedMidpoint {
    /// Gragg's rule with this many substeps (even) into column `column`.
    fn midpoint(
        &mut self,
        equations: &dyn Equations,
        time_s: f64,
        step_s: f64,
        state: &[f64],
        column: usize,
        substeps: usize,
    ) {
        let h = step_s / substeps as f64;
        let [old, new] = &mut self.points;
        old.copy_from_slice(state);
        equations.rate(time_s, state, &mut self.rate);
        for i in 0..state.len() {
            new[i] = state[i] + h * self.rate[i];
        }
        for step in 1..substeps {
            equations.rate(time_s + step as f64 * h, new, &mut self.rate);
            for i in 0..state.len() {
                let next = old[i] + 2.0 * h * self.rate[i];
                old[i] = std::mem::replace(&mut new[i], next);
            }
        }
        equations.rate(time_s + step_s, new, &mut self.rate);
        for (i, value) in self.columns[column].iter_mut().enumerate() {
            *value = 0.5 * (old[i] + new[i] + h * self.rate[i]);
        }
    }
}

impl Integrator for ExtrapolatedMidpoint {
    fn step(&mut self, equations: &dyn Equations, time_s: f64, step_s: f64, state: &mut [f64]) {
        let n = equations.len();
        self.columns.resize(COLUMNS, Vec::new());
        let all = self.columns.iter_mut().chain(&mut self.points);
        all.chain([&mut self.rate])
            .for_each(|values| values.resize(n, 0.0));
        for column in 0..COLUMNS {
            let substeps = 2 * (column + 1);
            self.midpoint(equations, time_s, step_s, state, column, substeps);
        }
        // In place: after round r, column k holds the extrapolation over columns k - r to k.
        for round in 1..COLUMNS {
            for column in (round..COLUMNS).rev() {
                let ratio = (column + 1) as f64 / (column + 1 - round) as f64;
                let weight = 1.0 / (ratio * ratio - 1.0);
                let (before, after) = self.columns.split_at_mut(column);
                for (value, coarse) in after[0].iter_mut().zip(&before[column - 1]) {
                    *value += (*value - coarse) * weight;
                }
            }
        }
        state.copy_from_slice(&self.columns[COLUMNS - 1]);
    }

    fn evaluations(&self) -> usize {
        // 1 + 2 substeps in each column, less the one at the start that is counted with them.
        (1..=COLUMNS).map(|column| 2 * column + 1).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x'' = -x with a force: x = cos t + t/2 sin t solves x'' + x = cos t.
    struct Driven;

    impl Equations for Driven {
        fn len(&self) -> usize {
            2
        }

        fn rate(&self, time_s: f64, state: &[f64], rate: &mut [f64]) {
            rate[0] = state[1];
            rate[1] = time_s.cos() - state[0];
        }
    }

    fn error(integrator: &mut dyn Integrator, steps: usize) -> f64 {
        let h = 3.0 / steps as f64;
        let mut state = [1.0, 0.0];
        (0..steps).for_each(|i| integrator.step(&Driven, i as f64 * h, h, &mut state));
        (state[0] - (3.0f64.cos() + 1.5 * 3.0f64.sin())).abs()
    }

    #[test]
    fn each_integrator_converges_with_its_order() {
        let mut rule = RungeKutta4::default();
        let order = (error(&mut rule, 20) / error(&mut rule, 40)).log2();
        assert!((order - 4.0).abs() < 0.15, "{order}");
        // Order 16 is at rounding with one step per radian; half of them shows it.
        let mut rule = ExtrapolatedMidpoint::default();
        assert!(error(&mut rule, 3) < 1e-13, "{}", error(&mut rule, 3));
        let (coarse, fine) = (error(&mut rule, 1), error(&mut rule, 2));
        assert!(coarse < 1e-7 && coarse / fine > 4e3, "{coarse} {fine}");
        assert_eq!(rule.evaluations(), 80);
    }
}
