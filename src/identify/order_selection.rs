//! How many roots the data support: what each further one explains, what it costs, and whether it
//! foretells what was left out.
//!
//! Over the noise of each function (level × course, as the fit weights it), the lines are
//! background + roots + noise. The background is constant, slope and poles that crowd towards the
//! ends of the band, so that modes outside it count as no root. Roots come one after the other:
//! those that were identified, then the other poles that stay over the orders, each time the one
//! that explains most of what those before it left over, all amplitudes fitted anew (orthogonal
//! least squares: Chen, Billings and Luo 1989, International Journal of Control 50). With `q` what
//! is left of a root's course `1/(iω − λ)` beside the others, of length 1, function f gains
//!
//! `g_f = 2 |qᴴe_f|² / Σ_k |q_k|² var_fk`, chi-squared of two degrees of freedom where there is no
//! such root,
//!
//! raised for noise that lines share. A function holds the root where that pays, so that one root
//! changes `BIC = −2 ln L + k ln N` by `2 ln N − Σ_f max(0, g_f − 2 ln N)`, with `N` independent
//! real numbers of the data (Schwarz 1978, Annals of Statistics 6). Lines T that are left out are
//! foretold with errors `(1 − H)⁻¹ e` of covariance `C = (1 − H)⁻¹`, with the rest `e` and the hat
//! matrix `H` on them (Allen 1974, Technometrics 16). Of T only n lines S in the middle are judged,
//! as lines that share noise with those that are left foretell themselves (hv-block: Racine 2000,
//! Journal of Econometrics 99): by how unlikely they are where they were not known, `−ln p = n ln
//! π + x_SᴴC_SS⁻¹x_S + ln det C_SS` with `x = Ce` (Geisser and Eddy 1979, Journal of the American
//! Statistical Association 74). Too few roots leave a large e, too many foretell with large
//! covariances. The poles stay where all lines put them.

use std::cmp::Reverse;
use std::ops::Range;

use num_complex::Complex64;

use crate::axis::Band;
use crate::frf::FrfSet;
use crate::linalg::{self, ComplexMatrix};
use crate::modal::Pole;

use crate::identify::Identification;
use crate::identify::data::band_frfs::Receptances;
use crate::identify::data::out_of_band_basis::{Background, Outside};
use crate::identify::data::residual::Rest;
use crate::identify::error::IdentifyError;
use crate::identify::estimator::PoleStatus;
use crate::identify::noise::band_profile::Profile;

/// Share of a course that must be left beside the others.
const LEAST_LEFT: f64 = 1e-6;
/// Other poles that are tried for each identified root, and fewest.
const OTHERS_PER_ROOT: usize = 1;
const FEWEST_OTHERS: usize = 4;
/// Longest stretch that is left out.
const LONGEST: usize = 8;
/// A stretch whose lines the background takes for more than this share is foretold by nothing else:
/// at the ends of the band.
const MOST_TAKEN: f64 = 0.5;
/// Fewest stretches that tell how sure a difference is.
const FEWEST_STRETCHES: usize = 8;
/// The rest of a model is as small as that of the largest within this factor.
const AS_SMALL: f64 = 1.1;

/// How unlikely values are that were left out: `−ln p − ln π` of each, 1 for noise that is foretold
/// without an error. Lines at the ends of the band that the background takes for itself do not
/// count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foretold {
    /// Mean.
    pub mean: f64,
    /// Standard error of its difference from the least, by the scatter of the differences over
    /// stretches.
    pub std: f64,
}

/// How much of the data the first so many roots explain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tried {
    /// The last of them; `None` for the background alone.
    pub pole: Option<Pole>,
    /// Whether that was identified, and not merely a pole that stays over the orders.
    pub identified: bool,
    /// Functions that hold it.
    pub holding: usize,
    /// BIC less that of the background alone.
    pub bic: f64,
    /// How unlikely left-out lines are; `None` where left-out lines are all that tells a root, or
    /// too few are foretold.
    pub predicted: Option<Foretold>,
    /// Mean square of what is left over, over the noise, for each degree of freedom. Below 1 where
    /// lines share noise that comes by the force: the fit takes part of that in.
    pub rest: f64,
}

/// What the data support.
#[derive(Clone, Debug, PartialEq)]
pub struct Support {
    /// Functions.
    pub functions: usize,
    /// Lines.
    pub lines: usize,
    /// Lines that are left out together.
    pub stretch: usize,
    /// Whether the noise of every function came with the data; else what the fit leaves over tells
    /// it.
    pub noise_stated: bool,
    /// Number of identified roots; a repeated one counts once.
    pub identified: usize,
    /// With no root, one, two, ...
    pub tried: Vec<Tried>,
}

impl Support {
    /// Number of roots of the least BIC.
    pub fn by_bic(&self) -> usize {
        let all = self.tried.iter().enumerate();
        let least = all.min_by(|a, b| a.1.bic.total_cmp(&b.1.bic));
        least.map_or(0, |(count, _)| count)
    }

    /// Fewest roots that foretell what was left out as well as any, within one standard error
    /// (Breiman, Friedman, Olshen and Stone 1984, Classification and Regression Trees, 3.4.3);
    /// `None` where too few lines can be foretold.
    pub fn by_prediction(&self) -> Option<usize> {
        let all = self.tried.iter().filter_map(|own| own.predicted);
        let least = all.map(|own| own.mean).reduce(f64::min)?;
        let as_well = |own: &Tried| {
            let own = own.predicted;
            own.is_some_and(|own| own.mean - least <= own.std)
        };
        self.tried.iter().position(as_well)
    }

    /// Fewest roots that leave no more over, but for a tenth, than any number up to that of the
    /// least BIC.
    pub fn by_rest(&self) -> usize {
        let least = self
            .tried
            .iter()
            .take(self.by_bic() + 1)
            .map(|own| own.rest);
        let least = least.fold(f64::INFINITY, f64::min);
        let small = |own: &Tried| own.rest <= AS_SMALL * least;
        self.tried.iter().position(small).unwrap_or(0)
    }
}

/// What the roots of an identification in a band, and then the other poles that stay over its
/// orders, explain of a set.
///
/// # Errors
/// [`IdentifyError`] when set and band do not go together.
pub fn support(set: &FrfSet, band: Band, own: &Identification) -> Result<Support, IdentifyError> {
    let mut data = Receptances::new(set, band)?;
    let identified = roots(own, set.added_damping_rad_s);
    let others = others(own, (set.added_damping_rad_s, band), &identified);
    // What the identified roots leave over says how large the noise is, and how lines share it.
    let mut first = Fitted::new(&data);
    for lambda in &identified {
        first.take(Course::of(*lambda, &first));
    }
    let mut rest = first.over_noise();
    data.tell_noise(&mut rest);
    data.lines_share_noise(&mut rest);
    let mut fitted = Fitted::new(&data);
    let mut tried = vec![fitted.tried(None)];
    let mut surprises = vec![fitted.surprises()];
    for (identified, all) in [(true, &identified), (false, &others)] {
        let mut left: Vec<Course> = all.iter().map(|own| Course::of(*own, &fitted)).collect();
        while let Some((course, gains)) = fitted.best(&mut left) {
            let lambda = course.lambda;
            fitted.take(course);
            fitted.count(&gains);
            let lambda = lambda + set.added_damping_rad_s;
            tried.push(fitted.tried(Some((Pole { lambda }, identified, &gains))));
            surprises.push(fitted.surprises());
        }
    }
    for (tried, predicted) in tried.iter_mut().zip(foretold(&surprises)) {
        tried.predicted = predicted;
    }
    Ok(Support {
        functions: data.functions(),
        lines: data.lines(),
        stretch: fitted.stretch,
        noise_stated: data.variance_measured(),
        identified: tried.iter().filter(|own| own.identified).count(),
        tried,
    })
}

/// Means of `−ln p − ln π`, and how sure each difference from the least is.
fn foretold(surprises: &[Option<Vec<f64>>]) -> Vec<Option<Foretold>> {
    let mean = |all: &[f64]| all.iter().sum::<f64>() / all.len() as f64;
    let known = surprises.iter().flatten();
    let least = known.min_by(|a, b| mean(a).total_cmp(&mean(b)));
    let of = |own: &Option<Vec<f64>>| {
        let (own, least) = (own.as_ref()?, least?);
        let differences: Vec<f64> = own.iter().zip(least).map(|(a, b)| a - b).collect();
        let (count, middle) = (own.len() as f64, mean(&differences));
        let square: f64 = differences.iter().map(|d| (d - middle).powi(2)).sum();
        (own.len() >= FEWEST_STRETCHES).then(|| Foretold {
            mean: mean(own),
            std: (square / (count - 1.0) / count).sqrt(),
        })
    };
    surprises.iter().map(of).collect()
}

/// Poles of the identified modes as in the data, each once.
fn roots(own: &Identification, added_damping_rad_s: f64) -> Vec<Complex64> {
    let mut all: Vec<Complex64> = Vec::new();
    for pole in own.model.modes.iter().filter_map(|mode| mode.pole()) {
        let lambda = pole.lambda - added_damping_rad_s;
        if !all.contains(&lambda) {
            all.push(lambda);
        }
    }
    all
}

/// Poles as in the data that stay over the orders and that no mode was made of, of the highest
/// order each, none nearer to another or to a root than a decay rate.
fn others(
    own: &Identification,
    (added_damping_rad_s, band): (f64, Band),
    identified: &[Complex64],
) -> Vec<Complex64> {
    let stays = own.stabilization.iter();
    let mut stays: Vec<_> = stays
        .filter(|own| own.status == PoleStatus::Stable)
        .filter(|own| own.pole.lambda.re < 0.0 && band.contains(own.pole.natural_frequency_hz()))
        .collect();
    stays.sort_by_key(|own| Reverse(own.order));
    let most = (OTHERS_PER_ROOT * identified.len()).max(FEWEST_OTHERS);
    let mut chosen: Vec<Complex64> = Vec::new();
    for point in stays {
        let lambda = point.pole.lambda - added_damping_rad_s;
        let near =
            |other: &Complex64| (other - lambda).norm() < lambda.re.abs().max(other.re.abs());
        if chosen.len() < most && !identified.iter().chain(&chosen).any(near) {
            chosen.push(lambda);
        }
    }
    chosen
}

/// A root's course over the lines beside what is fitted already, of length 1.
struct Course {
    lambda: Complex64,
    /// One column.
    values: ComplexMatrix,
    /// Length that was left of it.
    left: f64,
}

impl Course {
    fn of(lambda: Complex64, fitted: &Fitted) -> Self {
        let value = |k: usize, _| {
            (Complex64::new(0.0, fitted.data.omega[k]) - lambda).inv() / fitted.course[k]
        };
        let mut own = Self {
            lambda,
            values: linalg::complex_matrix(fitted.data.lines(), 1, value),
            left: 1.0,
        };
        own.normalise();
        own.left = 1.0;
        own.beside(&fitted.basis);
        own
    }

    fn normalise(&mut self) {
        let length = self.values.norm_l2();
        if length > 0.0 {
            self.left *= length;
            linalg::by_column(&mut self.values, |_, column| {
                column.iter_mut().for_each(|value| *value /= length);
            });
        }
    }

    /// Twice, as once leaves what rounding makes of a course that nearly all goes.
    fn beside(&mut self, basis: &ComplexMatrix) {
        for _ in 0..2 {
            let along = linalg::adjoint_product(basis, self.values.as_ref());
            self.values = linalg::less_product(self.values.as_ref(), (basis, &along), |_, _| ());
            self.normalise();
        }
    }
}

/// Background and roots fitted to all lines.
struct Fitted<'a> {
    data: &'a Receptances,
    /// Relative course of the noise, and the root of the mean variance of each function.
    course: Vec<f64>,
    /// Variance of every value over what level and course say: by function and line.
    ratio: Vec<Vec<f64>>,
    /// Orthonormal columns over the noise: lines × columns.
    basis: ComplexMatrix,
    /// What they leave over, over level and course: lines × functions.
    rest: ComplexMatrix,
    /// How much of the noise of a function the columns take, in that of a line: 1 each where noise
    /// is white.
    taken: f64,
    stretch: usize,
    /// Stretches that are foretold.
    foretold: Vec<Range<usize>>,
    /// ln N.
    ln_count: f64,
    bic: f64,
}

impl<'a> Fitted<'a> {
    fn new(data: &'a Receptances) -> Self {
        let (lines, functions) = (data.lines(), data.functions());
        let Profile { level, course } = Profile::new(data, 0..lines);
        let background = Background::new(&data.omega, &(0..lines), &Outside::Anywhere);
        let ratio = |f: usize| {
            let own = data.variance[f].iter().zip(&course);
            let own = own.map(|(v, c)| v / (level[f] * c).powi(2));
            own.collect::<Vec<f64>>()
        };
        let value = |k: usize, f: usize| data.values[f][k] / (level[f] * course[k]);
        let alike = data.correlation.alike();
        let stretch = (alike.round() as usize).clamp(1, LONGEST);
        let mut own = Self {
            ratio: (0..functions).map(ratio).collect(),
            basis: linalg::complex_matrix(lines, 0, |_, _| Complex64::ZERO),
            rest: linalg::complex_matrix(lines, functions, value),
            taken: 0.0,
            stretch,
            foretold: Vec::new(),
            ln_count: (2.0 * (lines * functions) as f64 / alike).ln(),
            bic: 0.0,
            data,
            course,
        };
        let basis = background.basis(&data.omega, &own.course);
        own.add(&basis, alike);
        let all = (0..lines).step_by(stretch);
        let all = all.map(|k| k..(k + stretch).min(lines));
        let mean = |own: &Range<usize>, hat: &ComplexMatrix| {
            let diagonal = (0..hat.nrows()).map(|k| hat[(k, k)].re);
            diagonal.sum::<f64>() / own.len() as f64
        };
        own.foretold = all
            .filter(|lines| mean(lines, &own.hat(lines)) < MOST_TAKEN)
            .collect();
        own
    }

    /// `H` of some lines.
    fn hat(&self, lines: &Range<usize>) -> ComplexMatrix {
        let rows = self.basis.subrows(lines.start, lines.len());
        rows * rows.adjoint()
    }

    /// Takes the columns out of the rest; each takes so many times the noise of a line.
    fn add(&mut self, columns: &ComplexMatrix, raised: f64) {
        let along = linalg::adjoint_product(columns, self.rest.as_ref());
        self.rest = linalg::less_product(self.rest.as_ref(), (columns, &along), |_, _| ());
        self.taken += raised * columns.ncols() as f64;
        let first = self.basis.ncols();
        let own = |k: usize, c: usize| match c.checked_sub(first) {
            None => self.basis[(k, c)],
            Some(c) => columns[(k, c)],
        };
        self.basis = linalg::complex_matrix(columns.nrows(), first + columns.ncols(), own);
    }

    /// Puts a root to the others; one that is nothing of its own beside them is left out.
    fn take(&mut self, mut course: Course) {
        course.beside(&self.basis);
        if course.left > LEAST_LEFT {
            self.add(&course.values, self.raised(course.lambda));
        }
    }

    /// Takes out that which lowers BIC most, with its gains by function.
    fn best(&self, left: &mut Vec<Course>) -> Option<(Course, Vec<f64>)> {
        for course in left.iter_mut() {
            course.beside(&self.basis);
        }
        left.retain(|course| course.left > LEAST_LEFT);
        let gains: Vec<Vec<f64>> = left.iter().map(|course| self.gains(course)).collect();
        let lowered = |place: &usize| self.lowered(&gains[*place]);
        let best = (0..left.len()).max_by(|a, b| lowered(a).total_cmp(&lowered(b)))?;
        Some((left.swap_remove(best), gains[best].clone()))
    }

    /// `g_f` of every function.
    fn gains(&self, course: &Course) -> Vec<f64> {
        let along = linalg::adjoint_product(&course.values, self.rest.as_ref());
        let raised = self.raised(course.lambda);
        let gain = |f: usize| {
            let terms = course.values.col_as_slice(0).iter().zip(&self.ratio[f]);
            let variance: f64 = terms.map(|(q, ratio)| q.norm_sqr() * ratio).sum();
            2.0 * along[(0, f)].norm_sqr() / (raised * variance)
        };
        (0..self.data.functions()).map(gain).collect()
    }

    /// What the amplitude of a pole collects of noise that lines share, over what it collects of
    /// white noise.
    fn raised(&self, lambda: Complex64) -> f64 {
        let shared = &self.data.correlation;
        shared.of_amplitude(-lambda.re, self.data.step)
    }

    /// By how much BIC falls.
    fn lowered(&self, gains: &[f64]) -> f64 {
        let held = gains
            .iter()
            .map(|gain| (gain - 2.0 * self.ln_count).max(0.0));
        held.sum::<f64>() - 2.0 * self.ln_count
    }

    fn count(&mut self, gains: &[f64]) {
        self.bic -= self.lowered(gains);
    }

    fn tried(&self, last: Option<(Pole, bool, &[f64])>) -> Tried {
        let free = (self.rest.nrows() as f64 - self.taken).max(1.0);
        let energy = self.over_noise().energy();
        let holds = |gain: &&f64| **gain > 2.0 * self.ln_count;
        Tried {
            pole: last.map(|(pole, _, _)| pole),
            identified: last.is_some_and(|(_, identified, _)| identified),
            holding: last.map_or(0, |(_, _, gains)| gains.iter().filter(holds).count()),
            bic: self.bic,
            predicted: None,
            rest: energy / (free * self.rest.ncols() as f64),
        }
    }

    /// What is left over, over the noise of each value.
    fn over_noise(&self) -> Rest {
        let mut values = self.rest.clone();
        linalg::by_column(&mut values, |f, column| {
            for (value, ratio) in column.iter_mut().zip(&self.ratio[f]) {
                *value /= ratio.sqrt();
            }
        });
        Rest {
            lines: 0..self.data.lines(),
            values,
        }
    }

    /// `−ln p − ln π` for each value of every stretch, foretold from the lines outside it and its
    /// neighbours that share noise with it.
    fn surprises(&self) -> Option<Vec<f64>> {
        let rest = self.over_noise().values;
        let guard = if self.stretch > 1 { self.stretch } else { 0 };
        let of = |own: &Range<usize>| {
            let out = own.start.saturating_sub(guard)..(own.end + guard).min(rest.nrows());
            let hat = self.hat(&out);
            let one = |r: usize, c: usize| Complex64::from(f64::from(u8::from(r == c)));
            let known =
                linalg::complex_matrix(out.len(), out.len(), |r, c| one(r, c) - hat[(r, c)]);
            let covariance = linalg::inverse_hermitian(&known)?;
            let errors = &covariance * rest.subrows(out.start, out.len());
            let (first, size) = (own.start - out.start, own.len());
            let errors = errors.subrows(first, size);
            let own = |r: usize, c: usize| covariance[(first + r, first + c)];
            let covariance = linalg::complex_matrix(size, size, own);
            let wide = linalg::inverse_hermitian(&covariance)? * errors;
            let functions = wide.ncols();
            let square = |f: usize| -> f64 {
                (0..size)
                    .map(|k| (errors[(k, f)].conj() * wide[(k, f)]).re)
                    .sum()
            };
            let mean = (0..functions).map(square).sum::<f64>() / functions as f64;
            let surprise = (mean + covariance.determinant().re.ln()) / size as f64;
            surprise.is_finite().then_some(surprise)
        };
        self.foretold.iter().map(of).collect()
    }
}
