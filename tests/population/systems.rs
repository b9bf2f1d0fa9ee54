//! The family of linear systems known by their modes from which FRFs with white noise are drawn: 300 of them, each from its
//! number alone.
//!
//! A system has shapes `φ` of unit modal mass at its responses; the first of these are hit as well (driving points), and
//! the receptance residues are `φ_o φ_i / (2 i ω_d)`. Frequencies are uniform over the band, components normal, all else as
//! the constants say. Systems of more modal overlap than [`MOST_OVERLAP`] are drawn again: where every half-power width holds
//! several modes there are no modes to tell.

use std::f64::consts::TAU;
use std::fmt;

use modalign::axis::{Band, FrequencyAxis};
use modalign::dof::Dof;
use modalign::frf::{FrfSet, Function, FunctionData, synthesise};
use modalign::modal::Pole;
use modalign::quantity::FrfKind;
use num_complex::Complex64;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{ChiSquared, Distribution, StandardNormal};

/// Systems of the family.
pub const SYSTEMS: usize = 300;
/// Each system is a stream of this seed.
const SEED: u64 = 50_602;
/// Fewest and most modes inside the band.
const MODES: (usize, usize) = (3, 40);
/// Damping ratios; a system has a range of its own inside, its ends log-uniform, its modes log-uniform between.
const DAMPING: (f64, f64) = (0.001, 0.08);
/// Signal-to-noise ratio of every function, dB: rms over the band over rms noise of a line.
const SNR_DB: (f64, f64) = (30.0, 80.0);
const REFERENCES: (usize, usize) = (1, 3);
const RESPONSES: (usize, usize) = (6, 30);
/// Lower edge of the band, Hz, and upper over lower, both log-uniform.
const LOWER_EDGE_HZ: (f64, f64) = (20.0, 200.0);
const EDGE_RATIO: (f64, f64) = (1.5, 12.0);
/// Lines of the band, log-uniform, but so many that the narrowest resonance has [`LINES_PER_WIDTH`] if the most can do that.
const LINES: (usize, usize) = (200, 4000);
/// A record of five time constants has `5/π` lines to a half-power width.
const LINES_PER_WIDTH: f64 = 1.6;
/// Sum of the half-power widths over the width of the band.
const MOST_OVERLAP: f64 = 0.5;
/// Share of the systems with modes below and above the band, most on each side, and how far they lie.
const OUTSIDE: (f64, usize) = (0.5, 3);
const BELOW: (f64, f64) = (0.4, 1.0);
const ABOVE: (f64, f64) = (1.0, 1.5);
/// Share of those whose lines go on beyond the band, by how much of its width on each side.
const OVERHANG: (f64, f64) = (0.5, 0.1);
/// Share of systems with complex shapes, and most standard deviation of the phases, degrees.
const COMPLEX: (f64, f64) = (0.3, 15.0);
/// Share of systems whose variances are estimated from so many averages; those of the others are exact.
const ESTIMATED: (f64, (u32, u32)) = (0.5, (4, 16));
/// No mode lies nearer to an edge than this many half-power widths: there it is chance on which side its peak is seen.
const EDGE_WIDTHS: f64 = 1.0;

/// A mode of the truth.
#[derive(Clone, Debug)]
pub struct TrueMode {
    pub pole: Pole,
    /// At the responses, unit modal mass.
    pub shape: Vec<Complex64>,
}

impl TrueMode {
    pub fn hz(&self) -> f64 {
        self.pole.natural_frequency_hz()
    }

    pub fn width_hz(&self) -> f64 {
        self.pole.half_power_width_hz()
    }

    /// Receptance residue of a response for a hit at another one, m/(N s).
    pub fn residue(&self, response: usize, reference: usize) -> Complex64 {
        self.shape[response] * self.participation(reference)
    }

    /// What multiplies the shape to give the residues of a reference.
    pub fn participation(&self, reference: usize) -> Complex64 {
        self.shape[reference] / Complex64::new(0.0, 2.0 * self.pole.lambda.im)
    }
}

/// A system and how it is measured.
#[derive(Clone, Debug)]
pub struct System {
    pub number: u64,
    /// In ascending frequency, those outside the band included.
    pub modes: Vec<TrueMode>,
    pub axis: FrequencyAxis,
    pub band: Band,
    pub kind: FrfKind,
    /// The first so many responses are hit.
    pub references: usize,
    pub responses: usize,
    pub snr_db: f64,
    /// Averages that the stated variances are estimated from; exact variances without.
    pub averages: Option<u32>,
}

impl System {
    /// The system of a number.
    pub fn draw(number: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        random.set_stream(number);
        loop {
            let system = Self::try_draw(number, &mut random);
            if system.overlap() <= MOST_OVERLAP {
                return system;
            }
        }
    }

    fn try_draw(number: u64, random: &mut ChaCha8Rng) -> Self {
        let count = random.random_range(MODES.0..=MODES.1);
        let lo_hz = log_uniform(random, LOWER_EDGE_HZ);
        let hi_hz = lo_hz * log_uniform(random, EDGE_RATIO);
        let band = Band::new(lo_hz, hi_hz).unwrap();
        let references = random.random_range(REFERENCES.0..=REFERENCES.1);
        let responses = random.random_range(RESPONSES.0..=RESPONSES.1);
        let ends = [log_uniform(random, DAMPING), log_uniform(random, DAMPING)];
        let damping = (ends[0].min(ends[1]), ends[0].max(ends[1]));
        let mut poles = poles(random, (count, (lo_hz, hi_hz)), (band, damping));
        let outside = random.random_bool(OUTSIDE.0);
        if outside {
            let below = random.random_range(1..=OUTSIDE.1);
            let above = random.random_range(1..=OUTSIDE.1);
            let ranges = [(below, (BELOW, lo_hz)), (above, (ABOVE, hi_hz))];
            for (count, (shares, edge)) in ranges {
                let range = (shares.0 * edge, shares.1 * edge);
                poles.extend(self::poles(random, (count, range), (band, damping)));
            }
        }
        poles.sort_by(|a, b| {
            a.natural_frequency_hz()
                .total_cmp(&b.natural_frequency_hz())
        });
        let phase = if random.random_bool(COMPLEX.0) {
            random.random_range(0.0..COMPLEX.1).to_radians()
        } else {
            0.0
        };
        let modes = poles.into_iter().map(|pole| TrueMode {
            pole,
            shape: (0..responses).map(|_| component(random, phase)).collect(),
        });
        let modes: Vec<TrueMode> = modes.collect();
        let overhang = if outside && random.random_bool(OVERHANG.0) {
            OVERHANG.1
        } else {
            0.0
        };
        let axis = axis(random, &modes, (band, overhang));
        let kinds = [FrfKind::Receptance, FrfKind::Accelerance];
        Self {
            number,
            modes,
            axis,
            band,
            kind: kinds[random.random_range(0..2)],
            references,
            responses,
            snr_db: random.random_range(SNR_DB.0..SNR_DB.1),
            averages: random
                .random_bool(ESTIMATED.0)
                .then(|| random.random_range(ESTIMATED.1.0..=ESTIMATED.1.1)),
        }
    }

    /// Whether a mode lies in the band.
    pub fn inside(&self, mode: &TrueMode) -> bool {
        self.band.contains(mode.hz())
    }

    /// Modal overlap of the band: the sum of the half-power widths over its own.
    fn overlap(&self) -> f64 {
        let inside = self.modes.iter().filter(|mode| self.inside(mode));
        inside.map(TrueMode::width_hz).sum::<f64>() / self.band.width_hz()
    }

    /// The degree of freedom of a response.
    pub fn dof(response: usize) -> Dof {
        format!("{}:+Z", response + 1).parse().unwrap()
    }

    /// Response and reference of every function, reference by reference.
    pub fn pairs(&self) -> Vec<(usize, usize)> {
        (0..self.references)
            .flat_map(|i| (0..self.responses).map(move |o| (o, i)))
            .collect()
    }

    /// The functions without noise.
    pub fn exact(&self) -> FrfSet {
        let pairs: Vec<(usize, usize)> = self.pairs();
        let name = |&(o, i): &(usize, usize)| (Self::dof(o), Self::dof(i));
        let of_mode = |mode: &TrueMode| {
            let residues = pairs.iter().map(|p| (name(p), mode.residue(p.0, p.1)));
            (mode.pole, residues.collect())
        };
        let terms: Vec<(Pole, modalign::frf::Residues)> = self.modes.iter().map(of_mode).collect();
        let terms: Vec<_> = terms.iter().map(|(pole, a)| (*pole, a)).collect();
        let names: Vec<(Dof, Dof)> = pairs.iter().map(name).collect();
        synthesise(&terms, self.axis, &names, self.kind, 0.0).unwrap()
    }

    /// True variance of each function of [`Self::exact`].
    pub fn variances(&self, exact: &FrfSet) -> Vec<f64> {
        let lines = self.axis.lines(&self.band);
        let share = 10f64.powf(-self.snr_db / 10.0) / lines.len() as f64;
        let power = |i| -> f64 {
            exact.values(i)[lines.clone()]
                .iter()
                .map(Complex64::norm_sqr)
                .sum()
        };
        (0..exact.len()).map(|i| share * power(i)).collect()
    }

    /// The functions with their noise, of which each draw has its own.
    pub fn measured(&self, draw: u64) -> FrfSet {
        let exact = self.exact();
        let variances = self.variances(&exact);
        let mut random = ChaCha8Rng::seed_from_u64(SEED + 1 + draw);
        random.set_stream(self.number);
        let mut set = FrfSet::new(self.axis);
        let freedom = self.averages.map(|n| 2.0 * f64::from(n - 1));
        for (i, variance) in variances.iter().enumerate() {
            let values = exact.values(i).iter();
            let values = values.map(|h| h + white(&mut random, *variance)).collect();
            let chi = freedom.map(|freedom| ChiSquared::new(freedom).unwrap());
            let mut stated = || match (chi, freedom) {
                (Some(chi), Some(freedom)) => variance * chi.sample(&mut random) / freedom,
                _ => *variance,
            };
            let variance = Some((0..self.axis.len).map(|_| stated()).collect());
            let function = Function {
                averages: self.averages,
                variance_dof: freedom,
                ..exact.functions()[i].clone()
            };
            let data = FunctionData {
                values,
                coherence: None,
                variance,
            };
            set.push(function, data).unwrap();
        }
        set
    }
}

impl fmt::Display for System {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let inside: Vec<&TrueMode> = self.modes.iter().filter(|m| self.inside(m)).collect();
        let damping = |mode: &&TrueMode| 100.0 * mode.pole.damping_ratio();
        let least = inside.iter().map(damping).fold(f64::MAX, f64::min);
        let most = inside.iter().map(damping).fold(0.0, f64::max);
        let narrowest = inside.iter().map(|m| m.width_hz()).fold(f64::MAX, f64::min);
        write!(
            f,
            "system {}: {} modes ({} outside), {least:.2} to {most:.2} %, overlap {:.2}, {:.1}:{:.1} Hz, \
             {} lines ({:.1} to the narrowest{}), {} x {} {:?}, {:.0} dB, {} averages{}",
            self.number,
            inside.len(),
            self.modes.len() - inside.len(),
            self.overlap(),
            self.band.lo_hz,
            self.band.hi_hz,
            self.axis.lines(&self.band).len(),
            narrowest / self.axis.step_hz,
            if self.axis.len > self.axis.lines(&self.band).len() + 2 {
                ", more beyond"
            } else {
                ""
            },
            self.responses,
            self.references,
            self.kind,
            self.snr_db,
            self.averages.map_or("exact".to_owned(), |n| n.to_string()),
            if self.modes[0].shape.iter().any(|c| c.im != 0.0) {
                ", complex"
            } else {
                ""
            },
        )
    }
}

fn log_uniform(random: &mut ChaCha8Rng, (lo, hi): (f64, f64)) -> f64 {
    lo * (hi / lo).powf(random.random_range(0.0..1.0))
}

/// Complex noise of variance E|z|².
fn white(random: &mut ChaCha8Rng, variance: f64) -> Complex64 {
    let mut part = || -> f64 { StandardNormal.sample(random) };
    Complex64::new(part(), part()) * (0.5 * variance).sqrt()
}

/// A normal component with a normal phase.
pub fn component(random: &mut ChaCha8Rng, phase: f64) -> Complex64 {
    let size: f64 = StandardNormal.sample(random);
    let turn: f64 = StandardNormal.sample(random);
    Complex64::from_polar(1.0, phase * turn) * size
}

/// Poles in a range of frequencies, none at an edge of the band.
fn poles(
    random: &mut ChaCha8Rng,
    (count, (lo, hi)): (usize, (f64, f64)),
    (band, damping): (Band, (f64, f64)),
) -> Vec<Pole> {
    let mut found = Vec::with_capacity(count);
    while found.len() < count {
        let zeta = log_uniform(random, damping);
        let pole = Pole::from_frequency(random.random_range(lo..hi), zeta);
        let clear = EDGE_WIDTHS * pole.half_power_width_hz();
        let from = |edge: f64| (pole.natural_frequency_hz() - edge).abs();
        if from(band.lo_hz) >= clear && from(band.hi_hz) >= clear {
            found.push(pole);
        }
    }
    found
}

/// The lines of the band, and of an overhang on both sides.
fn axis(
    random: &mut ChaCha8Rng,
    modes: &[TrueMode],
    (band, overhang): (Band, f64),
) -> FrequencyAxis {
    let drawn = log_uniform(random, (LINES.0 as f64, LINES.1 as f64));
    let inside = modes.iter().filter(|mode| band.contains(mode.hz()));
    let narrowest = inside.map(TrueMode::width_hz).fold(f64::MAX, f64::min);
    let needed = LINES_PER_WIDTH * band.width_hz() / narrowest;
    let lines = drawn.max(needed).min(LINES.1 as f64).round();
    let step_hz = band.width_hz() / (lines - 1.0);
    let beyond = (overhang * lines)
        .floor()
        .min((band.lo_hz / step_hz).floor() - 1.0);
    FrequencyAxis {
        start_hz: band.lo_hz - beyond * step_hz,
        step_hz,
        len: (lines + 2.0 * beyond) as usize,
    }
}

/// Angular frequencies of the lines of the band.
pub fn omega(system: &System) -> Vec<f64> {
    let lines = system.axis.lines(&system.band);
    lines.map(|k| TAU * system.axis.hz(k)).collect()
}
