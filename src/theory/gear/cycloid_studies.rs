//! The parameter studies of the cycloid ball transmission's paper: how its third, fourth,
//! thirteenth and fourteenth root go over the trochoid ratio, the rolling circle, two stiffnesses
//! and the number of balls, and where modes change places.
//!
//! Roots are counted as the paper counts them, distinct ones in ascending order from the root at 0,
//! so that a number passes from one mode to another where loci cross.
//!
//! # Reference
//! Yang, An and Duan (2016), figures 6 to 8 and the text beside them.

use crate::theory::parameter::index_of;
use crate::theory::quantity::allowed_or;
use crate::theory::{
    CycloidBall, EventKind, Locus, ModeOptions, ModelQuantity, SweepRange, TheoreticalModel,
    TheoryError, model_roots, modes, sweep,
};

/// Numbers of the roots of figures 6 to 8, from 1.
const ROOTS: [usize; 4] = [3, 4, 13, 14];
/// Trochoid ratio K at one rolling circle, as parts of its value.
const RATIOS: [f64; 5] = [0.6, 0.8, 1.0, 1.1, 1.15];
/// Radius r0 of the rolling circle at one trochoid ratio, as parts of its value: 2 to 7 mm in set
/// B.
const RADII: [f64; 8] = [0.5, 0.75, 0.9, 1.0, 1.1, 1.25, 1.5, 1.75];
/// Stiffnesses between input and planet disc, N/m.
const STIFFNESSES: [f64; 7] = [1e7, 2e7, 3e7, 4e7, 5e7, 7e7, 9e7];
/// Stiffness at which the mode jumps in the paper, N/m.
const PRINTED_JUMP: f64 = 3e7;
/// More balls than the machine has.
const MORE_BALLS: [f64; 6] = [-2.0, -1.0, 0.0, 1.0, 2.0, 4.0];

/// Roots 3, 4, 13 and 14 along a study, rad/s.
pub(super) type Study = Vec<[f64; 4]>;

/// A machine whose parameters are changed.
pub(super) struct Studies<'a> {
    pub model: &'a CycloidBall,
    pub values: &'a [f64],
}

impl Studies<'_> {
    fn index(&self, name: &str) -> Result<usize, TheoryError> {
        index_of(self.model.name(), self.model.parameters(), name)
    }

    pub fn value(&self, name: &str) -> Result<f64, TheoryError> {
        Ok(self.values[self.index(name)?])
    }

    /// The four roots with values changed; not numbers where a value is out of its bounds or a root
    /// is not there.
    pub fn roots(&self, changes: &[(&str, f64)]) -> Result<[f64; 4], TheoryError> {
        let mut values = self.values.to_vec();
        for (name, value) in changes {
            values[self.index(name)?] = *value;
        }
        let solved = modes(self.model, &values, &[], &ModeOptions::default());
        let roots = solved.map(|solved| {
            let roots = model_roots(self.model, &solved);
            let root = |number: usize| roots.get(number - 1).map(|root| root.omega_rad_s);
            ROOTS.map(|number| root(number).unwrap_or(f64::NAN))
        });
        allowed_or([f64::NAN; 4], roots)
    }

    /// Over K with the rolling circle r0 = e/K kept.
    pub fn over_ratio(&self) -> Result<Study, TheoryError> {
        let (ratio, e) = (
            self.value("trochoid_ratio")?,
            self.value("half_eccentricity")?,
        );
        let at = |part: &f64| {
            let changes = [
                ("trochoid_ratio", part * ratio),
                ("half_eccentricity", part * e),
            ];
            self.roots(&changes)
        };
        RATIOS.iter().map(at).collect()
    }

    /// Over r0 with K kept.
    pub fn over_radius(&self) -> Result<Study, TheoryError> {
        let e = self.value("half_eccentricity")?;
        let at = |part: &f64| self.roots(&[("half_eccentricity", part * e)]);
        RADII.iter().map(at).collect()
    }

    /// Over one of the stiffnesses between input and planet disc.
    pub fn over_stiffness(&self, name: &str) -> Result<Study, TheoryError> {
        let at = |k: &f64| self.roots(&[(name, *k)]);
        STIFFNESSES.iter().map(at).collect()
    }

    /// Over the number of reduction balls.
    pub fn over_balls(&self) -> Result<Study, TheoryError> {
        let balls = self.value("ball_count")?;
        let at = |more: &f64| self.roots(&[("ball_count", balls + more)]);
        MORE_BALLS.iter().map(at).collect()
    }

    /// Over the number of reduction balls, the largest departure of a root's multiplicity from the
    /// paper's words: the first and the twelfth root change as Z2 does, the others not at all.
    pub fn multiplicities_off(&self) -> Result<f64, TheoryError> {
        let balls = self.value("ball_count")?;
        let (less, more) = (MORE_BALLS[0], MORE_BALLS[MORE_BALLS.len() - 1]);
        let range = SweepRange {
            lower: balls + less,
            upper: balls + more,
            count: (more - less) as usize + 1,
        };
        let swept = sweep(self.model, self.values, "ball_count", range, None).map(Some);
        let Some(swept) = allowed_or(None, swept)? else {
            return Ok(f64::NAN);
        };
        let off = |(number, locus): (usize, &Locus)| {
            let first = locus.multiplicity[0] as f64;
            let pairs = swept.values.iter().zip(&locus.multiplicity);
            let change = |value: &f64| match number {
                1 | 12 => value - range.lower,
                _ => 0.0,
            };
            pairs
                .map(|(value, count)| (*count as f64 - first - change(value)).abs())
                .fold(0.0, f64::max)
        };
        Ok((1..).zip(&swept.loci).map(off).fold(0.0, f64::max))
    }

    /// Where locus `lower`, numbered from 1 as the roots at the first value, crosses the next one,
    /// with the event's coupling.
    fn crossing(
        &self,
        parameter: &str,
        (from, to): (f64, f64),
        lower: usize,
    ) -> Result<[f64; 2], TheoryError> {
        let range = SweepRange {
            lower: from,
            upper: to,
            count: STIFFNESSES.len(),
        };
        let swept = sweep(self.model, self.values, parameter, range, None).map(Some);
        let Some(swept) = allowed_or(None, swept)? else {
            return Ok([f64::NAN; 2]);
        };
        let found = swept
            .events
            .iter()
            .find(|event| event.kind == EventKind::Crossing && event.loci == [lower - 1, lower]);
        Ok(found.map_or([f64::NAN; 2], |event| [event.place, event.coupling]))
    }

    /// Place of the mode jump over k03y, N/m, and the coupling of the modes there.
    pub fn jump(&self) -> Result<[f64; 2], TheoryError> {
        let ends = (STIFFNESSES[0], STIFFNESSES[STIFFNESSES.len() - 1]);
        self.crossing("k_03y", ends, 14)
    }

    /// Rolling circle at which roots 3 and 4 change places, m.
    pub fn radius_of_exchange(&self) -> Result<f64, TheoryError> {
        let (ratio, e) = (
            self.value("trochoid_ratio")?,
            self.value("half_eccentricity")?,
        );
        let ends = (RADII[0] * e, RADII[RADII.len() - 1] * e);
        Ok(self.crossing("half_eccentricity", ends, 3)?[0] / ratio)
    }
}

/// Changes of a root from each value of a study to the next, percent.
fn steps(study: &[[f64; 4]], root: usize) -> Vec<f64> {
    let column = ROOTS
        .iter()
        .position(|number| *number == root)
        .unwrap_or_default();
    let steps = study
        .windows(2)
        .map(|pair| 100.0 * (pair[1][column] / pair[0][column] - 1.0));
    steps.filter(|step| step.is_finite()).collect()
}

fn least(steps: &[f64]) -> f64 {
    steps.iter().copied().reduce(f64::min).unwrap_or(f64::NAN)
}

fn largest(steps: &[f64]) -> f64 {
    steps.iter().copied().reduce(f64::max).unwrap_or(f64::NAN)
}

/// Sum of the sizes of all steps: how much a root moves at all.
fn movement(steps: &[f64]) -> f64 {
    steps.iter().map(|step| step.abs()).sum()
}

/// What the paper says in figures and words of figures 6 to 8.
pub(super) fn study_quantities(
    model: &CycloidBall,
    values: &[f64],
) -> Result<Vec<ModelQuantity>, TheoryError> {
    let studies = Studies { model, values };
    let (ratio, radius) = (studies.over_ratio()?, studies.over_radius()?);
    let (k_x, k_y) = (
        studies.over_stiffness("k_03x")?,
        studies.over_stiffness("k_03y")?,
    );
    let balls = studies.over_balls()?;
    let [jump, coupling] = studies.jump()?;
    let before = STIFFNESSES.partition_point(|k| *k <= PRINTED_JUMP);
    let (below, above) = (&k_y[..before], &k_y[before..]);
    let turning = steps(&radius, 14);
    let rise = |name, study: &[[f64; 4]], root: usize, over: &str| {
        let meaning = format!(
            "least change of ω{root} from one value of {over} to the next: above 0 where it rises throughout"
        );
        ModelQuantity::new(name, least(&steps(study, root)), "%", &meaning)
    };
    let moved = |name, study: &[[f64; 4]], root: usize, over: &str| {
        let meaning = format!("all changes of ω{root} over {over} together");
        ModelQuantity::new(name, movement(&steps(study, root)), "%", &meaning)
    };
    let (over_k, over_r0) = ("K, r0 kept", "r0, K kept");
    let over_stiffness = "1e7 to 9e7 N/m of k03x";
    let over_other = "1e7 to 9e7 N/m of k03y";
    let over_balls = "Z2, Z3 = Z2 + 1";
    Ok(vec![
        rise("rise_3_over_k", &ratio, 3, over_k),
        rise("rise_4_over_k", &ratio, 4, over_k),
        rise("rise_13_over_k", &ratio, 13, over_k),
        rise("rise_14_over_k", &ratio, 14, over_k),
        rise("rise_3_over_r0", &radius, 3, over_r0),
        rise("rise_4_over_r0", &radius, 4, over_r0),
        rise("rise_13_over_r0", &radius, 13, over_r0),
        ModelQuantity::new(
            "first_step_14_over_r0",
            turning.first().copied().unwrap_or(f64::NAN),
            "%",
            "first change of ω14 over r0, K kept",
        ),
        ModelQuantity::new(
            "last_step_14_over_r0",
            turning.last().copied().unwrap_or(f64::NAN),
            "%",
            "last change of ω14 over r0, K kept",
        ),
        ModelQuantity::new(
            "r0_of_exchange",
            1e3 * studies.radius_of_exchange()?,
            "mm",
            "rolling circle at which ω3 and ω4 cross, K kept: there both change their slopes",
        ),
        moved("change_3_over_k03x", &k_x, 3, over_stiffness),
        moved("change_4_over_k03x", &k_x, 4, over_stiffness),
        moved("change_3_over_k03y", &k_y, 3, over_other),
        moved("change_4_over_k03y", &k_y, 4, over_other),
        rise("rise_13_over_k03x", &k_x, 13, over_stiffness),
        rise("rise_14_over_k03x", &k_x, 14, over_stiffness),
        rise("rise_14_below_jump", below, 14, "1e7 to 3e7 N/m of k03y"),
        moved("change_14_above_jump", above, 14, "4e7 to 9e7 N/m of k03y"),
        ModelQuantity::new(
            "jump_k03y",
            jump,
            "N/m",
            "k03y at which ω14 passes from one mode to another: the loci, followed by shape, cross",
        ),
        ModelQuantity::new(
            "jump_coupling",
            coupling,
            "",
            "coupling factor of the modes that cross there: 0 for a crossing, 1 for a veering",
        ),
        ModelQuantity::new(
            "multiplicities_off_over_z2",
            studies.multiplicities_off()?,
            "",
            "largest departure of a root's multiplicity from changing as Z2 does (ω1, ω12) or not at all (the others)",
        ),
        rise("rise_3_over_z2", &balls, 3, over_balls),
        rise("rise_4_over_z2", &balls, 4, over_balls),
        rise("rise_13_over_z2", &balls, 13, over_balls),
        ModelQuantity::new(
            "rise_14_over_z2",
            largest(&steps(&balls, 14)),
            "%",
            "largest change of ω14 from one Z2 to the next, Z3 = Z2 + 1: below 0 where it falls throughout",
        ),
    ])
}
