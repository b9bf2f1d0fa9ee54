//! The family of linear systems known by their modes from which FRFs with white noise are drawn:
//! 300 of them, each from its number alone.
//!
//! A system has shapes `φ` of unit modal mass at its responses; the first of these are hit as well
//! (driving points), and the receptance residues are `φ_o φ_i / (2 i ω_d)`. Frequencies are uniform
//! over the band, components normal, all else as the constants say. Systems of more modal overlap
//! than [`MAX_OVERLAP`] are drawn again: where every half-power width holds several modes there
//! are no separable modes.

use std::fmt;

use modalign::axis::{Band, FrequencyAxis};
use modalign::dof::Dof;
use modalign::frf::FrfSet;
use modalign::modal::Pole;
use modalign::quantity::FrfKind;
use modalign::study::{FrfNoise, Judge, System, TrueMode};
use num_complex::Complex64;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Systems of the family.
pub const SYSTEMS: usize = 300;
/// Each system is a stream of this seed.
const SEED: u64 = 50_602;
/// Fewest and most modes inside the band.
const MODES: (usize, usize) = (3, 40);
/// Damping ratios; every system has a narrower range with log-uniform ends, and its modes are
/// log-uniform between them.
const DAMPING: (f64, f64) = (0.001, 0.08);
/// Signal-to-noise ratio of every function, dB: rms over the band over rms noise of a line.
const SNR_DB: (f64, f64) = (30.0, 80.0);
const REFERENCES: (usize, usize) = (1, 3);
const RESPONSES: (usize, usize) = (6, 30);
/// Lower edge of the band, Hz, and upper over lower, both log-uniform.
const LOWER_EDGE_HZ: (f64, f64) = (20.0, 200.0);
const EDGE_RATIO: (f64, f64) = (1.5, 12.0);
/// Lines of the band, log-uniform, but so many that the narrowest resonance has [`LINES_PER_WIDTH`]
/// if the most can do that.
const LINES: (usize, usize) = (200, 4000);
/// A record of five time constants has `5/π` lines to a half-power width.
const LINES_PER_WIDTH: f64 = 1.6;
/// Sum of the half-power widths over the width of the band.
const MAX_OVERLAP: f64 = 0.5;
/// Share of the systems with modes below and above the band, most on each side, and how far they
/// lie.
const OUTSIDE: (f64, usize) = (0.5, 3);
const BELOW: (f64, f64) = (0.4, 1.0);
const ABOVE: (f64, f64) = (1.0, 1.5);
/// Share of those whose lines go on beyond the band, by how much of its width on each side.
const OVERHANG: (f64, f64) = (0.5, 0.1);
/// Share of systems with complex shapes, and most standard deviation of the phases, degrees.
const COMPLEX: (f64, f64) = (0.3, 15.0);
/// Share of systems whose variances are estimated from so many averages; those of the others are
/// exact.
const ESTIMATED: (f64, (u32, u32)) = (0.5, (4, 16));
/// No mode lies nearer to an edge than this many half-power widths: there it is chance on which
/// side its peak is seen.
const EDGE_WIDTHS: f64 = 1.0;

/// A system of the family and its noise.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// Also the stream of its noise.
    pub number: u64,
    pub system: System,
    pub noise: FrfNoise,
}

impl Drawn {
    /// The system of a number.
    pub fn draw(number: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        random.set_stream(number);
        loop {
            let drawn = Self::try_draw(number, &mut random);
            if drawn.system.overlap() <= MAX_OVERLAP {
                return drawn;
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
        let modes = poles.into_iter().map(|pole| {
            let shape = (0..responses).map(|_| component(random, phase)).collect();
            mode(pole, shape, references)
        });
        let modes: Vec<TrueMode> = modes.collect();
        let overhang = if outside && random.random_bool(OVERHANG.0) {
            OVERHANG.1
        } else {
            0.0
        };
        let axis = axis(random, &modes, (band, overhang));
        let kinds = [FrfKind::Receptance, FrfKind::Accelerance];
        let system = System {
            modes,
            axis,
            band,
            kind: kinds[random.random_range(0..2)],
            responses: dofs(responses),
            references: dofs(references),
            record_end_s: None,
        };
        let noise = FrfNoise {
            snr_db: random.random_range(SNR_DB.0..SNR_DB.1),
            averages: random
                .random_bool(ESTIMATED.0)
                .then(|| random.random_range(ESTIMATED.1.0..=ESTIMATED.1.1)),
        };
        Self {
            number,
            system,
            noise,
        }
    }

    /// The FRFs with the noise of a draw.
    pub fn measured(&self, draw: u64) -> FrfSet {
        let mut random = ChaCha8Rng::seed_from_u64(SEED + 1 + draw);
        random.set_stream(self.number);
        self.system.noisy(&self.noise, &mut random).unwrap()
    }

    /// Judges what is found of it.
    pub fn judge(&self) -> Judge<'_> {
        Judge::new(&self.system, &self.variances())
    }

    /// True variance of each function.
    pub fn variances(&self) -> Vec<f64> {
        let exact = self.system.exact().unwrap();
        self.system.variances(&exact, self.noise.snr_db)
    }
}

/// The first so many points.
pub fn dofs(count: usize) -> Vec<Dof> {
    let dof = |number| format!("{number}:+Z").parse().unwrap();
    (1..=count).map(dof).collect()
}

/// A mode of unit modal mass, whose first responses are hit.
pub fn mode(pole: Pole, shape: Vec<Complex64>, references: usize) -> TrueMode {
    let at_references = shape[..references].to_vec();
    TrueMode::of_unit_mass(pole, shape, &at_references)
}

impl fmt::Display for Drawn {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let system = &self.system;
        let inside = system.modes.iter().filter(|m| system.inside(m));
        let inside: Vec<&TrueMode> = inside.collect();
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
            system.modes.len() - inside.len(),
            system.overlap(),
            system.band.lo_hz,
            system.band.hi_hz,
            system.axis.lines(&system.band).len(),
            narrowest / system.axis.step_hz,
            if system.axis.len > system.axis.lines(&system.band).len() + 2 {
                ", more beyond"
            } else {
                ""
            },
            system.responses.len(),
            system.references.len(),
            system.kind,
            self.noise.snr_db,
            self.noise
                .averages
                .map_or("exact".to_owned(), |n| n.to_string()),
            if system.modes[0].shape.iter().any(|c| c.im != 0.0) {
                ", complex"
            } else {
                ""
            },
        )
    }
}

pub fn log_uniform(random: &mut ChaCha8Rng, (lo, hi): (f64, f64)) -> f64 {
    lo * (hi / lo).powf(random.random_range(0.0..1.0))
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
